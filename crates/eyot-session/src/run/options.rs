//! What a run is told.

use crate::engines::EngineOptions;
use crate::error::RunError;
use crate::event::JournalEntry;
use crate::session::SessionOptions;
use crate::stream::{self, Stream};
use crate::watch::Watcher;
use eyot_core::Limits;
use eyot_io::timeline::Record;
use eyot_recipe::{Recipe, Registry};
use std::path::PathBuf;
use std::time::Duration;

/// What a run needs to know that does not change a byte of the result.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Threads; all cores if not given.
    pub threads: Option<usize>,
    /// Folder for the results; made if need be. Without one nothing is written.
    pub out: Option<PathBuf>,
    /// Time between two checkpoints.
    pub checkpoint_every: Duration,
    /// Steps between two looks at the commands; chosen by the time they take if not given.
    pub chunk: Option<u64>,
    /// Upper bounds on what the run may use.
    pub limits: Limits,
    /// Whether the world is made in one piece.
    pub stream: Stream,
    /// What carries out the plans. If not given, what did so before a resumed run was stopped, and else the processor.
    pub engine: Option<EngineOptions>,
    /// Whether the run waits for a command before its first step.
    pub paused: bool,
    /// Whether a stopped run in the folder may be overwritten.
    pub restart: bool,
    /// Whether files in the folder that are not of a former run are overwritten.
    pub force: bool,
    /// Commands of an earlier run that are to be given again at the same steps.
    pub replay: Vec<JournalEntry>,
    /// How the run is recorded, if it is; a resumed run goes on with the recording in its folder without being told.
    pub record: Option<Record>,
    /// Who looks at the world between steps; a run that is watched is never streamed.
    pub watch: Option<Watcher>,
}

impl Default for RunOptions {
    fn default() -> Self {
        Self {
            threads: None,
            out: None,
            checkpoint_every: Duration::from_secs(60),
            chunk: None,
            limits: Limits::default(),
            stream: Stream::Auto,
            engine: None,
            paused: false,
            restart: false,
            force: false,
            replay: Vec::new(),
            record: None,
            watch: None,
        }
    }
}

impl RunOptions {
    /// What of it concerns the session.
    pub(super) fn session(&self) -> SessionOptions {
        SessionOptions {
            checkpoint_every: self.checkpoint_every,
            chunk: self.chunk,
            limits: self.limits,
            engine: self.engine.clone(),
            paused: self.paused,
            replay: self.replay.clone(),
            record: self.record,
            watch: self.watch.clone(),
        }
    }

    /// Whether a run with these options is streamed.
    pub(super) fn is_streamed(&self, recipe: &Recipe, registry: &Registry) -> Result<bool, RunError> {
        stream::chosen(recipe, self.stream, self.out.is_some(), &self.limits, registry.outputs())
    }
}
