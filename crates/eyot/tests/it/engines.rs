//! Runs on a graphics card: a device that is lost on the way, and one that cannot hold the world.

use crate::common;

use eyot::{Command, EngineChoice, EngineOptions, Event, JournalEntry, Outcome, Registry, Run, RunError, RunOptions};
use std::path::Path;
use std::time::Duration;

const HILLS: &str = r#"
name = "Hills"
[grid]
size = [48, 40]
cell = 10.0
[[step]]
generate = "fbm"
amplitude = 120.0
[[step]]
simulate = ["hydraulic", "thermal"]
steps = 120
"#;

/// A run on a graphics device, with what it told; `None` without one, which is said, and fails where one is required.
fn run(lose_device_after: Option<u64>, out: Option<&Path>) -> Option<(Outcome, Vec<Event>)> {
    let engine = EngineOptions { choice: EngineChoice::Gpu, adapter: None, lose_device_after };
    let options = RunOptions {
        engine: Some(engine),
        out: out.map(Path::to_owned),
        chunk: Some(10),
        // So that the device has something to go on from; without a folder there are none.
        checkpoint_every: Duration::ZERO,
        replay: vec![JournalEntry { recipe_step: 2, step: 75, set: "hydraulic.rain=0.01".to_owned() }],
        ..RunOptions::default()
    };
    let handle = Run::start(common::recipe(HILLS, &[]), options).unwrap();
    let events: Vec<Event> = handle.events().iter().collect();
    match handle.join() {
        Ok(outcome) => Some((outcome, events)),
        Err(RunError::Device(e))
            if std::env::var_os("EYOT_REQUIRE_GPU").is_none() && e.to_string().contains("no graphics") =>
        {
            eprintln!("skipped: {e}");
            None
        }
        Err(e) => panic!("{e}"),
    }
}

fn warnings(events: &[Event]) -> Vec<String> {
    events
        .iter()
        .filter_map(|e| if let Event::Warning { message } = e { Some(message.to_string()) } else { None })
        .collect()
}

/// Largest difference of the heights, as a share of the relief.
fn difference(a: &Outcome, b: &Outcome) -> f32 {
    let [a, b] = [a, b].map(|o| o.world.get("height").unwrap());
    let (low, high) = a.min_max();
    let worst = a.iter().zip(b.iter()).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
    worst / (high - low)
}

#[test]
fn a_run_survives_the_loss_of_its_device() {
    let Some((undisturbed, quiet)) = run(None, None) else { return };
    assert!(warnings(&quiet).is_empty(), "{quiet:?}");
    // With checkpoints on the way it goes on from the last one, without a folder from the beginning of the simulation.
    let folder = tempfile::tempdir().unwrap();
    for (out, least) in [(Some(folder.path()), 1), (None, 0)] {
        let Some((outcome, events)) = run(Some(85), out) else { return };
        let told = warnings(&events);
        assert!(outcome.finished && told.len() == 1 && told[0].contains("goes on after"), "{told:?}");
        let words: Vec<&str> = told[0].split(' ').collect();
        let at = words.iter().position(|w| *w == "after").unwrap();
        let steps: u64 = words[at + 1].parse().unwrap();
        assert!((least..=90).contains(&steps), "{told:?}");
        let off = difference(&undisturbed, &outcome);
        println!("lost after 85 steps, went on after {steps}: heights differ by {off:.1e} of the relief");
        assert!(off <= 1e-4, "{off}");
        assert_eq!(outcome.world.step, undisturbed.world.step);
        // A change by hand is made at its step, also where that comes twice.
        assert_eq!(outcome.journal, undisturbed.journal);
        let [mass, same] = [&outcome, &undisturbed].map(|o| o.world.ledger.amount("water.rain"));
        assert!((mass - same).abs() <= 1e-5 * same.abs(), "rain {mass} instead of {same}");
    }
}

/// What `run.json` says of the engines.
fn engines(folder: &Path) -> serde_json::Value {
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.join("run.json")).unwrap()).unwrap();
    report["engines"].clone()
}

#[test]
fn a_stopped_run_goes_on_with_its_engine() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let Some((undisturbed, _)) = run(None, Some(&whole)) else { return };
    let options = |engine| RunOptions { engine, chunk: Some(10), ..RunOptions::default() };
    let stop_on_the_way = || {
        let engine = EngineOptions { choice: EngineChoice::Gpu, ..EngineOptions::default() };
        let replay = vec![JournalEntry { recipe_step: 2, step: 75, set: "hydraulic.rain=0.01".to_owned() }];
        let options = RunOptions { out: Some(parts.clone()), replay, ..options(Some(engine)) };
        let handle = Run::start(common::recipe(HILLS, &[]), options).unwrap();
        for event in handle.events() {
            if matches!(event, Event::Progress(p) if p.step == 40) {
                handle.send(Command::Stop);
            }
        }
        assert!(!handle.join().unwrap().finished);
    };
    let resume = |engine| {
        let handle = Run::resume(&parts, &Registry::standard(), options(engine)).unwrap();
        let events: Vec<Event> = handle.events().iter().collect();
        (handle.join().unwrap(), events)
    };
    stop_on_the_way();
    let (outcome, events) = resume(None);
    assert!(warnings(&events).is_empty(), "{events:?}");
    assert_eq!(outcome.fingerprint, undisturbed.fingerprint, "the same device gives the same bytes");
    assert_eq!(engines(&parts), engines(&whole));
    assert!(engines(&parts)[0].as_str().is_some_and(|e| e.starts_with("gpu (")), "{}", engines(&parts));
    // Another engine goes on if it is asked for; that is told, and written down.
    std::fs::remove_dir_all(&parts).unwrap();
    stop_on_the_way();
    let (_, events) = resume(Some(EngineOptions::default()));
    assert!(warnings(&events)[0].contains("cpu goes on"), "{events:?}");
    assert_eq!(engines(&parts)[1], "cpu");
}

/// Chunks of steps are as long as the time allows and checkpoints come when they are due; what the ledger says must not hang on either.
#[test]
fn two_runs_on_a_card_have_the_same_ledger() {
    let folder = tempfile::tempdir().unwrap();
    let run = |out: Option<&Path>| {
        let engine = EngineOptions { choice: EngineChoice::Gpu, adapter: None, lose_device_after: None };
        let checkpoint_every = if out.is_some() { Duration::ZERO } else { Duration::from_secs(60) };
        let options = RunOptions {
            engine: Some(engine),
            out: out.map(Path::to_owned),
            checkpoint_every,
            ..RunOptions::default()
        };
        match Run::start(common::recipe(HILLS, &[]), options).unwrap().join() {
            Ok(outcome) => Some(outcome.world),
            Err(RunError::Device(_)) if std::env::var_os("EYOT_REQUIRE_GPU").is_none() => None,
            Err(e) => panic!("{e}"),
        }
    };
    let Some(once) = run(None) else { return };
    for again in [run(None).unwrap(), run(Some(folder.path())).unwrap()] {
        assert!(again.layers() == once.layers());
        assert_eq!(again.ledger, once.ledger);
    }
    assert!(once.ledger.amount("water.evaporated") > 0.0);
    let report = std::fs::read(folder.path().join("run.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert!(report["timing"]["card_seconds"].is_number(), "{report}");
}
