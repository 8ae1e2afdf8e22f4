//! Sessions: the same runs, polled by their host.

use crate::stubs::{GOOD, parse};

use eyot::session::{Budget, Clock, Host, Session, SessionOptions, Status};
use eyot::{Change, Command, Event, JournalEntry, Recipe, Run, RunOptions};
use std::time::{Duration, Instant};

fn recipe(steps: u64) -> Recipe {
    parse(GOOD, &[&format!("step.2.steps={steps}")]).unwrap()
}

fn session(steps: u64, options: SessionOptions) -> Session {
    Session::new(recipe(steps), options, Host::new(Clock::system())).unwrap()
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
    for _ in 0..20 {
        let begun = Instant::now();
        s.advance(Budget::Time(Duration::from_millis(10))).unwrap();
        // Whole seconds would be a chunk of 0.3 s, or all of it: other tests are at work beside this one.
        assert!(begun.elapsed() < Duration::from_secs(5));
    }
    assert!(s.world().step > before + 9 && s.world().step < 1_000_000);
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
    let still = Host::new(Clock::new(|| Duration::ZERO));
    let mut s = Session::new(recipe(60), SessionOptions::default(), still).unwrap();
    while s.advance(Budget::Steps(5)).unwrap() == Status::Working {}
    let run = Run::start(recipe(60), RunOptions::default()).unwrap().join().unwrap();
    assert_eq!(s.into_outcome().unwrap().fingerprint, run.fingerprint);
}
