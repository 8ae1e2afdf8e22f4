//! Saved worlds.

use crate::{limits, scratch};
use eyot::{Boundary, Grid, Limits, World};
use eyot_core::component::{Points, Table, Type};
use eyot_core::layer::known;
use eyot_core::{Centering, LayerSpec};
use eyot_io::checkpoint;
use serde_json::Value;
use std::ops::Range;

pub(crate) const WORDS: &[&str] =
    &["width", "height", "layers", "Cell", "FaceX", "FaceY", "null", "-1", "1e999", "18446744073709551615", "{", "["];

/// A checkpoint whose checksums fit, so that damage gets as far as it can.
pub(crate) fn read(bytes: &[u8]) -> bool {
    let (path, again) = (scratch("world.eyot"), scratch("again.eyot"));
    std::fs::write(&path, repaired(bytes)).expect("room for an input");
    let Ok(loaded) = checkpoint::load(&path, &limits(), &eyot::component_kinds()) else { return false };
    // What can be read can be written, unless it holds numbers that the header cannot carry, and is then the same.
    if checkpoint::save(&again, &loaded.world, &loaded.recipe_toml, &loaded.state).is_ok() {
        let back = checkpoint::load(&again, &limits(), &eyot::component_kinds()).expect("a checkpoint of our own");
        assert_eq!(back.world.fingerprint(), loaded.world.fingerprint());
        assert_eq!((back.recipe_toml, back.state), (loaded.recipe_toml, loaded.state));
    }
    true
}

/// The layout is explained in `eyot-io`: 8 bytes, a version, the length of the header, the header, its checksum.
pub(crate) fn with_checksum(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let length = bytes.get(12..20).and_then(|b| usize::try_from(u64::from_le_bytes(b.try_into().ok()?)).ok());
    let Some(end) =
        length.and_then(|n| n.checked_add(20)).filter(|e| e.checked_add(4).is_some_and(|e| e <= bytes.len()))
    else {
        return bytes;
    };
    let sum = crc32fast::hash(&bytes[..end]);
    bytes[end..end + 4].copy_from_slice(&sum.to_le_bytes());
    bytes
}

/// The components of a checkpoint with a sound header: name, kind, and where their bytes are.
pub(crate) fn parts(bytes: &[u8]) -> Vec<(String, String, Range<usize>)> {
    let length = bytes.get(12..20).and_then(|b| usize::try_from(u64::from_le_bytes(b.try_into().ok()?)).ok());
    let Some(end) = length.and_then(|n| n.checked_add(20)) else { return Vec::new() };
    let Some(header) = bytes.get(20..end).and_then(|text| serde_json::from_slice::<Value>(text).ok()) else {
        return Vec::new();
    };
    let mut at = end + 4;
    let mut parts = Vec::new();
    for c in header["components"].as_array().into_iter().flatten() {
        let Some(last) = c["bytes"].as_u64().and_then(|n| at.checked_add(usize::try_from(n).ok()?)) else { break };
        if last.checked_add(4).is_none_or(|last| last > bytes.len()) {
            break;
        }
        let text = |key: &str| c[key].as_str().unwrap_or_default().to_owned();
        parts.push((text("name"), text("kind"), at..last));
        at = last + 4;
    }
    parts
}

/// A checkpoint with other bytes at a place in a component, and a checksum that fits; as it was if there is no such place.
pub(crate) fn changed(mut bytes: Vec<u8>, component: usize, at: usize, by: &[u8]) -> Vec<u8> {
    let parts = parts(&bytes);
    let Some((_, _, part)) = parts.get(component) else { return bytes };
    if at + by.len() <= part.len() {
        let from = part.start + at;
        bytes[from..from + by.len()].copy_from_slice(by);
    }
    seal(&mut bytes, part.clone());
    bytes
}

/// Puts the checksum of some bytes behind them.
fn seal(bytes: &mut [u8], part: Range<usize>) {
    let sum = crc32fast::hash(&bytes[part.clone()]);
    bytes[part.end..part.end + 4].copy_from_slice(&sum.to_le_bytes());
}

/// [`with_checksum`], with those of the components.
fn repaired(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = with_checksum(bytes);
    let parts = parts(&bytes);
    parts.into_iter().for_each(|(_, _, part)| seal(&mut bytes, part));
    bytes
}

/// A world with a layer in cells, one on faces, and a ledger.
pub(crate) fn world() -> World {
    let grid = Grid::new(5, 3, 10.0, Boundary::OPEN, &Limits::default()).expect("a sound grid");
    let mut world = World::new(grid, 1);
    world.ensure(&known::HEIGHT, 2.5);
    world.ensure(&LayerSpec::new("flux_x", "m", "Flow to the east", (f32::MIN, f32::MAX)).on(Centering::FaceX), 0.5);
    world.ledger.add("water.rain", 0.1, "m3", "Rain", 1);
    let mut table = Table::new([("month", "month", Type::U64), ("cover", "1", Type::F64)]);
    table.push(&[1.0, 0.5]).expect("a row");
    world.components.insert("census", table);
    let mut points = Points::new([("radius", "m", Type::F32)]);
    points.push([1.0, 2.0, 3.0], &[0.5]).expect("a point");
    world.components.insert("trees", points);
    world
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let (path, world) = (scratch("seed.eyot"), world());
    let state = serde_json::json!({ "done_steps": 1, "journal": [] });
    checkpoint::save(&path, &world, "seed = 7", &state).expect("a sound world");
    vec![std::fs::read(path).expect("the world")]
}
