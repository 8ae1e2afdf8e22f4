//! Engines of hosts that must not wait, such as browsers: the same bytes, asked for again and again.

use crate::engine::{Lift, engine, erosion, mountain};
use eyot_core::engine::EngineError;
use eyot_core::process::{Scheduled, Span};
use eyot_core::stepper::Simulation;
use eyot_core::{Boundary, Control, World};
use eyot_gpu::{GpuEngine, GpuError, Options};
use eyot_land::simulate::PROCESSES;
use std::time::{Duration, Instant};

/// Rules, an action that cannot fail, and one that may.
fn processes() -> Vec<Scheduled> {
    let power = PROCESSES.iter().find(|e| e.name == "streampower").unwrap();
    let mut processes = erosion();
    processes.insert(1, Scheduled { name: "lift", process: Box::new(Lift(None)), every: 5 });
    processes.push(Scheduled { name: "power", process: (power.make)((power.defaults)()).unwrap(), every: 7 });
    processes
}

/// Asks until there is an answer, which never takes long; how often there was none.
fn poll<T>(mut ask: impl FnMut() -> Result<T, EngineError>) -> (u32, Result<T, EngineError>) {
    let begun = Instant::now();
    for asked in 0.. {
        match ask() {
            Err(EngineError::NotReady) => std::thread::yield_now(),
            outcome => return (asked, outcome),
        }
        assert!(begun.elapsed() < Duration::from_secs(120), "no answer");
    }
    unreachable!("it has an answer")
}

fn advance(e: &mut GpuEngine, s: &mut Simulation, world: &mut World, span: Span) -> (u32, Result<(), EngineError>) {
    poll(|| s.advance(e, world, span, &Control::none()))
}

fn download(engine: &mut GpuEngine, world: &mut World) -> Result<(), EngineError> {
    poll(|| engine.download(world).map_err(EngineError::from)).1
}

#[test]
fn an_engine_that_never_waits_makes_the_same_bytes() {
    let Some(mut waits) = engine(Options::default()) else { return };
    let Some(mut polled) = engine(Options::default().polled(true)) else { return };
    let start = mountain(40, Boundary::OPEN);
    let (mut a, mut b) = (start.clone(), start);
    let span = |from| Span { from, steps: 16 };
    let (mut one, mut other) = (Simulation::new(processes()), Simulation::new(processes()));
    let mut refused = 0;
    for from in [0, 16] {
        one.advance(&mut waits, &mut a, span(from), &Control::none()).unwrap();
        let (often, outcome) = advance(&mut polled, &mut other, &mut b, span(from));
        outcome.unwrap();
        refused += often;
    }
    waits.download(&mut a).unwrap();
    download(&mut polled, &mut b).unwrap();
    println!("not ready {refused} times");
    assert!(refused > 0 && waits.work().waits > 0);
    assert_eq!(polled.work().waits, 0, "it waited");
    assert_eq!((a.step, &a.components), (b.step, &b.components));
    assert!(a.layers() == b.layers(), "layers");
    assert!(a.ledger.amount("lift.rock") > 0.0);
    for (name, account) in a.ledger.iter() {
        assert_eq!(account.amount.to_bits(), b.ledger.amount(name).to_bits(), "{name}");
    }
    let e = polled.simulate(&mut b, &processes(), span(32), &Control::none()).unwrap_err();
    assert!(matches!(e, GpuError::CannotWait), "it has no place to keep: {e}");
}

#[test]
fn a_device_lost_between_two_looks_leaves_the_last_sound_world() {
    for looks in [1, 5, 20] {
        let Some(mut engine) = engine(Options::default().polled(true)) else { return };
        let (mut world, mut simulation) = (mountain(40, Boundary::CLOSED), Simulation::new(processes()));
        advance(&mut engine, &mut simulation, &mut world, Span { from: 0, steps: 8 }).1.unwrap();
        download(&mut engine, &mut world).unwrap();
        let sound = world.clone();
        let span = Span { from: 8, steps: 64 };
        for _ in 0..looks {
            let outcome = simulation.advance(&mut engine, &mut world, span, &Control::none());
            assert!(matches!(outcome, Ok(()) | Err(EngineError::NotReady)), "{outcome:?}");
        }
        engine.gpu().destroy();
        let (_, outcome) = advance(&mut engine, &mut simulation, &mut world, span);
        assert!(matches!(outcome, Err(EngineError::Device(e)) if e.lost));
        assert_eq!(world, sound, "after {looks} looks");
    }
}
