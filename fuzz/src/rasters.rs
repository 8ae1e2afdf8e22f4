//! Height maps from files.

use crate::{limits, scratch};
use eyot::core::layer::known;
use eyot::io::{RasterFormat, ReadOptions, read_raster, write_layer};
use eyot::{Field, Georeference, Grid, Limits, Rim, World};
use std::path::Path;

pub(crate) const PNG_WORDS: &[&str] = &["IHDR", "IDAT", "IEND", "tEXt", "iTXt", "PLTE", "tRNS", "acTL", "fcTL"];
pub(crate) const R32_WORDS: &[&str] =
    &["width", "height", "cell_m", "-1", "1e999", "null", "18446744073709551615", "\"", "{", "[["];

/// Any format that is told from its content.
pub(crate) fn read(bytes: &[u8]) -> bool {
    let path = scratch("raster");
    std::fs::write(&path, bytes).expect("room for an input");
    read_file(&path)
}

/// Raw floats with the description beside them: two bytes for the length of the description, then both.
pub(crate) fn read_described(bytes: &[u8]) -> bool {
    let Some((length, rest)) = bytes.split_first_chunk() else { return false };
    let (description, values) = rest.split_at(usize::from(u16::from_le_bytes(*length)).min(rest.len()));
    let path = scratch("raster.r32");
    std::fs::write(&path, values).expect("room for an input");
    std::fs::write(scratch("raster.r32.json"), description).expect("room for an input");
    read_file(&path)
}

fn read_file(path: &Path) -> bool {
    let options = ReadOptions { low_m: Some(0.0), high_m: Some(1.0), ..ReadOptions::default() };
    let own = read_raster(path, &ReadOptions::default(), &limits());
    match own.or_else(|_| read_raster(path, &options, &limits())) {
        Ok(r) => {
            assert!(r.field.find_not_finite().is_none(), "a value that is not finite");
            assert!(r.field.width() > 0 && r.field.height() > 0, "a raster without cells");
            let sound = |(x, y): (f64, f64)| x.is_finite() && y.is_finite() && x > 0.0 && y > 0.0;
            assert!(r.cell_m.is_none_or(sound), "cells of {:?} m", r.cell_m);
            true
        }
        Err(e) => {
            assert!(!e.to_string().is_empty());
            false
        }
    }
}

pub(crate) fn geotiff() -> Vec<Vec<u8>> {
    // Turned over, cut in tiles, without a place, and one cell.
    let mut south = world(33, 20);
    if let Some(g) = &mut south.georeference {
        g.transform[5] = -g.transform[5];
    }
    let mut nowhere = world(300, 5);
    nowhere.georeference = None;
    [world(70, 40), south, nowhere, world(1, 1)].iter().map(|w| written(w, RasterFormat::GeoTiff)).collect()
}

pub(crate) fn png() -> Vec<Vec<u8>> {
    vec![written(&world(30, 20), RasterFormat::Png16), written(&world(1, 1), RasterFormat::Png16)]
}

pub(crate) fn r32() -> Vec<Vec<u8>> {
    let values = written(&world(7, 5), RasterFormat::R32);
    let description = std::fs::read(scratch("seed.json")).expect("a description");
    vec![[&(description.len() as u16).to_le_bytes()[..], &description, &values].concat()]
}

fn written(world: &World, format: RasterFormat) -> Vec<u8> {
    let path = scratch("seed");
    write_layer(&path, world, &world.layers()[0], format).expect("a sound raster");
    std::fs::read(path).expect("the raster")
}

fn world(width: usize, height: usize) -> World {
    let grid = Grid::new(width, height, 10.0, Rim::CLOSED, &Limits::default()).expect("a sound grid");
    let mut world = World::new(grid, 1);
    world.georeference = Some(Georeference {
        transform: [5e5, 10.0, 0.0, 4e6, 0.0, -10.0],
        epsg: Some(32611),
        geographic: false,
        nodata: Some(-1.0),
    });
    let hills = |x: usize, y: usize| ((x * x + 3 * y) % 97) as f32 * 0.5;
    world.put(&known::HEIGHT, Field::from_fn(width, height, hills)).expect("a field of the grid's size");
    world
}
