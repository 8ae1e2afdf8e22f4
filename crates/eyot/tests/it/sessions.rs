//! Sessions: the same runs, polled by their host.

use crate::stubs::{GOOD, parse, registry};

use eyot::session::{Budget, Clock, Host, Session, SessionOptions, Status};
use eyot::{
    Change, Command, Event, JournalEntry, Limits, Overrides, Recipe, RecipeSource, Record, Registry, Run, RunOptions,
};
use eyot_io::storage::Memory;
use std::time::{Duration, Instant};

fn recipe(steps: u64) -> Recipe {
    parse(GOOD, &[&format!("step.2.steps={steps}")]).unwrap()
}

fn session(steps: u64, options: SessionOptions) -> Session {
    Session::new(recipe(steps), options, Host::new(&registry(), Clock::system())).unwrap()
}

#[test]
fn a_session_that_is_polled_makes_the_bytes_of_a_run() {
    let run = Run::start(recipe(200), RunOptions::default()).unwrap().join().unwrap();
    for budget in
        [Budget::Time(Duration::ZERO), Budget::Time(Duration::from_millis(16)), Budget::Steps(7), Budget::Piece]
    {
        let mut s = session(200, SessionOptions::default());
        let mut events = Vec::new();
        while s.advance(budget).unwrap() == Status::Working {
            events.extend(s.events());
        }
        events.extend(s.events());
        assert_eq!(s.advance(budget).unwrap(), Status::Finished);
        assert!(matches!(events.first(), Some(Event::Started { .. })));
        assert!(matches!(events.last(), Some(Event::Done { .. })));
        assert_eq!(events.iter().filter(|e| matches!(e, Event::StepDone { .. })).count(), 3);
        let outcome = s.into_outcome().unwrap();
        assert!(outcome.finished && outcome.outputs.is_empty());
        assert_eq!(outcome.fingerprint, run.fingerprint, "{budget:?}");
        assert_eq!(outcome.world, run.world);
    }
}

#[test]
fn a_budget_of_steps_is_kept_and_one_of_time_nearly() {
    let mut s = session(1_000_000, SessionOptions::default());
    while s.world().step == 0 {
        assert_eq!(s.advance(Budget::Steps(1)).unwrap(), Status::Working);
    }
    let before = s.world().step;
    assert_eq!(s.advance(Budget::Steps(9)).unwrap(), Status::Working);
    assert_eq!(s.world().step, before + 9);
    for _ in 0..3 {
        let begun = Instant::now();
        s.advance(Budget::Time(Duration::from_millis(2))).unwrap();
        // Whole seconds would be a chunk of 0.3 s, or all of it: other tests are at work beside this one.
        assert!(begun.elapsed() < Duration::from_secs(5));
    }
    assert!(s.world().step > before + 9);
    s.command(Command::Stop);
    assert_eq!(s.advance(Budget::Piece).unwrap(), Status::Working);
    assert_eq!(s.advance(Budget::Piece).unwrap(), Status::Stopped);
    assert!(!s.into_outcome().unwrap().finished);
}

#[test]
fn a_paused_session_returns_at_once_and_takes_typed_commands() {
    let mut s = session(40, SessionOptions { paused: true, ..SessionOptions::default() });
    let until_paused = |s: &mut Session| while s.advance(Budget::Piece).unwrap() != Status::Paused {};
    until_paused(&mut s);
    assert_eq!(s.advance(Budget::Time(Duration::from_secs(3600))).unwrap(), Status::Paused);
    s.command(Command::Step(11));
    until_paused(&mut s);
    // A generator counts as one.
    assert_eq!(s.world().step, 10);
    s.events();
    s.command(Command::Change(Change::new("hydraulic.rain", 0.5)));
    s.command(Command::Change(Change::new("hydraulic.rian", 0.5)));
    until_paused(&mut s);
    let entry = JournalEntry { recipe_step: 2, step: 10, set: "hydraulic.rain = 0.5".into() };
    match &s.events()[..] {
        [Event::Changed(e), Event::NotChanged { set, reason }] => {
            assert!(*e == entry && reason.to_string().contains("did you mean `rain`?"), "{reason}");
            assert_eq!(set, "hydraulic.rian = 0.5");
        }
        other => panic!("{other:?}"),
    }
    s.command(Command::Resume);
    while s.advance(Budget::Piece).unwrap() == Status::Working {}
    let outcome = s.into_outcome().unwrap();
    assert_eq!(outcome.journal, std::slice::from_ref(&entry));
    let again = Run::start(recipe(40), RunOptions { replay: vec![entry], ..RunOptions::default() }).unwrap();
    assert_eq!(again.join().unwrap().fingerprint, outcome.fingerprint);
}

/// A host may have a clock that stands still: everything comes in chunks of steps then.
#[test]
fn a_session_needs_no_clock_of_the_system() {
    let still = Host::new(&registry(), Clock::new(|| Duration::ZERO));
    let mut s = Session::new(recipe(60), SessionOptions::default(), still).unwrap();
    while s.advance(Budget::Steps(5)).unwrap() == Status::Working {}
    let run = Run::start(recipe(60), RunOptions::default()).unwrap().join().unwrap();
    assert_eq!(s.into_outcome().unwrap().fingerprint, run.fingerprint);
}

/// Runs until it ends, or until so many steps are done, and stops it there.
fn go(mut s: Session, until: u64) -> eyot::Outcome {
    loop {
        match s.advance(Budget::Steps(5)).unwrap() {
            Status::Working if s.world().step >= until => s.command(Command::Stop),
            Status::Working => {}
            Status::Finished | Status::Stopped => return s.into_outcome().unwrap(),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_session_in_memory_is_stopped_resumed_and_set_back_without_a_disk() {
    let folder = tempfile::tempdir().unwrap();
    let record = Some(Record { every: 10, max_bytes: 1 << 30 });
    let run = RunOptions { out: Some(folder.path().to_owned()), record, ..RunOptions::default() };
    let run = Run::start(recipe(60), run).unwrap().join().unwrap();
    let memory = Memory::new();
    let host = || Host::new(&registry(), Clock::system()).with_storage(memory.clone());
    let options = || SessionOptions { record, ..SessionOptions::default() };

    let part = go(Session::new(recipe(60), options(), host()).unwrap(), 30);
    assert!(!part.finished && part.world.step >= 30 && part.world.step < 60);
    assert!(memory.names().contains(&"checkpoint.eyot".to_owned()));
    // Set back to an earlier frame, and forth again to the end.
    let mut s = Session::resume(SessionOptions { paused: true, ..options() }, host()).unwrap();
    while s.advance(Budget::Piece).unwrap() != Status::Paused {}
    s.command(Command::Rewind { step: 12, forget: false });
    while s.advance(Budget::Piece).unwrap() != Status::Paused {}
    assert_eq!(s.world().step, 10);
    assert!(s.events().iter().any(|e| matches!(e, Event::Rewound { frame: 1, steps_done: 10, .. })));
    s.command(Command::Resume);
    let end = go(s, u64::MAX);
    assert!(end.finished);
    assert_eq!(end.fingerprint, run.fingerprint);
    let names = memory.names();
    assert!(names.contains(&"world.eyot".to_owned()) && !names.contains(&"checkpoint.eyot".to_owned()), "{names:?}");
    assert!(Session::resume(options(), host()).is_err(), "a finished run was resumed");
    // The recordings are the same, frame by frame.
    let pieces = |name: &&String| name.starts_with("timeline.zarr/height/");
    for name in names.iter().filter(pieces) {
        let bytes = eyot_io::storage::read_bytes(&memory, name, 1 << 30).unwrap();
        assert!(std::fs::read(folder.path().join(name)).unwrap() == bytes, "{name}");
    }
    assert!(names.iter().filter(pieces).count() >= 7);
}

/// Whoever is killed before the first checkpoint leaves the recipe.
#[test]
fn a_session_that_was_dropped_at_its_start_begins_anew() {
    let memory = Memory::new();
    let host = || Host::new(&registry(), Clock::system()).with_storage(memory.clone());
    let mut s = Session::new(recipe(60), SessionOptions::default(), host()).unwrap();
    s.advance(Budget::Steps(1)).unwrap();
    drop(s);
    let mut s = Session::resume(SessionOptions::default(), host()).unwrap();
    assert!(matches!(&s.events()[..], [Event::Warning { message }] if message.to_string().contains("begins anew")));
    let whole = Run::start(recipe(60), RunOptions::default()).unwrap().join().unwrap();
    assert_eq!(go(s, u64::MAX).fingerprint, whole.fingerprint);
}

/// A reef whose sea rises by `rise` metres in each of `steps` steps of a year.
fn drowning(rise: f64, steps: u64) -> Result<Recipe, String> {
    drowning_every(1, rise, steps)
}

/// The same in every so many steps.
fn drowning_every(every: u64, rise: f64, steps: u64) -> Result<Recipe, String> {
    let text = format!(
        "[grid]\nsize = 8\n[[step]]\ngenerate = \"cone\"\nheight = 300.0\n[[step]]\nsimulate = [\"reef\"]\nsteps = {steps}\n\
         reef.years_per_step = 10000\nreef.sea_level_rise = {}\nreef.every = {every}\n",
        rise / 10000.0
    );
    crate::common::parse(&text, &[], eyot::Overrides::default(), &eyot::Limits::default())
}

#[test]
fn a_sea_that_would_leave_the_range_of_heights_is_refused_before_the_run() {
    let e = drowning(4.0, 4000).err().unwrap();
    assert!(e.contains("step 2 (reef) goes too far: after step 3001 the sea would stand at 12004.0 m"), "{e}");
    drowning(4.0, 3000).unwrap();
    drowning(-4.0, 3000).unwrap();
    assert!(drowning(-4.0, 3001).err().unwrap().contains("-12004.0 m"));
}

/// Farther than the check looks the run itself finds out, before the step.
#[test]
fn a_run_that_drowns_ends_before_and_leaves_a_checkpoint_that_can_be_read() {
    let memory = Memory::new();
    let host = || Host::new(&eyot::Registry::standard(), Clock::system()).with_storage(memory.clone());
    let options = || SessionOptions { chunk: Some(100), ..SessionOptions::default() };
    let recipe = drowning_every(10, 3.6, 40_000).unwrap();
    let mut s = Session::new(recipe, options(), host()).unwrap();
    while s.world().step < 1000 {
        assert_eq!(s.advance(Budget::Piece).unwrap(), Status::Working);
    }
    s.command(Command::Stop);
    while s.advance(Budget::Piece).unwrap() == Status::Working {}
    let mut s = Session::resume(options(), host()).unwrap();
    let e = loop {
        if let Err(e) = s.advance(Budget::Piece) {
            break e;
        }
    };
    assert!(e.to_string().contains("after step 33331 the sea would stand at 12002.4 m"), "{e}");
    assert!(e.help().is_some() && s.world().step == 33_300);
    let again = Session::resume(options(), host()).unwrap();
    assert!(again.world().step >= 1000 && again.world().sea_level_m <= 12000.0);
}

/// What `check` would refuse of a recipe is refused at work, too, and the run goes on.
#[test]
fn a_change_that_would_drown_the_world_is_not_made() {
    let options = SessionOptions { chunk: Some(50), ..SessionOptions::default() };
    let host = Host::new(&eyot::Registry::standard(), Clock::system());
    let mut s = Session::new(drowning(4.0, 200).unwrap(), options, host).unwrap();
    while s.world().step < 100 {
        assert_eq!(s.advance(Budget::Piece).unwrap(), Status::Working);
    }
    s.events();
    for change in [Change::new("reef.sea_level_rise", 0.012), Change::new("sea_level", 11_900.0)] {
        s.command(Command::Change(change));
        assert_eq!(s.advance(Budget::Piece).unwrap(), Status::Working);
        let events = s.events();
        let refused =
            |e: &Event| matches!(e, Event::NotChanged { reason, .. } if reason.to_string().contains("the sea would"));
        assert!(events.iter().any(refused), "{events:?}");
    }
    while s.advance(Budget::Piece).unwrap() == Status::Working {}
    let outcome = s.into_outcome().unwrap();
    assert!(outcome.finished && outcome.journal.is_empty());
}

/// What the frames of a recording say of their runs, but for times.
fn frames(memory: &Memory) -> Vec<serde_json::Value> {
    let storage = std::sync::Arc::new(memory.clone());
    let timeline = eyot_io::timeline::Timeline::open_in(storage, "timeline.zarr", &eyot::Limits::default()).unwrap();
    let timeless = |i: usize| {
        let mut state = timeline.state(i).unwrap();
        ["seconds", "timings", "card_seconds"].iter().for_each(|key| state[*key] = serde_json::Value::Null);
        serde_json::json!([timeline.frames()[i].step, state])
    };
    (0..timeline.frames().len()).map(timeless).collect()
}

/// Wherever it is killed, also between the last step of one simulation and the first of the next, or after the very last.
#[test]
fn a_recording_is_the_same_however_often_its_run_was_killed() {
    let text = GOOD.replacen(
        "[[step]]\ngenerate = \"noise\"\nlayer",
        "[[step]]\nsimulate = [\"hydraulic\"]\nsteps = 15\n[[step]]\nenabled = false\ngenerate = \"noise\"\nlayer",
        1,
    );
    let recipe = || parse(&text.replace("layers = [\"height\", \"rough\"]", ""), &["step.2.steps=20"]).unwrap();
    let record = Some(Record { every: 10, max_bytes: 1 << 30 });
    let options =
        || SessionOptions { record, chunk: Some(5), checkpoint_every: Duration::ZERO, ..SessionOptions::default() };
    // While the clock stands still, a checkpoint is due after each piece of work.
    let clock = || Clock::new(|| Duration::ZERO);
    let host = |memory: &Memory| Host::new(&registry(), clock()).with_storage(memory.clone());
    let whole = Memory::new();
    go(Session::new(recipe(), options(), host(&whole)).unwrap(), u64::MAX);
    let wanted = frames(&whole);
    assert_eq!(wanted.iter().map(|f| f[0].as_u64().unwrap()).collect::<Vec<_>>(), [0, 10, 20, 30, 35]);
    for pieces in 1.. {
        let memory = Memory::new();
        let mut s = Session::new(recipe(), options(), host(&memory)).unwrap();
        let mut ended = false;
        for _ in 0..pieces {
            ended |= s.advance(Budget::Piece).unwrap() != Status::Working;
        }
        drop(s);
        if ended {
            assert!(pieces > 10, "{pieces}");
            break;
        }
        go(Session::resume(options(), host(&memory)).unwrap(), u64::MAX);
        assert_eq!(frames(&memory), wanted, "killed after {pieces} pieces");
    }
}

/// A clock of the test's own: each look at it is so many milliseconds later.
fn announced(steps: u64, milliseconds: u64) -> (Vec<(f64, u64, bool)>, u64) {
    let looks = std::sync::Arc::new(std::sync::atomic::AtomicU64::new(0));
    let clock = Clock::new(move || {
        let n = looks.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        Duration::from_millis(n * milliseconds)
    });
    let mut s = Session::new(
        recipe(steps),
        SessionOptions { chunk: Some(1), ..SessionOptions::default() },
        Host::new(&registry(), clock),
    )
    .unwrap();
    while s.advance(Budget::Piece).unwrap() == Status::Working {}
    let long = |e: Event| match e {
        Event::Long { seconds, timed, rough } => Some((seconds, timed, rough)),
        _ => None,
    };
    (s.events().into_iter().filter_map(long).collect(), s.into_outcome().unwrap().fingerprint)
}

#[test]
fn a_run_that_will_take_minutes_says_so_early_and_once() {
    // Two looks at the clock a step: half a second each, three hundred steps.
    let (told, slow) = announced(300, 500);
    assert_eq!(told.len(), 1, "{told:?}");
    let (seconds, timed, rough) = told[0];
    assert!(timed <= 2 && !rough, "{told:?}");
    assert!((seconds - 0.5 * (300 - 1 - timed) as f64).abs() < 1e-6, "{told:?}");
    let (told, quick) = announced(300, 1);
    assert!(told.is_empty(), "{told:?}");
    assert_eq!(slow, quick, "the announcement changed the bytes");
}

/// Each crosses what `check` would refuse of a whole recipe: what processes share, and where the sea comes to.
#[test]
fn changes_are_checked_as_recipes_are() {
    let text = "[grid]\nsize = 12\ncell = 1000.0\n[[step]]\ngenerate = \"cone\"\nheight = 100.0\n[[step]]\nsimulate = [\"temperature\", \
                \"wind\", \"reef\"]\nsteps = 30\n[view]\nenabled = false\n";
    let source = RecipeSource { name: "t.toml".into(), text: text.into(), folder: ".".into() };
    let recipe =
        || Recipe::parse(source.clone(), Overrides::default(), &Registry::standard(), &Limits::default()).unwrap();
    let options = SessionOptions { paused: true, ..SessionOptions::default() };
    let mut s = Session::new(recipe(), options, Host::new(&Registry::standard(), Clock::system())).unwrap();
    let until_paused = |s: &mut Session| while s.advance(Budget::Piece).unwrap() != Status::Paused {};
    s.command(Command::Step(4));
    until_paused(&mut s);
    s.events();
    for (change, words) in [
        (Change::new("wind.tilt", 3.0), "write temperature.tilt = 3 as well"),
        (
            Change::together([Change::new("reef.sea_level_rise", 1.0), Change::new("reef.years_per_step", 1000.0)]),
            "the sea would stand at",
        ),
    ] {
        s.command(Command::Change(change));
        until_paused(&mut s);
        match &s.events()[..] {
            [Event::NotChanged { reason, .. }] => assert!(reason.to_string().contains(words), "{reason}"),
            other => panic!("{other:?}"),
        }
    }
    let tilt = |process: &str| Change::new(&format!("{process}.tilt"), 3.0);
    s.command(Command::Change(Change::together([tilt("wind"), tilt("temperature")])));
    s.command(Command::Change(Change::new("layer.height", 5.0)));
    s.command(Command::Resume);
    while s.advance(Budget::Piece).unwrap() == Status::Working {}
    let outcome = s.into_outcome().unwrap();
    assert_eq!(outcome.journal.len(), 2);
    assert!(outcome.world.ledger.amount("ground.by_hand") < 0.0);
    let o = RunOptions { replay: outcome.journal.clone(), ..RunOptions::default() };
    assert_eq!(Run::start(recipe(), o).unwrap().join().unwrap().fingerprint, outcome.fingerprint);
}
