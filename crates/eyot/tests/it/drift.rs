//! Plates beside a living world: whatever stops, edits or sets back a run, the world is the one that it would have been.

use crate::common;
use eyot::timeline::{Moment, rewind};
use eyot::{Command, Event, Limits, Outcome, Overrides, Recipe, RecipeSource, Record, Registry, Run, RunOptions};
use std::path::Path;

const TEXT: &str = r#"
name = "Drifting"
seed = 5
[grid]
size = [96, 48]
extent_m = [4e7, 2e7]
rim = ["wrap", "closed"]
[[step]]
name = "continents"
generate = "fbm"
amplitude = 3000.0
scale = 0.3
[[step]]
name = "life"
simulate = ["wind", "temperature", "humidity", "water", "weathering", "plates"]
steps = 60
plates.every = 7
plates.land = 0.4
[[export]]
format = "r32"
[view]
enabled = false
"#;

fn recipe() -> Recipe {
    let source = RecipeSource { name: "r.toml".into(), text: TEXT.into(), folder: ".".into() };
    Recipe::parse(source, Overrides::default(), &Registry::standard(), &Limits::default()).unwrap()
}

fn options(out: Option<&Path>, threads: usize) -> RunOptions {
    let record = out.map(|_| Record { every: 5, max_bytes: 1 << 30 });
    RunOptions { threads: Some(threads), out: out.map(Path::to_owned), record, ..RunOptions::default() }
}

/// Plates are hurried while a step of theirs is under way, then asked for a new cycle.
fn touched(out: Option<&Path>, threads: usize) -> Outcome {
    let handle = Run::start(recipe(), RunOptions { paused: true, ..options(out, threads) }).unwrap();
    for (steps, at, set) in [(18, 17, "plates.speed=0.1"), (14, 31, "plates.restarts=1")] {
        handle.send(Command::Step(steps));
        common::wait_for(&handle, |e| matches!(e, Event::Paused { recipe_step: 2, step } if *step == at));
        handle.send(Command::Change(eyot::Change::parse(set).unwrap()));
        common::wait_for(&handle, |e| matches!(e, Event::Changed(_)));
    }
    handle.send(Command::Resume);
    handle.join().unwrap()
}

#[test]
fn drifting_worlds_are_the_same_however_they_are_run() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let plain = Run::start(recipe(), options(None, 2)).unwrap().join().unwrap();
    let first = touched(Some(&out), 2);
    assert_ne!(first.fingerprint, plain.fingerprint);
    assert!(first.world.ledger.amount("crust.removed") > 0.0, "weather works on the crust");
    assert_eq!(touched(None, 1).fingerprint, first.fingerprint, "one thread");
    let replay = RunOptions { replay: first.journal.clone(), chunk: Some(4), ..options(None, 3) };
    let again = Run::start(recipe(), replay).unwrap().join().unwrap();
    assert_eq!(again.fingerprint, first.fingerprint, "replayed in other pieces");
    assert_eq!(again.world.ledger, first.world.ledger);
    // Back to frames before, between and after the changes, and to one at which plates take their turn.
    for step in [55, 35, 30, 20, 10] {
        rewind(&out, Moment::Step(step), false, &Registry::standard(), &Limits::default()).unwrap();
        let again = Run::resume(&out, &Registry::standard(), options(None, 2)).unwrap().join().unwrap();
        assert_eq!(again.fingerprint, first.fingerprint, "from {step}");
    }
    rewind(&out, Moment::Step(10), true, &Registry::standard(), &Limits::default()).unwrap();
    let forgotten = Run::resume(&out, &Registry::standard(), options(None, 2)).unwrap().join().unwrap();
    assert_eq!(forgotten.fingerprint, plain.fingerprint);
}
