//! The CPU engine: runs plans on all cores.
//!
//! Several steps make one chain of passes, which is swept as `sweep` says. Every cell's value is a pure function of the plan, so bands,
//! chains and threads never change a bit. Nor do they change a sum: each pass keeps its own per row, which are folded in a fixed order
//! and added to the ledger's accounts in the order of the plan, so that it does not matter either where a simulation is cut into spans.

use super::arena::Arena;
use super::{Ahead, Borrowed, Engine, EngineError, MemoryEstimate, Saved};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::isa::Isa;
use crate::limits::Limits;
use crate::plan::Plan;
use crate::process::{Moment, Scheduled, Span, plan_step};
use crate::stepper::Simulation;
use crate::world::World;
use std::borrow::Cow;

/// How plans are executed on the cores of the current rayon pool.
#[derive(Clone, Copy, Debug)]
pub struct CpuEngine {
    /// Instruction set.
    pub isa: Isa,
    /// Steps run as one chain; 0 chooses.
    pub chain: usize,
    /// Rows of a band; 0 chooses. Raised to what the chain's lag needs.
    pub band: usize,
    /// Bounds on what may be allocated.
    pub limits: Limits,
}

impl Default for CpuEngine {
    fn default() -> Self {
        Self { isa: Isa::best(), chain: 0, band: 0, limits: Limits::default() }
    }
}

impl CpuEngine {
    /// The engine, ready to work.
    pub const fn runner(self) -> CpuRunner {
        CpuRunner { engine: self, arena: None, chain: 1, completed: 0 }
    }

    /// Runs a span of steps of the given processes on the world. What acts is made anew; a [`Simulation`] keeps it from span to span.
    ///
    /// # Errors
    /// As [`Simulation::advance`].
    pub fn simulate(
        &self,
        world: &mut World,
        processes: &[Scheduled],
        span: Span,
        control: &Control<'_>,
    ) -> Result<()> {
        let outcome = Simulation::new(processes).advance(&mut self.runner(), world, span, control);
        outcome.map_err(EngineError::without_device)
    }

    /// Runs the passes of a plan once, outside of any step.
    ///
    /// # Errors
    /// If memory would exceed the limits or a pass names a layer that is not there; then nothing has changed.
    pub fn apply(&self, world: &mut World, plan: &Plan) -> Result<()> {
        let fields = world.layers().len() + plan.scratch_layers().len() + plan.doubled_layers().len();
        let need = MemoryEstimate { fields, action_bytes_per_cell: 0 };
        self.limits.check_bytes("the start values of a layer", need.bytes(&world.grid))?;
        let mut arena = Arena::new(world);
        let outcome = arena.run(self, plan, &world.ledger);
        arena.give_back(world);
        outcome
    }

    /// Steps of a chain for plans of so many passes a step.
    fn chain_length(&self, grid: &Grid, passes: usize) -> u64 {
        let passes = passes.max(1) as u64;
        match self.chain {
            // Measured (docs/performance.md): for two passes a step, two steps when all layers fit the last cache and four
            // when they do not; a single pass needs twice as many to keep its rows in cache as long.
            0 if grid.cells() <= 1 << 19 => (4 / passes).max(2),
            0 => (8 / passes).max(4),
            n => n as u64,
        }
    }
}

impl EngineError {
    /// The error of an engine that has no device.
    fn without_device(self) -> Error {
        match self {
            Self::Core(e) => e,
            e @ (Self::Device(_) | Self::NotReady) => unreachable!("the processor is no device: {e}"),
        }
    }
}

/// A [`CpuEngine`] at work. The world has its layers back at the end of each span.
pub struct CpuRunner {
    engine: CpuEngine,
    arena: Option<Arena>,
    /// Steps of a chain.
    chain: u64,
    completed: u64,
}

impl CpuRunner {
    /// How it works.
    pub const fn engine(&self) -> &CpuEngine {
        &self.engine
    }

    fn arena(&mut self, world: &mut World) -> &mut Arena {
        self.arena.get_or_insert_with(|| Arena::new(world))
    }
}

impl Engine for CpuRunner {
    fn name(&self) -> String {
        format!("cpu ({})", self.engine.isa.name())
    }

    /// The processor gives the same bytes with all its instruction sets.
    fn kind(&self) -> String {
        "cpu".to_owned()
    }

    fn limits(&self) -> Limits {
        self.engine.limits
    }

    fn begin(&mut self, world: &mut World, ahead: &Ahead<'_>) -> Result<(), EngineError> {
        let need = MemoryEstimate::of(world.domain().global(), world.layers().len(), ahead.processes);
        self.engine.limits.check_bytes("this simulation", need.bytes(&world.grid))?;
        let mut first = Plan::default();
        let mut moment = Moment::of(world);
        plan_step(ahead.processes, 0, &mut moment, &mut first);
        self.chain = self.engine.chain_length(&world.grid, first.passes.len());
        self.completed = 0;
        self.arena = Some(Arena::new(world));
        Ok(())
    }

    fn plan_end(&self, _ahead: &Ahead<'_>, at: u64) -> u64 {
        at + self.chain
    }

    fn run(&mut self, world: &mut World, plan: &Plan, ahead: &Ahead<'_>) -> Result<(), EngineError> {
        let engine = self.engine;
        self.arena(world).run(&engine, plan, &world.ledger)?;
        self.completed += ahead.completes;
        Ok(())
    }

    fn lend(
        &mut self,
        world: &mut World,
        borrowed: &Borrowed,
        work: &mut dyn FnMut(&mut World) -> Result<()>,
    ) -> Result<(), EngineError> {
        Ok(self.arena(world).lend(world, &borrowed.writes, work)?)
    }

    fn save(&mut self, world: &mut World, writes: &[Cow<'static, str>]) -> Result<Saved, EngineError> {
        let mut saved = None;
        let keep = |world: &mut World| {
            let saved = saved.insert(Saved::new(world));
            writes.iter().try_for_each(|name| saved.keep(world, name))
        };
        self.arena(world).lend(world, &[], keep)?;
        Ok(saved.unwrap_or_else(|| Saved::new(world)))
    }

    fn restore(&mut self, world: &mut World, saved: Saved) {
        if let Some(arena) = self.arena.take() {
            arena.give_back(world);
        }
        saved.put_back(world);
    }

    fn completed(&self) -> u64 {
        self.completed
    }

    fn wait(&mut self) -> Result<(), EngineError> {
        Ok(())
    }

    fn end(&mut self, world: &mut World) -> Result<(), EngineError> {
        if let Some(arena) = self.arena.take() {
            arena.give_back(world);
        }
        Ok(world.check_finite(&format!("step {}", world.step))?)
    }

    fn download(&mut self, _world: &mut World) -> Result<(), EngineError> {
        Ok(())
    }

    fn release(&mut self) {}

    fn fall_back(&mut self, _world: &mut World) {}

    fn apply(&mut self, world: &mut World, plan: &Plan) -> Result<(), EngineError> {
        Ok(self.engine.apply(world, plan)?)
    }
}
