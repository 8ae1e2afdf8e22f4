//! Height maps from files.

use crate::{BETWEEN, limits, parts, scratch};
use eyot::{Boundary, Field, Georeference, Grid, Limits, World};
use eyot_core::layer::known;
use eyot_io::{RasterFormat, ReadOptions, RowOrder, Sample, read_raster, write_layer};
use std::path::Path;

pub(crate) const PNG_WORDS: &[&str] = &["IHDR", "IDAT", "IEND", "tEXt", "iTXt", "PLTE", "tRNS", "acTL", "fcTL"];
pub(crate) const SIDECAR_WORDS: &[&str] =
    &["width", "height", "cell_m", "\"low\": 0", "-1", "1e999", "null", "18446744073709551615", "\"", "{", "[["];
pub(crate) const RAW_WORDS: &[&str] =
    &["u8", "i16be", "u16", "f16", "f32be", "u64", "f64", "0", "-1", "4294967295", "65536", "nan", "1e40"];
pub(crate) const EXR_WORDS: &[&str] = &[
    "channels\0chlist\0",
    "dataWindow\0box2i\0",
    "tiles\0tiledesc\0",
    "compression\0compression\0",
    "lineOrder\0",
    "\0",
];
pub(crate) const NPY_WORDS: &[&str] = &[
    "'descr': ",
    "'<f8'",
    "'|u1'",
    "'>i2'",
    "'|O'",
    "True",
    "(1, 7, 5)",
    "(-1,",
    "18446744073709551615",
    "(",
    ")",
    "\n%%\n",
];

/// Any format that is told from its content.
pub(crate) fn read(bytes: &[u8]) -> bool {
    let path = scratch("raster");
    std::fs::write(&path, bytes).expect("room for an input");
    read_file(&path)
}

pub(crate) fn read_r32(bytes: &[u8]) -> bool {
    read_described(bytes, "raster.r32")
}

pub(crate) fn read_r16(bytes: &[u8]) -> bool {
    read_described(bytes, "raster.r16")
}

pub(crate) fn read_npy(bytes: &[u8]) -> bool {
    read_described(bytes, "raster.npy")
}

/// A description and the file beside it.
fn read_described(bytes: &[u8], name: &str) -> bool {
    let [description, values] = parts(bytes);
    let path = scratch(name);
    std::fs::write(&path, values).expect("room for an input");
    // An empty description is none.
    let beside = scratch(&format!("{name}.json"));
    if description.is_empty() {
        std::fs::remove_file(beside).ok();
    } else {
        std::fs::write(beside, description).expect("room for an input");
    }
    read_file(&path)
}

/// Raw numbers by flags: `u16le COLUMNS ROWS NODATA` in the first part, then the numbers.
pub(crate) fn read_raw(bytes: &[u8]) -> bool {
    let [flags, values] = parts(bytes);
    let flags = String::from_utf8_lossy(flags);
    let flags: Vec<&str> = flags.split_whitespace().collect();
    let word = |i: usize| flags.get(i).copied().unwrap_or_default();
    let Some((sample, byte_order)) = Sample::parse(word(0)) else { return false };
    let path = scratch("raster.bin");
    std::fs::write(&path, values).expect("room for an input");
    let options = ReadOptions {
        sample: Some(sample),
        byte_order: Some(byte_order),
        size: word(1).parse().ok().zip(word(2).parse().ok()),
        nodata: word(3).parse().ok(),
        row_order: Some(RowOrder::SouthFirst),
        ..ReadOptions::default()
    };
    read_with(&path, &options)
}

/// Reads what tells all by itself, else with a scale.
pub(crate) fn read_file(path: &Path) -> bool {
    read_with(path, &ReadOptions::default())
}

fn read_with(path: &Path, options: &ReadOptions) -> bool {
    let scaled = ReadOptions { low_m: Some(0.0), high_m: Some(1.0), ..options.clone() };
    let own = read_raster(path, options, &limits());
    match own.or_else(|_| read_raster(path, &scaled, &limits())) {
        Ok(r) => {
            assert!(r.field.find_not_finite().is_none(), "a value that is not finite");
            assert!(r.field.width() > 0 && r.field.height() > 0, "a raster without cells");
            let sound = |(x, y): (f64, f64)| x.is_finite() && y.is_finite() && x > 0.0 && y > 0.0;
            assert!(r.cell_m.is_none_or(sound), "cells of {:?} m", r.cell_m);
            let place = |g: &Georeference| {
                let [_, a, b, _, c, d] = g.transform;
                g.transform.iter().all(|v| v.is_finite()) && a.hypot(c) > 0.0 && b.hypot(d) > 0.0
            };
            assert!(r.georeference.as_ref().is_none_or(place), "a place of no use: {:?}", r.georeference);
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
    vec![described(RasterFormat::R32)]
}

pub(crate) fn r16() -> Vec<Vec<u8>> {
    vec![described(RasterFormat::R16)]
}

pub(crate) fn npy() -> Vec<Vec<u8>> {
    let own = described(RasterFormat::Npy);
    let array = |head: &str, values: &[u8]| {
        let length = (head.len() as u16).to_le_bytes();
        [BETWEEN, b"\x93NUMPY\x01\x00", &length, head.as_bytes(), values].concat()
    };
    vec![
        own,
        array("{'descr': '>i2', 'fortran_order': True, 'shape': (2, 3), }", &[7; 12]),
        array("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 1, 2), }", &[64; 16]),
    ]
}

pub(crate) fn raw() -> Vec<Vec<u8>> {
    let input = |flags: &str, values: &[u8]| [flags.as_bytes(), BETWEEN, values].concat();
    vec![
        input("i16be 5 3 -32768", &(0..30).collect::<Vec<u8>>()),
        input("f32le", &[64; 4 * 9]),
        input("u8 4 4 0", &[0, 1, 2, 3, 0, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]),
        input("f16be 2 2 nan", &[0x3c, 0, 0x7e, 0, 0xc0, 0, 0, 1]),
        input("u64 1 1", &[9; 8]),
    ]
}

/// Ours, and images in other layouts, compressions and number types.
pub(crate) fn exr() -> Vec<Vec<u8>> {
    use exr::prelude::*;
    let image = |encoding: Encoding, wide: bool, size: usize| {
        let value = |p: Vec2<usize>| (p.x() * 3 + p.y()) as f32;
        let half = |p: Vec2<usize>| (f16::from_f32(value(p)),);
        let mut out = std::io::Cursor::new(Vec::new());
        if wide {
            let channels = SpecificChannels::build().with_channel("Z").with_pixel_fn(|p| (value(p),));
            let layer = Layer::new((size, size), LayerAttributes::named("l"), encoding, channels);
            Image::from_layer(layer).write().to_buffered(&mut out).expect("a sound image");
        } else {
            let channels = SpecificChannels::build().with_channel("Y").with_pixel_fn(half);
            let layer = Layer::new((size, size), LayerAttributes::named("l"), encoding, channels);
            Image::from_layer(layer).write().to_buffered(&mut out).expect("a sound image");
        }
        out.into_inner()
    };
    let encoding = |compression, blocks| Encoding { compression, blocks, line_order: LineOrder::Increasing };
    vec![
        written(&world(20, 18), RasterFormat::Exr),
        image(encoding(Compression::Uncompressed, Blocks::ScanLines), true, 7),
        image(encoding(Compression::RLE, Blocks::Tiles(Vec2(8, 8))), false, 12),
        image(encoding(Compression::PIZ, Blocks::ScanLines), false, 9),
        image(encoding(Compression::PXR24, Blocks::Tiles(Vec2(16, 4))), true, 9),
        image(encoding(Compression::B44, Blocks::ScanLines), false, 8),
    ]
}

/// A file of ours with what lies beside it.
fn described(format: RasterFormat) -> Vec<u8> {
    let values = written(&world(7, 5), format);
    let description = std::fs::read(scratch("seed.json")).expect("a description");
    [&description, BETWEEN, &values].concat()
}

fn written(world: &World, format: RasterFormat) -> Vec<u8> {
    let path = scratch("seed");
    write_layer(&path, world, &world.layers()[0], format).expect("a sound raster");
    std::fs::read(path).expect("the raster")
}

pub(crate) fn world(width: usize, height: usize) -> World {
    let grid = Grid::new(width, height, 10.0, Boundary::CLOSED, &Limits::default()).expect("a sound grid");
    let mut world = World::new(grid, 1);
    world.georeference = Some(Georeference {
        transform: [5e5, 10.0, 0.0, 4e6, 0.0, -10.0],
        epsg: Some(32611),
        geographic: false,
        nodata: Some(-1.0),
        ..Georeference::default()
    });
    let hills = |x: usize, y: usize| ((x * x + 3 * y) % 97) as f32 * 0.5;
    world.put(&known::HEIGHT, Field::from_fn(width, height, hills)).expect("a field of the grid's size");
    world
}
