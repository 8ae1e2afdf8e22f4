//! The GPU engine under the core's stepper.
//!
//! A plan of whole steps ends where a block does and before each step in which something acts, wherever spans end: what goes into a
//! dispatch decides how results are rounded.

use crate::engine::{GpuEngine, Misfit, block_end};
use crate::error::{GpuError, Result as GpuResult};
use eyot_core::engine::{Ahead, Borrowed, CpuEngine, DeviceError, Engine, EngineError, Saved};
use eyot_core::plan::Plan;
use eyot_core::process::acts;
use eyot_core::remedy::Worded;
use eyot_core::{Error, Grid, Limits, World};
use std::borrow::Cow;

impl From<GpuError> for EngineError {
    fn from(e: GpuError) -> Self {
        match e {
            GpuError::Core(e) => Self::Core(e),
            GpuError::CannotWait => Self::NotReady,
            e => Self::Device(e.into()),
        }
    }
}

impl From<GpuError> for DeviceError {
    fn from(e: GpuError) -> Self {
        use GpuError::{Limits, NoAdapter, OutOfMemory, Picture};
        let refused = matches!(e, NoAdapter { .. } | Picture { .. } | OutOfMemory { .. } | Limits { .. });
        Self { lost: e.is_lost(), refused, sentence: e.sentence(), source: Box::new(e) }
    }
}

impl From<EngineError> for GpuError {
    fn from(e: EngineError) -> Self {
        match e {
            EngineError::Core(e) => Self::Core(e),
            EngineError::NotReady => Self::CannotWait,
            EngineError::Device(e) => e.source.downcast().map_or_else(|e| Self::Fault(e.to_string()), |e| *e),
            e => Self::Fault(e.to_string()),
        }
    }
}

impl GpuEngine {
    fn run_plan(&mut self, world: &mut World, plan: &Plan, ahead: &Ahead<'_>) -> GpuResult<()> {
        if self.options.polled {
            self.keep_pace()?;
        }
        match self.submit(plan, ahead.completes) {
            Err(Misfit::Rebuild) => self.rebuild(world, ahead.processes, ahead.span, ahead.within_step)?,
            Err(Misfit::Failed(e)) => return Err(e),
            Ok(()) => return Ok(()),
        }
        self.submit(plan, ahead.completes).map_err(|misfit| match misfit {
            Misfit::Failed(e) => e,
            Misfit::Rebuild => GpuError::Fault("a plan does not fit the world that was made for it".into()),
        })
    }
}

impl Engine for GpuEngine {
    fn name(&self) -> String {
        format!("gpu ({})", self.gpu().name())
    }

    fn limits(&self) -> Limits {
        self.options.limits
    }

    fn block(&self, grid: &Grid) -> u64 {
        Self::block(self, grid)
    }

    fn begin(&mut self, world: &mut World, ahead: &Ahead<'_>) -> Result<(), EngineError> {
        if world.is_window() {
            return Err(Error::Window("the engine of graphics cards works on whole grids".to_owned()).into());
        }
        self.gpu().check()?;
        self.start_span();
        if !self.is_resident() {
            self.make_resident(world, ahead.processes, ahead.span, &[])?;
        }
        Ok(())
    }

    fn plan_end(&self, ahead: &Ahead<'_>, at: u64) -> u64 {
        // What acts is done by the processor, and the card waits for it.
        match self.resident_grid() {
            Some(grid) if !acts(ahead.processes, at) => block_end(ahead.processes, at, Self::block(self, grid)),
            _ => at + 1,
        }
    }

    fn run(&mut self, world: &mut World, plan: &Plan, ahead: &Ahead<'_>) -> Result<(), EngineError> {
        self.run_plan(world, plan, ahead)?;
        self.count_steps(ahead.completes);
        Ok(())
    }

    fn lend(
        &mut self,
        world: &mut World,
        borrowed: &Borrowed,
        work: &mut dyn FnMut(&mut World) -> eyot_core::Result<()>,
    ) -> Result<(), EngineError> {
        Ok(self.lend_layers(world, borrowed, work)?)
    }

    fn save(&mut self, world: &mut World, writes: &[Cow<'static, str>]) -> Result<Saved, EngineError> {
        Self::download(self, world)?;
        let held: u128 = world.layers().iter().map(|l| l.field.bytes() as u128).sum();
        self.options.limits.check_bytes("a copy of the world to go back to", 2 * held)?;
        let mut saved = Saved::new(world);
        writes.iter().try_for_each(|name| saved.keep(world, name))?;
        Ok(saved)
    }

    fn restore(&mut self, world: &mut World, saved: Saved) {
        // The other layers of the world have been up to date since then; what is on the card is in the middle of a step.
        saved.put_back(world);
        Self::release(self);
    }

    fn completed(&self) -> u64 {
        self.steps_completed()
    }

    fn wait(&mut self) -> Result<(), EngineError> {
        Ok(self.finish()?)
    }

    fn end(&mut self, world: &mut World) -> Result<(), EngineError> {
        Ok(self.end_span(world)?)
    }

    fn download(&mut self, world: &mut World) -> Result<(), EngineError> {
        Ok(Self::download(self, world)?)
    }

    fn release(&mut self) {
        Self::release(self);
    }

    fn fall_back(&mut self, world: &mut World) {
        Self::fall_back(self, world);
    }

    /// On the processor, so that simulations begin with the same bytes on all engines.
    fn apply(&mut self, world: &mut World, plan: &Plan) -> Result<(), EngineError> {
        Ok(CpuEngine { limits: self.options.limits, ..CpuEngine::default() }.apply(world, plan)?)
    }
}
