//! Results in memory: the files of a folder, byte by byte, and what they say when they are read back.

use crate::common;
use eyot::formats::{Input, ReadOptions, read_raster};
use eyot::session::{Budget, Clock, Folder, Host, Memory, RunFiles, Session, SessionOptions, Status, Storage};
use eyot::{Limits, Registry};
use eyot_io::storage::read_bytes;
use std::collections::BTreeMap;
use std::path::Path;

const ISLE: &str = r#"
name = "Isle"
[grid]
size = [40, 32]
cell = 20.0
[[step]]
generate = "cone"
height = 300.0
[[step]]
simulate = ["hydraulic"]
steps = 4
[view]
enabled = true
size = [32, 24]
[[export]]
format = "png16"
layers = ["height"]
[[export]]
format = "geotiff"
layers = ["height"]
[[export]]
format = "r16"
layers = ["height"]
[[export]]
format = "r32"
layers = ["height"]
[[export]]
format = "exr"
layers = ["height"]
[[export]]
format = "npy"
layers = ["height"]
[[export]]
format = "zarr"
layers = ["height", "water"]
[[export]]
format = "glb"
levels = 1
[[export]]
format = "obj"
[[export]]
what = "map"
layers = ["height"]
[[export]]
preset = "unity"
size = 33
"#;

/// Runs the recipe to its end.
fn run(storage: impl Storage + 'static) -> eyot::Outcome {
    let host = Host::new(&Registry::standard(), Clock::system()).with_storage(storage).with_outputs(RunFiles);
    let mut s = Session::new(common::recipe(ISLE, &[]), SessionOptions::default(), host).unwrap();
    while s.advance(Budget::Steps(100)).unwrap() == Status::Working {}
    s.into_outcome().unwrap()
}

/// All files of a folder, by their names in it.
fn files(folder: &Path, prefix: &str, found: &mut BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let name = format!("{prefix}{}", entry.file_name().to_str().unwrap());
        match entry.path().is_dir() {
            true => files(&entry.path(), &format!("{name}/"), found),
            false => drop(found.insert(name, std::fs::read(entry.path()).unwrap())),
        }
    }
}

#[test]
fn a_session_in_memory_exports_the_files_of_a_folder() {
    let (folder, memory) = (tempfile::tempdir().unwrap(), Memory::new());
    let on_disk = run(Folder::new(folder.path()));
    let held = run(memory.clone());
    assert!(on_disk.finished && held.finished && on_disk.fingerprint == held.fingerprint);
    let mut there = BTreeMap::new();
    files(folder.path(), "", &mut there);
    assert_eq!(memory.names(), there.keys().cloned().collect::<Vec<_>>());
    for name in ["height.png", "terrain.glb", "height.tif", "height.r16.json", "preview.png", "world.zarr/zarr.json"] {
        assert!(there.contains_key(name), "{name} is not among {:?}", there.keys());
    }
    // Where they lie is their folder or nothing; what they are called is the same.
    let names = |o: &eyot::Outcome| o.outputs.iter().map(|p| p.file_name().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(names(&on_disk), names(&held));
    for (name, bytes) in &there {
        let mut pair = [bytes.clone(), read_bytes(&memory, name, 1 << 30).unwrap()];
        if name == "run.json" {
            pair.iter_mut().for_each(|text| {
                let mut report: serde_json::Value = serde_json::from_slice(text).unwrap();
                report["timing"].take();
                *text = report.to_string().into_bytes();
            });
        }
        assert!(pair[0] == pair[1], "{name}");
    }
    let (options, limits) = (ReadOptions::default(), Limits::default());
    for name in ["height.png", "height.tif", "height.r16", "height.r32", "height.exr", "height.npy"] {
        let read = read_raster(Input::blob(&memory, name), &options, &limits).unwrap();
        assert_eq!(read, read_raster(&folder.path().join(name), &options, &limits).unwrap(), "{name}");
        assert_eq!((read.cell_m, read.name.as_str()), (Some((20.0, 20.0)), "height"), "{name}");
    }
    let glb = read_bytes(&memory, "terrain.glb", 1 << 30).unwrap();
    assert_eq!((&glb[..4], glb.len()), (&b"glTF"[..], u32::from_le_bytes(glb[8..12].try_into().unwrap()) as usize));
}

#[test]
fn a_session_in_memory_is_not_written_to_the_working_folder() {
    let memory = Memory::new();
    run(memory.clone());
    for name in memory.names() {
        assert!(!Path::new(&name).exists(), "{name}");
    }
}
