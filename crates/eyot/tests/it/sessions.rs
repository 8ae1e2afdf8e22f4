//! Sessions: the same runs, polled by their host.

use crate::stubs::{GOOD, parse, registry};

use eyot::io::storage::Memory;
use eyot::session::{Budget, Clock, Host, Session, SessionOptions, Status};
use eyot::{Change, Command, Event, JournalEntry, Recipe, Record, Run, RunOptions};
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
        [Event::Changed(e), Event::Warning { message }] => {
            assert!(*e == entry && message.to_string().contains("did you mean `rain`?"), "{message}");
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
        let bytes = eyot::io::storage::read_bytes(&memory, name, 1 << 30).unwrap();
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
