//! Recorded runs: the same bytes with and without, every frame the world of its step, and exact ways back.

use crate::common;
use eyot::timeline::{Branching, Moment, Timeline, branch, rewind};
use eyot::{
    Command, Event, Limits, Outcome, Overrides, Recipe, RecipeSource, Record, Registry, Run, RunError, RunOptions,
    store,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const TEXT: &str = r#"
name = "Recorded"
seed = 5
sea_level = 20.0
[grid]
size = [40, 30]
cell = 10.0
rim = "open"
[[step]]
name = "hill"
generate = "cone"
height = 150.0
[[step]]
name = "rain"
simulate = ["hydraulic", "thermal"]
steps = 47
[[step]]
name = "ash"
generate = "fbm"
amplitude = 5.0
[[step]]
name = "reefs"
simulate = ["hydraulic", "reef"]
steps = 33
[[step]]
name = "dust"
generate = "fbm"
amplitude = 1.0
[[export]]
format = "r32"
[view]
enabled = false
"#;

const RECORD: Record = Record { every: 10, max_bytes: 1 << 30 };

fn recipe(set: &[&str]) -> Recipe {
    let source = RecipeSource { name: "r.toml".into(), text: TEXT.into(), folder: ".".into() };
    let overrides = Overrides { set: set.iter().map(|s| (*s).to_owned()).collect(), ..Overrides::default() };
    Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).unwrap()
}

fn options(out: Option<&Path>, record: Option<Record>) -> RunOptions {
    RunOptions { threads: Some(2), out: out.map(Path::to_owned), record, ..RunOptions::default() }
}

fn run(out: &Path, record: Option<Record>) -> Outcome {
    Run::start(recipe(&[]), options(Some(out), record)).unwrap().join().unwrap()
}

fn resume(out: &Path) -> Outcome {
    Run::resume(out, &Registry::standard(), options(None, None)).unwrap().join().unwrap()
}

/// Runs without a recording to an exact step of a simulation, and shows the world.
fn world_at(recipe_step: usize, step: u64) -> eyot::World {
    let name = if recipe_step == 2 { "rain" } else { "reefs" };
    let mut sets = vec![format!("{name}.steps={}", step.max(1)), "dust.enabled=false".to_owned()];
    if recipe_step == 2 {
        sets.extend(["ash.enabled=false".to_owned(), "reefs.enabled=false".to_owned()]);
    }
    if step == 0 {
        sets.push(format!("{name}.enabled=false"));
    }
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    Run::start(recipe(&sets), options(None, None)).unwrap().join().unwrap().world
}

/// The results: every file but the recording; the report without its times.
fn results(out: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let files = std::fs::read_dir(out).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_file());
    files
        .map(|path| {
            let mut bytes = std::fs::read(&path).unwrap();
            if path.ends_with("run.json") {
                let mut report: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
                report.as_object_mut().unwrap().remove("timing");
                bytes = report.to_string().into_bytes();
            }
            (path.file_name().unwrap().into(), bytes)
        })
        .collect()
}

fn all_files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut out = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            out.extend(all_files(&path));
        } else {
            out.insert(path.clone(), std::fs::read(&path).unwrap());
        }
    }
    out
}

fn assert_same(a: &BTreeMap<PathBuf, Vec<u8>>, b: &BTreeMap<PathBuf, Vec<u8>>, what: &str) {
    assert!(a.keys().eq(b.keys()), "{what}: {:?} and {:?}", a.keys(), b.keys());
    for (name, bytes) in a {
        assert!(*bytes == b[name], "{what}: {} differs", name.display());
    }
}

fn timeline(out: &Path) -> Timeline {
    Timeline::open(out, &Limits::default()).unwrap()
}

fn places(t: &Timeline) -> Vec<(u64, usize, u64)> {
    t.frames().iter().map(|f| (f.steps_done, f.recipe_step, f.step)).collect()
}

#[test]
fn frames_are_the_worlds_of_their_steps_and_the_results_those_of_an_unrecorded_run() {
    let folder = tempfile::tempdir().unwrap();
    let (plain, out) = (folder.path().join("plain"), folder.path().join("out"));
    run(&plain, None);
    let outcome = run(&out, Some(RECORD));
    assert_same(&results(&plain), &results(&out), "recorded");
    let t = timeline(&out);
    // Ends of simulations are frames, too; the state after the ash takes the place of that before it.
    let expected = [
        (0, 2, 0),
        (10, 2, 10),
        (20, 2, 20),
        (30, 2, 30),
        (40, 2, 40),
        (47, 4, 0),
        (50, 4, 3),
        (60, 4, 13),
        (70, 4, 23),
        (80, 6, 0),
    ];
    assert_eq!(places(&t), expected);
    for frame in &t.frames()[..9] {
        assert_eq!(
            t.load(frame.frame, &eyot::component_kinds()).unwrap(),
            world_at(frame.recipe_step, frame.step),
            "{frame:?}"
        );
    }
    assert_eq!(t.load(9, &eyot::component_kinds()).unwrap(), outcome.world);
    assert_eq!(t.find(Moment::Step(69)).unwrap().steps_done, 60);
    assert!(t.find(Moment::Frame(10)).is_err());
    assert!(
        t.load(0, &eyot::component_kinds()).unwrap().get("water").is_none()
            && t.load(1, &eyot::component_kinds()).unwrap().get("water").is_some()
    );
}

#[test]
fn a_run_set_back_goes_on_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    run(&out, Some(RECORD));
    let (whole, recorded) = (results(&out), places(&timeline(&out)));
    for moment in [Moment::Step(0), Moment::Step(39), Moment::Frame(5), Moment::Step(60), Moment::Frame(9)] {
        let done = rewind(&out, moment, false, &Registry::standard(), &Limits::default()).unwrap();
        assert_eq!(done.dropped, 9 - done.frame.frame);
        assert!(done.has_results);
        assert_eq!(timeline(&out).frames().last(), Some(&done.frame));
        assert!(matches!(Run::start(recipe(&[]), options(Some(&out), None)), Err(RunError::Unfinished { .. })));
        resume(&out);
        assert_same(&results(&out), &whole, &format!("{moment:?}"));
        // The recording went on without being told, and knows every frame again.
        assert_eq!(places(&timeline(&out)), recorded, "{moment:?}");
    }
    assert!(matches!(
        Run::resume(&out, &Registry::standard(), options(None, None)),
        Err(RunError::NothingToResume { finished: true, .. })
    ));
}

/// Two changes by hand, at 13 steps and, exactly where there is a frame, at 20.
fn touched(out: &Path) -> Outcome {
    let handle = Run::start(recipe(&[]), RunOptions { paused: true, ..options(Some(out), Some(RECORD)) }).unwrap();
    for (steps, set) in [(14, "hydraulic.rain=0.01"), (7, "thermal.enabled=false")] {
        handle.send(Command::Step(steps));
        let at = if steps == 14 { 13 } else { 20 };
        common::wait_for(&handle, |e| matches!(e, Event::Paused { recipe_step: 2, step } if *step == at));
        handle.send(Command::Change(eyot::Change::parse(set).unwrap()));
        common::wait_for(&handle, |e| matches!(e, Event::Changed(_)));
    }
    handle.send(Command::Resume);
    handle.join().unwrap()
}

#[test]
fn changes_by_hand_are_made_again_or_forgotten() {
    let folder = tempfile::tempdir().unwrap();
    let (plain, out) = (folder.path().join("plain"), folder.path().join("out"));
    let untouched = run(&plain, None);
    let first = touched(&out);
    assert_eq!(first.journal.len(), 2);
    assert_ne!(first.fingerprint, untouched.fingerprint);
    let whole = results(&out);
    for step in [60, 20, 10, 0] {
        rewind(&out, Moment::Step(step), false, &Registry::standard(), &Limits::default()).unwrap();
        let again = resume(&out);
        assert_eq!(again.journal, first.journal, "from {step}");
        assert_same(&results(&out), &whole, &format!("from {step}"));
    }
    // Twice before it goes on: nothing is lost on the way.
    rewind(&out, Moment::Step(60), false, &Registry::standard(), &Limits::default()).unwrap();
    rewind(&out, Moment::Step(10), false, &Registry::standard(), &Limits::default()).unwrap();
    assert_eq!(resume(&out).fingerprint, first.fingerprint);
    rewind(&out, Moment::Step(10), true, &Registry::standard(), &Limits::default()).unwrap();
    let forgotten = resume(&out);
    assert!(forgotten.journal.is_empty());
    assert_eq!(forgotten.fingerprint, untouched.fingerprint);
}

#[test]
fn a_branch_leaves_the_original_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (out, other, third) = (folder.path().join("out"), folder.path().join("other"), folder.path().join("third"));
    let first = touched(&out);
    let before = all_files(&out);
    let from = |out2: &Path, set: &[&str]| {
        let how = Branching { set: set.iter().map(|s| (*s).to_owned()).collect(), forget: false };
        branch(&out, Moment::Step(33), out2, &how, &Registry::standard(), &Limits::default())
    };
    assert_eq!(from(&other, &[]).unwrap().frame.steps_done, 30);
    assert_eq!(resume(&other).fingerprint, first.fingerprint);
    assert_eq!(places(&timeline(&other)), places(&timeline(&out)));
    from(&third, &["rain.steps=35", "ash.amplitude=9.0"]).unwrap();
    let changed = resume(&third);
    assert_ne!(changed.fingerprint, first.fingerprint);
    assert_eq!(changed.world.step, 35 + 33);
    for (out2, set, part) in [
        (&other, &[][..], "not empty"),
        (&folder.path().join("x"), &["seed=6"][..], "settled"),
        (&folder.path().join("z"), &["hill.height=90.0"][..], "a change comes too late"),
        (&folder.path().join("y"), &["ash.amplitude=wet"][..], "amplitude"),
    ] {
        let e = from(out2, set).unwrap_err();
        assert!(e.is_refusal() && e.to_string().contains(part), "{e}");
    }
    assert_same(&all_files(&out), &before, "the original");
}

#[test]
fn a_paused_run_goes_back_and_forth() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, out, other) = (folder.path().join("whole"), folder.path().join("out"), folder.path().join("other"));
    let first = touched(&whole);
    let handle = Run::start(recipe(&[]), RunOptions { paused: true, ..options(Some(&out), Some(RECORD)) }).unwrap();
    handle.send(Command::Step(14));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { step: 13, .. }));
    handle.send(Command::Change(eyot::Change::parse("hydraulic.rain=0.01").unwrap()));
    handle.send(Command::Step(7));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { step: 20, .. }));
    handle.send(Command::Change(eyot::Change::parse("thermal.enabled=false").unwrap()));
    // The ash is a step, too.
    handle.send(Command::Step(27 + 1 + 14));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { recipe_step: 4, step: 14 }));
    let go = |step| {
        handle.send(Command::Rewind { step, forget: false });
        common::wait_for(&handle, |e| matches!(e, Event::Rewound { .. } | Event::Warning { .. }))
    };
    for (step, at) in [(15, 10), (61, 60), (0, 0), (47, 47), (29, 20)] {
        let back = go(step);
        assert!(matches!(back, Event::Rewound { steps_done, .. } if steps_done == at), "{back:?}");
        handle.send(Command::Snapshot);
        let Event::Snapshot { world, .. } = common::wait_for(&handle, |e| matches!(e, Event::Snapshot { .. })) else {
            panic!()
        };
        let t = timeline(&whole);
        assert_eq!(*world, t.load(t.find(Moment::Step(at)).unwrap().frame, &eyot::component_kinds()).unwrap());
    }
    handle.send(Command::Branch { step: 12, out: other.clone() });
    common::wait_for(&handle, |e| matches!(e, Event::Branched { steps_done: 10, .. }));
    // Stopped there, it stays there: the frames beyond belong to a future that may not be.
    handle.send(Command::Stop);
    assert_eq!(handle.join().unwrap().world.step, 20);
    let handle = Run::resume(&out, &Registry::standard(), options(None, None)).unwrap();
    assert_eq!(handle.join().unwrap().fingerprint, first.fingerprint);
    assert_same(&results(&out), &results(&whole), "back and forth");
    assert_eq!(resume(&other).fingerprint, first.fingerprint);
}

#[test]
fn a_paused_run_that_went_back_takes_another_way() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let handle = Run::start(recipe(&[]), RunOptions { paused: true, ..options(Some(&out), Some(RECORD)) }).unwrap();
    handle.send(Command::Step(34));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { step: 33, .. }));
    handle.send(Command::Rewind { step: 10, forget: true });
    common::wait_for(&handle, |e| matches!(e, Event::Rewound { frame: 1, .. }));
    handle.send(Command::Change(eyot::Change::parse("hydraulic.rain=0.01").unwrap()));
    common::wait_for(&handle, |e| matches!(e, Event::Changed(entry) if entry.step == 10));
    assert_eq!(places(&timeline(&out)), [(0, 2, 0), (10, 2, 10)]);
    handle.send(Command::Resume);
    let other = handle.join().unwrap();
    let again = RunOptions { replay: other.journal.clone(), ..options(None, None) };
    let again = Run::start(recipe(&[]), again).unwrap().join().unwrap();
    assert_eq!(again.fingerprint, other.fingerprint);
    assert_eq!(timeline(&out).frames().len(), 10);
}

#[test]
fn a_run_resumes_from_its_last_frame_if_that_is_later_than_its_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let first = run(&out, Some(RECORD));
    let early = folder.path().join("early");
    branch(&out, Moment::Step(0), &early, &Branching::default(), &Registry::standard(), &Limits::default()).unwrap();
    // As a kill leaves it: an early checkpoint that says nothing of going back, and frames.
    rewind(&out, Moment::Step(60), false, &Registry::standard(), &Limits::default()).unwrap();
    let checkpoint = out.join(store::CHECKPOINT_FILE);
    let saved =
        eyot_io::checkpoint::load(&early.join(store::CHECKPOINT_FILE), &Limits::default(), &eyot::component_kinds())
            .unwrap();
    let mut state = saved.state.clone();
    state["rewound"] = false.into();
    let early_checkpoint = || eyot_io::checkpoint::save(&checkpoint, &saved.world, &saved.recipe_toml, &state).unwrap();
    early_checkpoint();
    let started = |what: &str| {
        let handle =
            Run::resume(&out, &Registry::standard(), RunOptions { paused: true, ..options(None, None) }).unwrap();
        let at = common::wait_for(&handle, |e| matches!(e, Event::Paused { .. }));
        handle.send(Command::Stop);
        handle.join().unwrap();
        assert!(matches!(at, Event::Paused { .. }), "{what}");
        at
    };
    assert!(matches!(started("from the frame"), Event::Paused { recipe_step: 4, step: 13 }));
    // Damaged frames and damaged checkpoints stand in for each other.
    std::fs::write(&checkpoint, "garbage").unwrap();
    assert!(matches!(started("without a checkpoint"), Event::Paused { recipe_step: 4, step: 13 }));
    early_checkpoint();
    std::fs::write(out.join("timeline.zarr/height/c/7/0/0"), "garbage").unwrap();
    assert!(matches!(started("from the frame before"), Event::Paused { recipe_step: 4, step: 3 }));
    assert_eq!(resume(&out).fingerprint, first.fingerprint);
}

#[test]
fn a_recording_that_cannot_be_is_refused_and_one_that_fails_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let refused = |recipe: Recipe, out: Option<&Path>, record| {
        let Err(e) = Run::start(recipe, options(out, Some(record))) else { panic!("it ran") };
        assert!(e.is_refusal() && e.help().is_some(), "{e}");
        e.to_string()
    };
    let dry = recipe(&["rain.enabled=false", "reefs.enabled=false"]);
    assert!(refused(dry, Some(&out), RECORD).contains("simulates nothing"));
    assert!(refused(recipe(&[]), None, RECORD).contains("without a folder"));
    assert!(
        refused(recipe(&[]), Some(&out), Record { max_bytes: 1 << 20, ..RECORD }).contains("cannot hold two frames")
    );
    assert!(!out.exists());
    for moment in [Moment::Step(0), Moment::Frame(0)] {
        let e = rewind(folder.path(), moment, false, &Registry::standard(), &Limits::default()).unwrap_err();
        assert!(e.to_string().contains("holds no recording") && e.is_refusal(), "{e}");
    }
    // Something that is no recording has its name.
    std::fs::create_dir_all(out.join("timeline.zarr")).unwrap();
    std::fs::write(out.join("timeline.zarr/mine.txt"), "x").unwrap();
    assert!(Run::start(recipe(&[]), options(Some(&out), Some(RECORD))).is_err());
    assert!(run(&out, None).finished && out.join("timeline.zarr/mine.txt").exists());
    // A recording that is broken while the run is at work does not end it.
    let out = folder.path().join("broken");
    let handle = Run::start(recipe(&[]), RunOptions { paused: true, ..options(Some(&out), Some(RECORD)) }).unwrap();
    handle.send(Command::Step(14));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { step: 13, .. }));
    std::fs::remove_dir_all(out.join("timeline.zarr")).unwrap();
    std::fs::write(out.join("timeline.zarr"), "x").unwrap();
    handle.send(Command::Resume);
    let warnings = handle.events().iter().filter(|e| matches!(e, Event::Warning { .. })).count();
    assert_eq!(warnings, 1);
    assert!(handle.join().unwrap().finished);
}

#[test]
fn a_folder_at_work_is_not_set_back_and_a_new_run_has_no_old_frames() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    run(&out, Some(RECORD));
    let handle = Run::start(recipe(&[]), RunOptions { paused: true, ..options(Some(&out), Some(RECORD)) }).unwrap();
    let removed = common::wait_for(&handle, |e| matches!(e, Event::Warning { .. }));
    assert!(
        matches!(&removed, Event::Warning { message } if message.to_string().contains("was removed")),
        "{removed:?}"
    );
    common::wait_for(&handle, |e| matches!(e, Event::Paused { .. }));
    assert!(matches!(
        rewind(&out, Moment::Step(0), false, &Registry::standard(), &Limits::default()),
        Err(RunError::Busy { .. })
    ));
    // Looking is always possible.
    assert!(timeline(&out).frames().is_empty());
    handle.send(Command::Stop);
    handle.join().unwrap();
    let e = rewind(&out, Moment::Step(0), false, &Registry::standard(), &Limits::default()).unwrap_err();
    assert!(e.to_string().contains("no frames yet"), "{e}");
    let o = RunOptions { restart: true, ..options(Some(&out), None) };
    Run::start(recipe(&[]), o).unwrap().join().unwrap();
    assert!(!out.join("timeline.zarr").exists());
}

/// The attribute `seconds_per_step` of a recording.
fn clock(out: &Path) -> Option<f64> {
    let text = std::fs::read_to_string(out.join("timeline.zarr/zarr.json")).unwrap();
    serde_json::from_str::<serde_json::Value>(&text).unwrap()["attributes"]["seconds_per_step"].as_f64()
}

/// Processes that share a clock give steps a length in time; those that do not, or a change by hand, take it away.
#[test]
fn recordings_have_times_where_processes_agree() {
    let folder = tempfile::tempdir().unwrap();
    let recorded = |name: &str, set: &[&str], replay: Vec<eyot::JournalEntry>| {
        let out = folder.path().join(name);
        let o = RunOptions { replay, ..options(Some(&out), Some(RECORD)) };
        Run::start(recipe(set), o).unwrap().join().unwrap();
        clock(&out)
    };
    // Hydraulic erosion counts seconds, the reef years.
    assert_eq!(recorded("both", &[], vec![]), None);
    let seconds = recorded("rain", &["reefs.enabled=false", "hydraulic.time_step=0.125"], vec![]);
    assert_eq!(seconds, Some(0.125));
    let every = recorded("every", &["reefs.enabled=false", "hydraulic.time_step=0.125", "hydraulic.every=2"], vec![]);
    assert_eq!(every, Some(0.0625));
    let set = "hydraulic.time_step=0.25".to_owned();
    let change = vec![eyot::JournalEntry { recipe_step: 2, step: 15, set }];
    assert_eq!(recorded("changed", &["reefs.enabled=false", "hydraulic.time_step=0.125"], change), None);
    let other = "hydraulic.rain=0.001".to_owned();
    let change = vec![eyot::JournalEntry { recipe_step: 2, step: 15, set: other }];
    assert_eq!(recorded("kept", &["reefs.enabled=false", "hydraulic.time_step=0.125"], change), Some(0.125));
}

/// What is lost of a recording costs its frame and no other: ways back lead to the frames that are whole, by name.
#[test]
fn lost_frames_are_told_and_the_others_lead_back() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    run(&out, Some(RECORD));
    let whole = results(&out);
    let store = out.join("timeline.zarr");
    std::fs::remove_file(store.join(".frames/2.eyot")).unwrap();
    std::fs::remove_file(store.join("height/c/4/0/0")).unwrap();
    std::fs::write(store.join("water/c/6/0/0"), "damaged").unwrap();
    let t = timeline(&out);
    let damaged: Vec<_> = t.damaged().iter().map(|d| (d.frame, d.steps_done)).collect();
    assert_eq!(damaged, [(2, 20), (4, 40)], "{:?}", t.damaged());
    assert_eq!(t.frames().iter().map(|f| f.frame).collect::<Vec<_>>(), [0, 1, 3, 5, 6, 7, 8, 9]);
    assert_eq!(t.find(Moment::Step(45)).unwrap().frame, 3);
    let e = t.find(Moment::Frame(2)).unwrap_err().to_string();
    assert!(e.contains("frame 2 of step 20") && e.contains("2.eyot"), "{e}");
    // By number it is an error; by step the next one before it.
    let limits = Limits::default();
    for (moment, part) in [(Moment::Frame(4), "frame 4 is missing"), (Moment::Frame(6), "water")] {
        let e = rewind(&out, moment, false, &Registry::standard(), &limits).unwrap_err();
        assert!(e.is_refusal() && e.to_string().contains(part), "{e}");
    }
    let other = folder.path().join("other");
    let to = Moment::Step(42);
    let done = branch(&out, to, &other, &Branching::default(), &Registry::standard(), &limits).unwrap();
    assert_eq!((done.frame.frame, done.damaged.len(), done.damaged[0].frame), (3, 1, 4));
    let done = rewind(&out, Moment::Step(55), false, &Registry::standard(), &limits).unwrap();
    assert_eq!((done.frame.steps_done, done.damaged.len()), (47, 1));
    assert!(done.damaged[0].reason.to_string().contains("water"), "{:?}", done.damaged);
    // Both go on to the same bytes.
    resume(&out);
    resume(&other);
    assert_same(&whole, &results(&out), "set back");
    assert_same(&whole, &results(&other), "branched");
    // A killed run goes on from the last frame that can be read.
    let torn = folder.path().join("torn");
    branch(&other, Moment::Step(70), &torn, &Branching::default(), &Registry::standard(), &limits).unwrap();
    std::fs::remove_file(torn.join("checkpoint.eyot")).unwrap();
    std::fs::write(torn.join("checkpoint.eyot"), "damaged").unwrap();
    let last = torn.join("timeline.zarr/height/c/8/0/0");
    std::fs::write(&last, "damaged").unwrap();
    let handle = Run::resume(&torn, &Registry::standard(), options(None, None)).unwrap();
    let told = common::wait_for(&handle, |e| matches!(e, Event::Warning { .. }));
    assert!(format!("{told:?}").contains("frame 8 of step 70"), "{told:?}");
    handle.join().unwrap();
    assert_same(&whole, &results(&torn), "torn");
}

/// A frame that says of itself what no run of its recipe comes to leads nowhere.
#[test]
fn frames_beyond_their_run_are_refused() {
    use eyot_io::timeline::Timeline as Store;
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    run(&out, Some(RECORD));
    let mut store = Store::open_to_write(&out.join("timeline.zarr"), &Limits::default()).unwrap();
    let last = store.load(9, &eyot::component_kinds()).unwrap();
    let mut wrong = Vec::new();
    let mut put = |change: &dyn Fn(&mut eyot::World, &mut serde_json::Value), part: &'static str| {
        let (mut world, mut state) = (last.world.clone(), last.state.clone());
        world.step = 1000 + wrong.len() as u64;
        change(&mut world, &mut state);
        store.append(&world, &last.recipe_toml, &state).unwrap();
        wrong.push(part);
    };
    put(&|_, _| {}, "at step 1000, the recipe has 80");
    put(&|_, state| state["done_steps"] = 7.into(), "7 steps of the recipe are done, it has 5");
    put(&|_, state| (state["done_steps"], state["done"]) = (1.into(), 48.into()), "48 steps of recipe step 2");
    put(&|world, _| world.grid.cell_x_m = 20.0, "40 x 30 cells of 20 x 10 m");
    let before = all_files(&out);
    for (i, part) in (10..).zip(wrong) {
        let e = rewind(&out, Moment::Frame(i), false, &Registry::standard(), &Limits::default()).unwrap_err();
        assert!(e.to_string().contains(part) && e.to_string().contains(&format!("frame {i}")), "{part}: {e}");
        let to = folder.path().join(i.to_string());
        let e = branch(&out, Moment::Frame(i), &to, &Branching::default(), &Registry::standard(), &Limits::default());
        assert!(e.unwrap_err().to_string().contains(part) && !to.exists(), "{part}");
    }
    assert_same(&before, &all_files(&out), "refused");
}

/// A branch stands for itself: not in the folder of its run, not around it, by whatever way.
#[test]
fn a_branch_goes_nowhere_near_its_run() {
    let folder = tempfile::tempdir().unwrap();
    let home = folder.path().canonicalize().unwrap();
    let out = home.join("runs/out");
    run(&out, Some(RECORD));
    std::fs::create_dir(home.join("empty")).unwrap();
    let mut ways = vec![
        (out.clone(), "is the folder of the run itself"),
        (out.join("branch"), "lies in the folder"),
        (out.join("timeline.zarr/branch"), "lies in the folder"),
        (home.join("runs"), "holds the folder"),
        (home.clone(), "holds the folder"),
        (home.join("empty/../runs/out/branch"), "lies in the folder"),
        (home.join("none/../runs/./out/deep/branch"), "lies in the folder"),
        (out.join("branch/../../../runs/out/x"), "lies in the folder"),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&out, home.join("link")).unwrap();
        std::os::unix::fs::symlink(&home, home.join("empty/up")).unwrap();
        ways.push((home.join("link/branch"), "lies in the folder"));
        ways.push((home.join("empty/up/runs/out/branch"), "lies in the folder"));
        ways.push((home.join("empty/up"), "holds the folder"));
    }
    let before = all_files(&out);
    for (way, part) in ways {
        let e = branch(&out, Moment::Step(20), &way, &Branching::default(), &Registry::standard(), &Limits::default());
        let e = e.unwrap_err();
        assert!(e.is_refusal() && e.to_string().contains(part), "{}: {e}", way.display());
    }
    assert_same(&before, &all_files(&out), "refused");
    assert!(!out.join("branch").exists() && !out.join("deep").exists());
    // One that is called almost the same is another folder.
    for way in [home.join("runs/out2"), out.join("../other")] {
        branch(&out, Moment::Step(20), &way, &Branching::default(), &Registry::standard(), &Limits::default()).unwrap();
    }
}
