//! An engine that is seldom ready.

use crate::engine::{Ahead, Borrowed, Engine, EngineError, Saved};
use crate::grid::Grid;
use crate::limits::Limits;
use crate::plan::Plan;
use crate::world::World;
use std::borrow::Cow;

/// Another engine that says [`EngineError::NotReady`] wherever it may, but for every third time: so that hosts which must not wait can be
/// tested without a device.
pub struct Hesitant<E> {
    engine: E,
    asked: u64,
    refused: u64,
}

impl<E: Engine> Hesitant<E> {
    /// A hesitant form of `engine`.
    pub fn new(engine: E) -> Self {
        Self { engine, asked: 0, refused: 0 }
    }

    /// How often it was not ready.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    fn ready(&mut self) -> Result<&mut E, EngineError> {
        self.asked += 1;
        if self.asked.is_multiple_of(3) {
            return Ok(&mut self.engine);
        }
        self.refused += 1;
        Err(EngineError::NotReady)
    }
}

impl<E: Engine> Engine for Hesitant<E> {
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
        work: &mut dyn FnMut(&mut World) -> crate::error::Result<()>,
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
