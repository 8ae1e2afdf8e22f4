//! Zarr stores that ask for far more work or memory than they have bytes.

#[allow(dead_code)] // the files here are folders
use crate::common;

use common::{Fixture, read};
use eyot_io::{ReadOptions, read_raster};
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;

fn plain() -> Value {
    json!([{ "name": "bytes", "configuration": { "endian": "little" } }])
}

/// Shards with their index before the data.
fn shards(chunk: Value, codecs: &Value) -> Value {
    json!([{ "name": "sharding_indexed", "configuration": {
        "chunk_shape": chunk, "codecs": codecs, "index_codecs": plain(), "index_location": "start" } }])
}

/// A store of `f32` with at most one chunk.
fn store(f: &Fixture, shape: Value, chunk_shape: Value, codecs: Value, chunk: Option<&[u8]>) -> PathBuf {
    typed(f, "float32", json!(0.0), (shape, chunk_shape), codecs, chunk)
}

fn typed(
    f: &Fixture,
    kind: &str,
    fill: Value,
    (shape, chunk_shape): (Value, Value),
    codecs: Value,
    chunk: Option<&[u8]>,
) -> PathBuf {
    let path = f.0.path().join("a.zarr");
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(path.join("c/0")).unwrap();
    let metadata = json!({
        "zarr_format": 3, "node_type": "array", "shape": shape, "data_type": kind, "fill_value": fill,
        "chunk_grid": { "name": "regular", "configuration": { "chunk_shape": chunk_shape } },
        "chunk_key_encoding": { "name": "default" }, "codecs": codecs,
    });
    fs::write(path.join("zarr.json"), metadata.to_string()).unwrap();
    if let Some(bytes) = chunk {
        fs::write(path.join("c/0/0"), bytes).unwrap();
    }
    path
}

fn index(entries: &[(u64, u64)]) -> Vec<u8> {
    entries.iter().flat_map(|e| [e.0.to_le_bytes(), e.1.to_le_bytes()].concat()).collect()
}

fn refused(path: &std::path::Path, part: &str) {
    let e = read(path).expect_err(part).to_string();
    assert!(e.contains("a.zarr") && e.contains(part), "{part}: {e}");
}

#[test]
fn chunks_may_be_larger_than_the_array_but_not_by_far() {
    let f = Fixture::new();
    assert!(read(&store(&f, json!([10, 10]), json!([512, 512]), plain(), None)).is_ok());
    let nothing = index(&[(u64::MAX, u64::MAX)]);
    let side = json!([16384, 16384]);
    let path = store(&f, json!([10, 10]), side.clone(), shards(side, &plain()), Some(&nothing));
    refused(&path, "far larger than the shape");
}

#[test]
fn arrays_of_too_many_files_are_not_searched_for_them() {
    let f = Fixture::new();
    refused(&store(&f, json!([1 << 15, 1 << 14]), json!([1, 1]), plain(), None), "at most 1048576 are read");
}

/// Every value would be the fill value, at the price of gigabytes.
#[test]
fn large_arrays_without_chunks_are_refused() {
    let f = Fixture::new();
    for chunk in [None, Some(&[7; 300][..])] {
        refused(
            &store(&f, json!([30_000, 30_000]), json!([512, 512]), plain(), chunk),
            "cannot hold its [30000, 30000]",
        );
    }
}

#[test]
fn shards_in_shards_are_refused() {
    let f = Fixture::new();
    let inner = shards(json!([8, 8]), &plain());
    let path = store(&f, json!([8, 8]), json!([8, 8]), shards(json!([8, 8]), &inner), None);
    refused(&path, "shards within shards");
}

/// A thousand chunks that are the same megabyte.
#[test]
fn chunks_of_a_shard_may_not_share_bytes() {
    let f = Fixture::new();
    let values = [1.0f32, 2.0].map(f32::to_le_bytes).concat();
    let codecs = shards(json!([1, 1]), &plain());
    let apart = [index(&[(32, 4), (36, 4)]), values.clone()].concat();
    let path = store(&f, json!([1, 2]), json!([1, 2]), codecs.clone(), Some(&apart));
    assert_eq!(read(&path).unwrap().field.to_vec(), [1.0, 2.0]);
    let shared = [index(&[(0, 40), (0, 40)]), values].concat();
    refused(&store(&f, json!([1, 2]), json!([1, 2]), codecs, Some(&shared)), "bytes, 4 are needed");
    let zeros: Vec<(u64, u64)> = (0..3).map(|_| (48, 4)).collect();
    let shared = [index(&zeros), 5.0f32.to_le_bytes().to_vec()].concat();
    // Three times four bytes of fifty-two are fewer than there are; thirty times four are not.
    let path = store(&f, json!([1, 3]), json!([1, 3]), shards(json!([1, 1]), &plain()), Some(&shared));
    assert!(read(&path).is_ok());
    let many = [index(&[(0, 16); 30]), vec![0; 4]].concat();
    let zstd = json!([plain()[0], { "name": "zstd" }]);
    refused(&store(&f, json!([1, 30]), json!([1, 30]), shards(json!([1, 1]), &zstd), Some(&many)), "c/0/0");
}

/// The fill value of a shard's missing chunks is written in the array's own numbers.
#[test]
fn missing_chunks_of_half_precision_have_their_fill_value() {
    let f = Fixture::new();
    let nothing = index(&[(u64::MAX, u64::MAX)]);
    let sizes = (json!([2, 2]), json!([2, 2]));
    let path = typed(&f, "float16", json!(1.5), sizes, shards(json!([2, 2]), &plain()), Some(&nothing));
    assert!(read(&path).unwrap().field.iter().all(|v| v == 1.5));
}

#[test]
fn metadata_of_many_megabytes_are_not_parsed() {
    let f = Fixture::new();
    let path = store(&f, json!([1, 1]), json!([1, 1]), plain(), None);
    fs::write(path.join("zarr.json"), format!("[{}0]", "0,".repeat(3 << 20))).unwrap();
    refused(&path, "far too long");
}

/// Opening a pipe waits for somebody who writes to it.
#[cfg(unix)]
#[test]
fn pipes_folders_and_loops_are_no_chunks() {
    let f = Fixture::new();
    let open = |path: &PathBuf| read_raster(path, &ReadOptions::default(), &eyot_core::Limits::default());
    let path = store(&f, json!([1, 1]), json!([1, 1]), plain(), None);
    let chunk = path.join("c/0/0");
    assert!(std::process::Command::new("mkfifo").arg(&chunk).status().unwrap().success());
    refused(&path, "no ordinary file");
    fs::remove_file(&chunk).unwrap();
    fs::create_dir(&chunk).unwrap();
    refused(&path, "no ordinary file");
    fs::remove_dir(&chunk).unwrap();
    std::os::unix::fs::symlink("0", &chunk).unwrap();
    assert!(open(&path).unwrap_err().to_string().contains("leads to itself"));
}

/// A megabyte of them would keep a processor busy for half a minute, a gigabyte for hours.
#[test]
fn chunks_that_hold_far_more_than_is_wanted_are_not_unpacked() {
    let f = Fixture::new();
    // Eight million times of each cell, of which the last is wanted.
    let deep = |codecs: &Value| store(&f, json!([8_000_000, 32, 32]), json!([8_000_000, 1, 1]), codecs.clone(), None);
    refused(&deep(&plain()), "31250 MiB in 1024 chunks would be unpacked for 1024 values");
    // As many in one shard, in chunks of a value.
    let side = json!([1024, 1024, 8]);
    let path = store(&f, json!([1024, 1024, 8]), side, shards(json!([1, 1, 1]), &plain()), None);
    refused(&path, "8388608 chunks would be unpacked for 8192 values");
    // A year of days is usual.
    assert!(read(&store(&f, json!([365, 64, 64]), json!([365, 16, 16]), plain(), None)).is_ok());
    assert!(read(&store(&f, json!([64, 64]), json!([64, 64]), shards(json!([1, 1]), &plain()), None)).is_ok());
}

/// Opening one would wait for somebody to write to it.
#[cfg(unix)]
#[test]
fn pipes_are_refused_before_they_are_opened() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("f.npy");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|s| s.success()) {
        return;
    }
    let (sender, done) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let limits = eyot_core::Limits::default();
        let said = [
            eyot_io::layer_names(&pipe).unwrap_err().to_string(),
            read_raster(&pipe, &ReadOptions::default(), &limits).unwrap_err().to_string(),
        ];
        sender.send(said)
    });
    let said = done.recv_timeout(std::time::Duration::from_secs(20)).expect("it waits for the pipe");
    assert!(said.iter().all(|s| s.contains("no ordinary file")), "{said:?}");
}
