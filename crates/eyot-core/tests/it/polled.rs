//! Engines whose host must not wait: a span keeps its place wherever it is told that the engine is not ready.

use crate::actions::{scheduled, world};
use eyot_core::engine::{Ahead, Borrowed, CpuEngine, CpuRunner, Engine, EngineError, Saved};
use eyot_core::plan::Plan;
use eyot_core::process::Span;
use eyot_core::stepper::Simulation;
use eyot_core::{Cancel, Control, Error, Grid, Limits, Rim, World};
use std::borrow::Cow;

/// The processor, which is ready only when it is asked for the third time.
struct Slow {
    engine: CpuRunner,
    asked: u32,
    refused: u32,
}

impl Slow {
    fn new() -> Self {
        Self { engine: CpuEngine::default().runner(), asked: 0, refused: 0 }
    }

    fn ready(&mut self) -> Result<&mut CpuRunner, EngineError> {
        self.asked += 1;
        if self.asked.is_multiple_of(3) {
            return Ok(&mut self.engine);
        }
        self.refused += 1;
        Err(EngineError::NotReady)
    }
}

impl Engine for Slow {
    fn name(&self) -> String {
        self.engine.name()
    }
    fn limits(&self) -> Limits {
        self.engine.limits()
    }
    fn block(&self, grid: &Grid) -> u64 {
        self.engine.block(grid)
    }
    fn begin(&mut self, world: &mut World, ahead: &Ahead<'_>) -> Result<(), EngineError> {
        self.engine.begin(world, ahead)
    }
    fn plan_end(&self, ahead: &Ahead<'_>, at: u64) -> u64 {
        self.engine.plan_end(ahead, at)
    }
    fn run(&mut self, world: &mut World, plan: &Plan, ahead: &Ahead<'_>) -> Result<(), EngineError> {
        self.ready()?.run(world, plan, ahead)
    }
    fn lend(
        &mut self,
        world: &mut World,
        borrowed: &Borrowed,
        work: &mut dyn FnMut(&mut World) -> eyot_core::Result<()>,
    ) -> Result<(), EngineError> {
        self.ready()?.lend(world, borrowed, work)
    }
    fn save(&mut self, world: &mut World, writes: &[Cow<'static, str>]) -> Result<Saved, EngineError> {
        self.ready()?.save(world, writes)
    }
    fn restore(&mut self, world: &mut World, saved: Saved) {
        self.engine.restore(world, saved);
    }
    fn completed(&self) -> u64 {
        self.engine.completed()
    }
    fn wait(&mut self) -> Result<(), EngineError> {
        self.ready()?.wait()
    }
    fn end(&mut self, world: &mut World) -> Result<(), EngineError> {
        self.ready()?.end(world)
    }
    fn download(&mut self, world: &mut World) -> Result<(), EngineError> {
        self.ready()?.download(world)
    }
    fn release(&mut self) {
        self.engine.release();
    }
    fn fall_back(&mut self, world: &mut World) {
        self.engine.fall_back(world);
    }
    fn apply(&mut self, world: &mut World, plan: &Plan) -> Result<(), EngineError> {
        self.engine.apply(world, plan)
    }
}

/// Asks until there is another answer; how often, and the answer. The `nth` time a stop is asked for.
fn poll(world: &mut World, nth: u32, cancel: Cancel) -> (u32, Result<(), EngineError>) {
    let (mut engine, mut simulation) = (Slow::new(), Simulation::new(scheduled(None)));
    let control = Control::new(cancel.clone(), &|_, _| {});
    for asked in 1.. {
        if asked == nth {
            cancel.raise();
        }
        match simulation.advance(&mut engine, world, Span { from: 0, steps: 9 }, &control) {
            Err(EngineError::NotReady) => assert_eq!(engine.refused, asked),
            outcome => return (asked, outcome),
        }
    }
    unreachable!("it has an end")
}

fn straight(steps: u64) -> World {
    let mut w = world(Rim::WRAP);
    CpuEngine::default().simulate(&mut w, &scheduled(None), Span { from: 0, steps }, &Control::none()).unwrap();
    w
}

#[test]
fn a_span_goes_on_where_its_engine_was_not_ready() {
    let mut polled = world(Rim::WRAP);
    let (asked, outcome) = poll(&mut polled, 0, Cancel::default());
    outcome.unwrap();
    assert!(asked > 40, "{asked}");
    assert_eq!(polled, straight(9));
}

#[test]
fn a_stop_leaves_whole_steps_wherever_the_engine_was_not_ready() {
    let mut steps = Vec::new();
    for nth in (1..40).step_by(3) {
        let mut polled = world(Rim::WRAP);
        let (_, outcome) = poll(&mut polled, nth, Cancel::default());
        assert!(matches!(outcome, Err(EngineError::Core(Error::Cancelled(_)))), "{outcome:?}");
        assert_eq!(polled, straight(polled.step), "stopped when asked for the {nth}th time");
        steps.push(polled.step);
    }
    assert!(steps.is_sorted() && steps[0] == 0 && steps.last() > Some(&3), "{steps:?}");
}
