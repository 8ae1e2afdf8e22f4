//! Fuzz targets: everything that reads what others wrote, each as a function of bytes that must come to its end without a
//! panic, a huge allocation or a wrong result.
//!
//! Two things call them: the program of this crate, which needs nothing but stable Rust and runs in continuous integration,
//! and libFuzzer (`fuzz/libfuzzer`), which finds its way by coverage but needs a nightly compiler. Inputs that once broke
//! something, or that lead somewhere new, are kept in `fuzz/corpus/TARGET` and replayed by `cargo test`.

mod components;
pub mod corpus;
mod expressions;
pub mod mutate;
mod network;
mod rasters;
mod recipes;
mod states;
mod stores;
mod timelines;
mod worlds;

use eyot::Limits;
use std::path::PathBuf;
use std::sync::OnceLock;

/// Most memory that a target may take for any input, bytes.
pub const MAX_BYTES: usize = 512 << 20;

/// A way into the program.
pub struct Target {
    /// Name of its corpus.
    pub name: &'static str,
    /// Takes one input; false if it was refused.
    pub run: fn(&[u8]) -> bool,
    /// Sound inputs to start from.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Words that inputs of this kind are made of.
    pub words: &'static [&'static str],
}

/// All targets. An importer of a new format is one more line.
pub const TARGETS: &[Target] = &[
    Target { name: "geotiff", run: rasters::read, seeds: rasters::geotiff, words: &[] },
    Target { name: "png", run: rasters::read, seeds: rasters::png, words: rasters::PNG_WORDS },
    Target { name: "r32", run: rasters::read_r32, seeds: rasters::r32, words: rasters::SIDECAR_WORDS },
    Target { name: "r16", run: rasters::read_r16, seeds: rasters::r16, words: rasters::SIDECAR_WORDS },
    Target { name: "raw", run: rasters::read_raw, seeds: rasters::raw, words: rasters::RAW_WORDS },
    Target { name: "exr", run: rasters::read, seeds: rasters::exr, words: rasters::EXR_WORDS },
    Target { name: "npy", run: rasters::read_npy, seeds: rasters::npy, words: rasters::NPY_WORDS },
    Target { name: "zarr", run: stores::read, seeds: stores::seeds, words: stores::WORDS },
    Target { name: "checkpoint", run: worlds::read, seeds: worlds::seeds, words: worlds::WORDS },
    Target { name: "component", run: components::read, seeds: components::seeds, words: &[] },
    Target { name: "state", run: states::read, seeds: states::seeds, words: &[] },
    Target { name: "timeline", run: timelines::read, seeds: timelines::seeds, words: timelines::WORDS },
    Target { name: "recipe", run: recipes::read, seeds: recipes::seeds, words: recipes::WORDS },
    Target { name: "set", run: recipes::read_flags, seeds: recipes::flags, words: recipes::WORDS },
    Target { name: "records", run: network::read, seeds: network::seeds, words: network::WORDS },
    Target { name: "orders", run: network::read_order, seeds: network::orders, words: network::WORDS },
    Target { name: "expression", run: expressions::read, seeds: expressions::seeds, words: expressions::WORDS },
];

pub use components::component_by_component;
pub use states::{field_by_field, finished, loaded};

/// The target of a name.
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|t| t.name == name)
}

/// Far below [`MAX_BYTES`]: what is refused by these limits must be refused before it is allocated.
fn limits() -> Limits {
    Limits { max_cells: 1 << 22, max_bytes: 64 << 20, ..Limits::default() }
}

/// A file for the input of this process, in memory where the system has such a place.
fn scratch(name: &str) -> PathBuf {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let make = || tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).expect("a folder for inputs");
    let folder = FOLDER.get_or_init(make).path().join(format!("{:?}", std::thread::current().id()));
    std::fs::create_dir_all(&folder).expect("a folder for inputs");
    folder.join(name)
}

/// Stands between the files of an input that is several of them.
const BETWEEN: &[u8] = b"\n%%\n";

/// An input as its files; the last one may hold anything.
fn parts<const N: usize>(mut bytes: &[u8]) -> [&[u8]; N] {
    std::array::from_fn(|i| {
        let end = bytes.windows(BETWEEN.len()).position(|w| w == BETWEEN).filter(|_| i + 1 < N);
        let part = &bytes[..end.unwrap_or(bytes.len())];
        bytes = end.map_or(&[][..], |end| &bytes[end + BETWEEN.len()..]);
        part
    })
}
