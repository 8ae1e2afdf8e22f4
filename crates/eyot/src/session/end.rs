//! The end of a session: results, or a checkpoint.

use super::{Outcome, Phase, Session, Status};
use crate::clock;
use crate::error::RunError;
use crate::event::Event;
use crate::outputs::Outputs;
use crate::state::State;
use crate::store::{self, WORLD_FILE};
use eyot_core::Control;
use std::path::{Path, PathBuf};

/// What is known of an end beside the world.
pub(super) struct Ended {
    fingerprint: u64,
    finished: bool,
    outputs: Vec<PathBuf>,
}

impl Session {
    pub(super) fn end(&mut self, stopped: bool) -> Result<(), RunError> {
        self.settle();
        if self.state.place() != (0, 0) {
            self.show(self.state.done);
        }
        let fingerprint = self.world.fingerprint();
        let mut finished = !stopped && !self.cancel.is_raised();
        let outputs = match self.host.out.clone().filter(|_| finished) {
            Some(out) => match self.results(&out, fingerprint) {
                Ok(files) => files,
                Err(RunError::Stopped) => {
                    finished = false;
                    // The world, which is written first, is where writing goes on.
                    let world = store::unfinished(&out).filter(|p| p.ends_with(WORLD_FILE));
                    world.map_or_else(|| self.checkpoint(), |w| Ok(Some(w)))?.into_iter().collect()
                }
                Err(e) => return Err(e),
            },
            None if finished => Vec::new(),
            None => self.checkpoint()?.into_iter().collect(),
        };
        self.phase = Phase::Over(if finished { Status::Finished } else { Status::Stopped });
        self.tell(if finished {
            let fingerprint = format!("{fingerprint:016x}");
            Event::Done { outputs: outputs.clone(), fingerprint, seconds: self.seconds() }
        } else {
            Event::Stopped { checkpoint: outputs.first().cloned() }
        });
        self.ended = Some(Ended { fingerprint, finished, outputs });
        Ok(())
    }

    /// How it ended, once it has.
    pub fn into_outcome(self) -> Option<Outcome> {
        let Ended { fingerprint, finished, outputs } = self.ended?;
        Some(Outcome { world: self.world, fingerprint, finished, outputs, journal: self.state.journal })
    }

    fn results(&self, out: &Path, fingerprint: u64) -> Result<Vec<PathBuf>, RunError> {
        let outputs = Outputs {
            recipe: &self.recipe,
            world: &self.world,
            source: &self.world,
            fingerprint,
            clock: clock::of_run(&self.recipe, &self.state.journal),
            out,
            limits: &self.options.limits,
            control: &Control::new(self.cancel.clone(), &|_, _| {}),
            tell: &|event| self.tell(event),
        };
        let state = State { seconds: self.seconds(), finished: true, ..self.state.clone() };
        outputs.write(&state, &mut |_| {})
    }
}
