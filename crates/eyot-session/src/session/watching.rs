//! What a session does for those who watch it.

use super::Session;
use crate::error::RunError;
use crate::event::Event;
use crate::watch::Look;

impl Session {
    pub(super) fn begin_watching(&mut self) -> Result<(), RunError> {
        self.watching.as_mut().map_or(Ok(()), |w| w.begin(&self.recipe, &self.options.limits))
    }

    /// Steps of simulation from one look to the next.
    pub(super) fn look_distance(&self) -> u64 {
        self.watching.as_ref().map_or(u64::MAX, |w| w.every())
    }

    /// Steps of simulation to the next look.
    pub(super) fn steps_to_look(&self) -> u64 {
        let distance = self.look_distance();
        distance - self.world.step % distance
    }

    /// To be called before the world changes.
    pub(super) fn unsee(&mut self) {
        if let Some(watching) = &mut self.watching {
            watching.unsee();
        }
    }

    /// Shows the world as it is after `step` steps of the recipe's step, unless it was seen so already.
    pub(super) fn show(&mut self, step: u64) {
        if self.watching.as_ref().is_none_or(|w| w.is_seen()) {
            return;
        }
        self.settle();
        let Some(watching) = &mut self.watching else { return };
        // Once all steps of the recipe are done, the last one.
        let recipe_step = (self.state.done_steps + 1).min(watching.totals().len());
        let total = watching.totals().get(recipe_step.wrapping_sub(1)).copied().unwrap_or_default();
        let look = Look { world: &self.world, recipe_step, step, total, cancel: &self.cancel };
        if let Some(message) = watching.look(&look) {
            self.tell(Event::Warning { message: message.into() });
        }
    }
}
