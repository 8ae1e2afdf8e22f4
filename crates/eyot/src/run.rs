//! A run: a thread that works, commands that go in and events that come out.

use crate::backend::io::{self, timeline::Record};
use crate::drive::Driver;
use crate::engines::EngineOptions;
use crate::error::RunError;
use crate::event::{Command, Event, JournalEntry};
use crate::lock::FolderLock;
use crate::process_set;
use crate::recipe::{ProcessUse, Recipe, Work};
use crate::registry::Registry;
use crate::state::State;
use crate::store::{self, REPORT_FILE, TIMELINE_STORE};
use crate::stream::{self, Stream};
use crate::timeline;
use crate::watch::Watcher;
use eyot_core::{Cancel, Limits, World};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
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
            replay: Vec::new(),
            record: None,
            watch: None,
        }
    }
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

/// The entry point to runs.
#[derive(Clone, Copy, Debug)]
pub struct Run;

/// A run at work.
pub struct Handle {
    remote: Remote,
    events: Receiver<Event>,
    thread: JoinHandle<Result<Outcome, RunError>>,
}

/// Something that commands can be given through; may be cloned and sent to other threads.
#[derive(Clone, Debug)]
pub struct Remote {
    commands: Sender<Command>,
    cancel: Cancel,
}

impl Remote {
    /// Gives a command. False if the run has ended.
    pub fn send(&self, command: Command) -> bool {
        let stop = command == Command::Stop;
        let sent = self.commands.send(command).is_ok();
        if stop {
            // A long step must not delay the stop: the engine ends after the step it is in.
            self.cancel.raise();
        }
        sent
    }
}

impl Handle {
    /// What commands are given through.
    pub fn remote(&self) -> Remote {
        self.remote.clone()
    }

    /// Gives a command. False if the run has ended.
    pub fn send(&self, command: Command) -> bool {
        self.remote.send(command)
    }

    /// The events; the channel closes when the run has ended.
    pub fn events(&self) -> &Receiver<Event> {
        &self.events
    }

    /// Waits for the end.
    ///
    /// # Errors
    /// If the run failed.
    pub fn join(self) -> Result<Outcome, RunError> {
        let Self { remote, events, thread } = self;
        drop((remote, events));
        thread.join().unwrap_or_else(|panic| {
            let text = panic
                .downcast_ref::<String>()
                .cloned()
                .or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
            Err(RunError::Fault(text.unwrap_or_else(|| "for an unknown reason".to_owned())))
        })
    }
}

impl Run {
    /// Finds what [`Run::start`] would refuse beside the folder for the results, and says whether the run would be streamed.
    ///
    /// # Errors
    /// If the options ask for a streamed run, or one in one piece, or a recording, and it cannot be, or if the commands to be
    /// given again do not fit the recipe.
    pub fn check(recipe: &Recipe, options: &RunOptions) -> Result<bool, RunError> {
        let mut steps: Vec<(usize, Vec<ProcessUse>)> = Vec::new();
        for step in recipe.enabled_steps() {
            if let Work::Simulate(work) = &step.work {
                steps.push((step.number, work.processes.clone()));
            }
        }
        for entry in &options.replay {
            let misfit = |reason: String| RunError::Replay { set: entry.set.clone(), step: entry.recipe_step, reason };
            let Some((_, uses)) = steps.iter_mut().find(|(number, _)| *number == entry.recipe_step) else {
                return Err(misfit("this recipe simulates nothing there".to_owned()));
            };
            process_set::apply(uses, &entry.set, &Registry::standard(), &recipe.grid, &|_| true)
                .map_err(|p| misfit(p.to_string()))?;
        }
        timeline::check(recipe, options)?;
        stream::chosen(recipe, options)
    }

    /// Starts a recipe on a thread of its own.
    ///
    /// # Errors
    /// If the folder cannot be used: another run works there, a stopped run is there and `restart` is not set, or the
    /// system refuses. If the options ask for a streamed run, or one in one piece, and it cannot be.
    pub fn start(recipe: Recipe, options: RunOptions) -> Result<Handle, RunError> {
        let streamed = Self::check(&recipe, &options)?;
        let lock = options.out.as_deref().map(prepare_folder).transpose()?;
        if let Some(out) = &options.out {
            while let Some(left) = store::unfinished(out) {
                if !options.restart {
                    return Err(RunError::Unfinished { folder: out.clone() });
                }
                std::fs::remove_file(&left).map_err(|source| RunError::Folder { path: left, source })?;
            }
        }
        let mut warnings = Vec::new();
        if let Some(out) = &options.out {
            warnings.extend(remove_recording(out, options.record.is_some())?);
        }
        let mut world = World::new(recipe.grid, recipe.seed);
        world.sea_level_m = recipe.sea_level_m;
        world.georeference = recipe.georeference.clone();
        let state = State { streamed, ..State::new(&recipe, options.replay.clone()) };
        launch(recipe, options, world, state, lock, warnings)
    }

    /// Continues a stopped run at the exact step: that of its checkpoint, or of the last recorded frame if it is later.
    ///
    /// # Errors
    /// If another run works in the folder, it holds no stopped run, the checkpoint is damaged, the recipe no longer passes its checks, or as
    /// [`Run::start`].
    pub fn resume(folder: &Path, registry: &Registry, options: RunOptions) -> Result<Handle, RunError> {
        let nothing = |finished| RunError::NothingToResume { folder: folder.to_owned(), finished };
        if !folder.is_dir() {
            return Err(nothing(false));
        }
        // Before looking: what a run at work leaves is not for others to continue.
        let lock = prepare_folder(folder)?;
        let path = store::unfinished(folder).ok_or_else(|| nothing(folder.join(REPORT_FILE).exists()))?;
        let damaged = |reason: String| RunError::Checkpoint { folder: folder.to_owned(), reason };
        let mut warnings = Vec::new();
        let (saved, state) =
            timeline::latest(folder, &path, &options.limits, registry.components(), &mut warnings).map_err(damaged)?;
        let recipe = state.recipe(saved.recipe_toml, state.overrides.clone(), registry, &options.limits)?;
        timeline::fits(&recipe, &saved.world, &state)
            .map_err(|e| damaged(format!("`{}` does not fit its recipe: {e}", path.display())))?;
        if saved.engine_version != crate::VERSION {
            let message = format!(
                "the checkpoint was written by version {}, this is {}; the result may differ from a run in one piece",
                saved.engine_version,
                crate::VERSION
            );
            warnings.push(message);
        }
        if state.streamed && options.watch.is_some() {
            return Err(RunError::Input {
                reason: format!("the run in `{}` is streamed: there is no world to watch", folder.display()),
                help: Some("continue it with `eyot resume`"),
            });
        }
        let stream = if state.streamed { Stream::Always } else { options.stream };
        let options = RunOptions { out: Some(folder.to_owned()), stream, ..options };
        timeline::check(&recipe, &options)?;
        if state.streamed {
            stream::chosen(&recipe, &options)?;
        }
        launch(recipe, options, saved.world, state, Some(lock), warnings)
    }
}

/// Removes the recording of an earlier run, whose frames are none of the new one's. Says so.
fn remove_recording(out: &Path, is_in_the_way: bool) -> Result<Option<String>, RunError> {
    let path = out.join(TIMELINE_STORE);
    let was_one = io::timeline::is_recording(&path);
    if was_one || is_in_the_way {
        io::timeline::remove(&path).map_err(RunError::input)?;
    }
    Ok(was_one.then(|| format!("`{}` of an earlier run was removed", path.display())))
}

fn prepare_folder(folder: &Path) -> Result<FolderLock, RunError> {
    std::fs::create_dir_all(folder).map_err(|source| RunError::Folder { path: folder.to_owned(), source })?;
    let lock = FolderLock::take(folder)?;
    io::remove_leftovers(folder);
    Ok(lock)
}

fn launch(
    recipe: Recipe,
    options: RunOptions,
    world: World,
    state: State,
    lock: Option<FolderLock>,
    warnings: Vec<String>,
) -> Result<Handle, RunError> {
    let threads = options.threads.unwrap_or(0);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("eyot-{i}"))
        .build()
        .map_err(|e| RunError::Threads { threads, reason: e.to_string() })?;
    let (commands, inbox) = channel();
    let (outbox, events) = channel();
    let cancel = Cancel::default();
    let remote = Remote { commands, cancel: cancel.clone() };
    for message in warnings {
        // The receiver is alive: it is returned below.
        let _ = outbox.send(Event::Warning { message });
    }
    let thread = std::thread::Builder::new()
        .name("eyot-run".to_owned())
        .spawn(move || {
            let driver = Driver::new(recipe, options, world, state, inbox, outbox.clone(), cancel);
            let result = pool.install(|| driver.drive());
            // Released before the client hears of the end, so that it may start the next run at once.
            drop(lock);
            let last = match &result {
                Ok(o) if o.outcome.finished => Event::Done {
                    outputs: o.outcome.outputs.clone(),
                    fingerprint: format!("{:016x}", o.outcome.fingerprint),
                    seconds: o.seconds,
                },
                Ok(o) => Event::Stopped { checkpoint: o.outcome.outputs.first().cloned() },
                Err(e) => Event::Failed { message: e.to_string(), help: e.help() },
            };
            // The client may have gone; the result is then nobody's.
            let _ = outbox.send(last);
            result.map(|o| o.outcome)
        })
        .map_err(|e| RunError::Threads { threads: threads.max(1), reason: e.to_string() })?;
    Ok(Handle { remote, events, thread })
}
