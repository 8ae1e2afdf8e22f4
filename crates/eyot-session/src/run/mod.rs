//! A run: a [`Session`] with a thread, a thread pool and a folder of its own, commands that go in and events that come out.

mod options;
mod streamed;

use crate::error::RunError;
use crate::event::{Command, Event};
use crate::files::{CHECKPOINT_FILE, REPORT_FILE, TIMELINE_STORE, check_free, unfinished};
use crate::frames::{self, stopped};
use crate::host::{Branches, Events, Host, NewBranch};
use crate::lock::{FolderLock, LOCK_FILE};
use crate::session::{self, Budget, Outcome, Session, Status};
use crate::state::State;
use crate::stream::Stream;
use crate::timeline;
use eyot_core::remedy;
use eyot_core::remedy::{Action, Remedy};
use eyot_core::{Cancel, World};
use eyot_io as io;
use eyot_io::storage::{Folder, Keep, Memory, Storage, write_bytes};
use eyot_recipe::{Recipe, Registry};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

pub use options::RunOptions;

/// A paused run looks this often whether something is due.
const LOOK: Duration = Duration::from_secs(1);
/// One whose engine is not ready asks again after so long: little beside what goes to a card at a time.
const NAP: Duration = Duration::from_millis(1);

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
    pub fn check(recipe: &Recipe, options: &RunOptions, registry: &Registry) -> Result<bool, RunError> {
        session::check(recipe, &options.session(), registry, options.out.is_some())?;
        options.is_streamed(recipe, registry)
    }

    /// Starts a recipe on a thread of its own. Of the `host`, registry, clock, engines and outputs are used; the run sees to the rest.
    ///
    /// # Errors
    /// If the folder cannot be used: another run works there, a stopped run is there and `restart` is not set, files that are not of
    /// a former run would be overwritten and `force` is not set, or the system refuses. If the options ask for a streamed run, or one in one piece, and it cannot be.
    pub fn start(recipe: Recipe, options: RunOptions, host: &Host) -> Result<Handle, RunError> {
        launch(Begun::new(recipe, options, host)?, host)
    }

    /// As [`Run::start`], for a host that polls: a session in its own folder, if the options name one, on threads of the host's. It is never
    /// streamed, and the folder is free again when it has ended or is dropped.
    ///
    /// # Errors
    /// As [`Run::start`].
    pub fn session(recipe: Recipe, options: RunOptions, host: &Host) -> Result<Session, RunError> {
        let options = RunOptions { stream: Stream::Never, ..options };
        Begun::new(recipe, options, host)?.session(host)
    }

    /// As [`Run::resume`], for a host that polls; see [`Run::session`].
    ///
    /// # Errors
    /// As [`Run::resume`], and if the run was streamed.
    pub fn resume_session(folder: &Path, options: RunOptions, host: &Host) -> Result<Session, RunError> {
        let begun = Begun::again(folder, options, host)?;
        if begun.state.streamed {
            return Err(RunError::input("a streamed run is no session"));
        }
        begun.session(host)
    }

    /// A session that goes on from [`Session::checkpoint_bytes`], without a folder.
    ///
    /// # Errors
    /// If they are damaged, or the recipe in them no longer passes its checks.
    pub fn session_of(checkpoint: &[u8], options: RunOptions, host: &Host) -> Result<Session, RunError> {
        let memory = Memory::new();
        write_bytes(&memory, CHECKPOINT_FILE, Keep::Loose, checkpoint).map_err(RunError::file)?;
        let storage: Arc<dyn Storage> = Arc::new(memory);
        let mut warnings = Vec::new();
        let (recipe, world, state) =
            stopped(&storage, CHECKPOINT_FILE, &options.limits, &host.registry, &mut warnings)?;
        let options = RunOptions { out: None, record: None, ..options };
        Begun { recipe, options, world, state, lock: None, warnings }.session(host)
    }

    /// Continues a stopped run at the exact step: that of its checkpoint, or of the last recorded frame if it is later.
    ///
    /// # Errors
    /// If another run works in the folder, it holds no stopped run, the checkpoint is damaged, the recipe no longer passes its checks, or as
    /// [`Run::start`].
    pub fn resume(folder: &Path, options: RunOptions, host: &Host) -> Result<Handle, RunError> {
        launch(Begun::again(folder, options, host)?, host)
    }
}

/// A run that has its folder and has not done anything yet.
struct Begun {
    recipe: Recipe,
    options: RunOptions,
    world: World,
    state: State,
    lock: Option<FolderLock>,
    warnings: Vec<Remedy>,
}

impl Begun {
    /// At the first step of a recipe.
    fn new(recipe: Recipe, options: RunOptions, host: &Host) -> Result<Self, RunError> {
        let streamed = Run::check(&recipe, &options, &host.registry)?;
        let lock = options.out.as_deref().map(prepare_folder).transpose()?;
        if let Some(out) = &options.out {
            let storage = storage_of(out);
            if !options.force {
                check_free(&recipe, streamed, &*storage)?;
            }
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
        Ok(Self { recipe, options, world, state, lock, warnings })
    }

    /// Where a stopped run in a folder goes on.
    fn again(folder: &Path, options: RunOptions, host: &Host) -> Result<Self, RunError> {
        let nothing = |finished| RunError::NothingToResume { folder: folder.to_owned(), finished };
        if !folder.is_dir() {
            return Err(nothing(false));
        }
        let was_locked = folder.join(LOCK_FILE).is_file();
        // Before looking: what a run at work leaves is not for others to continue.
        let lock = prepare_folder(folder)?;
        let storage = storage_of(folder);
        let Some(name) = unfinished(&*storage) else {
            let finished = folder.join(REPORT_FILE).exists();
            return Err(if was_locked && !finished { killed_at_once(folder) } else { nothing(finished) });
        };
        let mut warnings = Vec::new();
        let (recipe, world, state) = stopped(&storage, name, &options.limits, &host.registry, &mut warnings)?;
        if state.streamed && options.watch.is_some() {
            return Err(RunError::refused(
                format!("the run in `{}` is streamed: there is no world to watch", folder.display()),
                remedy!["continue it with ", Action::Resume(None)],
            ));
        }
        let stream = if state.streamed { Stream::Always } else { options.stream };
        let options = RunOptions { out: Some(folder.to_owned()), stream, ..options };
        frames::check(&recipe, options.record, true)?;
        if state.streamed {
            options.is_streamed(&recipe, &host.registry)?;
        }
        Ok(Self { recipe, options, world, state, lock: Some(lock), warnings })
    }

    /// The host of such a run: with its folder.
    fn host(&self, host: &Host) -> Result<Host, RunError> {
        let out = self.options.out.as_deref();
        let held = out.map(|out| Folder::held(out).map_err(RunError::file)).transpose()?;
        Ok(Host {
            storage: held.map(|folder| Arc::new(folder) as Arc<dyn Storage>),
            outputs: host.outputs.clone().filter(|_| out.is_some()),
            branches: out.map(|out| Arc::new(FolderBranches(out.to_owned())) as Arc<dyn Branches>),
            ..host.clone()
        })
    }

    fn session(self, host: &Host) -> Result<Session, RunError> {
        let host = self.host(host)?;
        for message in self.warnings {
            host.events.tell(Event::Warning { message });
        }
        let session = Session::at(self.recipe, self.options.session(), host, self.world, self.state);
        Ok(session.holding(self.lock))
    }
}

/// What a run left that was killed before it could write its recipe.
fn killed_at_once(folder: &Path) -> RunError {
    RunError::refused(
        format!("the run in `{}` was killed before it began, and left nothing to continue", folder.display()),
        remedy!["start it again with ", Action::Run],
    )
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

fn launch(begun: Begun, host: &Host) -> Result<Handle, RunError> {
    let host = begun.host(host)?;
    let Begun { recipe, options, world, state, lock, warnings } = begun;
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
    let host = Host { events: pass_on(outbox.clone(), last.clone()), ..host };
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

/// Advances a session to its end, and waits for commands where it is paused and for an engine that does not do so itself.
fn drive(mut session: Session, inbox: &Receiver<Command>) -> Result<Outcome, RunError> {
    loop {
        inbox.try_iter().for_each(|command| session.command(command));
        match session.advance(Budget::Piece)? {
            Status::Working => {}
            Status::Waiting => std::thread::sleep(NAP),
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

/// Puts branches into folders beside that of the run.
struct FolderBranches(PathBuf);

impl Branches for FolderBranches {
    fn begin(&self, new: &NewBranch<'_>) -> Result<(), RunError> {
        timeline::branch_off(new.recording, &self.0, new.frame, new.saved, new.state, new.out)
    }
}
