//! Cells without a value stay so from a GeoTIFF or a Zarr store into another, however the file lies.

use eyot_core::{Field, Limits};
use eyot_io::{About, Raster, RasterFormat, ReadOptions, WriteOptions, read_raster, write_rows};
use std::path::Path;

/// A slope with a round hole and a missing corner, larger than a tile.
fn holed() -> Raster {
    let (width, height) = (300, 270);
    let gone = |i: usize| {
        let (x, y) = (i % width, i / width);
        (x < 3 && y < 2) || (x as f64 - 200.0).hypot(y as f64 - 100.0) < 40.0
    };
    let missing = (0..width * height).map(gone).collect();
    Raster { missing: Some(missing), ..Raster::of(Field::from_fn(width, height, |x, y| (x + 2 * y) as f32)) }
}

fn through(raster: &Raster, path: &Path, format: RasterFormat) -> Raster {
    let about = About { name: "height".into(), unit: "m".into(), ..raster.about() };
    write_rows(path, &mut raster.rows(), &about, format, &WriteOptions::default()).unwrap();
    read_raster(path, &ReadOptions::default(), &Limits::default()).unwrap()
}

#[test]
fn missing_cells_stay_missing() {
    let folder = tempfile::tempdir().unwrap();
    let raster = holed();
    for (format, file) in [(RasterFormat::GeoTiff, "a.tif"), (RasterFormat::Zarr, "a.zarr")] {
        let back = through(&raster, &folder.path().join(file), format);
        assert_eq!(back.missing, raster.missing, "{format:?}");
        let marks = raster.missing.as_ref().unwrap();
        for (i, gone) in marks.iter().enumerate().filter(|(_, gone)| !**gone) {
            let (x, y) = (i % 300, i / 300);
            assert!(!gone && back.field.get(x, y) == raster.field.get(x, y), "{format:?} at {x}, {y}");
        }
        // And through the other one.
        let (other, file) = match format {
            RasterFormat::GeoTiff => (RasterFormat::Zarr, "b.zarr"),
            _ => (RasterFormat::GeoTiff, "b.tif"),
        };
        assert_eq!(through(&back, &folder.path().join(file), other).missing, raster.missing, "{format:?} {other:?}");
    }
}

#[test]
fn other_formats_hold_the_filled_values() {
    let folder = tempfile::tempdir().unwrap();
    let raster = holed();
    let back = through(&raster, &folder.path().join("a.npy"), RasterFormat::Npy);
    assert_eq!((back.missing, back.field), (None, raster.field));
}

/// What cannot be seen is no height: painters cut coasts out like this.
#[test]
fn transparent_cells_of_a_png_are_missing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    for wide in [1, 2] {
        let mut encoder = png::Encoder::new(std::fs::File::create(&path).unwrap(), 3, 2);
        encoder.set_color(png::ColorType::GrayscaleAlpha);
        encoder.set_depth(if wide == 2 { png::BitDepth::Sixteen } else { png::BitDepth::Eight });
        // A height and how much of it is seen, six times.
        let cells = [(10, 255), (10, 0), (10, 1), (30, 255), (200, 0), (30, 128)];
        let bytes: Vec<u8> = cells.iter().flat_map(|&(v, a)| [[v].repeat(wide), [a].repeat(wide)].concat()).collect();
        encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
        let options = ReadOptions { low_m: Some(0.0), high_m: Some(255.0), ..ReadOptions::default() };
        let raster = read_raster(&path, &options, &Limits::default()).unwrap();
        assert_eq!(raster.missing, Some(vec![false, true, false, false, true, false]));
        assert!(raster.field.get(1, 1) < 31.0, "the value of a hidden cell counts");
    }
}

/// A file that GDAL has written (`tests/gis/make.py`).
fn foreign(name: &str, options: &ReadOptions) -> Result<Raster, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gis").join(name);
    read_raster(&path, options, &Limits::default()).map_err(|e| e.to_string())
}

#[test]
fn a_mask_inside_the_file_marks_cells() {
    let raster = foreign("masked.tif", &ReadOptions::default()).unwrap();
    let corner: Vec<bool> = (0..120).map(|i| i % 12 < 3 && i / 12 < 2).collect();
    assert_eq!(raster.missing, Some(corner));
    assert_eq!((raster.field.get(3, 0), raster.suspect()), (115.0, None));
}

#[test]
fn one_of_several_bands_is_read() {
    let of = |band| foreign("bands.tif", &ReadOptions { band, ..ReadOptions::default() });
    assert!(of(None).unwrap_err().contains("2 bands"));
    assert!(of(Some(0)).is_err() && of(Some(3)).is_err());
    assert_eq!(of(Some(1)).unwrap().field.min_max(), (7.0, 7.0));
    assert_eq!(of(Some(2)).unwrap().field.min_max(), (100.0, 182.0));
}

#[test]
fn numbers_that_usually_mark_missing_cells_are_suspect_until_they_do() {
    let of = |name, nodata| foreign(name, &ReadOptions { nodata, ..ReadOptions::default() }).unwrap();
    assert_eq!(of("untagged.tif", None).suspect(), Some((-9999.0, 6)));
    assert_eq!(of("beyond.tif", None).suspect(), Some((f32::MIN, 6)));
    for (name, mark) in [("untagged.tif", -9999.0), ("beyond.tif", -3.4028235e38)] {
        let said = of(name, Some(mark));
        assert_eq!((said.filled(), said.suspect()), (6, None), "{name}");
    }
}

/// A plain TIFF of bytes with so many bands, a strip and no compression.
fn bytes_as_tiff(width: u16, height: u16, bands: u16, values: &[u8]) -> Vec<u8> {
    let mut out = b"II*\0\x08\0\0\0".to_vec();
    let short = |tag: u16, v: u32| (tag, 3_u16, v);
    let count = values.len() as u32;
    let entries = [
        short(256, width.into()),
        short(257, height.into()),
        short(258, 8),
        short(259, 1),
        short(262, 1),
        (273, 4, 8 + 2 + 10 * 12 + 4),
        short(277, bands.into()),
        short(278, height.into()),
        (279, 4, count),
        short(284, 1),
    ];
    out.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, value) in entries {
        out.extend(tag.to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend(1_u32.to_le_bytes());
        out.extend(value.to_le_bytes());
    }
    out.extend([0; 4]);
    out.extend(values);
    out
}

/// GDAL keeps masks beside files that have no room for one.
#[test]
fn a_mask_beside_the_file_counts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    std::fs::write(&path, bytes_as_tiff(3, 2, 1, &[10, 20, 30, 40, 50, 60])).unwrap();
    let read = || {
        read_raster(
            &path,
            &ReadOptions { low_m: Some(0.0), high_m: Some(255.0), ..ReadOptions::default() },
            &Limits::default(),
        )
    };
    assert_eq!(read().unwrap().missing, None);
    let mask = folder.path().join("a.tif.msk");
    std::fs::write(&mask, bytes_as_tiff(3, 2, 1, &[255, 255, 0, 255, 1, 255])).unwrap();
    let raster = read().unwrap();
    assert_eq!(raster.missing, Some(vec![false, false, true, false, false, false]));
    // Filled from around, and not with what stood there.
    assert_ne!(raster.field.get(2, 0), 30.0);
    assert_eq!(raster.field.get(1, 1), 50.0);
    // One that belongs to another image is no mask of this one.
    std::fs::write(&mask, bytes_as_tiff(2, 2, 1, &[255, 255, 0, 255])).unwrap();
    let refused = read().unwrap_err().to_string();
    assert!(refused.contains("a.tif.msk") && refused.contains("does not fit"), "{refused}");
}
