//! Checkpoints.

use super::Session;
use crate::error::RunError;
use crate::event::Event;
use crate::files::CHECKPOINT_FILE;
use eyot_core::remedy;
use eyot_io::checkpoint;
use eyot_io::storage::Storage;
use std::path::PathBuf;

impl Session {
    /// Writes a checkpoint before anything is done, which holds little but the recipe: whenever the session is killed, it can be
    /// resumed.
    pub(super) fn keep_beginning(&mut self) {
        let Some(storage) = self.host.storage.as_ref().filter(|_| self.state.place() == (0, 0)) else { return };
        if storage.bytes(CHECKPOINT_FILE).is_none() {
            let written = self.save();
            self.only_begun = written.is_ok();
            self.note_checkpoint(written.err());
        }
    }

    /// Removes a checkpoint that holds little but the recipe: if it was the recipe that failed, going on would fail again.
    pub(super) fn forget_beginning(&mut self) {
        if let Some(storage) = self.host.storage.as_ref().filter(|_| std::mem::take(&mut self.only_begun)) {
            // If it stays, the next run says that it is there.
            let _ = storage.remove(CHECKPOINT_FILE);
        }
    }

    pub(super) fn checkpoint_is_due(&self) -> bool {
        self.host.clock.since(self.last_checkpoint) >= self.options.checkpoint_every
    }

    /// Writes a checkpoint if it is time and the engine has given the world back. One that cannot be written is no reason to end: the next
    /// may succeed.
    pub(super) fn checkpoint_if_due(&mut self) {
        if !self.checkpoint_is_due() || !self.is_brought_back() {
            return;
        }
        let begun = self.host.clock.now();
        let written = self.checkpoint();
        self.note_checkpoint(written.err());
        // A slow disk must not take more than a tenth of the time.
        let rest = self.host.clock.since(begun) * 10;
        self.last_checkpoint = self.host.clock.now() + rest.saturating_sub(self.options.checkpoint_every);
    }

    fn note_checkpoint(&mut self, failed: Option<RunError>) {
        let silent = std::mem::replace(&mut self.warned_of_checkpoint, failed.is_some());
        // Once is enough until one succeeds again.
        if let Some(e) = failed.filter(|_| !silent) {
            let message = remedy!["no checkpoint: ", e, "; the run goes on and tries again"];
            self.tell(Event::Warning { message });
        }
    }

    /// Writes a checkpoint if the session has begun anything; used on the way out of an error, which is told anyway.
    pub(super) fn checkpoint_if_possible(&mut self) {
        if self.state.done > 0 || self.state.done_steps > 0 {
            let _ = self.checkpoint();
        }
    }

    pub(super) fn checkpoint(&mut self) -> Result<Option<PathBuf>, RunError> {
        let Some(storage) = &self.host.storage else { return Ok(None) };
        let path = storage.place(CHECKPOINT_FILE);
        self.settle();
        self.save()?;
        self.only_begun = false;
        self.last_checkpoint = self.host.clock.now();
        self.tell(Event::Checkpoint { path: path.clone() });
        Ok(Some(path))
    }

    fn save(&mut self) -> Result<(), RunError> {
        let storage = self.host.storage.clone();
        storage.map_or(Ok(()), |storage| self.save_in(&*storage))
    }

    /// Writes the world as it is, and what is to be remembered beside it.
    pub(super) fn save_in(&mut self, storage: &dyn Storage) -> Result<(), RunError> {
        self.state.seconds = self.seconds();
        let state = serde_json::to_value(&self.state).map_err(|e| RunError::Fault(e.to_string()))?;
        checkpoint::save_in(storage, CHECKPOINT_FILE, &self.world, &self.recipe.source.text, &state)
            .map_err(RunError::file)
    }
}
