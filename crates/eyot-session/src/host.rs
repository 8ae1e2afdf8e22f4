//! What the host of a session gives it: the time, somebody who hears its events, and where its files go.

use crate::engines::{Engines, Processor};
use crate::error::RunError;
use crate::event::Event;
use crate::state::State;
use eyot_core::{Control, Limits, World};
use eyot_io::Source;
use eyot_io::checkpoint::Checkpoint;
use eyot_io::storage::Storage;
use eyot_io::timeline::Timeline;
use eyot_recipe::{Recipe, Registry};
use std::collections::VecDeque;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Tells the time since some moment that stays the same.
#[derive(Clone)]
pub struct Clock(Arc<dyn Fn() -> Duration + Send + Sync>);

impl Clock {
    /// A clock of the host's own, such as a browser's.
    pub fn new(now: impl Fn() -> Duration + Send + Sync + 'static) -> Self {
        Self(Arc::new(now))
    }

    /// The clock of the system.
    #[cfg(not(all(target_arch = "wasm32", target_os = "unknown")))]
    pub fn system() -> Self {
        let begun = std::time::Instant::now();
        Self::new(move || begun.elapsed())
    }

    /// The time, since some moment.
    pub fn now(&self) -> Duration {
        (self.0)()
    }

    /// The time since an earlier one.
    pub(crate) fn since(&self, earlier: Duration) -> Duration {
        self.now().saturating_sub(earlier)
    }
}

impl fmt::Debug for Clock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Clock")
    }
}

/// Where the events of a session go: to a listener as they happen, or into a queue until somebody asks.
#[derive(Clone)]
pub struct Events(Way);

#[derive(Clone)]
enum Way {
    Queue(Arc<Mutex<VecDeque<Event>>>),
    Listener(Arc<dyn Fn(Event) + Send + Sync>),
}

impl Events {
    /// Into a queue: [`Session::events`](crate::Session::events) hands them out.
    pub fn queue() -> Self {
        Self(Way::Queue(Arc::default()))
    }

    /// To somebody who hears them as they happen, also in the midst of long work; from any thread, one at a time.
    pub fn listener(hear: impl Fn(Event) + Send + Sync + 'static) -> Self {
        Self(Way::Listener(Arc::new(hear)))
    }

    pub(crate) fn tell(&self, event: Event) {
        match &self.0 {
            Way::Queue(queue) => queue.lock().unwrap_or_else(PoisonError::into_inner).push_back(event),
            Way::Listener(hear) => hear(event),
        }
    }

    /// What has been told since the last time; nothing if there is a listener.
    pub(crate) fn take(&self) -> Vec<Event> {
        match &self.0 {
            Way::Queue(queue) => queue.lock().unwrap_or_else(PoisonError::into_inner).drain(..).collect(),
            Way::Listener(_) => Vec::new(),
        }
    }
}

impl fmt::Debug for Events {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if matches!(self.0, Way::Queue(_)) { "Events::queue" } else { "Events::listener" })
    }
}

/// What a session has come to.
#[non_exhaustive]
pub struct Results<'a> {
    /// The recipe.
    pub recipe: &'a Recipe,
    /// The world in its last state; of a streamed run, an overview in coarser cells.
    pub world: &'a World,
    /// Fingerprint of the whole world.
    pub fingerprint: u64,
    /// Seconds of a step of simulation, if that is known.
    pub clock: Option<f64>,
    /// The same layers, or, of a streamed run, those in full, row by row.
    pub source: &'a dyn Source,
    /// What the run remembers.
    pub state: &'a State,
    /// Where the session's own files lie, and the results are to go.
    pub storage: Option<&'a dyn Storage>,
    /// Fails if something else is in that place by now: what was written is then not there.
    pub in_place: &'a dyn Fn() -> Result<(), RunError>,
    /// Upper bounds on what writing may use.
    pub limits: &'a Limits,
    /// Raised on a request to stop.
    pub control: &'a Control<'a>,
    /// Hears of files and warnings.
    pub tell: &'a dyn Fn(Event),
}

/// Writes what a session has come to: files, pictures, a report.
pub trait Outputs: Send + Sync {
    /// Writes everything, and says where. Exports that the state counts as done and that are still there are left alone; `exported`
    /// hears the count after each other one.
    ///
    /// # Errors
    /// If something could not be written; [`RunError::Stopped`] on a request to stop.
    fn write(&self, results: &Results<'_>, exported: &mut dyn FnMut(usize)) -> Result<Vec<PathBuf>, RunError>;

    /// The erosion score of a world's land, which the run's progress tells; `None` if there is none, or nobody measures it. It is asked
    /// for so rarely that it costs little of a run's time.
    fn score(&self, _world: &World) -> Option<f64> {
        None
    }
}

/// A recorded moment that another run is to begin at.
#[non_exhaustive]
pub struct NewBranch<'a> {
    /// The recording, whose frames up to this one the other run has, too.
    pub recording: &'a Timeline,
    /// The frame's number, from 0.
    pub frame: usize,
    /// The world.
    pub saved: &'a Checkpoint,
    /// What the run remembers there.
    pub state: &'a State,
    /// Where the client wants it.
    pub out: &'a Path,
}

/// Begins other runs.
pub trait Branches: Send + Sync {
    /// Puts a moment where another run can go on from it.
    ///
    /// # Errors
    /// If that place cannot be used.
    fn begin(&self, branch: &NewBranch<'_>) -> Result<(), RunError>;
}

/// What the host of a session gives it.
#[derive(Clone)]
#[non_exhaustive]
pub struct Host {
    /// Generators, processes and kinds of components.
    pub registry: Registry,
    /// The time.
    pub clock: Clock,
    /// What carries out plans.
    pub engines: Arc<dyn Engines>,
    /// Who hears what happens.
    pub events: Events,
    /// Where checkpoints and the recording lie. Without one there are none.
    pub storage: Option<Arc<dyn Storage>>,
    /// Who writes the results. Without it the storage gets the world alone, as [`WORLD_FILE`](crate::WORLD_FILE).
    pub outputs: Option<Arc<dyn Outputs>>,
    /// Who begins other runs.
    pub branches: Option<Arc<dyn Branches>>,
}

impl Host {
    /// A host that keeps and writes nothing, works with the processor alone and asks for the events.
    pub fn new(registry: &Registry, clock: Clock) -> Self {
        let registry = registry.clone();
        let (engines, events) = (Arc::new(Processor), Events::queue());
        Self { registry, clock, engines, events, storage: None, outputs: None, branches: None }
    }

    /// Fails if the storage's place was moved, removed or replaced.
    pub(crate) fn in_place(&self) -> Result<(), RunError> {
        self.storage.as_ref().map_or(Ok(()), |s| s.check()).map_err(RunError::file)
    }

    /// The same with a place for checkpoints and the recording.
    #[must_use]
    pub fn with_storage(self, storage: impl Storage + 'static) -> Self {
        Self { storage: Some(Arc::new(storage)), ..self }
    }

    /// The same with other engines.
    #[must_use]
    pub fn with_engines(self, engines: impl Engines + 'static) -> Self {
        Self { engines: Arc::new(engines), ..self }
    }

    /// The same with somebody who writes the results.
    #[must_use]
    pub fn with_outputs(self, outputs: impl Outputs + 'static) -> Self {
        Self { outputs: Some(Arc::new(outputs)), ..self }
    }
}
