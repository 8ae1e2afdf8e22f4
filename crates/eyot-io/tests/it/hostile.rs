//! Broken and hostile files: a clear error for each, never a panic and never a large allocation.
//!
//! TIFF, which can go wrong in more ways than all others, has its own file.

use crate::common;

use common::{Fixture, read, refused};
use eyot_core::Limits;
use eyot_io::{ReadOptions, read_raster};
use std::path::Path;

fn png_chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut crc = crc32fast::Hasher::new();
    crc.update(kind);
    crc.update(data);
    [&(data.len() as u32).to_be_bytes(), &kind[..], data, &crc.finalize().to_be_bytes()].concat()
}

/// A PNG header for an image of any size and colour type, without pixels.
fn png_header(width: u32, height: u32, depth: u8, colour: u8) -> Vec<u8> {
    let ihdr = [&width.to_be_bytes()[..], &height.to_be_bytes(), &[depth, colour, 0, 0, 0]].concat();
    [&b"\x89PNG\r\n\x1a\n"[..], &png_chunk(b"IHDR", &ihdr)].concat()
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

// ---- what is no raster

#[test]
fn what_is_no_raster_is_named() {
    let f = Fixture::new();
    assert!(refused(&f.file("empty.tif", b"")).contains("empty"));
    assert!(refused(&f.file("short.tif", b"II")).contains("no GeoTIFF, PNG, EXR, NPY"));
    assert!(refused(&f.file("text.tif", b"hello there, this is text")).contains("no GeoTIFF, PNG, EXR, NPY"));
    assert!(refused(&f.file("photo.png", &[0xff, 0xd8, 0xff, 0xe0, 0, 0, 0, 0])).contains("JPEG"));
    assert!(refused(&f.file("ascii.png", b"\x89PNG\n\x1a\n.....")).contains("as binary"));
    // A square needs no description of its size, anything else does.
    assert_eq!(read(&f.file("square.r32", &[0; 16])).unwrap().field.width(), 2);
    let e = refused(&f.file("alone.r32", &[0; 20]));
    assert!(e.contains("alone.r32.json") && e.contains("input_size"), "{e}");
    assert!(refused(&f.0.path().join("none.tif")).contains("check the name"));
    assert!(refused(f.0.path()).contains("a folder"));
    #[cfg(target_os = "linux")]
    assert!(refused(Path::new("/dev/zero")).contains("no ordinary file"));
}

// ---- PNG

#[test]
fn png_headers_that_claim_too_much_are_refused() {
    let f = Fixture::new();
    for (w, h) in [(1 << 31, 1), ((1 << 31) - 1, (1 << 31) - 1), (200_000, 200_000), (1, (1 << 31) - 1)] {
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
    assert_eq!(values(&f.file("8.png", &grey_png(&f, 8, &[0, 51, 102, 255]))), [0.0, 20.0, 40.0, 100.0]);
    assert_eq!(
        values(&f.file("16.png", &grey_png(&f, 16, &[0, 0, 0x33, 0x33, 0x66, 0x66, 255, 255]))),
        [0.0, 20.0, 40.0, 100.0]
    );
    assert_eq!(values(&f.file("1.png", &grey_png(&f, 1, &[0b0100_0000, 0b1000_0000]))), [0.0, 100.0, 100.0, 0.0]);
    let path = f.0.path().join("8.png");
    let open = read_raster(&path, &ReadOptions::default(), &Limits::default()).unwrap_err().to_string();
    assert!(open.contains("low_m and high_m"), "{open}");
    let nan = ReadOptions { low_m: Some(f64::NAN), high_m: Some(1.0), ..ReadOptions::default() };
    assert!(read_raster(&path, &nan, &Limits::default()).is_err());
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
        (r#"{"format": "r32", "width": 3, "height": 3}"#, "36 bytes, the file has 24"),
        (r#"{"format": "r32", "width": 0, "height": 3}"#, "0x3"),
        (r#"{"format": "r32", "width": 4000000000, "height": 4000000000}"#, "too large"),
        (r#"{"format": "r32", "width": 18446744073709551615, "height": 18446744073709551615}"#, "too large"),
        (r#"{"format": "r32", "width": -3, "height": 2}"#, "not a description"),
        (r#"{"format": "r32", "width": 3, "height": 2, "crc32": "00000000"}"#, "checksum"),
        (r#"{"format": "r32", "width": 3, "height": 2, "byte_order": "middle"}"#, "not a description"),
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
    let limits = Limits { max_bytes: 1 << 20, ..Limits::default() };
    let e = read_raster(&path, &ReadOptions::default(), &limits).unwrap_err().to_string();
    assert!(e.contains("too large"), "{e}");
}
