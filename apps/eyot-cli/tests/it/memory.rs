//! A large island in bounded memory.

// The system's own account of the most that a process has held.
#![cfg(target_os = "linux")]

use crate::common;

/// Files, pictures and mesh included. Measured: 2.14 GiB, while the view is drawn; the world itself has ten layers of 64 MiB.
#[test]
fn an_island_of_4096_by_4096_cells_fits_in_4_gib() {
    let folder = tempfile::tempdir().unwrap();
    // The memory of a run does not grow with its steps, nor with octaves.
    let few = ["erosion.steps=1", "growth.steps=1", "fbm.octaves=1", "view.size=[320, 200]"];
    let mut args = vec!["run", "island", "--size", "4096", "--out", "out", "--quiet"];
    few.iter().for_each(|s| args.extend(["--set", s]));
    let child = common::eyot(folder.path(), &args).spawn().unwrap();
    let (ended, most_kib) = common::wait_with_peak(child);
    assert!(ended.success());
    let most = most_kib as f64 / (1 << 20) as f64;
    assert!((1.0..4.0).contains(&most), "the run held {most:.2} GiB");
    assert!(folder.path().join("out/terrain.glb").is_file() && folder.path().join("out/relief.png").is_file());
}
