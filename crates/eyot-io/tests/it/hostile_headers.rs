//! Headers that promise far more than the file has bytes, names that lead to no file, and places of no use.

use crate::common;

use common::{Fixture, read, refused};
use eyot_core::{Boundary, Field, Grid, Limits, World, layer::known};
use eyot_io::{RasterFormat, write_layer};
use std::fs;

/// A PNG of zeros that ends after a few bytes of them.
fn png(width: u32, height: u32, depth: u8, interlaced: u8) -> Vec<u8> {
    let chunk = |kind: &[u8], data: &[u8]| {
        let body = [kind, data].concat();
        [&(data.len() as u32).to_be_bytes()[..], &body, &crc32fast::hash(&body).to_be_bytes()].concat()
    };
    let header = [&width.to_be_bytes()[..], &height.to_be_bytes(), &[depth, 0, 0, 0, interlaced]].concat();
    // An empty zlib stream.
    let data = [0x78, 0x9c, 3, 0, 0, 0, 0, 1];
    [b"\x89PNG\r\n\x1a\n".to_vec(), chunk(b"IHDR", &header), chunk(b"IDAT", &data), chunk(b"IEND", b"")].concat()
}

/// Both sizes meet the limits of a run. An interlaced image is held whole, and so was touched.
#[test]
fn pngs_of_thousands_of_pixels_a_byte_are_refused() {
    let f = Fixture::new();
    for (depth, interlaced) in [(16, 0), (8, 0), (16, 1), (1, 1)] {
        let e = refused(&f.file("a.png", &png(30_000, 30_000, depth, interlaced)));
        assert!(e.contains("cannot hold its 30000x30000 cells"), "{e}");
    }
    assert!(refused(&f.file("b.png", &png(0x7fff_ffff, 0x7fff_ffff, 16, 0))).contains("too large"));
}

/// The start of an image of square tiles, which has no pixels.
fn exr(size: u32, tile: [u32; 2]) -> Vec<u8> {
    let attribute = |name: &str, kind: &str, data: &[u8]| {
        [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &(data.len() as u32).to_le_bytes(), data].concat()
    };
    let window = [0, 0, size - 1, size - 1].map(u32::to_le_bytes).concat();
    let channel = [b"Y\0".as_slice(), &[2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0]].concat();
    let tiles = [tile.map(u32::to_le_bytes).concat(), vec![0]].concat();
    [
        vec![0x76, 0x2f, 0x31, 0x01, 2, 2, 0, 0],
        attribute("channels", "chlist", &channel),
        attribute("compression", "compression", &[3]),
        attribute("dataWindow", "box2i", &window),
        attribute("displayWindow", "box2i", &window),
        attribute("lineOrder", "lineOrder", &[0]),
        attribute("pixelAspectRatio", "float", &1f32.to_le_bytes()),
        attribute("screenWindowCenter", "v2f", &[0; 8]),
        attribute("screenWindowWidth", "float", &1f32.to_le_bytes()),
        attribute("tiles", "tiledesc", &tiles),
        vec![0; 65],
    ]
    .concat()
}

/// One tile is one block, so that the table of blocks needs eight bytes.
#[test]
fn exrs_of_one_huge_tile_are_refused() {
    let e = refused(&Fixture::new().file("a.exr", &exr(16_000, [16_000; 2])));
    assert!(e.contains("cannot hold its 16000x16000 cells"), "{e}");
}

/// Fuzzing found 1.6 GiB taken for an image of 9 x 9 pixels.
#[test]
fn exrs_of_tiles_far_larger_than_the_image_are_refused() {
    let e = refused(&Fixture::new().file("a.exr", &exr(9, [0x2000_0010, 4])));
    assert!(e.contains("tiles of 8192 MiB"), "{e}");
}

/// A step of no length would make cells of no size.
#[test]
fn a_description_with_a_place_of_no_use_is_one_without() {
    let f = Fixture::new();
    let mut world = World::new(Grid::new(3, 2, 10.0, Boundary::CLOSED, &Limits::default()).unwrap(), 1);
    world.put(&known::HEIGHT, Field::new(3, 2, 1.0)).unwrap();
    for format in [RasterFormat::R32, RasterFormat::R16, RasterFormat::Npy] {
        let path = f.0.path().join(format!("a.{}", format.extension()));
        write_layer(&path, &world, &world.layers()[0], format).unwrap();
        let beside = f.0.path().join(format!("a.{}.json", format.extension()));
        let mut value: serde_json::Value = serde_json::from_slice(&fs::read(&beside).unwrap()).unwrap();
        for (transform, sound) in [([5.0, 10.0, 0.0, 7.0, 0.0, -10.0], true), ([5.0, 0.0, 0.0, 7.0, 0.0, -10.0], false)]
        {
            value["georeference"] =
                serde_json::json!({ "transform": transform, "epsg": 32611, "geographic": false, "nodata": null });
            fs::write(&beside, value.to_string()).unwrap();
            assert_eq!(read(&path).unwrap().georeference.is_some(), sound, "{format:?} {transform:?}");
        }
    }
}

#[cfg(unix)]
#[test]
fn a_link_to_itself_is_called_one() {
    let f = Fixture::new();
    let path = f.0.path().join("a.tif");
    std::os::unix::fs::symlink("a.tif", &path).unwrap();
    assert!(refused(&path).contains("leads to itself"));
}
