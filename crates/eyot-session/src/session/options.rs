//! What a session is told when it begins and when it goes on, and what it says when it ends.

use crate::engines::EngineOptions;
use crate::error::RunError;
use crate::event::JournalEntry;
use crate::frames;
use crate::watch::Watcher;
use eyot_core::remedy::{Remedy, Worded};
use eyot_core::{Limits, World};
use eyot_io::timeline::Record;
use eyot_recipe::{ProcessUse, Recipe, Registry, Work, process_set};
use std::path::PathBuf;
use std::time::Duration;

/// What a session needs to know that does not change a byte of the result.
#[derive(Clone, Debug)]
pub struct SessionOptions {
    /// Time between two checkpoints.
    pub checkpoint_every: Duration,
    /// Steps between two looks at the commands; chosen by the time they take if not given.
    pub chunk: Option<u64>,
    /// Upper bounds on what the session may use.
    pub limits: Limits,
    /// What carries out the plans. If not given, what did so before a resumed run was stopped, and else the processor.
    pub engine: Option<EngineOptions>,
    /// Whether it waits for a command before its first step.
    pub paused: bool,
    /// Commands of an earlier run that are to be given again at the same steps.
    pub replay: Vec<JournalEntry>,
    /// How it is recorded, if it is; a resumed one goes on with the recording that is there without being told.
    pub record: Option<Record>,
    /// Who looks at the world between steps.
    pub watch: Option<Watcher>,
}

impl Default for SessionOptions {
    fn default() -> Self {
        Self {
            checkpoint_every: Duration::from_secs(60),
            chunk: None,
            limits: Limits::default(),
            engine: None,
            paused: false,
            replay: Vec::new(),
            record: None,
            watch: None,
        }
    }
}

/// How much a session may do before it returns. It does at least one piece of work: a chunk of steps, a generator, or the files of
/// the results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Budget {
    /// Pieces of work as long as the time is not over; chunks of steps fit into it once their speed is known.
    Time(Duration),
    /// At most so many steps of simulation; a generator counts as one.
    Steps(u64),
    /// One piece of work, of about 0.3 s where it can be cut.
    Piece,
}

/// How a session stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// There is more to do.
    Working,
    /// It waits for a command.
    Paused,
    /// Its engine is not ready, and may not be waited for: there is more to do after some milliseconds. In a browser the engine gets on
    /// only between two turns of the event loop.
    Waiting,
    /// It has come to its end.
    Finished,
    /// It was stopped on request.
    Stopped,
    /// It has failed; [`Session::advance`](super::Session::advance) said why.
    Failed,
}

/// How a run ended.
#[derive(Debug)]
pub struct Outcome {
    /// The world in its last state; of a streamed run, an overview in coarser cells.
    pub world: World,
    /// Fingerprint of the whole world.
    pub fingerprint: u64,
    /// False if the run was stopped.
    pub finished: bool,
    /// The files that were written; the checkpoint if the run was stopped.
    pub outputs: Vec<PathBuf>,
    /// Commands that changed the bytes.
    pub journal: Vec<JournalEntry>,
}

/// Finds what a session would refuse: a recording that cannot be, commands of an earlier run that do not fit.
pub(crate) fn check(
    recipe: &Recipe,
    options: &SessionOptions,
    registry: &Registry,
    has_storage: bool,
) -> Result<(), RunError> {
    let mut steps: Vec<(usize, Vec<ProcessUse>)> = Vec::new();
    for step in recipe.enabled_steps() {
        if let Work::Simulate(work) = &step.work {
            steps.push((step.number, work.processes.clone()));
        }
    }
    for entry in &options.replay {
        let misfit = |reason: Remedy| RunError::Replay { set: entry.set.clone(), step: entry.recipe_step, reason };
        let Some((_, uses)) = steps.iter_mut().find(|(number, _)| *number == entry.recipe_step) else {
            return Err(misfit("this recipe simulates nothing there".into()));
        };
        process_set::apply(uses, &entry.set, registry, &recipe.grid, &|_| true).map_err(|p| misfit(p.sentence()))?;
    }
    frames::check(recipe, options.record, has_storage)
}
