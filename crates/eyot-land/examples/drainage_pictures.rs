//! Pictures of lakes and rivers, to look at: `cargo run --release -p eyot-land --example drainage_pictures -- FOLDER`.
//!
//! Blue: lakes that the depressions would hold. Light to dark: the logarithm of the drained area. The second picture of each
//! land is after breaching.

use eyot_core::layer::known::HEIGHT;
use eyot_core::process::{Generator, Site};
use eyot_core::{Boundary, Control, Field, Grid, Limits, World};
use eyot_drainage::{Land, RoutingRule};
use eyot_land::generate::fractal::{Fractal, Octaves};
use eyot_land::generate::{Breach, Fbm};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "out/drainage".to_owned());
    std::fs::create_dir_all(&folder)?;
    let control = Control::none();
    let tile = Path::new(env!("CARGO_MANIFEST_DIR")).join("../eyot-recipe/data/jacksboro.tif");
    let jacksboro = eyot_io::read_raster(&tile, &eyot_io::ReadOptions::default(), &Limits::default())?.field;
    let grid = Grid::new(512, 512, 30.0, Boundary::OPEN, &Limits::default())?;
    let world = World::new(grid, 1);
    let noise = Fbm { fractal: Fractal { noise: Octaves { octaves: 9, ..Octaves::default() }, ..Fractal::default() } };
    let fbm = noise.generate(&Site::whole(grid, 3, &world, &control), &Field::new(512, 512, 0.0))?;
    for (name, height, cell_m) in [("jacksboro", jacksboro, 90.0), ("fbm", fbm, 30.0)] {
        let grid = Grid::new(height.width(), height.height(), cell_m, Boundary::OPEN, &Limits::default())?;
        let mut world = World::new(grid, 1);
        world.sea_level_m = -1e6;
        world.put(&HEIGHT, height.clone())?;
        let cut = Breach { fill: false, ..Breach::default() };
        let breached = cut.generate(&Site::whole(grid, 1, &world, &control), &height)?;
        for (state, height) in [("before", &height), ("breached", &breached)] {
            for rule in [RoutingRule::D8, RoutingRule::Multiple, RoutingRule::Dinf] {
                let land = Land { height, grid: &grid, sea_level_m: -1e6, closed_rims: false };
                let drained = land.drain(rule, 1.1, &control)?;
                let most = (drained.area_m2.len() as f64 * grid.cell_area_m2()).ln();
                let least = grid.cell_area_m2().ln();
                let mut lakes = 0;
                let pixels: Vec<u8> = drained
                    .area_m2
                    .iter()
                    .zip(drained.filled.iter().zip(height.iter()))
                    .flat_map(|(area, (filled, height))| {
                        let shade = 255.0 * (1.0 - (area.ln() - least) / (most - least)).clamp(0.0, 1.0);
                        let lake = filled - height > 0.01;
                        lakes += usize::from(lake);
                        if lake { [(0.4 * shade) as u8, (0.6 * shade) as u8, 255] } else { [shade as u8; 3] }
                    })
                    .collect();
                let file = std::fs::File::create(format!("{folder}/{name}_{state}_{rule:?}.png"))?;
                let mut encoder = png::Encoder::new(file, grid.width as u32, grid.height as u32);
                encoder.set_color(png::ColorType::Rgb);
                encoder.write_header()?.write_image_data(&pixels)?;
                println!("{name} {state} {rule:?}: {:.2} % lakes", 100.0 * lakes as f64 / grid.cells() as f64);
            }
        }
    }
    Ok(())
}
