//! Recordings of runs: folders, as inputs of several parts.

use crate::worlds::{self, with_checksum};
use crate::{BETWEEN, limits, parts, scratch};
use eyot::Limits;
use eyot_io::timeline::{Record, Timeline};
use serde_json::{Map, Value, json};
use std::path::Path;

pub(crate) const WORDS: &[&str] = &[
    "\"shape\":",
    "\"time\":",
    "\"chunk_shape\":[1,512,512]",
    "\"dimension_names\":[\"time\",\"y\",\"x\"]",
    "x_face",
    "{\"frames\":2,\"keep\":[[0,0],[1,1]],\"dropped\":false}",
    "record_every_steps",
    "[2,",
    "[]",
    "-1",
    "18446744073709551615",
    "null",
    "\n%%\n",
];

/// The root, what else a frame needs, times, a shard of a layer in cells and one on faces, and what is left of a thinning.
const FILES: [&str; 6] =
    ["zarr.json", ".frames/0.eyot", "height/c/0/0/0", "flux_x/c/0/0/0", ".frames/thinning.json", "time/c/0"];

/// A recording whose frame has a checksum that fits, so that damage gets as far as it can.
pub(crate) fn read(bytes: &[u8]) -> bool {
    let store = scratch("timeline.zarr");
    let _ = std::fs::remove_dir_all(&store);
    for (name, bytes) in FILES.into_iter().zip(parts::<{ FILES.len() }>(bytes)).filter(|(_, b)| !b.is_empty()) {
        let path = store.join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder for an input");
        let bytes = if name.ends_with("0.eyot") { with_checksum(bytes) } else { bytes.to_vec() };
        std::fs::write(path, bytes).expect("room for an input");
    }
    // As many as the seeds have, and one more.
    let reads = |t: &Timeline, i: usize| t.look(i).is_ok() && t.load(i, &eyot::component_kinds()).is_ok();
    let found = Timeline::open(&store, &limits())
        .is_ok_and(|t| (0..t.frames().len().min(3)).filter(|&i| reads(&t, i)).count() > 0);
    // What a killed run had begun is carried out or refused.
    let _ = Timeline::open_to_write(&store, &limits());
    found
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let store = scratch("seed-timeline.zarr");
    let mut world = worlds::world();
    let record = Record { every: 1, max_bytes: 1 << 30 };
    let mut timeline = Timeline::create(&store, record, &Map::new(), &Limits::default()).expect("a recording");
    for step in 0..2 {
        world.step = step;
        timeline.append(&world, "seed = 7", &json!({ "done_steps": 1 })).expect("a frame");
    }
    timeline.truncate(1).expect("one frame");
    vec![FILES.map(|name| compact(&store.join(name))).join(BETWEEN)]
}

/// A file, JSON without its spaces; nothing if there is none.
fn compact(path: &Path) -> Vec<u8> {
    let bytes = std::fs::read(path).unwrap_or_default();
    let value: Option<Value> = serde_json::from_slice(&bytes).ok().filter(|_| path.ends_with("zarr.json"));
    value.map_or(bytes, |v| v.to_string().into_bytes())
}
