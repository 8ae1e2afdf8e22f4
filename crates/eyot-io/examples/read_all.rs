//! Reads every raster in a folder and writes what came of it as R32, for `ci/check_inputs.py`.
//!
//! `NAME.EXT` becomes `NAME.EXT.read.r32`; if it is refused, `NAME.EXT.error` holds the message.
//!
//! Usage: `cargo run -p eyot-io --example read_all -- FOLDER`

use eyot_core::{Boundary, Grid, Limits, World, layer::known};
use eyot_io::{RasterFormat, ReadOptions, read_raster, write_layer};
use std::path::PathBuf;

const READ: [&str; 5] = ["tif", "png", "exr", "npy", "zarr"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: read_all FOLDER")?);
    let options = ReadOptions { low_m: Some(0.0), high_m: Some(65535.0), ..ReadOptions::default() };
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if !path.extension().and_then(|e| e.to_str()).is_some_and(|e| READ.contains(&e)) {
            continue;
        }
        let beside = |ending: &str| PathBuf::from(format!("{}.{ending}", path.display()));
        match read_raster(&path, &options, &Limits::default()) {
            Ok(raster) => {
                let (x, y) = raster.cell_m.unwrap_or((1.0, 1.0));
                let grid = Grid {
                    width: raster.field.width(),
                    height: raster.field.height(),
                    cell_x_m: x,
                    cell_y_m: y,
                    rim: Boundary::CLOSED,
                };
                let mut world = World::new(grid, raster.filled() as u64);
                world.georeference = raster.georeference;
                world.put(&known::HEIGHT, raster.field)?;
                write_layer(&beside("read.r32"), &world, &world.layers()[0], RasterFormat::R32)?;
            }
            Err(e) => std::fs::write(beside("error"), e.to_string())?,
        }
    }
    Ok(())
}
