//! The CPU engine (placeholder).
use crate::control::Control;
use crate::error::Result;
use crate::process::{Scheduled, Span};
use crate::world::World;

/// Executes plans on all cores.
#[derive(Clone, Copy, Debug, Default)]
pub struct CpuEngine {}

impl CpuEngine {
    /// Runs a span of steps of the given processes on the world.
    ///
    /// # Errors
    /// On a request to stop (the world is then in the state after the last whole step, `world.step` tells which),
    /// and if a value that is not finite turns up.
    pub fn simulate(&self, world: &mut World, processes: &[Scheduled], span: Span, control: &Control<'_>) -> Result<()> {
        for i in 0..span.steps {
            let _ = (processes, span.from);
            world.step += 1;
            control.tick(i + 1, span.steps)?;
        }
        Ok(())
    }
}
