//! The real landscape in `data/`: an int16 GeoTIFF by another program, in geographic coordinates.

use eyot_core::Limits;
use eyot_io::{ReadOptions, read_raster};
use std::path::Path;

#[test]
fn jacksboro_is_read_with_its_cell_size_and_place() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../eyot-recipe/data/jacksboro.tif");
    let r = read_raster(&path, &ReadOptions::default(), &Limits::default()).unwrap();
    assert_eq!((r.field.width(), r.field.height(), r.filled()), (403, 344, 0));
    let (x, y) = r.cell_m.unwrap();
    // A degree at 36.3 N is 89.8 km and 110.97 km long.
    assert!((x - 74.84).abs() < 0.05 && (y - 92.47).abs() < 0.05, "{x} {y}");
    let g = r.georeference.unwrap();
    assert_eq!((g.epsg, g.geographic, g.nodata), (Some(4326), true, Some(-32768.0)));
    // The summit of Cross Mountain is the highest cell, and row 0 is north.
    let t = g.transform;
    let (column, row) = (((-84.2306 - t[0]) / t[1]) as usize, ((36.1983 - t[3]) / t[5]) as usize);
    let top = r.field.iter().fold(f32::MIN, f32::max);
    assert_eq!(top, 1076.0);
    let near = |i: usize| i - 1..=i + 1;
    assert!(near(row).any(|y| near(column).any(|x| r.field.get(x, y) == top)));
    assert_eq!([0, 1, 2].map(|x| r.field.get(x, 0)), [483.0, 487.0, 491.0]);
}
