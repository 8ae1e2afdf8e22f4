//! Inputs that are kept.

use crate::Target;
use std::path::PathBuf;

/// Where the inputs of a target lie.
pub fn folder(target: &Target) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target.name)
}

/// The seeds of a target and its kept inputs, in the order of their names.
pub fn inputs(target: &Target) -> Vec<(String, Vec<u8>)> {
    let seeds = (target.seeds)().into_iter().enumerate().map(|(i, s)| (format!("seed {i}"), s));
    let mut kept: Vec<(String, Vec<u8>)> = std::fs::read_dir(folder(target))
        .into_iter()
        .flatten()
        .filter_map(|e| {
            let path = e.ok()?.path();
            Some((path.file_name()?.to_string_lossy().into_owned(), std::fs::read(&path).ok()?))
        })
        .collect();
    kept.sort();
    seeds.chain(kept).collect()
}
