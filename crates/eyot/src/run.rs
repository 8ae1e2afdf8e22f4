//! A run: a [`Session`] with a thread, a thread pool and a folder of its own, commands that go in and events that come out.

mod streamed;

use crate::backend::io::{self, timeline::Record};
use crate::engines::EngineOptions;
use crate::error::RunError;
use crate::event::{Command, Event, JournalEntry};
use crate::lock::FolderLock;
use crate::outputs::Outputs;
use crate::recipe::Recipe;
use crate::registry::Registry;
use crate::session::files::{REPORT_FILE, TIMELINE_STORE, unfinished};
use crate::session::frames::stopped;
use crate::session::{self, Budget, Clock, Events, Host, NewBranch, Outcome, Results, Session, SessionOptions, Status};
use crate::state::State;
use crate::stream::{self, Stream};
use crate::timeline;
use crate::watch::Watcher;
use eyot_core::remedy;
use eyot_core::remedy::{Action, Remedy};
use eyot_core::{Cancel, Limits, World};
use eyot_io::storage::{Folder, Storage};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// A paused run looks this often whether something is due.
const LOOK: Duration = Duration::from_secs(1);

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

impl RunOptions {
    /// What of it concerns the session.
    fn session(&self) -> SessionOptions {
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
        session::check(recipe, &options.session(), &Registry::standard(), options.out.is_some())?;
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
            let storage = storage_of(out);
            while let Some(left) = unfinished(&*storage) {
                if !options.restart {
                    return Err(RunError::Unfinished { folder: out.clone() });
                }
                storage.remove(left).map_err(RunError::file)?;
            }
        }
        let mut warnings = Vec::new();
        if let Some(out) = &options.out {
            warnings.extend(remove_recording(out, options.record.is_some())?.map(Remedy::from));
        }
        let mut world = World::new(recipe.grid, recipe.seed);
        world.sea_level_m = recipe.sea_level_m;
        world.georeference = recipe.georeference.clone();
        let state = State { streamed, ..State::new(&recipe, options.replay.clone()) };
        launch(recipe, options, &Registry::standard(), world, state, lock, warnings)
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
        let storage = storage_of(folder);
        let name = unfinished(&*storage).ok_or_else(|| nothing(folder.join(REPORT_FILE).exists()))?;
        let mut warnings = Vec::new();
        let (recipe, world, state) = stopped(&storage, name, &options.limits, registry, &mut warnings)?;
        if state.streamed && options.watch.is_some() {
            return Err(RunError::refused(
                format!("the run in `{}` is streamed: there is no world to watch", folder.display()),
                remedy!["continue it with ", Action::Resume(None)],
            ));
        }
        let stream = if state.streamed { Stream::Always } else { options.stream };
        let options = RunOptions { out: Some(folder.to_owned()), stream, ..options };
        session::frames::check(&recipe, &options.session(), true)?;
        if state.streamed {
            stream::chosen(&recipe, &options)?;
        }
        launch(recipe, options, registry, world, state, Some(lock), warnings)
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
    registry: &Registry,
    world: World,
    state: State,
    lock: Option<FolderLock>,
    warnings: Vec<Remedy>,
) -> Result<Handle, RunError> {
    let threads = options.threads.unwrap_or(0);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("eyot-{i}"))
        .build()
        .map_err(|e| RunError::Threads { threads, reason: e.to_string() })?;
    let (commands, inbox) = channel();
    let (outbox, events) = channel();
    for message in warnings {
        // The receiver is alive: it is returned below.
        let _ = outbox.send(Event::Warning { message });
    }
    let last = Arc::new(Mutex::new(None));
    let host = Host {
        events: pass_on(outbox.clone(), last.clone()),
        storage: options.out.as_deref().map(storage_of),
        outputs: options.out.clone().map(|out| Arc::new(FolderOutputs(out)) as Arc<dyn session::Outputs>),
        branches: options.out.clone().map(|out| Arc::new(FolderBranches(out)) as Arc<dyn session::Branches>),
        ..Host::new(registry, Clock::system())
    };
    let cancel = Cancel::default();
    let remote = Remote { commands, cancel: cancel.clone() };
    let thread = std::thread::Builder::new()
        .name("eyot-run".to_owned())
        .spawn(move || {
            let result = pool.install(|| {
                if state.streamed {
                    streamed::run(recipe, &options, host, world, state, inbox, cancel)
                } else {
                    let session = Session::at(recipe, options.session(), host, world, state).stopped_by(cancel);
                    drive(session, &inbox)
                }
            });
            // Released before the client hears of the end, so that it may start the next run at once.
            drop(lock);
            if let Some(event) = last.lock().unwrap_or_else(PoisonError::into_inner).take() {
                // The client may have gone; the result is then nobody's.
                let _ = outbox.send(event);
            }
            result
        })
        .map_err(|e| RunError::Threads { threads: threads.max(1), reason: e.to_string() })?;
    Ok(Handle { remote, events, thread })
}

/// Passes events on, but for the last one, which is kept until the folder is free.
fn pass_on(outbox: Sender<Event>, last: Arc<Mutex<Option<Event>>>) -> Events {
    Events::listener(move |event| {
        if event.is_last() {
            *last.lock().unwrap_or_else(PoisonError::into_inner) = Some(event);
        } else {
            // A client that has gone does not stop a run; its files are still wanted.
            let _ = outbox.send(event);
        }
    })
}

/// Advances a session to its end, and waits for commands where it is paused.
fn drive(mut session: Session, inbox: &Receiver<Command>) -> Result<Outcome, RunError> {
    loop {
        inbox.try_iter().for_each(|command| session.command(command));
        match session.advance(Budget::Piece)? {
            Status::Working => {}
            Status::Paused => session.command(match inbox.recv_timeout(LOOK) {
                Ok(command) => command,
                Err(RecvTimeoutError::Timeout) => continue,
                // Nobody is left who could let it go on.
                Err(RecvTimeoutError::Disconnected) => Command::Stop,
            }),
            Status::Finished | Status::Stopped | Status::Failed => break,
        }
    }
    session.into_outcome().ok_or_else(|| RunError::Fault("it ended without a result".to_owned()))
}

fn storage_of(folder: &Path) -> Arc<dyn Storage> {
    Arc::new(Folder::new(folder))
}

/// Writes the results of a session into a folder.
struct FolderOutputs(PathBuf);

impl session::Outputs for FolderOutputs {
    fn write(&self, results: &Results<'_>) -> Result<Vec<PathBuf>, RunError> {
        let outputs = Outputs {
            recipe: results.recipe,
            world: results.world,
            source: results.world,
            fingerprint: results.fingerprint,
            clock: results.clock,
            out: &self.0,
            limits: results.limits,
            control: results.control,
            tell: results.tell,
        };
        outputs.write(results.state, &mut |_| {})
    }
}

/// Puts branches into folders beside that of the run.
struct FolderBranches(PathBuf);

impl session::Branches for FolderBranches {
    fn begin(&self, new: &NewBranch<'_>) -> Result<(), RunError> {
        timeline::branch_off(new.recording, &self.0, new.frame, new.saved, new.state, new.out)
    }
}
