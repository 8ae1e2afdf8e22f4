//! Broken, hostile and merely unusual TIFF files, made by hand.

use crate::common;

use common::{Fixture, read, refused};
use eyot_core::{CoordinateSystem, Limits};
use eyot_io::{RasterFormat, ReadOptions, WriteOptions, read_raster, write_layer, write_rows};

#[derive(Clone)]
struct Tiff {
    width: u32,
    height: u32,
    bits: u32,
    /// 1 unsigned, 2 signed, 3 floating point, 5 complex integer.
    format: u32,
    samples: u32,
    compression: u32,
    tags: Vec<(u16, Vec<u8>, u16)>,
    data: Vec<u8>,
    big_endian: bool,
}

impl Tiff {
    fn of(width: u32, height: u32, bits: u32, format: u32, data: &[u8]) -> Self {
        Self {
            width,
            height,
            bits,
            format,
            samples: 1,
            compression: 1,
            tags: vec![],
            data: data.to_vec(),
            big_endian: false,
        }
    }

    fn nodata(mut self, text: &str) -> Self {
        self.tags.push((42113, [text.as_bytes(), b"\0"].concat(), 2));
        self
    }

    fn doubles(mut self, tag: u16, values: &[f64]) -> Self {
        let big = self.big_endian;
        let bytes = values.iter().flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() }).collect();
        self.tags.push((tag, bytes, 12));
        self
    }

    fn shorts(mut self, tag: u16, values: &[u16]) -> Self {
        let big = self.big_endian;
        let bytes = values.iter().flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() }).collect();
        self.tags.push((tag, bytes, 3));
        self
    }

    /// Classic TIFF: header, one directory, its values, one strip.
    fn bytes(&self) -> Vec<u8> {
        let w16 = |v: u16| {
            if self.big_endian { v.to_be_bytes() } else { v.to_le_bytes() }
        };
        let w32 = |v: u32| {
            if self.big_endian { v.to_be_bytes() } else { v.to_le_bytes() }
        };
        let longs = [
            (256, self.width),
            (257, self.height),
            (258, self.bits),
            (259, self.compression),
            (262, 1),
            (273, 0),
            (277, self.samples),
            (278, self.height),
            (279, self.data.len() as u32),
            (339, self.format),
        ];
        let mut entries: Vec<(u16, u16, Vec<u8>)> = longs.iter().map(|&(t, v)| (t, 4, w32(v).to_vec())).collect();
        entries.extend(self.tags.iter().map(|(t, b, kind)| (*t, *kind, b.clone())));
        entries.sort_by_key(|e| e.0);
        let after = 8 + 2 + 12 * entries.len() as u32 + 4;
        let mut values: Vec<u8> = Vec::new();
        let mut directory = w16(entries.len() as u16).to_vec();
        let long_bytes: u32 = entries.iter().map(|e| if e.2.len() > 4 { e.2.len() as u32 } else { 0 }).sum();
        for (tag, kind, bytes) in &entries {
            let size = match kind {
                2 => 1,
                3 => 2,
                12 => 8,
                _ => 4,
            };
            directory.extend([w16(*tag), w16(*kind)].concat());
            directory.extend(w32((bytes.len() / size) as u32));
            if *tag == 273 {
                directory.extend(w32(after + long_bytes));
            } else if bytes.len() > 4 {
                directory.extend(w32(after + values.len() as u32));
                values.extend(bytes);
            } else {
                let mut short = bytes.clone();
                short.resize(4, 0);
                directory.extend(short);
            }
        }
        directory.extend(w32(0));
        let magic: &[u8] = if self.big_endian { b"MM\0*" } else { b"II*\0" };
        [magic, &w32(8), &directory, &values, &self.data].concat()
    }
}

#[test]
fn tiff_headers_that_claim_too_much_are_refused() {
    let f = Fixture::new();
    for (w, h) in
        [(200_000, 200_000), (u32::MAX, u32::MAX), (1, 1 << 29), (1 << 29, 1), (30_000, 30_000), (0, 3), (3, 0)]
    {
        for compression in [1, 5, 8, 32773] {
            let e = refused(&f.file("bomb.tif", &Tiff { compression, ..Tiff::of(w, h, 32, 3, &[0; 64]) }.bytes()));
            let clear = ["too large", "cannot hold", "broken or truncated"].iter().any(|c| e.contains(c));
            assert!(clear, "{w}x{h}: {e}");
            assert!(!e.contains("too large") || e.contains("is the file damaged?"), "{e}");
        }
    }
    // A small image in one monstrous tile.
    let tile = Tiff::of(4, 4, 32, 3, &[0; 64]).shorts(322, &[65520]).shorts(323, &[65520]).bytes();
    let _ = refused(&f.file("tile.tif", &tile));
}

#[test]
fn broken_tiffs_never_panic() {
    let f = Fixture::new();
    let whole = Tiff::of(3, 2, 16, 2, &[1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0]).nodata("3").bytes();
    assert_eq!(read(&f.file("whole.tif", &whole)).unwrap().filled(), 1);
    for n in 8..whole.len() {
        refused(&f.file("cut.tif", &whole[..n]));
    }
    for i in 4..whole.len() {
        for bit in 0..8 {
            let mut bytes = whole.clone();
            bytes[i] ^= 1 << bit;
            let _ = read(&f.file("flipped.tif", &bytes));
        }
    }
    // The directory points at itself or beyond the end.
    for offset in [4u32, 8, 9, 1 << 20, u32::MAX] {
        let mut bytes = whole.clone();
        bytes[4..8].copy_from_slice(&offset.to_le_bytes());
        let _ = read(&f.file("loop.tif", &bytes));
    }
}

#[test]
fn damaged_cogs_never_panic() {
    let f = Fixture::new();
    let grid = eyot_core::Grid::new(300, 270, 10.0, eyot_core::Boundary::CLOSED, &Limits::default()).unwrap();
    let mut world = eyot_core::World::new(grid, 1);
    let field = eyot_core::Field::from_fn(300, 270, |x, y| (x * y) as f32 * 0.01);
    world.put(&eyot_core::layer::known::HEIGHT, field).unwrap();
    let path = f.0.path().join("cog.tif");
    write_layer(&path, &world, &world.layers()[0], RasterFormat::GeoTiff).unwrap();
    let whole = std::fs::read(&path).unwrap();
    for i in (0..whole.len()).step_by(97).chain(0..1200) {
        let mut bytes = whole.clone();
        bytes[i] ^= 0xff;
        let _ = read(&f.file("flipped.tif", &bytes));
    }
    for part in 1..40 {
        refused(&f.file("cut.tif", &whole[..whole.len() * part / 40]));
    }
}

#[test]
fn all_number_types_and_byte_orders_are_read() {
    let f = Fixture::new();
    let samples: &[(u32, u32, Vec<u8>, Vec<u8>)] = &[
        (8, 1, vec![1, 200], vec![1, 200]),
        (8, 2, vec![1, 200], vec![1, 200]),
        (16, 1, [1u16, 60_000].map(u16::to_le_bytes).concat(), [1u16, 60_000].map(u16::to_be_bytes).concat()),
        (16, 2, [1i16, -500].map(i16::to_le_bytes).concat(), [1i16, -500].map(i16::to_be_bytes).concat()),
        (32, 1, [1u32, 70_000].map(u32::to_le_bytes).concat(), [1u32, 70_000].map(u32::to_be_bytes).concat()),
        (32, 2, [1i32, -70_000].map(i32::to_le_bytes).concat(), [1i32, -70_000].map(i32::to_be_bytes).concat()),
        (64, 2, [1i64, -9].map(i64::to_le_bytes).concat(), [1i64, -9].map(i64::to_be_bytes).concat()),
        (32, 3, [1f32, 0.25].map(f32::to_le_bytes).concat(), [1f32, 0.25].map(f32::to_be_bytes).concat()),
        (64, 3, [1f64, 0.25].map(f64::to_le_bytes).concat(), [1f64, 0.25].map(f64::to_be_bytes).concat()),
    ];
    let second = [200.0, -56.0, 60_000.0, -500.0, 70_000.0, -70_000.0, -9.0, 0.25, 0.25];
    for ((bits, format, little, big), second) in samples.iter().zip(second) {
        for (data, big_endian) in [(little, false), (big, true)] {
            let mut tiff = Tiff { big_endian, ..Tiff::of(2, 1, *bits, *format, data) };
            tiff = tiff.nodata("-12345");
            let r = read(&f.file("n.tif", &tiff.bytes())).unwrap();
            assert_eq!(
                (r.field.to_vec(), r.filled(), r.cell_m),
                (vec![1.0, second], 0, None),
                "{bits} {format} {big_endian}"
            );
        }
    }
    assert!(refused(&f.file("complex.tif", &Tiff::of(2, 1, 32, 5, &[0; 8]).bytes())).contains("complex.tif"));
    let rgb = Tiff { samples: 3, ..Tiff::of(1, 1, 8, 1, &[1, 2, 3]) }.bytes();
    let _ = refused(&f.file("rgb.tif", &rgb));
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

#[test]
fn missing_cells_are_filled_and_numbers_that_are_not_finite_are_refused() {
    let f = Fixture::new();
    let tiff = |values: &[f32]| Tiff::of(3, 1, 32, 3, &floats(values));
    let e = refused(&f.file("nan.tif", &tiff(&[1.0, f32::NAN, 3.0]).bytes()));
    assert!(e.contains("column 1, row 0") && e.contains("NaN"), "{e}");
    let e = refused(&f.file("inf.tif", &tiff(&[1.0, 2.0, f32::NEG_INFINITY]).bytes()));
    assert!(e.contains("column 2, row 0"), "{e}");
    // f64 values beyond f32.
    let huge = Tiff::of(2, 1, 64, 3, &[1.0f64, 1e300].map(f64::to_le_bytes).concat());
    assert!(refused(&f.file("huge.tif", &huge.bytes())).contains("column 1"));

    for (text, marker) in [
        ("nan", f32::NAN),
        ("-9999", -9999.0),
        (" -9999.0 ", -9999.0),
        ("-3.4028234663852886e+38", f32::MIN),
        ("-3.40282e+38", -3.40282e38),
    ] {
        let r = read(&f.file("holes.tif", &tiff(&[1.0, marker, 3.0]).nodata(text).bytes())).unwrap();
        assert_eq!(r.filled(), 1, "{text}");
        assert!((r.field.get(1, 0) - 2.0).abs() < 0.01);
    }
    let all = tiff(&[-1.0; 3]).nodata("-1").bytes();
    assert!(refused(&f.file("all.tif", &all)).contains("every cell is marked as missing"));
    let options = ReadOptions { nodata: Some(2.0), ..ReadOptions::default() };
    let path = f.file("own.tif", &tiff(&[1.0, 2.0, 3.0]).bytes());
    assert_eq!(read_raster(&path, &options, &Limits::default()).unwrap().filled(), 1);
}

#[test]
fn cell_sizes_come_from_the_georeference() {
    let f = Fixture::new();
    let base =
        |values: &[f32]| Tiff::of(2, 2, 32, 3, &floats(values)).doubles(33922, &[0.0, 0.0, 0.0, 10.0, 46.0, 0.0]);
    // Geographic, a tenth of a degree at 45.9 N.
    let geographic = base(&[1.0, 2.0, 3.0, 4.0]).doubles(33550, &[0.1, 0.1, 0.0]);
    let geographic = geographic.shorts(34735, &[1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326]);
    let r = read(&f.file("g.tif", &geographic.bytes())).unwrap();
    let (x, y) = r.cell_m.unwrap();
    assert!((x - 7760.0).abs() < 10.0 && (y - 11114.9).abs() < 1.0, "{x} {y}");
    let g = r.georeference.unwrap();
    assert_eq!((g.epsg, g.geographic, g.transform[0]), (Some(4326), true, 10.0));
    // Pixel-is-point: the same tie point names the middle of the cell.
    let point = base(&[0.0; 4]).doubles(33550, &[30.0, 30.0, 0.0]);
    let point = point.shorts(34735, &[1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 2, 3072, 0, 1, 32633]);
    let r = read(&f.file("p.tif", &point.bytes())).unwrap();
    let g = r.georeference.unwrap();
    assert_eq!((r.cell_m, g.epsg, g.transform[0], g.transform[3]), (Some((30.0, 30.0)), Some(32633), -5.0, 61.0));
    // From south to north, from east to west.
    let m = [-5.0, 0.0, 0.0, 100.0, 0.0, 20.0, 0.0, 7.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let turned = Tiff::of(2, 2, 32, 3, &floats(&[1.0, 2.0, 3.0, 4.0])).doubles(34264, &m).bytes();
    let r = read(&f.file("t.tif", &turned)).unwrap();
    assert_eq!(r.field.to_vec(), [4.0, 3.0, 2.0, 1.0]);
    assert_eq!((r.cell_m, r.georeference.unwrap().transform), (Some((5.0, 20.0)), [90.0, 5.0, 0.0, 47.0, 0.0, -20.0]));
    // A transform without extent says nothing.
    let flat = base(&[0.0; 4]).doubles(33550, &[0.0, 0.0, 0.0]).bytes();
    assert_eq!(read(&f.file("f.tif", &flat)).unwrap().cell_m, None);
}

fn keyed(directory: &[u16]) -> Tiff {
    let tiff = Tiff::of(2, 2, 32, 3, &floats(&[1.0, 2.0, 3.0, 4.0]));
    let tiff = tiff.doubles(33922, &[0.0, 0.0, 0.0, 10.0, 46.0, 0.0]).doubles(33550, &[30.0, 30.0, 0.0]);
    tiff.shorts(34735, directory)
}

/// What an EPSG code does not say of a coordinate system goes along as it stands, and broken keys do not.
#[test]
fn keys_beyond_a_code_are_carried() {
    let f = Fixture::new();
    let system = |tiff: Tiff| read(&f.file("k.tif", &tiff.bytes())).unwrap().georeference.unwrap().system;
    // All of this the code says, or nothing says anything.
    for plain in [
        &[1, 1, 0, 4, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32633, 3076, 0, 1, 9001][..],
        &[1, 1, 0, 4, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326, 2054, 0, 1, 9102],
        &[1, 1, 0, 1, 1025, 0, 1, 1],
    ] {
        assert_eq!(system(keyed(plain)), None, "{plain:?}");
    }
    // A projection by its parameters; the place has been moved from middles to corners, and so the keys say corners.
    let own = keyed(&[1, 1, 0, 4, 1024, 0, 1, 1, 1025, 0, 1, 2, 3072, 0, 1, 32767, 3078, 34736, 1, 1]);
    match system(own.clone().doubles(34736, &[0.5, 29.5])) {
        Some(CoordinateSystem::GeoKeys { directory, doubles, .. }) => {
            assert_eq!((directory[11], directory[15], &doubles[..]), (1, 32767, &[0.5, 29.5][..]));
        }
        other => panic!("{other:?}"),
    }
    // Its number is not there, and a directory that is too short.
    assert_eq!(system(own.doubles(34736, &[0.5])), None);
    let short = read(&f.file("k.tif", &keyed(&[1, 1, 0, 9, 1024, 0, 1, 1]).bytes()));
    assert!(short.is_err() || short.unwrap().georeference.is_none_or(|g| g.system.is_none()));
    // Heights in feet above a datum, and cells in feet of a code: both come back from a file of ours.
    let feet = keyed(&[1, 1, 0, 4, 1024, 0, 1, 1, 3072, 0, 1, 2225, 3076, 0, 1, 9003, 4099, 0, 1, 9002]);
    let mut r = read(&f.file("k.tif", &feet.bytes())).unwrap();
    let copy = f.0.path().join("copy.tif");
    write_rows(&copy, &mut r.rows(), &r.about(), RasterFormat::GeoTiff, &WriteOptions::default()).unwrap();
    let back = read(&copy).unwrap();
    let (side, (x, y)) = (30.0 * 1200.0 / 3937.0, r.cell_m.unwrap());
    assert!((x - side).abs() < 1e-12 && (y - side).abs() < 1e-12 && r.unit == "ft", "{x} {y} {}", r.unit);
    assert_eq!((&back.unit, back.cell_m), (&r.unit, r.cell_m));
    let (here, there) = (r.georeference.clone().unwrap(), back.georeference.unwrap());
    assert_eq!((here.epsg, here.system, here.transform), (there.epsg, there.system, there.transform));
    assert!(r.to_metres() && !r.to_metres());
    assert_eq!((r.field.to_vec(), &*r.unit), ([0.3048, 0.6096, 0.9144, 1.2192].map(|v: f64| v as f32).to_vec(), "m"));
}
