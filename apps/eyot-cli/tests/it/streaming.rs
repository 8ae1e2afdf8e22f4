//! Streamed runs as processes: what they take of the machine's memory, and what a kill leaves.

use crate::common;

use common::{eyot, said};
use std::io::{BufRead, BufReader};
use std::process::Stdio;

/// A world of 16384 x 16384 cells, one layer of which is 1 GiB, is made, exported twice and drawn.
#[cfg(target_os = "linux")]
#[test]
fn a_large_world_takes_less_memory_than_one_of_its_layers() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
        name = "Large"
        [grid]
        size = 16384
        cell = 30.0
        [[step]]
        generate = "fbm"
        amplitude = 2000.0
        [[export]]
        format = "geotiff"
        [[export]]
        format = "zarr"
    "#;
    std::fs::write(folder.path().join("large.toml"), text).unwrap();
    let child = eyot(folder.path(), &["run", "large.toml", "--quiet"]).spawn().unwrap();
    let (done, peak_kib) = common::wait_with_peak(child);
    assert!(done.success());
    for file in ["height.tif", "world.zarr/zarr.json", "preview.png", "relief.png", "run.json"] {
        assert!(folder.path().join("large").join(file).exists(), "{file}");
    }
    // Measured: 438 MiB.
    assert!(peak_kib < 1 << 20, "{} MiB", peak_kib >> 10);
}

/// As the run of a process that was killed, so the one that goes on: byte by byte that of a run in one piece.
#[test]
fn a_killed_run_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
        name = "Wide"
        [grid]
        size = [20000, 900]
        cell = 15.0
        [[step]]
        generate = "fbm"
        octaves = 4
        [[export]]
        format = "r32"
        [[export]]
        format = "geotiff"
        [[export]]
        format = "zarr"
        [view]
        enabled = false
    "#;
    std::fs::write(folder.path().join("wide.toml"), text).unwrap();
    said(folder.path(), &["run", "wide.toml", "--quiet", "--stream", "never", "--out", "whole"], 0, &[]);
    for killed_in in ["height.r32", "height.tif", "world.zarr"] {
        let args = ["run", "wide.toml", "--stream", "always", "--json", "--out", killed_in];
        let mut child = eyot(folder.path(), &args).stdout(Stdio::piped()).spawn().unwrap();
        for line in BufReader::new(child.stdout.take().unwrap()).lines() {
            let event: serde_json::Value = serde_json::from_str(&line.unwrap()).unwrap();
            if event["event"] == "writing" && event["path"].as_str().is_some_and(|p| p.ends_with(killed_in)) {
                child.kill().unwrap();
                break;
            }
        }
        child.wait().unwrap();
        let out = folder.path().join(killed_in);
        assert!(out.join("checkpoint.eyot").exists() && !out.join("run.json").exists(), "{killed_in}");
        said(folder.path(), &["resume", killed_in, "--quiet"], 0, &[]);
        let mut names: Vec<String> =
            std::fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        assert_eq!(names, ["height.r32", "height.r32.json", "height.tif", "run.json", "world.zarr"], "{killed_in}");
        for name in ["height.r32", "height.tif", "world.zarr/height/c/0/1/7"] {
            let [ours, whole] = [&out, &folder.path().join("whole")].map(|f| std::fs::read(f.join(name)).unwrap());
            assert!(ours == whole, "{name} differs after a kill in {killed_in}");
        }
    }
}
