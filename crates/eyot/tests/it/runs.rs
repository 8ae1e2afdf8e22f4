//! Runs as conversations: commands, events, checkpoints, the same bytes however a run was cut.

use crate::common;
use crate::stubs;

use eyot::{
    Command, Event, Handle, JournalEntry, Limits, Outcome, Overrides, Problems, Recipe, RecipeSource, Registry, Run,
    RunError, RunOptions, store,
};
use std::path::Path;
use std::time::Duration;
use stubs::{GOOD, parse, registry};

fn options(out: Option<&Path>) -> RunOptions {
    RunOptions { threads: Some(2), out: out.map(Path::to_owned), ..RunOptions::default() }
}

fn recipe(steps: u64) -> Recipe {
    parse(GOOD, &[&format!("step.2.steps={steps}")]).unwrap()
}

fn events(handle: &Handle) -> Vec<Event> {
    handle.events().iter().collect()
}

#[test]
fn a_run_tells_its_story_and_leaves_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/deep");
    let handle = Run::start(recipe(50), options(Some(&out))).unwrap();
    let events = events(&handle);
    let outcome = handle.join().unwrap();
    assert!(outcome.finished);
    assert!(matches!(events.first(), Some(Event::Started { size: [16, 12], steps: 3, threads: 2, .. })));
    assert!(matches!(events.last(), Some(Event::Done { .. })));
    assert_eq!(events.iter().filter(|e| matches!(e, Event::StepBegun { .. })).count(), 3);
    let mut files: Vec<String> =
        std::fs::read_dir(&out).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
    files.sort();
    files.retain(|f| !f.ends_with(".json") || f == "run.json");
    assert_eq!(files, ["height.r32", "preview.png", "relief.png", "rough.r32", "run.json", "world.eyot"]);
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("run.json")).unwrap()).unwrap();
    assert_eq!(report["seed"], 5);
    assert_eq!(report["fingerprint"], format!("{:016x}", outcome.world.fingerprint()));
    let opened = store::open(&out, &Limits::default()).unwrap();
    assert_eq!(opened.world, outcome.world);
    // A finished run may be run over, but not resumed.
    Run::start(recipe(50), options(Some(&out))).unwrap().join().unwrap();
    assert!(matches!(
        Run::resume(&out, &registry(), options(None)),
        Err(RunError::NothingToResume { finished: true, .. })
    ));
}

#[test]
fn threads_and_chunks_do_not_change_a_byte() {
    let run = |threads, chunk| {
        let o = RunOptions { threads: Some(threads), chunk, ..RunOptions::default() };
        Run::start(recipe(37), o).unwrap().join().unwrap().world
    };
    let one = run(1, None);
    for (threads, chunk) in [(2, Some(1)), (3, Some(7)), (8, Some(1000))] {
        assert_eq!(run(threads, chunk), one);
    }
}

/// Stops a run after some steps, by pausing at an exact step first.
fn stopped_after(recipe: Recipe, out: &Path, steps: u64) -> Outcome {
    let handle = Run::start(recipe, RunOptions { chunk: Some(5), paused: true, ..options(Some(out)) }).unwrap();
    // A generator counts as one step.
    handle.send(Command::Step(steps));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { .. }));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { .. }));
    assert!(handle.send(Command::Stop));
    assert!(matches!(events(&handle).last(), Some(Event::Stopped { checkpoint: Some(_) })));
    handle.join().unwrap()
}

#[test]
fn a_stopped_run_resumes_to_the_same_bytes() {
    let whole = Run::start(recipe(60), options(None)).unwrap().join().unwrap();
    for steps in [1, 2, 14, 60] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        let part = stopped_after(recipe(60), out, steps);
        assert!(!part.finished);
        assert_eq!(part.world.step, steps - 1);
        assert!(matches!(Run::start(recipe(60), options(Some(out))), Err(RunError::Unfinished { .. })));
        let handle = Run::resume(out, &registry(), options(None)).unwrap();
        assert!(matches!(events(&handle).first(), Some(Event::Started { resumed: true, .. })));
        let end = handle.join().unwrap();
        assert!(end.finished);
        assert_eq!(end.world, whole.world, "stopped after {steps}");
        assert!(!out.join(store::CHECKPOINT_FILE).exists() && !out.join("eyot.lock").exists());
    }
}

#[test]
fn restart_overwrites_a_stopped_run() {
    let folder = tempfile::tempdir().unwrap();
    stopped_after(recipe(60), folder.path(), 3);
    let o = RunOptions { restart: true, ..options(Some(folder.path())) };
    assert!(Run::start(recipe(60), o).unwrap().join().unwrap().finished);
}

#[test]
fn changes_by_hand_are_kept_in_the_journal_and_replay() {
    let folder = tempfile::tempdir().unwrap();
    let handle = Run::start(recipe(40), RunOptions { paused: true, ..options(Some(folder.path())) }).unwrap();
    handle.send(Command::Step(11));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { .. }));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { .. }));
    handle.send(Command::Change(eyot::Change::parse("hydraulic.rain=0.5").unwrap()));
    let changed = common::wait_for(&handle, |e| matches!(e, Event::Changed(_)));
    handle.send(Command::Change(eyot::Change::parse("hydraulic.rian=0.5").unwrap()));
    let warning = common::wait_for(&handle, |e| matches!(e, Event::NotChanged { .. }));
    assert!(
        matches!(&warning, Event::NotChanged { reason, .. } if reason.to_string().contains("did you mean `rain`?")),
        "{warning:?}"
    );
    handle.send(Command::Snapshot);
    common::wait_for(&handle, |e| matches!(e, Event::Snapshot { step: 10, .. }));
    // Stop and resume in between: the change must survive.
    handle.send(Command::Stop);
    handle.join().unwrap();
    let touched = Run::resume(folder.path(), &registry(), options(None)).unwrap().join().unwrap();
    let entry = JournalEntry { recipe_step: 2, step: 10, set: "hydraulic.rain = 0.5".into() };
    assert!(matches!(changed, Event::Changed(e) if e == entry));
    assert_eq!(touched.journal, [entry]);
    assert_eq!(touched.world.get("water").unwrap().get(0, 0), 0.5);
    let again = Run::start(recipe(40), RunOptions { replay: touched.journal.clone(), ..options(None) })
        .unwrap()
        .join()
        .unwrap();
    assert_eq!((again.world, again.journal), (touched.world, touched.journal));
}

#[test]
fn two_runs_do_not_share_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let first = Run::start(recipe(40), RunOptions { paused: true, ..options(Some(folder.path())) }).unwrap();
    // The lock is taken before `start` returns.
    match Run::start(recipe(40), options(Some(folder.path()))) {
        Err(e @ RunError::Busy { .. }) => assert!(e.to_string().contains(&std::process::id().to_string()), "{e}"),
        Err(RunError::Unfinished { .. }) | Ok(_) => panic!("the folder was used twice"),
        Err(e) => panic!("{e}"),
    }
    first.send(Command::Stop);
    first.join().unwrap();
}

#[test]
fn checkpoints_come_in_time_and_a_damaged_one_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let o = RunOptions { checkpoint_every: Duration::ZERO, chunk: Some(10), ..options(Some(folder.path())) };
    let handle = Run::start(recipe(100), o).unwrap();
    assert!(events(&handle).iter().any(|e| matches!(e, Event::Checkpoint { .. })));
    handle.join().unwrap();
    let path = folder.path().join(store::CHECKPOINT_FILE);
    std::fs::write(&path, b"EYOTCKPT garbage").unwrap();
    assert!(matches!(Run::resume(folder.path(), &registry(), options(None)), Err(RunError::Checkpoint { .. })));
}

#[test]
fn merges_masks_and_filters_run() {
    let text = r#"
[grid]
size = 8
[[step]]
generate = "noise"
[[step]]
generate = "noise"
layer = "mask"
height = 1.0
[[step]]
generate = "flip"
mask = "mask"
amount = 0.5
[[step]]
generate = "noise"
enabled = false
"#;
    let world = Run::start(parse(text, &[]).unwrap(), options(None)).unwrap().join().unwrap().world;
    assert_eq!(world.layers().len(), 2);
    assert!(
        world.layer("height").unwrap().field.iter().any(|h| h < 0.0)
            || world.layer("height").unwrap().field.sum() > 0.0
    );
}

#[test]
fn a_file_is_imported_and_resampled() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("first");
    let first = Run::start(recipe(1), options(Some(&out))).unwrap().join().unwrap().world;
    let text = r#"
[grid]
from = "first/height.r32"
[[step]]
generate = "import"
file = "first/height.r32"
"#;
    let source = eyot::RecipeSource { name: "second.toml".into(), text: text.into(), folder: folder.path().into() };
    let read = |size| {
        let overrides = eyot::Overrides { size, ..eyot::Overrides::default() };
        let recipe = Recipe::parse(source.clone(), overrides, &registry(), &Limits::default()).unwrap();
        Run::start(recipe, options(None)).unwrap().join().unwrap().world
    };
    assert_eq!(read(None).get("height"), first.get("height"));
    assert_eq!(read(Some((8, None))).grid.height, 6);
}

/// Whatever processes there are: cutting and chunking a run changes nothing.
#[test]
fn every_process_resumes_exactly() {
    let registry = Registry::standard();
    for name in registry.process_names() {
        // Plates need cells that they cannot skip in a step, m.
        let cell = if name == "plates" { 50_000.0 } else { 10.0 };
        // What a process cannot make itself.
        let needs =
            registry.process(name).map(|e| (e.make)(serde_json::json!({})).unwrap().needs()).unwrap_or_default();
        let needs = needs.iter().map(|l| format!("[[step]]\ngenerate = \"constant\"\nlayer = \"{l}\"\nvalue = 0.0\n"));
        let needs: String = needs.collect();
        let text = format!(
            "[grid]\nsize = 32\ncell = {cell:.1}\n[[step]]\ngenerate = \"cone\"\nheight = 200.0\n{needs}[[step]]\nsimulate = [\"{name}\"]\nsteps = 23\n"
        );
        let read =
            || Recipe::parse(stubs::source(&text), eyot::Overrides::default(), &registry, &Limits::default()).unwrap();
        let whole = Run::start(read(), RunOptions { chunk: Some(23), ..options(None) }).unwrap().join().unwrap().world;
        let folder = tempfile::tempdir().unwrap();
        stopped_after(read(), folder.path(), 9);
        let resumed = Run::resume(folder.path(), &registry, options(None)).unwrap().join().unwrap().world;
        assert_eq!(resumed.fingerprint(), whole.fingerprint(), "{name}");
    }
}

fn standard(text: &str, limits: &Limits) -> Result<Recipe, Problems> {
    let source = RecipeSource { name: "r.toml".into(), text: text.into(), folder: ".".into() };
    Recipe::parse(source, Overrides::default(), &Registry::standard(), limits)
}

const RAIN: &str = "[grid]\nsize = 16\n[[step]]\ngenerate = \"cone\"\n[[step]]\nsimulate = \"hydraulic\"\nsteps = 20\n";

#[test]
fn a_change_that_would_end_the_run_is_not_made() {
    let recipe = standard(RAIN, &Limits::default()).unwrap();
    let handle = Run::start(recipe, RunOptions { paused: true, ..options(None) }).unwrap();
    handle.send(Command::Step(3));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { step: 2, .. }));
    handle.send(Command::Change(eyot::Change::parse("hydraulic.springs=0.5").unwrap()));
    let warning = common::wait_for(&handle, |e| matches!(e, Event::NotChanged { .. }));
    assert!(
        matches!(&warning, Event::NotChanged { reason, .. } if reason.to_string().contains("needs the layer `springs`")),
        "{warning:?}"
    );
    handle.send(Command::Resume);
    let outcome = handle.join().unwrap();
    assert!(outcome.finished && outcome.journal.is_empty());
}

#[test]
fn commands_that_do_not_fit_the_recipe_are_refused_before_the_run() {
    let entry = |recipe_step, set: &str| JournalEntry { recipe_step, step: 5, set: set.into() };
    for (entry, answer) in [
        (entry(1, "hydraulic.rain=0.1"), "simulates nothing there"),
        (entry(7, "hydraulic.rain=0.1"), "simulates nothing there"),
        (entry(2, "thermal.enabled=false"), "does not simulate `thermal`"),
        (entry(2, "hydraulic.rain=wet"), "nothing is called `wet`"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let recipe = standard(RAIN, &Limits::default()).unwrap();
        let Err(e) = Run::start(recipe, RunOptions { replay: vec![entry], ..options(Some(&out)) }) else {
            panic!("it ran: {answer}")
        };
        assert!(matches!(e, RunError::Replay { .. }) && e.to_string().contains(answer), "{e}");
        assert!(e.help().is_some() && !out.exists());
    }
}

/// What streams and drainage take beside the layers is known before the run, and names the step.
#[test]
fn actions_count_as_memory() {
    let text = |process: &str| {
        format!(
            "[grid]\nsize = 1000\nrim = \"open\"\n[[step]]\ngenerate = \"fbm\"\n[[step]]\nname = \"channels\"\n\
             simulate = \"{process}\"\nsteps = 1\n[view]\nenabled = false\n"
        )
    };
    let within = |process: &str, mib: u64| {
        let limits = Limits { max_bytes: mib << 20, ..Limits::default() };
        standard(&text(process), &limits).map(|_| ()).map_err(|p| p.to_string())
    };
    // The layers of a million cells take 17 and 25 MiB with the copies to go back to.
    for process in ["streampower", "drainage"] {
        let refused = within(process, 40).unwrap_err();
        assert!(refused.contains("step 2 (channels)") && refused.contains("MiB"), "{refused}");
        within(process, 200).unwrap();
    }
    within("thermal", 40).unwrap();
}

/// Files would go half to one folder and half to another, and the report would list what is not there.
#[cfg(unix)]
#[test]
fn a_folder_that_is_moved_away_and_made_anew_gets_nothing() {
    for linked in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        let (out, away, other) = (folder.path().join("out"), folder.path().join("away"), folder.path().join("other"));
        let handle = Run::start(recipe(50), RunOptions { paused: true, ..options(Some(&out)) }).unwrap();
        common::wait_for(&handle, |e| matches!(e, Event::Paused { .. }));
        std::fs::rename(&out, &away).unwrap();
        std::fs::create_dir(&other).unwrap();
        if linked {
            std::os::unix::fs::symlink(&other, &out).unwrap();
        } else {
            std::fs::rename(&other, &out).unwrap();
        }
        handle.send(Command::Resume);
        let e = handle.join().unwrap_err().to_string();
        assert!(e.contains("was moved, removed or replaced"), "{e}");
        assert_eq!(std::fs::read_dir(&out).unwrap().count(), 0, "files in the other folder");
        // What there was goes on where it is now.
        let outcome = Run::resume(&away, &registry(), options(None)).unwrap().join().unwrap();
        assert!(outcome.finished && away.join("run.json").is_file());
    }
    // A folder that is gone is not made again either.
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let handle = Run::start(recipe(50), RunOptions { paused: true, ..options(Some(&out)) }).unwrap();
    common::wait_for(&handle, |e| matches!(e, Event::Paused { .. }));
    std::fs::remove_dir_all(&out).unwrap();
    handle.send(Command::Resume);
    assert!(handle.join().is_err() && !out.exists());
}
