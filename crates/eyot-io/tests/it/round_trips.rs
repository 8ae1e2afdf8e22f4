//! What is written comes back: exactly for formats of floats, within half a step for those of 16 bits.

use eyot_core::{Boundary, Field, Georeference, Grid, LayerSpec, Limits, World, layer::known};
use eyot_io::storage::{Keep, Memory, write_bytes};
use eyot_io::{Raster, RasterFormat, ReadOptions, Sample, read_raster, write_layer};
use proptest::prelude::*;
use std::io::Cursor;
use std::path::Path;

fn world(width: usize, height: usize, values: &[f32]) -> World {
    let grid = Grid { cell_y_m: 7.5, ..Grid::new(width, height, 10.0, Boundary::CLOSED, &Limits::default()).unwrap() };
    let mut world = World::new(grid, 7);
    world.put(&known::HEIGHT, Field::from_slice(width, height, values).unwrap()).unwrap();
    world
}

fn there_and_back(world: &World, format: RasterFormat) -> Raster {
    let folder = tempfile::tempdir().unwrap();
    // No extension: the content, or the file beside it, must tell.
    let path = folder.path().join("raster");
    write_layer(&path, world, &world.layers()[0], format).unwrap();
    let there: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    let described = matches!(format, RasterFormat::R32 | RasterFormat::R16 | RasterFormat::Npy);
    assert_eq!(there.len(), if described { 2 } else { 1 }, "{there:?}");
    read(&path)
}

fn read(path: &Path) -> Raster {
    read_raster(path, &ReadOptions::default(), &Limits::default()).unwrap()
}

fn bits(field: &Field) -> Vec<u32> {
    field.iter().map(f32::to_bits).collect()
}

/// Sizes around tile and overview bounds, single rows and columns, with any finite values.
fn rasters() -> impl Strategy<Value = (usize, usize, Vec<f32>)> {
    let side = || prop_oneof![4 => 1usize..20, 1 => 255usize..260];
    let value = || {
        prop_oneof![
            6 => -12000.0f32..12000.0,
            1 => prop::num::f32::NORMAL | prop::num::f32::SUBNORMAL | prop::num::f32::ZERO,
            1 => Just(-9999.0f32),
            1 => Just(-0.0f32),
        ]
    };
    (side(), side()).prop_flat_map(move |(w, h)| {
        // A short random pattern repeated: sizes matter more than many independent values.
        prop::collection::vec(value(), 1..64).prop_map(move |p| (w, h, (0..w * h).map(|i| p[i % p.len()]).collect()))
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn formats_of_floats_are_exact((w, h, values) in rasters()) {
        let world = world(w, h, &values);
        for format in RasterFormat::ALL.into_iter().filter(|f| !f.is_quantised()) {
            let back = there_and_back(&world, format);
            prop_assert_eq!(bits(&back.field), bits(&world.layers()[0].field), "{:?}", format);
            prop_assert_eq!(back.filled(), 0);
            prop_assert_eq!(back.cell_m, Some((10.0, 7.5)));
        }
    }

    #[test]
    fn formats_of_16_bits_are_within_half_a_step((w, h, values) in rasters()) {
        let world = world(w, h, &values);
        let back = there_and_back(&world, RasterFormat::Png16);
        prop_assert_eq!(&there_and_back(&world, RasterFormat::R16).field, &back.field);
        let (min, max) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), &v| (a.min(v.into()), b.max(v.into())));
        // Half a step, and the rounding of the result to f32.
        let allowed = (max - min) / 65535.0 / 2.0 * 1.0001 + f64::from(f32::EPSILON) * min.abs().max(max.abs());
        for (a, b) in back.field.iter().zip(&values) {
            prop_assert!((f64::from(a) - f64::from(*b)).abs() <= allowed, "{} {} {}", a, b, allowed);
        }
        prop_assert_eq!(back.cell_m, Some((10.0, 7.5)));
    }
}

#[test]
fn every_format_writes_the_smallest_grids() {
    for (w, h) in [(1, 1), (3, 7), (1, 300), (300, 1)] {
        let values: Vec<f32> = (0..w * h).map(|i| i as f32 * 0.37 - 4.0).collect();
        let world = world(w, h, &values);
        for format in RasterFormat::ALL {
            let back = there_and_back(&world, format);
            assert_eq!((back.field.width(), back.field.height()), (w, h));
        }
    }
}

#[test]
fn a_flat_layer_keeps_its_level_in_png() {
    let back = there_and_back(&world(4, 3, &[12.25; 12]), RasterFormat::Png16);
    assert!(back.field.iter().all(|v| v == 12.25));
}

#[test]
fn georeferences_survive() {
    let projected = Georeference {
        transform: [500_010.0, 30.0, 0.0, 4_100_020.0, 0.0, -30.0],
        epsg: Some(32611),
        geographic: false,
        nodata: Some(-32768.0),
        ..Georeference::default()
    };
    let geographic = Georeference {
        transform: [-84.4, 1.0 / 1200.0, 0.0, 36.7, 0.0, -1.0 / 1200.0],
        epsg: Some(4326),
        geographic: true,
        nodata: Some(-9999.0),
        ..Georeference::default()
    };
    let rotated = Georeference { transform: [10.0, 28.0, 9.0, 20.0, 9.0, -28.0], ..projected.clone() };
    let values: Vec<f32> = (0..20 * 30).map(|i| (i % 37) as f32).collect();
    for g in [projected, geographic, rotated] {
        let mut world = world(20, 30, &values);
        world.georeference = Some(g.clone());
        for format in RasterFormat::ALL {
            let back = there_and_back(&world, format);
            let found = back.georeference.unwrap();
            assert_eq!((found.epsg, found.geographic, found.nodata), (g.epsg, g.geographic, g.nodata), "{format:?}");
            let (x, y) = back.cell_m.unwrap();
            assert!(x > 1.0 && y > 1.0);
            for (a, b) in found.transform.iter().zip(g.transform) {
                assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{format:?} {found:?}");
            }
        }
    }
}

#[test]
fn values_equal_to_the_nodata_value_are_not_lost() {
    let mut world = world(2, 2, &[-9999.0, f32::MIN, 1.0, 2.0]);
    for nodata in [None, Some(-9999.0), Some(f64::NAN)] {
        world.georeference =
            Some(Georeference { transform: [0.0, 1.0, 0.0, 0.0, 0.0, -1.0], nodata, ..Georeference::default() });
        let back = there_and_back(&world, RasterFormat::GeoTiff);
        assert_eq!(back.filled(), 0);
        assert_eq!(back.field, world.layers()[0].field);
    }
}

#[test]
fn layers_that_cannot_be_written_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut bad = world(3, 3, &[0.0; 9]);
    bad.layer_mut("height").unwrap().field.set(1, 2, f32::NAN);
    let mut foreign = world(3, 3, &[0.0; 9]);
    foreign.grid.width = 4;
    for world in [&bad, &foreign] {
        for format in RasterFormat::ALL {
            let e = write_layer(&folder.path().join("a"), world, &world.layers()[0], format).unwrap_err().to_string();
            assert!(e.contains("column 1, row 2") || e.contains("4x3"), "{e}");
        }
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn words_beyond_ascii_do_not_stop_an_export() {
    let mut world = world(2, 2, &[0.0, 1.0, 2.0, 3.0]);
    let spec = LayerSpec { meaning: "Höhe über dem Meer – 海拔".into(), unit: "m²".into(), ..known::HEIGHT };
    let field = world.remove("height").unwrap().field;
    world.put(&spec, field).unwrap();
    for format in RasterFormat::ALL {
        there_and_back(&world, format);
    }
}

#[test]
fn writers_and_readers_take_the_bytes_of_files() {
    let values: Vec<f32> = (0..300 * 20).map(|i| (i % 97) as f32).collect();
    let world = world(300, 20, &values);
    let folder = tempfile::tempdir().unwrap();
    for format in RasterFormat::ALL.into_iter().filter(|f| *f != RasterFormat::Zarr) {
        let path = folder.path().join(format!("height.{}", format.extension()));
        write_layer(&path, &world, &world.layers()[0], format).unwrap();
        let mut bytes = Vec::new();
        write_layer(&mut bytes, &world, &world.layers()[0], format).unwrap();
        assert!(std::fs::read(&path).unwrap() == bytes, "{format:?}");
        // What only a description beside it says of a file, nothing says of a stream.
        let size = (format.is_quantised() || format == RasterFormat::R32).then_some((300, 20));
        let sample = match format {
            RasterFormat::R32 => Some(Sample::Float(4)),
            RasterFormat::R16 => Some(Sample::Unsigned(2)),
            _ => None,
        };
        let options = ReadOptions { size, sample, low_m: Some(0.0), high_m: Some(96.0), ..ReadOptions::default() };
        let raster = read_raster(&mut Cursor::new(bytes), &options, &Limits::default()).unwrap();
        assert_eq!(bits(&raster.field), bits(&read_raster(&path, &options, &Limits::default()).unwrap().field));
        assert!(raster.field.iter().zip(&values).all(|(a, b)| (a - b).abs() < 0.01), "{format:?}");
    }
    let store = write_layer(&mut Vec::new(), &world, &world.layers()[0], RasterFormat::Zarr).unwrap_err().to_string();
    assert!(store.contains("more than one file"), "{store}");
    let empty = read_raster(&mut Cursor::new(Vec::new()), &ReadOptions::default(), &Limits::default()).unwrap_err();
    assert!(empty.to_string().contains("is empty"), "{empty}");
}

#[test]
fn masks_beside_images_are_found_in_storages_too() {
    let memory = Memory::new();
    let world = world(20, 10, &vec![5.0; 200]);
    write_layer((&memory, "a.tif"), &world, &world.layers()[0], RasterFormat::GeoTiff).unwrap();
    let read = || read_raster((&memory, "a.tif"), &ReadOptions::default(), &Limits::default());
    assert_eq!(read().unwrap().missing, None);
    write_bytes(&memory, "a.tif.msk", Keep::Whole, b"no mask").unwrap();
    assert!(read().unwrap_err().to_string().contains("a.tif.msk"));
}
