//! Zarr stores: folders, as inputs of several parts.

use crate::{BETWEEN, parts, rasters, scratch};
use eyot_io::{RasterFormat, write_layer};
use serde_json::{Value, json};

pub(crate) const WORDS: &[&str] = &[
    "\"shape\":",
    "\"chunk_shape\":",
    "\"codecs\":",
    "{\"name\":\"zstd\"}",
    "{\"name\":\"gzip\"}",
    "{\"name\":\"crc32c\"}",
    "float64",
    "uint8",
    "int16",
    "bool",
    "[1,",
    "[]",
    "0",
    "-1",
    "4000000",
    "18446744073709551615",
    "\"NaN\"",
    "\"0x7fc00000\"",
    "null",
    "\n%%\n",
];

/// Metadata and the only chunk of the array, metadata of its place and of its x axis, and the axis's chunk.
const FILES: [&str; 6] =
    ["height/zarr.json", "spatial_ref/zarr.json", "x/zarr.json", "y/zarr.json", "x/c/0", "height/c/0/0/0"];

/// A store of one array with its coordinates.
pub(crate) fn read(bytes: &[u8]) -> bool {
    let store = scratch("store");
    let _ = std::fs::remove_dir_all(&store);
    let put = |name: &str, bytes: &[u8]| {
        let path = store.join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder for an input");
        std::fs::write(path, bytes).expect("room for an input");
    };
    put("zarr.json", br#"{"zarr_format":3,"node_type":"group"}"#);
    for (name, bytes) in FILES.into_iter().zip(parts::<{ FILES.len() }>(bytes)).filter(|(_, b)| !b.is_empty()) {
        put(name, bytes);
    }
    rasters::read_file(&store)
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let store = scratch("seed.zarr");
    let world = rasters::world(6, 5);
    write_layer(&store, &world, &world.layers()[0], RasterFormat::Zarr).expect("a sound store");
    let file = |name: &str| std::fs::read(store.join(name)).expect("a file of the store");
    let compact = |name: &str| {
        let value: Value = serde_json::from_slice(&file(name)).expect("metadata");
        value.to_string().into_bytes()
    };
    let own: Vec<Vec<u8>> =
        FILES.iter().map(|name| if name.ends_with("json") { compact(name) } else { file(name) }).collect();
    let chunk: Vec<u8> = (0..30).flat_map(|i| (i as f32 * 0.5).to_le_bytes()).collect();
    // One chunk after its index.
    let index = [16_u64, 120].map(u64::to_le_bytes).concat();
    let plain = json!([{ "name": "bytes", "configuration": { "endian": "little" } }]);
    let shard = json!([{ "name": "sharding_indexed", "configuration": { "chunk_shape": [1, 5, 6], "codecs": plain,
        "index_codecs": plain, "index_location": "start" } }]);
    vec![own.join(BETWEEN), array(&plain, &chunk), array(&shard, &[index, chunk].concat())]
}

/// An array without a place and without checksums, which would hide what lies behind them.
fn array(codecs: &Value, chunk: &[u8]) -> Vec<u8> {
    let metadata = json!({
        "zarr_format": 3, "node_type": "array", "shape": [1, 5, 6], "data_type": "float32", "fill_value": "NaN",
        "chunk_grid": { "name": "regular", "configuration": { "chunk_shape": [1, 5, 6] } },
        "chunk_key_encoding": { "name": "default" }, "codecs": codecs,
        "attributes": { "scale_factor": 0.5, "missing_value": -1 },
    });
    [metadata.to_string().as_bytes(), b"", b"", b"", b"", chunk].join(BETWEEN)
}
