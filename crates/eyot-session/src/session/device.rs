//! The engine of a session: bringing the world up to what it has done, and going on when it is lost.

use super::Session;
use crate::engines::{EngineChoice, EngineOptions, Opened};
use crate::error::RunError;
use crate::event::{Event, JournalEntry};
use eyot_core::Error;
use eyot_core::engine::{DeviceError, EngineError};
use eyot_core::remedy;
use eyot_recipe::Step;

/// A device that is lost more often than this is not tried again.
const MAX_DEVICES_LOST: u32 = 3;

/// Why steps were not done.
pub(super) enum Failure {
    /// The work itself; or a request to stop.
    Work(Error),
    /// The device. The world is what it was when it was last brought back.
    Device(DeviceError),
}

impl From<EngineError> for Failure {
    fn from(e: EngineError) -> Self {
        match e {
            EngineError::Core(e) => Self::Work(e),
            EngineError::Device(e) => Self::Device(e),
            other => Self::Device(DeviceError {
                lost: false,
                refused: false,
                sentence: other.to_string().into(),
                source: Box::new(other),
            }),
        }
    }
}

impl Session {
    /// Brings the world up to what the engine has done.
    pub(super) fn download(&mut self) -> Result<(), Failure> {
        self.engine.engine_mut().download(&mut self.world)?;
        self.settled = self.state.done;
        Ok(())
    }

    /// As [`Session::download`] where the session is about to stop or to look at the world: if the device is lost, the world is
    /// what it was before, and so is the count of its steps.
    pub(super) fn settle(&mut self) {
        if let Err(Failure::Device(e)) = self.download() {
            let lost = format!("; {} steps since the world was last saved are lost", self.state.done - self.settled);
            self.tell(Event::Warning { message: remedy![e, lost] });
            self.unwind();
        }
    }

    /// Takes the steps back that only the engine knew; changes by hand since then will be made again at their steps.
    fn unwind(&mut self) {
        self.state.done = self.settled;
        let number = self.state.done_steps + 1;
        let (settled, journal) = (self.settled, std::mem::take(&mut self.state.journal));
        let (later, kept) = journal.into_iter().partition(|e| e.recipe_step == number && e.step > settled);
        self.state.journal = kept;
        self.state.replay.splice(0..0, Vec::<JournalEntry>::into_iter(later));
    }

    /// Goes on from the last world that was brought back: on the device opened anew, or on the processor if that was left open.
    pub(super) fn go_on_without(&mut self, error: DeviceError, step: &Step) -> Result<(), RunError> {
        self.unwind();
        self.devices_lost += 1;
        let auto = self.asked.choice == EngineChoice::Auto;
        let again = if error.lost && self.devices_lost <= MAX_DEVICES_LOST {
            self.host.engines.open(&self.asked, self.options.limits).ok()
        } else if auto {
            let cpu = EngineOptions { choice: EngineChoice::Cpu, ..self.asked.clone() };
            self.host.engines.open(&cpu, self.options.limits).ok()
        } else {
            None
        };
        let Some(Opened { engine, .. }) = again else {
            // What has been done must not be lost with the device.
            self.checkpoint_if_possible();
            return Err(RunError::Device(error));
        };
        self.engine = engine;
        let (number, done) = (step.number, self.state.done);
        let on = format!("; step {number} goes on after {done} steps with {}", self.engine.engine().name());
        self.tell(Event::Warning { message: remedy![error.sentence, on] });
        Ok(())
    }
}
