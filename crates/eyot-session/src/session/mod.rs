//! A run that is polled: whoever hosts a [`Session`] gives it time on a thread of its own choice, commands go in as values and
//! events come out.
//!
//! A session starts no thread, asks no clock of the system and waits for nobody: a paused one returns at once, and so does one whose
//! engine is not ready ([`Status::Waiting`]). Parallel work goes to the caller's thread pool. [`Run`](crate::Run) gives a session a thread, a pool and a folder.
//!
//! ```
//! use eyot_core::Limits;
//! use eyot_recipe::{Overrides, Recipe, RecipeSource, Registry};
//! use eyot_session::{Budget, Clock, Host, Session, SessionOptions, Status};
//!
//! let registry = Registry::new(eyot_land::generate::GENERATORS, &[]);
//! let text = "[grid]\nsize = 32\n[[step]]\ngenerate = \"cone\"\nheight = 300.0\n";
//! let source = RecipeSource { name: "hill.toml".into(), text: text.into(), folder: ".".into() };
//! let recipe = Recipe::parse(source, Overrides::default(), &registry, &Limits::default())?;
//! let mut session = Session::new(recipe, SessionOptions::default(), Host::new(&registry, Clock::system()))?;
//! while session.advance(Budget::Time(std::time::Duration::from_millis(16)))? == Status::Working {
//!     for event in session.events() {
//!         println!("{event:?}");
//!     }
//! }
//! let outcome = session.into_outcome().expect("it has ended");
//! assert!(outcome.finished);
//! # Ok::<(), eyot_session::RunError>(())
//! ```

mod change;
mod device;
mod end;
mod generate;
mod hands;
mod keep;
mod options;
mod progress;
mod recording;
mod requests;
mod simulate;
mod trial;
mod watching;

use crate::engines::{EngineOptions, OpenEngine, Opened, processor};
use crate::error::RunError;
use crate::event::{Command, Event};
use crate::host::Host;
use crate::lock::FolderLock;
use crate::state::State;
use crate::watch::Watching;
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Worded};
use eyot_core::{Cancel, World};
use eyot_recipe::{ProcessUse, Recipe, Step, Work};
use std::sync::Arc;
use std::time::Duration;

use device::Layers;
use end::Ended;
use progress::{label, overall};
use recording::Recorder;
use simulate::Simulation;

pub(crate) use options::check;
pub use options::{Budget, Outcome, SessionOptions, Status};
pub(crate) use requests::{Request, Requests};

/// Chunks of steps aim at this long: short enough for commands, long enough to cost nothing.
const CHUNK_TIME: Duration = Duration::from_millis(300);
/// Progress of long work is passed on at most this often.
pub(crate) const PROGRESS_TIME: Duration = Duration::from_millis(100);

/// A run that is polled.
pub struct Session {
    recipe: Arc<Recipe>,
    options: SessionOptions,
    host: Host,
    world: World,
    state: State,
    requests: Requests,
    cancel: Cancel,
    begun: Duration,
    seconds_before: f64,
    last_checkpoint: Duration,
    warned_of_checkpoint: bool,
    /// Whether the checkpoint holds nothing but the recipe.
    only_begun: bool,
    resumed: bool,
    /// How to find an engine.
    asked: EngineOptions,
    engine: Box<dyn OpenEngine>,
    /// Steps of the simulation under way that the world's own layers have seen; the engine may be ahead of them.
    settled: u64,
    layers: Layers,
    devices_lost: u32,
    recorder: Option<Recorder>,
    watching: Option<Watching>,
    phase: Phase,
    /// The world is with the host.
    lent: bool,
    /// What keeps others out of its folder.
    lock: Option<FolderLock>,
    /// What chunks of steps aim at.
    chunk_time: Duration,
    /// Steps that may be done in this call.
    steps_left: u64,
    ended: Option<Ended>,
}

/// What comes next.
enum Phase {
    /// To open the engine.
    New,
    /// The next step of the recipe.
    Between,
    /// Steps of a simulation.
    Simulating(Box<Simulation>),
    /// The results, or a checkpoint if it was stopped.
    Ending { stopped: bool },
    /// Nothing any more.
    Over(Status),
}

/// How a piece of work went.
enum Turn {
    Worked,
    /// There was none: it waits for a command.
    Paused,
    /// There was none: the engine is not ready.
    Waiting,
}

/// What commands lead to.
enum Heard {
    GoOn,
    /// The session was set back: world and state say where to go on.
    Back,
    Wait,
    Stop,
}

impl Session {
    /// A session at the first step of a recipe.
    ///
    /// # Errors
    /// If the options ask for a recording that cannot be, or if the commands to be given again do not fit the recipe.
    pub fn new(recipe: Recipe, options: SessionOptions, host: Host) -> Result<Self, RunError> {
        check(&recipe, &options, &host.registry, host.storage.is_some())?;
        let mut world = World::new(recipe.grid, recipe.seed);
        world.sea_level_m = recipe.sea_level_m;
        world.georeference = recipe.georeference.clone();
        let state = State::new(&recipe, options.replay.clone());
        Ok(Self::at(recipe, options, host, world, state))
    }

    /// A session that goes on with the stopped run in the host's storage, at the exact step: that of its checkpoint, or of the
    /// last recorded frame if it is later.
    ///
    /// # Errors
    /// If there is no storage or no stopped run in it, the checkpoint is damaged, the recipe no longer passes its checks, or as
    /// [`Session::new`].
    pub fn resume(options: SessionOptions, host: Host) -> Result<Self, RunError> {
        let Some(storage) = &host.storage else { return Err(RunError::input("there is no storage to go on from")) };
        let folder = storage.place("");
        let finished = storage.bytes(crate::files::REPORT_FILE).is_some();
        let name = crate::files::unfinished(&**storage)
            .ok_or_else(|| RunError::NothingToResume { folder: folder.clone(), finished })?;
        let mut warnings = Vec::new();
        let (recipe, world, state) =
            crate::frames::stopped(storage, name, &options.limits, &host.registry, &mut warnings)?;
        if state.streamed {
            return Err(RunError::input("a streamed run is no session"));
        }
        check(&recipe, &options, &host.registry, true)?;
        for message in warnings {
            host.events.tell(Event::Warning { message });
        }
        Ok(Self::at(recipe, options, host, world, state))
    }

    /// A session that goes on from a world and what its run remembers.
    pub(crate) fn at(recipe: Recipe, options: SessionOptions, host: Host, world: World, state: State) -> Self {
        let now = host.clock.now();
        let limits = options.limits;
        let requests = Requests::new(host.events.clone(), options.paused);
        let watching = options.watch.clone().map(Watching::new);
        let (seconds_before, resumed) = (state.seconds, state.seconds > 0.0 || state.finished);
        let asked = options.engine.clone().unwrap_or_else(|| state.engine.clone());
        let state = State { finished: false, engine: asked.clone(), ..state };
        Self {
            recipe: Arc::new(recipe),
            options,
            host,
            world,
            state,
            requests,
            cancel: Cancel::default(),
            begun: now,
            seconds_before,
            last_checkpoint: now,
            warned_of_checkpoint: false,
            only_begun: false,
            resumed,
            asked,
            engine: processor(limits),
            settled: 0,
            layers: Layers::Current,
            devices_lost: 0,
            recorder: None,
            watching,
            phase: Phase::New,
            lent: false,
            lock: None,
            chunk_time: CHUNK_TIME,
            steps_left: u64::MAX,
            ended: None,
        }
    }

    /// Gives a command, which takes effect between two steps: at the next [`Session::advance`].
    pub fn command(&mut self, command: Command) {
        self.requests.push(command);
    }

    /// What breaks off work under way, from another thread, as [`Command::Stop`] does between two pieces of it.
    pub fn cancel(&self) -> Cancel {
        self.cancel.clone()
    }

    /// The same session with a flag of the host's own in the place of [`Session::cancel`].
    pub(crate) fn stopped_by(self, cancel: Cancel) -> Self {
        Self { cancel, ..self }
    }

    /// The same session, which holds the lock of its folder until it has ended.
    pub(crate) fn holding(self, lock: Option<FolderLock>) -> Self {
        Self { lock, ..self }
    }

    /// What has happened since the last call; always empty if the host has a listener.
    pub fn events(&mut self) -> Vec<Event> {
        self.host.events.take()
    }

    /// The world as it is. With a graphics card at work it may be some steps behind: [`Command::Snapshot`] brings it up to date.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The engine that works for it; the processor's until the session has begun.
    pub fn engine(&self) -> &dyn OpenEngine {
        &*self.engine
    }

    /// What it runs.
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// Works for about as long as `budget` says, on this thread and in the pool that it belongs to; less if it then waits for a command
    /// or for the engine.
    ///
    /// # Errors
    /// If a step, the engine or a file fails. The session is over then.
    pub fn advance(&mut self, budget: Budget) -> Result<Status, RunError> {
        if self.lent {
            return Ok(Status::Paused);
        }
        let begun = self.host.clock.now();
        (self.chunk_time, self.steps_left) = match budget {
            Budget::Time(time) => (time.min(CHUNK_TIME), u64::MAX),
            Budget::Steps(n) => (CHUNK_TIME, n.max(1)),
            Budget::Piece => (CHUNK_TIME, u64::MAX),
        };
        loop {
            match self.turn() {
                Ok(Turn::Worked) => {}
                Ok(Turn::Paused) => return Ok(Status::Paused),
                Ok(Turn::Waiting) => return Ok(Status::Waiting),
                Err(e) => {
                    self.phase = Phase::Over(Status::Failed);
                    self.lock = None;
                    self.forget_beginning();
                    self.tell(Event::Failed { message: e.sentence(), help: e.help() });
                    return Err(e);
                }
            }
            if let Phase::Over(status) = self.phase {
                self.lock = None;
                return Ok(status);
            }
            let goes_on = match budget {
                Budget::Time(time) => self.host.clock.since(begun) < time,
                Budget::Steps(_) => self.steps_left > 0,
                Budget::Piece => false,
            };
            if !goes_on {
                return Ok(Status::Working);
            }
        }
    }

    /// Does one piece of work.
    fn turn(&mut self) -> Result<Turn, RunError> {
        // Whatever fails leaves nothing to go on with.
        match std::mem::replace(&mut self.phase, Phase::Over(Status::Failed)) {
            Phase::New => {
                self.begin()?;
                self.phase = Phase::Between;
            }
            Phase::Between => return self.between(),
            Phase::Simulating(simulation) => return self.simulate(simulation),
            ending @ Phase::Ending { .. } if !self.is_brought_back() => {
                self.phase = ending;
                return Ok(Turn::Waiting);
            }
            Phase::Ending { stopped } => self.end(stopped)?,
            over @ Phase::Over(_) => self.phase = over,
        }
        Ok(Turn::Worked)
    }

    fn begin(&mut self) -> Result<(), RunError> {
        let Opened { engine, warning } = self.host.engines.open(&self.asked, self.options.limits)?;
        self.engine = engine;
        let grid = self.world.grid;
        self.tell(Event::Started {
            name: self.recipe.name.clone(),
            size: [grid.width, grid.height],
            cell_m: [grid.cell_x_m, grid.cell_y_m],
            seed: self.recipe.seed,
            steps: self.recipe.enabled_steps().count(),
            engine: self.engine.engine().name(),
            threads: rayon::current_num_threads(),
            resumed: self.resumed,
            out: self.host.storage.as_ref().map(|s| s.place("")),
        });
        let other = self.state.engines.last().filter(|last| **last != self.engine.engine().kind()).map(|last| {
            let now = self.engine.engine().kind();
            format!("{last} has simulated so far and {now} goes on: not to the bytes of a run in one piece")
        });
        let doubts = if self.resumed { Vec::new() } else { self.recipe.doubts() };
        for message in warning.into_iter().chain(other.map(Remedy::from)).chain(doubts) {
            self.tell(Event::Warning { message });
        }
        self.begin_recording();
        self.begin_watching()?;
        self.keep_beginning();
        if self.state.place() != (0, 0) {
            self.show(self.state.done);
        }
        Ok(())
    }

    /// Goes to the next step of the recipe.
    fn between(&mut self) -> Result<Turn, RunError> {
        let recipe = self.recipe.clone();
        let Some(step) = recipe.steps.get(self.state.done_steps) else {
            self.record();
            self.engine.keep();
            self.phase = Phase::Ending { stopped: false };
            return Ok(Turn::Worked);
        };
        match &step.work {
            _ if !step.enabled => self.step_done(),
            Work::Simulate(work) => self.begin_simulation(step, work)?,
            Work::Generate(work) => match self.attend(step, None)? {
                // A simulation listens before each of its own steps.
                Heard::GoOn => self.generate_step(step, work)?,
                heard => return Ok(self.turn_away(&heard)),
            },
        }
        Ok(Turn::Worked)
    }

    /// A step of the recipe is behind.
    fn step_done(&mut self) {
        self.state.done_steps += 1;
        self.state.done = 0;
        self.phase = Phase::Between;
        self.checkpoint_if_due();
    }

    /// Leaves a step before its end.
    fn turn_away(&mut self, heard: &Heard) -> Turn {
        match heard {
            Heard::GoOn | Heard::Wait => self.phase = Phase::Between,
            Heard::Back => {
                self.phase = Phase::Between;
                self.show(self.state.done);
            }
            Heard::Stop => {
                self.engine.keep();
                self.phase = Phase::Ending { stopped: true };
            }
        }
        if matches!(heard, Heard::Wait) { Turn::Paused } else { Turn::Worked }
    }

    /// Does what the client asked for.
    fn attend(&mut self, step: &Step, mut uses: Option<&mut Vec<ProcessUse>>) -> Result<Heard, RunError> {
        loop {
            match self.requests.next(step.number, self.state.done) {
                Request::GoOn => return Ok(Heard::GoOn),
                Request::Stop => return Ok(Heard::Stop),
                Request::Wait => {
                    self.checkpoint_if_due();
                    return Ok(Heard::Wait);
                }
                Request::Change(change) => self.change(step, uses.as_deref_mut(), &change),
                Request::Snapshot => {
                    self.settle();
                    let world = Arc::new(self.world.clone());
                    self.tell(Event::Snapshot { recipe_step: step.number, step: self.state.done, world });
                }
                Request::Rewind(to, forget) => match self.rewind_to(to, forget) {
                    Ok(()) => return Ok(Heard::Back),
                    Err(e) => self.tell(Event::Warning { message: remedy!["the run was not set back: ", e] }),
                },
                Request::Branch(from, out) => {
                    if let Err(e) = self.branch(from, &out) {
                        self.tell(Event::Warning {
                            message: remedy![format!("`{}` was not made: ", out.display()), e],
                        });
                    }
                }
            }
        }
    }

    /// Counts steps that were done.
    fn did(&mut self, steps: u64) {
        self.requests.did(steps);
        self.steps_left = self.steps_left.saturating_sub(steps);
    }

    fn seconds(&self) -> f64 {
        self.seconds_before + self.host.clock.since(self.begun).as_secs_f64()
    }

    fn tell(&self, event: Event) {
        self.host.events.tell(event);
    }
}
