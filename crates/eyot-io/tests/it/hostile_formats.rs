//! Broken and hostile R16, NPY, EXR and Zarr: a clear error for each, never a panic and never a large allocation.

use crate::common;

use common::{Fixture, read, refused};
use eyot_core::{Field, Grid, Limits, Rim, World, layer::known};
use eyot_io::{RasterFormat, ReadOptions, Sample, read_raster, write_layer};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

fn world(w: usize, h: usize) -> World {
    let mut world = World::new(Grid::new(w, h, 10.0, Rim::CLOSED, &Limits::default()).unwrap(), 1);
    world.put(&known::HEIGHT, Field::from_fn(w, h, |x, y| (x * 7 + y) as f32 * 0.5)).unwrap();
    world
}

fn written(f: &Fixture, name: &str, format: RasterFormat) -> PathBuf {
    let world = world(40, 30);
    let path = f.0.path().join(name);
    write_layer(&path, &world, &world.layers()[0], format).unwrap();
    path
}

// ---- headerless numbers

#[test]
fn raw_files_without_a_description_need_flags() {
    let f = Fixture::new();
    let path = f.file("a.r16", &[0; 2 * 12]);
    let open = |o: &ReadOptions| read_raster(&path, o, &Limits::default());
    let e = open(&ReadOptions::default()).unwrap_err().to_string();
    assert!(e.contains("input_size"), "{e}");
    let sized = ReadOptions { size: Some((4, 3)), ..ReadOptions::default() };
    let e = open(&sized).unwrap_err().to_string();
    assert!(e.contains("input_range"), "{e}");
    let whole = ReadOptions { low_m: Some(5.0), high_m: Some(6.0), ..sized.clone() };
    assert!(open(&whole).unwrap().field.iter().all(|v| v == 5.0));
    let e = open(&ReadOptions { size: Some((5, 3)), ..whole.clone() }).unwrap_err().to_string();
    assert!(e.contains("need 30 bytes, the file has 24"), "{e}");
    let e = open(&ReadOptions { size: Some((usize::MAX, usize::MAX)), ..whole.clone() }).unwrap_err().to_string();
    assert!(e.contains("too large"), "{e}");
    let e = open(&ReadOptions { high_m: Some(f64::INFINITY), ..whole.clone() }).unwrap_err().to_string();
    assert!(e.contains("finite"), "{e}");
    // Numbers of other kinds, with missing cells.
    let values: Vec<u8> = [1i16, 2, -32768, 4].iter().flat_map(|v| v.to_be_bytes()).collect();
    let path = f.file("b.bin", &values);
    let o = ReadOptions {
        sample: Some(Sample::Signed(2)),
        byte_order: Some(eyot_io::ByteOrder::Big),
        nodata: Some(-32768.0),
        ..ReadOptions::default()
    };
    let r = read_raster(&path, &o, &Limits::default()).unwrap();
    assert_eq!((r.filled(), r.field.get(0, 0), r.field.get(1, 1)), (1, 1.0, 4.0));
}

// ---- NPY

fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), data].concat()
}

#[test]
fn npy_headers_are_checked() {
    let f = Fixture::new();
    let of = |descr: &str, fortran: &str, shape: &str, data: &[u8]| {
        let header = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n");
        f.file("a.npy", &npy(&header, data))
    };
    let values = |path: &Path| read(path).unwrap().field.to_vec();
    assert_eq!(values(&of("|u1", "False", "(2, 3)", &[1, 2, 3, 4, 5, 6])), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(values(&of("|u1", "True", "(2, 3)", &[1, 4, 2, 5, 3, 6])), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(values(&of(">i2", "False", "(1, 2)", &[0xff, 0xfe, 0, 7])), [-2.0, 7.0]);
    for (descr, shape, part) in [
        ("<f4", "(4294967296, 4294967296)", "too large"),
        ("<f4", "(18446744073709551615, 18446744073709551615)", "too large"),
        ("<f4", "(99999999999999999999, 1)", "no sizes"),
        ("<f4", "(-1, 4)", "no sizes"),
        ("<f4", "(0, 4)", "at least 1"),
        ("<f4", "(4,)", "(rows, columns)"),
        ("<f4", "(2, 3, 4)", "(rows, columns)"),
        ("<f4", "(2, 2)", "needs 16 bytes"),
        ("<c8", "(1, 1)", "astype"),
        ("|O", "(1, 1)", "astype"),
        ("<f99", "(1, 1)", "astype"),
        ("", "(1, 1)", "astype"),
        ("=f4", "(1, 1)", "order of bytes"),
    ] {
        let e = refused(&of(descr, "False", shape, &[0; 8]));
        assert!(e.contains(part), "{descr} {shape}: {e}");
    }
    for (bytes, part) in [
        (&b"\x93NUMPY\x09\x00"[..], "version 9"),
        (&b"\x93NUMPY\x01\x00"[..], "ends in its header"),
        (&b"\x93NUMPY\x02\x00\xff\xff\xff\xff"[..], "header of"),
        (&b"\x93NUMPY\x01\x00\x10\x00{}"[..], "ends in its header"),
        (&b"\x93NUMPY\x01\x00\x02\x00{}"[..], "`descr`"),
    ] {
        let e = refused(&f.file("b.npy", bytes));
        assert!(e.contains(part), "{e}");
    }
}

// ---- EXR

#[test]
fn exr_windows_of_absurd_size_are_refused() {
    let f = Fixture::new();
    let path = written(&f, "a.exr", RasterFormat::Exr);
    let whole = fs::read(&path).unwrap();
    let window = |name: &[u8]| whole.windows(name.len()).position(|w| w == name).unwrap() + name.len();
    // name, type `box2i`, length 16, then the numbers.
    let at = window(b"dataWindow\0box2i\0") + 4;
    for (xy, what) in [
        ([0, 0, i32::MAX - 1, i32::MAX - 1], "2^31 squared"),
        ([i32::MIN, i32::MIN, i32::MAX, i32::MAX], "2^32 squared"),
        ([0, 0, 199_999, 199_999], "200000 squared"),
        ([0, 0, 30_000, 30_000], "30001 squared"),
        ([10, 10, 0, 0], "turned over"),
    ] {
        let mut bytes = whole.clone();
        for (i, v) in xy.iter().enumerate() {
            bytes[at + 4 * i..at + 4 * i + 4].copy_from_slice(&i32::to_le_bytes(*v));
        }
        let limits = Limits { max_bytes: 256 << 20, ..Limits::default() };
        let path = f.file("bomb.exr", &bytes);
        let e = read_raster(&path, &ReadOptions::default(), &limits).expect_err(what).to_string();
        assert!(e.contains("bomb.exr"), "{what}: {e}");
    }
    for n in (8..whole.len()).step_by(13) {
        refused(&f.file("cut.exr", &whole[..n]));
    }
    let e = read_raster(&path, &ReadOptions { layer: Some("Q".into()), ..ReadOptions::default() }, &Limits::default());
    assert!(e.unwrap_err().to_string().contains("there is Y"));
}

// ---- Zarr

fn metadata(store: &Path) -> Value {
    serde_json::from_slice(&fs::read(store.join("height/zarr.json")).unwrap()).unwrap()
}

#[test]
fn zarr_metadata_are_checked_before_anything_is_allocated() {
    let f = Fixture::new();
    let store = written(&f, "a.zarr", RasterFormat::Zarr);
    let good = metadata(&store);
    let file = store.join("height/zarr.json");
    let codec = |name: &str| json!([{ "name": "bytes", "configuration": { "endian": "little" } }, { "name": name }]);
    for (at, value, part) in [
        ("/chunk_grid/configuration/chunk_shape", json!([1, 4_000_000, 4_000_000]), "MiB are read"),
        ("/chunk_grid/configuration/chunk_shape", json!([1, u64::MAX, u64::MAX]), "MiB are read"),
        ("/chunk_grid/configuration/chunk_shape", json!([1, 0, 512]), "does not fit"),
        ("/chunk_grid/configuration/chunk_shape", json!([512]), "does not fit"),
        ("/chunk_grid/configuration/chunk_shape", json!([1, 100, 100]), "do not divide"),
        ("/chunk_grid/name", json!("rectangular"), "not regular"),
        ("/shape", json!([1, 4_000_000_000u64, 4_000_000_000u64]), "more values than"),
        ("/shape", json!([1, 1_000_000, 1_000_000]), "too large"),
        ("/shape", json!([1, u64::MAX, u64::MAX]), "more values than"),
        ("/shape", json!([-1, 5]), "no list of sizes"),
        ("/shape", json!([1, 1, 1, 1, 1, 1, 1, 1, 1]), "9 dimensions"),
        ("/shape", json!([1, 0, 10]), "need rows and columns"),
        ("/data_type", json!("complex64"), "complex64"),
        ("/data_type", json!({ "name": "struct" }), "struct"),
        ("/codecs", codec("blosc"), "`blosc` is not read"),
        ("/codecs", json!([{ "name": "zstd" }]), "no codec turns values"),
        ("/codecs", json!("zstd"), "no list"),
        ("/storage_transformers", json!([{ "name": "x" }]), "storage transformers"),
        ("/chunk_key_encoding", json!({ "name": "x" }), "chunk_key_encoding"),
        ("/fill_value", json!("later"), "fill value"),
        ("/zarr_format", json!(2), "zarr_format=3"),
        ("/node_type", json!("tree"), "no array"),
        ("/codecs/0/configuration/chunk_shape", json!([1, 4_000_000, 4_000_000]), "do not divide"),
        ("/codecs/0/configuration/index_codecs", json!([{ "name": "gzip" }]), "index"),
    ] {
        let mut bad = good.clone();
        *bad.pointer_mut(at).unwrap() = value.clone();
        fs::write(&file, bad.to_string()).unwrap();
        let e = read(&store).expect_err(&format!("{at} {value}")).to_string();
        assert!(e.contains(part), "{at} {value}: {e}");
    }
    fs::write(&file, "{").unwrap();
    assert!(refused_store(&store).contains("JSON"));
    fs::write(&file, good.to_string()).unwrap();
    assert!(read(&store).is_ok());
}

fn refused_store(store: &Path) -> String {
    read(store).unwrap_err().to_string()
}

#[test]
fn damaged_shards_are_refused_and_missing_ones_are_the_fill_value() {
    let f = Fixture::new();
    let store = written(&f, "a.zarr", RasterFormat::Zarr);
    let shard = store.join("height/c/0/0/0");
    let whole = fs::read(&shard).unwrap();
    for i in (0..whole.len()).step_by(7) {
        let mut bytes = whole.clone();
        bytes[i] ^= 0x20;
        fs::write(&shard, &bytes).unwrap();
        // Chunks and index all have checksums.
        assert!(read(&store).is_err(), "byte {i}");
    }
    for n in (0..whole.len()).step_by(11) {
        fs::write(&shard, &whole[..n]).unwrap();
        assert!(read(&store).is_err(), "{n} bytes");
    }
    fs::remove_file(&shard).unwrap();
    // NaN, which nothing marks as missing; with the option, no cell is left.
    assert!(refused_store(&store).contains("NaN"));
    let e = read_raster(&store, &ReadOptions { nodata: Some(f64::NAN), ..ReadOptions::default() }, &Limits::default());
    assert!(e.unwrap_err().to_string().contains("every cell"));
}

/// A chunk that unpacks to far more than its shape.
#[test]
fn compressed_bombs_end_at_the_size_of_a_chunk() {
    let f = Fixture::new();
    let store = written(&f, "a.zarr", RasterFormat::Zarr);
    let mut plain = metadata(&store);
    plain["codecs"] = json!([{ "name": "bytes", "configuration": { "endian": "little" } }, { "name": "zstd" }]);
    plain["chunk_grid"]["configuration"]["chunk_shape"] = json!([1, 30, 40]);
    fs::write(store.join("height/zarr.json"), plain.to_string()).unwrap();
    let bomb = zstd::bulk::compress(&vec![0; 64 << 20], 19).unwrap();
    assert!(bomb.len() < 10_000);
    fs::write(store.join("height/c/0/0/0"), bomb).unwrap();
    assert!(refused_store(&store).contains("more than its shape"));
}

#[test]
fn stores_replace_stores_and_nothing_else() {
    let f = Fixture::new();
    let store = written(&f, "a.zarr", RasterFormat::Zarr);
    written(&f, "a.zarr", RasterFormat::Zarr);
    assert!(read(&store).is_ok());
    let other = f.0.path().join("mine.zarr");
    fs::create_dir(&other).unwrap();
    fs::write(other.join("precious"), b"x").unwrap();
    let world = world(4, 4);
    let e = write_layer(&other, &world, &world.layers()[0], RasterFormat::Zarr).unwrap_err().to_string();
    assert!(e.contains("choose another name"), "{e}");
    assert!(other.join("precious").exists());
    let names: Vec<_> = fs::read_dir(f.0.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "{names:?}");
}
