//! Broken and hostile files: a clear error for each, never a panic and never a large allocation.

use eyot_core::Limits;
use eyot_io::{Raster, RasterFormat, ReadOptions, Result, read_raster, write_layer};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

struct Fixture(TempDir);

impl Fixture {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

fn read(path: &Path) -> Result<Raster> {
    read_raster(
        path,
        &ReadOptions {
            low_m: Some(0.0),
            high_m: Some(100.0),
            nodata: None,
        },
        &Limits::default(),
    )
}

/// The error's text; it must name the file.
fn refused(path: &Path) -> String {
    let text = read(path).expect_err(&path.display().to_string()).to_string();
    assert!(text.contains(path.file_name().unwrap().to_str().unwrap()), "{text}");
    text
}

// ---- hand-made files

fn png_chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut crc = crc32fast::Hasher::new();
    crc.update(kind);
    crc.update(data);
    [
        &(data.len() as u32).to_be_bytes(),
        &kind[..],
        data,
        &crc.finalize().to_be_bytes(),
    ]
    .concat()
}

/// A PNG header for an image of any size and colour type, without pixels.
fn png_header(width: u32, height: u32, depth: u8, colour: u8) -> Vec<u8> {
    let ihdr = [
        &width.to_be_bytes()[..],
        &height.to_be_bytes(),
        &[depth, colour, 0, 0, 0],
    ]
    .concat();
    [&b"\x89PNG\r\n\x1a\n"[..], &png_chunk(b"IHDR", &ihdr)].concat()
}

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
        let bytes = values
            .iter()
            .flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() })
            .collect();
        self.tags.push((tag, bytes, 12));
        self
    }

    fn shorts(mut self, tag: u16, values: &[u16]) -> Self {
        let big = self.big_endian;
        let bytes = values
            .iter()
            .flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() })
            .collect();
        self.tags.push((tag, bytes, 3));
        self
    }

    /// Classic TIFF: header, one directory, its values, one strip.
    fn bytes(&self) -> Vec<u8> {
        let w16 = |v: u16| {
            if self.big_endian {
                v.to_be_bytes()
            } else {
                v.to_le_bytes()
            }
        };
        let w32 = |v: u32| {
            if self.big_endian {
                v.to_be_bytes()
            } else {
                v.to_le_bytes()
            }
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
        let long_bytes: u32 = entries
            .iter()
            .map(|e| if e.2.len() > 4 { e.2.len() as u32 } else { 0 })
            .sum();
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

// ---- what is no raster

#[test]
fn what_is_no_raster_is_named() {
    let f = Fixture::new();
    assert!(refused(&f.file("empty.tif", b"")).contains("empty"));
    assert!(refused(&f.file("short.tif", b"II")).contains("no GeoTIFF, PNG or R32"));
    assert!(refused(&f.file("text.tif", b"hello there, this is text")).contains("no GeoTIFF, PNG or R32"));
    assert!(refused(&f.file("photo.png", &[0xff, 0xd8, 0xff, 0xe0, 0, 0, 0, 0])).contains("JPEG"));
    assert!(refused(&f.file("ascii.png", b"\x89PNG\n\x1a\n.....")).contains("as binary"));
    assert!(refused(&f.file("alone.r32", &[0; 16])).contains("alone.r32.json"));
    assert!(refused(&f.0.path().join("none.tif")).contains("check the name"));
    assert!(refused(f.0.path()).contains("a folder"));
    #[cfg(target_os = "linux")]
    assert!(refused(Path::new("/dev/zero")).contains("no ordinary file"));
}

// ---- PNG

#[test]
fn png_headers_that_claim_too_much_are_refused() {
    let f = Fixture::new();
    for (w, h) in [
        (1 << 31, 1),
        ((1 << 31) - 1, (1 << 31) - 1),
        (200_000, 200_000),
        (1, (1 << 31) - 1),
    ] {
        let e = refused(&f.file("bomb.png", &png_header(w, h, 16, 0)));
        assert!(e.contains("too large") || e.contains("broken PNG"), "{e}");
    }
    assert!(refused(&f.file("zero.png", &png_header(0, 5, 16, 0))).contains("broken PNG"));
}

#[test]
fn broken_and_coloured_pngs_are_refused() {
    let f = Fixture::new();
    let path = f.0.path().join("p.png");
    eyot_io::write_rgb_png(&path, 2, 2, &[[1, 2, 3]; 4]).unwrap();
    assert!(refused(&path).contains("colour image"));
    let whole = grey_png(&f, 8, &[0, 50, 100, 255]);
    for n in 8..whole.len() {
        // The last chunk and its checksum carry nothing; everything before must be there.
        if n < whole.len() - 12 {
            refused(&f.file("cut.png", &whole[..n]));
        }
    }
    for i in 8..whole.len() {
        let mut bytes = whole.clone();
        bytes[i] ^= 0x10;
        let _ = read(&f.file("flipped.png", &bytes));
    }
}

fn grey_png(f: &Fixture, depth: u8, samples: &[u8]) -> Vec<u8> {
    let path = f.0.path().join("grey.png");
    let mut e = png::Encoder::new(std::fs::File::create(&path).unwrap(), 2, 2);
    e.set_color(png::ColorType::Grayscale);
    e.set_depth(png::BitDepth::from_u8(depth).unwrap());
    e.write_header().unwrap().write_image_data(samples).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn grey_pngs_are_scaled_by_the_options() {
    let f = Fixture::new();
    let values = |path: &Path| read(path).unwrap().field.to_vec();
    assert_eq!(
        values(&f.file("8.png", &grey_png(&f, 8, &[0, 51, 102, 255]))),
        [0.0, 20.0, 40.0, 100.0]
    );
    assert_eq!(
        values(&f.file("16.png", &grey_png(&f, 16, &[0, 0, 0x33, 0x33, 0x66, 0x66, 255, 255]))),
        [0.0, 20.0, 40.0, 100.0]
    );
    assert_eq!(
        values(&f.file("1.png", &grey_png(&f, 1, &[0b0100_0000, 0b1000_0000]))),
        [0.0, 100.0, 100.0, 0.0]
    );
    let path = f.0.path().join("8.png");
    let open = read_raster(&path, &ReadOptions::default(), &Limits::default())
        .unwrap_err()
        .to_string();
    assert!(open.contains("low_m and high_m"), "{open}");
    let nan = ReadOptions {
        low_m: Some(f64::NAN),
        high_m: Some(1.0),
        nodata: None,
    };
    assert!(read_raster(&path, &nan, &Limits::default()).is_err());
}

// ---- TIFF

#[test]
fn tiff_headers_that_claim_too_much_are_refused() {
    let f = Fixture::new();
    for (w, h) in [
        (200_000, 200_000),
        (u32::MAX, u32::MAX),
        (1, 1 << 29),
        (1 << 29, 1),
        (30_000, 30_000),
        (0, 3),
        (3, 0),
    ] {
        for compression in [1, 5, 8, 32773] {
            let e = refused(
                &f.file(
                    "bomb.tif",
                    &Tiff {
                        compression,
                        ..Tiff::of(w, h, 32, 3, &[0; 64])
                    }
                    .bytes(),
                ),
            );
            let clear = ["too large", "cannot hold", "broken or truncated"]
                .iter()
                .any(|c| e.contains(c));
            assert!(clear, "{w}x{h}: {e}");
        }
    }
    // A small image in one monstrous tile.
    let tile = Tiff::of(4, 4, 32, 3, &[0; 64])
        .shorts(322, &[65520])
        .shorts(323, &[65520])
        .bytes();
    let _ = refused(&f.file("tile.tif", &tile));
}

#[test]
fn broken_tiffs_never_panic() {
    let f = Fixture::new();
    let whole = Tiff::of(3, 2, 16, 2, &[1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0])
        .nodata("3")
        .bytes();
    assert_eq!(read(&f.file("whole.tif", &whole)).unwrap().filled, 1);
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
    let grid = eyot_core::Grid::new(300, 270, 10.0, eyot_core::Rim::CLOSED, &Limits::default()).unwrap();
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
        (
            16,
            1,
            [1u16, 60_000].map(u16::to_le_bytes).concat(),
            [1u16, 60_000].map(u16::to_be_bytes).concat(),
        ),
        (
            16,
            2,
            [1i16, -500].map(i16::to_le_bytes).concat(),
            [1i16, -500].map(i16::to_be_bytes).concat(),
        ),
        (
            32,
            1,
            [1u32, 70_000].map(u32::to_le_bytes).concat(),
            [1u32, 70_000].map(u32::to_be_bytes).concat(),
        ),
        (
            32,
            2,
            [1i32, -70_000].map(i32::to_le_bytes).concat(),
            [1i32, -70_000].map(i32::to_be_bytes).concat(),
        ),
        (
            64,
            2,
            [1i64, -9].map(i64::to_le_bytes).concat(),
            [1i64, -9].map(i64::to_be_bytes).concat(),
        ),
        (
            32,
            3,
            [1f32, 0.25].map(f32::to_le_bytes).concat(),
            [1f32, 0.25].map(f32::to_be_bytes).concat(),
        ),
        (
            64,
            3,
            [1f64, 0.25].map(f64::to_le_bytes).concat(),
            [1f64, 0.25].map(f64::to_be_bytes).concat(),
        ),
    ];
    let second = [200.0, -56.0, 60_000.0, -500.0, 70_000.0, -70_000.0, -9.0, 0.25, 0.25];
    for ((bits, format, little, big), second) in samples.iter().zip(second) {
        for (data, big_endian) in [(little, false), (big, true)] {
            let mut tiff = Tiff {
                big_endian,
                ..Tiff::of(2, 1, *bits, *format, data)
            };
            tiff = tiff.nodata("-12345");
            let r = read(&f.file("n.tif", &tiff.bytes())).unwrap();
            assert_eq!(
                (r.field.to_vec(), r.filled, r.cell_m),
                (vec![1.0, second], 0, None),
                "{bits} {format} {big_endian}"
            );
        }
    }
    assert!(refused(&f.file("complex.tif", &Tiff::of(2, 1, 32, 5, &[0; 8]).bytes())).contains("complex.tif"));
    let rgb = Tiff {
        samples: 3,
        ..Tiff::of(1, 1, 8, 1, &[1, 2, 3])
    }
    .bytes();
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
        assert_eq!(r.filled, 1, "{text}");
        assert!((r.field.get(1, 0) - 2.0).abs() < 0.01);
    }
    let all = tiff(&[-1.0; 3]).nodata("-1").bytes();
    assert!(refused(&f.file("all.tif", &all)).contains("every cell is marked as missing"));
    let options = ReadOptions {
        nodata: Some(2.0),
        ..ReadOptions::default()
    };
    let path = f.file("own.tif", &tiff(&[1.0, 2.0, 3.0]).bytes());
    assert_eq!(read_raster(&path, &options, &Limits::default()).unwrap().filled, 1);
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
    assert_eq!(
        (r.cell_m, g.epsg, g.transform[0], g.transform[3]),
        (Some((30.0, 30.0)), Some(32633), -5.0, 61.0)
    );
    // From south to north, from east to west.
    let m = [
        -5.0, 0.0, 0.0, 100.0, 0.0, 20.0, 0.0, 7.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
    ];
    let turned = Tiff::of(2, 2, 32, 3, &floats(&[1.0, 2.0, 3.0, 4.0]))
        .doubles(34264, &m)
        .bytes();
    let r = read(&f.file("t.tif", &turned)).unwrap();
    assert_eq!(r.field.to_vec(), [4.0, 3.0, 2.0, 1.0]);
    assert_eq!(
        (r.cell_m, r.georeference.unwrap().transform),
        (Some((5.0, 20.0)), [90.0, 5.0, 0.0, 47.0, 0.0, -20.0])
    );
    // A transform without extent says nothing.
    let flat = base(&[0.0; 4]).doubles(33550, &[0.0, 0.0, 0.0]).bytes();
    assert_eq!(read(&f.file("f.tif", &flat)).unwrap().cell_m, None);
}

// ---- R32

#[test]
fn r32_and_its_description_must_agree() {
    let f = Fixture::new();
    let path = f.file("a.r32", &floats(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    let describe = |json: &str| f.file("a.r32.json", json.as_bytes());
    describe(r#"{"format": "r32", "width": 3, "height": 2}"#);
    assert_eq!(read(&path).unwrap().field.to_vec(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    describe(r#"{"format": "r32", "width": 3, "height": 2, "row_order": "south to north"}"#);
    assert_eq!(read(&path).unwrap().field.to_vec(), [4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
    for (json, part) in [
        (
            r#"{"format": "r32", "width": 3, "height": 3}"#,
            "36 bytes, the file has 24",
        ),
        (r#"{"format": "r32", "width": 0, "height": 3}"#, "0x3"),
        (
            r#"{"format": "r32", "width": 4000000000, "height": 4000000000}"#,
            "too large",
        ),
        (
            r#"{"format": "r32", "width": 18446744073709551615, "height": 18446744073709551615}"#,
            "too large",
        ),
        (r#"{"format": "r32", "width": -3, "height": 2}"#, "not a description"),
        (
            r#"{"format": "r32", "width": 3, "height": 2, "crc32": "00000000"}"#,
            "checksum",
        ),
        (
            r#"{"format": "r32", "width": 3, "height": 2, "byte_order": "middle"}"#,
            "not a description",
        ),
        ("{", "not a description"),
    ] {
        describe(json);
        assert!(refused_by(&path).contains(part), "{json}: {}", refused_by(&path));
    }
    assert!(refused(&describe("{}")).contains("JSON"));
    f.file("a.r32", &floats(&[1.0, f32::INFINITY, 3.0, 4.0, 5.0, 6.0]));
    describe(r#"{"format": "r32", "width": 3, "height": 2}"#);
    assert!(refused(&path).contains("column 1, row 0"));
}

fn refused_by(path: &Path) -> String {
    read(path).unwrap_err().to_string()
}

/// Narrow grids take far more memory than their cells: rows are padded.
#[test]
fn the_padding_of_narrow_grids_counts_against_the_limit() {
    let f = Fixture::new();
    let path = f.file("n.r32", &[0; 4 * 5000]);
    f.file("n.r32.json", br#"{"format": "r32", "width": 1, "height": 5000}"#);
    let limits = Limits {
        max_bytes: 1 << 20,
        ..Limits::default()
    };
    let e = read_raster(&path, &ReadOptions::default(), &limits)
        .unwrap_err()
        .to_string();
    assert!(e.contains("too large"), "{e}");
}
