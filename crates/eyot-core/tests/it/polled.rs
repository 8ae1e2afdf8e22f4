//! Engines whose host must not wait: a span keeps its place wherever it is told that the engine is not ready.

use crate::actions::{scheduled, world};
use eyot_core::engine::{CpuEngine, EngineError, Hesitant};
use eyot_core::process::Span;
use eyot_core::stepper::Simulation;
use eyot_core::{Boundary, Cancel, Control, Error, World};

/// Asks until there is another answer; how often, and the answer. The `nth` time a stop is asked for.
fn poll(world: &mut World, nth: u64, cancel: Cancel) -> (u64, Result<(), EngineError>) {
    let mut engine = Hesitant::new(CpuEngine::default().runner());
    let mut simulation = Simulation::new(scheduled(None));
    let control = Control::new(cancel.clone(), &|_, _| {});
    for asked in 1.. {
        if asked == nth {
            cancel.raise();
        }
        match simulation.advance(&mut engine, world, Span { from: 0, steps: 9 }, &control) {
            Err(EngineError::NotReady) => assert_eq!(engine.refused(), asked),
            outcome => return (asked, outcome),
        }
    }
    unreachable!("it has an end")
}

fn straight(steps: u64) -> World {
    let mut w = world(Boundary::WRAP);
    CpuEngine::default().simulate(&mut w, &scheduled(None), Span { from: 0, steps }, &Control::none()).unwrap();
    w
}

#[test]
fn a_span_goes_on_where_its_engine_was_not_ready() {
    let mut polled = world(Boundary::WRAP);
    let (asked, outcome) = poll(&mut polled, 0, Cancel::default());
    outcome.unwrap();
    assert!(asked > 40, "{asked}");
    assert_eq!(polled, straight(9));
}

#[test]
fn a_stop_leaves_whole_steps_wherever_the_engine_was_not_ready() {
    let mut steps = Vec::new();
    for nth in (1..40).step_by(3) {
        let mut polled = world(Boundary::WRAP);
        let (_, outcome) = poll(&mut polled, nth, Cancel::default());
        assert!(matches!(outcome, Err(EngineError::Core(Error::Cancelled(_)))), "{outcome:?}");
        assert_eq!(polled, straight(polled.step), "stopped when asked for the {nth}th time");
        steps.push(polled.step);
    }
    assert!(steps.is_sorted() && steps[0] == 0 && steps.last() > Some(&3), "{steps:?}");
}
