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

/// How the world's own layers stand.
pub(super) enum Layers {
    /// They are what the engine has made.
    Current,
    /// The engine has done more.
    Behind,
    /// They could not be brought back, which nobody has heard yet.
    Failed(Failure),
}

impl From<EngineError> for Failure {
    fn from(e: EngineError) -> Self {
        match e {
            EngineError::Core(e) => Self::Work(e),
            EngineError::Device(e) => Self::Device(e),
            // Of an engine that is not ready whoever asks it goes on another time.
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
    /// Asks the engine for all that it has done. False if it is not ready: then the session has to wait before it looks at the world.
    pub(super) fn is_brought_back(&mut self) -> bool {
        if let Layers::Behind = self.layers {
            self.layers = match self.engine.engine_mut().download(&mut self.world) {
                Ok(()) => Layers::Current,
                Err(EngineError::NotReady) => return false,
                Err(e) => Layers::Failed(e.into()),
            };
            if let Layers::Current = self.layers {
                self.settled = self.state.done;
            }
        }
        true
    }

    /// Brings the world up to what the engine has done; [`Session::is_brought_back`] has said that it is ready.
    pub(super) fn download(&mut self) -> Result<(), Failure> {
        let ready = self.is_brought_back();
        debug_assert!(ready, "the world is wanted of an engine that is not ready");
        match std::mem::replace(&mut self.layers, Layers::Behind) {
            Layers::Current => {}
            // The world is what it was when it was last brought back.
            Layers::Failed(e @ Failure::Device(_)) => {
                self.layers = Layers::Current;
                return Err(e);
            }
            Layers::Failed(e) => return Err(e),
            Layers::Behind => return Err(EngineError::NotReady.into()),
        }
        self.layers = Layers::Current;
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
        (self.engine, self.layers) = (engine, Layers::Current);
        let (number, done) = (step.number, self.state.done);
        let on = format!("; step {number} goes on after {done} steps with {}", self.engine.engine().name());
        self.tell(Event::Warning { message: remedy![error.sentence, on] });
        Ok(())
    }
}
