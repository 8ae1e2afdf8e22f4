//! The end of a session: results, or a checkpoint.

use super::{Outcome, Phase, Session, Status};
use crate::clock;
use crate::error::RunError;
use crate::event::Event;
use crate::files::{CHECKPOINT_FILE, REPORT_FILE, WORLD_FILE, unfinished};
use crate::host::Results;
use crate::state::State;
use eyot_core::Control;
use eyot_io::checkpoint;
use eyot_io::storage::{Keep, Storage, write_bytes};
use serde_json::json;
use std::path::PathBuf;

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
        let outputs = match finished.then(|| self.results(fingerprint)) {
            Some(Ok(files)) => files,
            Some(Err(RunError::Stopped)) => {
                finished = false;
                // The world, which is written first, is where writing goes on.
                let world = self.host.storage.as_ref().filter(|s| unfinished(&***s) == Some(WORLD_FILE));
                let world = world.map(|storage| storage.place(WORLD_FILE));
                world.map_or_else(|| self.checkpoint(), |w| Ok(Some(w)))?.into_iter().collect()
            }
            Some(Err(e)) => return Err(e),
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

    fn results(&self, fingerprint: u64) -> Result<Vec<PathBuf>, RunError> {
        let state = State { seconds: self.seconds(), finished: true, ..self.state.clone() };
        let results = Results {
            recipe: &self.recipe,
            world: &self.world,
            source: &self.world,
            fingerprint,
            clock: clock::of_run(&self.recipe, &self.state.journal, &self.host.registry),
            state: &state,
            storage: self.host.storage.as_deref(),
            in_place: &|| self.host.in_place(),
            limits: &self.options.limits,
            control: &Control::new(self.cancel.clone(), &|_, _| {}),
            tell: &|event| self.tell(event),
        };
        match (&self.host.outputs, &self.host.storage) {
            (Some(outputs), _) => outputs.write(&results, &mut |_| {}),
            (None, Some(storage)) => keep_world(&**storage, &results).map_err(RunError::file),
            (None, None) => Ok(Vec::new()),
        }
    }
}

/// Puts the finished world in the place of the checkpoint.
fn keep_world(storage: &dyn Storage, results: &Results<'_>) -> eyot_io::Result<Vec<PathBuf>> {
    let state = results.state.without_times();
    let value = serde_json::to_value(&state).unwrap_or_default();
    checkpoint::save_in(storage, WORLD_FILE, results.world, &results.recipe.source.text, &value)?;
    let report = json!({
        "name": results.recipe.name,
        "fingerprint": format!("{:016x}", results.fingerprint),
        "engines": state.engines,
        "journal": state.journal,
        "outputs": [WORLD_FILE],
    });
    write_bytes(storage, REPORT_FILE, Keep::Whole, format!("{report:#}\n").as_bytes())?;
    storage.remove(CHECKPOINT_FILE)?;
    Ok([WORLD_FILE, REPORT_FILE].map(|name| storage.place(name)).to_vec())
}
