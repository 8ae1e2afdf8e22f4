//! Files of the format before this one, in which components were lists of numbers: made by the program of that time.
//!
//! `version-2-reef.eyot` and `version-2-plates.eyot` are worlds after four steps, with the recipes that made them;
//! `version-2-frame.eyot` is the head of the last frame (step 5) of a recording of the reef.

use crate::common;
use eyot::io::checkpoint::{self, Checkpoint};
use eyot::timeline::Timeline;
use eyot::{Limits, Overrides, Recipe, RecipeSource, Record, Registry, Run, RunOptions, World, component_kinds};
use eyot_core::component::Table;
use eyot_plates::PlateState;
use eyot_reef::community::Population;
use std::path::{Path, PathBuf};

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/goldens").join(name)
}

fn former(name: &str) -> Checkpoint {
    checkpoint::load(&golden(name), &Limits::default(), &component_kinds()).unwrap()
}

/// The recipe of a file, with other numbers of steps.
fn recipe(saved: &Checkpoint, set: &[&str]) -> Recipe {
    let source = RecipeSource { name: "old.toml".into(), text: saved.recipe_toml.clone(), folder: ".".into() };
    // The run of the plates was made smaller on the command line.
    let set = set.iter().map(|s| (*s).to_owned()).collect();
    let size = Some((saved.world.grid.width as u32, Some(saved.world.grid.height as u32)));
    let overrides = Overrides { set, size, ..Overrides::default() };
    Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).unwrap()
}

fn made(recipe: Recipe) -> World {
    common::run(recipe, tempfile::tempdir().unwrap().path())
}

#[test]
fn worlds_of_the_version_before_are_read_by_the_kinds_that_own_their_names() {
    let reef = former("version-2-reef.eyot");
    // What that program printed.
    assert_eq!(format!("{:016x}", reef.world.fingerprint()), "f3506f56b17cc013");
    let population = reef.world.components.get::<Population>("corals").unwrap().unwrap();
    assert_eq!((population.months(), population.colonies().len(), population.algae().len()), (4, 10, 21));
    let plates = former("version-2-plates.eyot");
    assert_eq!(format!("{:016x}", plates.world.fingerprint()), "dbcf77c8adf56ecd");
    assert!(plates.world.components.get::<PlateState>("plates").unwrap().is_some());
    // They are what the same recipes make today, and stay it when they are written in today's format.
    let folder = tempfile::tempdir().unwrap();
    for (saved, name) in [(reef, "r.eyot"), (plates, "p.eyot")] {
        let path = folder.path().join(name);
        checkpoint::save(&path, &saved.world, &saved.recipe_toml, &saved.state).unwrap();
        let again = checkpoint::load(&path, &Limits::default(), &component_kinds()).unwrap();
        assert_eq!(again, saved);
        assert_eq!(made(recipe(&saved, &[])).fingerprint(), saved.world.fingerprint(), "{name}");
    }
}

#[test]
fn a_recording_of_the_version_before_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let recipe = recipe(&former("version-2-reef.eyot"), &["step.2.steps=5"]);
    let record = Some(Record { every: 2, max_bytes: 1 << 30 });
    let options = RunOptions { out: Some(folder.path().into()), record, ..RunOptions::default() };
    let mut world = Run::start(recipe, options).unwrap().join().unwrap().world;
    let head = folder.path().join("timeline.zarr/.frames/3.eyot");
    assert_ne!(std::fs::read(&head).unwrap(), std::fs::read(golden("version-2-frame.eyot")).unwrap());
    std::fs::copy(golden("version-2-frame.eyot"), &head).unwrap();
    let frame = Timeline::open(folder.path(), &Limits::default()).unwrap().load(3, &component_kinds()).unwrap();
    assert_eq!(format!("{:016x}", frame.fingerprint()), "65e67c28e70124a0");
    // The census of that time has no columns; its rows are the same.
    let census = world.components.get::<Table>("corals.census").unwrap().unwrap().clone();
    let corals = eyot_reef::corals::Corals::default();
    assert_eq!(*corals.census(&frame).unwrap(), census);
    world.components.remove("corals.census");
    let mut frame = frame;
    frame.components.remove("corals.census");
    assert_eq!(frame, world);
}
