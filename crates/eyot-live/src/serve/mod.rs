//! Runs that others watch over the network: a run whose every step goes to the clients of a [`Server`].
//!
//! The run's own thread looks at the world ([`Watch`](eyot_session::Watch)) and publishes it; the server sends what has changed. Clients that
//! it allows it may pause, resume and step the run, and change it, if that is allowed, too. They reach nothing else of it. Whoever has
//! paused it holds it: until that client resumes it or goes, others' orders are refused.

mod changes;
mod stage;

use crate::{Changed, Control, Ending, Notice, Order, Server, Status};
use eyot_core::Limits;
use eyot_core::remedy;
use eyot_core::remedy::Setting;
use eyot_recipe::Recipe;
use eyot_session::{Command, Event, Handle, Host, Outcome, Remote, Run, RunError, RunOptions, Stream, Watcher};
use std::net::SocketAddr;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};
use std::thread::JoinHandle;
use std::time::Duration;

use changes::Pending;
use stage::Stage;

/// What is sent, to whom, and how fast.
#[derive(Clone, Debug)]
pub struct ServeOptions {
    /// Where the server listens, and its limits.
    pub server: crate::Options,
    /// Layers that are sent.
    pub layers: Vec<String>,
    /// Steps of simulation from one moment to the next.
    pub every: u64,
    /// Whether colonies are sent with their 24 rays.
    pub rays: bool,
    /// Most steps of simulation a second; as fast as it goes without it.
    pub rate: Option<f64>,
    /// Clients that the run waits for before its first step.
    pub wait: usize,
}

impl Default for ServeOptions {
    fn default() -> Self {
        Self { server: crate::Options::default(), layers: Vec::new(), every: 1, rays: true, rate: None, wait: 0 }
    }
}

impl ServeOptions {
    /// Finds what such a run could not send.
    ///
    /// # Errors
    /// If a layer is none of the recipe's, or a copy of what is sent does not fit into memory.
    pub fn check(&self, recipe: &Recipe, limits: &Limits) -> Result<(), RunError> {
        stage::hello(recipe, self, limits).map(drop)
    }
}

/// A run at work with its server.
pub struct Serving {
    server: Arc<Server>,
    remote: Remote,
    events: Receiver<Event>,
    run: JoinHandle<Result<Outcome, RunError>>,
}

/// What the threads of server and run share.
struct ServerState {
    /// How orders reach the run, once it is there.
    remote: OnceLock<Remote>,
    server: OnceLock<Weak<Server>>,
    /// Clients to wait for, and those that are here.
    wait: usize,
    here: AtomicUsize,
    /// Whether the run still waits for them.
    waits: AtomicBool,
    /// The client that holds the run, or 0; when it leaves, the run goes on.
    held_by: AtomicU64,
    changes: Pending,
    events: Mutex<Sender<Event>>,
}

impl Serving {
    /// Starts a recipe and serves it.
    ///
    /// # Errors
    /// As [`Run::start`], and if the server cannot listen or there is nothing such as `options` want to send.
    pub fn start(recipe: Recipe, run: RunOptions, options: ServeOptions, host: &Host) -> Result<Self, RunError> {
        options.check(&recipe, &run.limits)?;
        Self::launch(run, options, |run| Run::start(recipe, run, host))
    }

    /// Continues a stopped run and serves it from there.
    ///
    /// # Errors
    /// As [`Run::resume`] and [`Serving::start`].
    pub fn resume(folder: &Path, run: RunOptions, options: ServeOptions, host: &Host) -> Result<Self, RunError> {
        Self::launch(run, options, |run| Run::resume(folder, run, host))
    }

    fn launch(
        run: RunOptions,
        options: ServeOptions,
        start: impl FnOnce(RunOptions) -> Result<Handle, RunError>,
    ) -> Result<Self, RunError> {
        let (sender, events) = channel();
        let state = Arc::new(ServerState {
            remote: OnceLock::new(),
            server: OnceLock::new(),
            wait: options.wait,
            here: AtomicUsize::new(0),
            waits: AtomicBool::new(options.wait > 0),
            held_by: AtomicU64::new(0),
            changes: Pending::default(),
            events: Mutex::new(sender),
        });
        let theirs = state.clone();
        let server = Server::bind(options.server.clone(), move |notice| theirs.hear(notice)).map_err(|e| {
            let help = match e {
                crate::Error::Public(_) => remedy!["to let other machines connect, add ", Setting::Public],
                crate::Error::Listen { .. } => remedy![
                    "choose another port with ",
                    Setting::Listen.to("127.0.0.1:PORT"),
                    "; 0 is any that is free",
                ],
            };
            RunError::refused(e.to_string(), help)
        })?;
        let server = Arc::new(server);
        // It is set here only.
        let _ = state.server.set(Arc::downgrade(&server));
        let waits = options.wait > 0;
        if waits {
            server.status(Status::Waits);
        }
        let url = format!("ws://{}/", server.address());
        let control = match &options.server.control {
            Control::Nobody => None,
            Control::Token(token) => Some(format!("{url}?token={token}")),
            Control::Everybody => Some(url.clone()),
        };
        let stage = Stage::new(server.clone(), options);
        let run =
            RunOptions { watch: Some(Watcher::new(stage)), stream: Stream::Never, paused: run.paused || waits, ..run };
        let handle = start(run)?;
        let remote = handle.remote();
        state.tell(Event::Serving { url, port: server.address().port(), control });
        // As above.
        let _ = state.remote.set(remote.clone());
        state.begin_if_complete();
        let theirs = server.clone();
        let run = std::thread::Builder::new()
            .name("eyot-events".to_owned())
            .spawn(move || pass_on(handle, &state, &theirs))
            .map_err(|e| RunError::Threads { threads: 1, reason: e.to_string() })?;
        Ok(Self { server, remote, events, run })
    }

    /// Where the server listens.
    pub fn address(&self) -> SocketAddr {
        self.server.address()
    }

    /// What commands are given through.
    pub fn remote(&self) -> Remote {
        self.remote.clone()
    }

    /// Events of the run and of its clients. Those of clients go on after the run's last one ([`Event::is_last`]).
    pub fn events(&self) -> &Receiver<Event> {
        &self.events
    }

    /// Waits for the end of the run, sends what clients have not read yet, and closes. Clients that do not take it in `patience` are
    /// cut off.
    ///
    /// # Errors
    /// If the run failed.
    pub fn join(self, patience: Duration) -> Result<Outcome, RunError> {
        let Self { server, run, .. } = self;
        let outcome = run.join().unwrap_or_else(|_| Err(RunError::Fault("in a thread of the server".to_owned())));
        match &outcome {
            Ok(o) if o.finished => server.close(1000, "the run is done", patience),
            Ok(_) => server.close(1001, "the run was stopped", patience),
            Err(_) => server.close(1011, "the run failed", patience),
        }
        outcome
    }
}

/// Passes the events of a run on, and tells clients what they mean to them.
fn pass_on(handle: Handle, state: &ServerState, server: &Server) -> Result<Outcome, RunError> {
    let mut ended = false;
    for event in handle.events() {
        match &event {
            Event::Paused { .. } if !state.waits.load(Ordering::Acquire) => server.status(Status::Paused),
            Event::Resumed => server.status(Status::Runs),
            Event::Writing { .. } => server.status(Status::Writes),
            Event::Changed(entry) => {
                state.changes.made(&entry.set);
                let set = entry.set.clone();
                server.changed(Changed { recipe_step: entry.recipe_step as u32, step: entry.step, set });
            }
            Event::NotChanged { set, reason } => {
                if let Some(client) = state.changes.made(set) {
                    server.refuse(client, &format!("not changed: `{set}`: {reason}"));
                }
            }
            // Messages name files of this machine, which are none of the clients' business.
            Event::Done { .. } => server.end(Ending::Done, "the run is done"),
            Event::Stopped { .. } => server.end(Ending::Stopped, "the run was stopped"),
            Event::Failed { .. } => server.end(Ending::Failed, "the run failed"),
            _ => {}
        }
        ended |= event.is_last();
        state.tell(event);
    }
    for client in state.changes.end() {
        server.refuse(client, changes::OVER);
    }
    let outcome = handle.join();
    if !ended {
        server.end(Ending::Failed, "the run failed");
        let message = outcome.as_ref().err().map_or_else(String::new, ToString::to_string);
        state.tell(Event::Failed { message: message.into(), help: None });
    }
    outcome
}

impl ServerState {
    fn tell(&self, event: Event) {
        // Whoever started the run may have gone; it goes on.
        let _ = self.events.lock().unwrap_or_else(PoisonError::into_inner).send(event);
    }

    fn hear(&self, notice: Notice) {
        match notice {
            Notice::Joined { client, address } => {
                self.here.fetch_add(1, Ordering::AcqRel);
                self.tell(Event::Joined { client, address: address.to_string() });
                self.begin_if_complete();
            }
            Notice::Left { client, address, reason } => {
                self.here.fetch_sub(1, Ordering::AcqRel);
                self.tell(Event::Left { client, address: address.to_string(), reason });
                // Nobody else may know that the run waits, nor why.
                if self.held_by.compare_exchange(client, 0, Ordering::AcqRel, Ordering::Acquire).is_ok()
                    && let Some(remote) = self.remote.get()
                {
                    remote.send(Command::Resume);
                }
            }
            Notice::Refused { address, reason } => self.tell(Event::Refused { address: address.to_string(), reason }),
            Notice::Order { client, order } => {
                if let Err(reason) = self.obey(client, order) {
                    self.refuse(client, &reason);
                }
            }
        }
    }

    /// Does what a client asks for, or says why not.
    fn obey(&self, client: u64, order: Order) -> Result<(), String> {
        let is_change = matches!(order, Order::Set { .. });
        if self.waits.load(Ordering::Acquire) {
            // Nobody hurries a run along that waits for others.
            return if is_change { Err("the run waits for its first clients".to_owned()) } else { Ok(()) };
        }
        // Who changes it does not hold it.
        let held = match is_change {
            true => Some(self.held_by.load(Ordering::Acquire)).filter(|&h| h != 0).map_or(Ok(0), Err),
            false => self.held_by.compare_exchange(0, client, Ordering::AcqRel, Ordering::Acquire),
        };
        if let Err(holder) = held
            && holder != client
        {
            return Err(format!("client {holder} holds the run, until it resumes it or goes"));
        }
        let Some(remote) = self.remote.get() else { return Ok(()) };
        let command = match order {
            Order::Pause => Command::Pause,
            Order::Resume => {
                self.held_by.store(0, Ordering::Release);
                Command::Resume
            }
            Order::Step(n) => Command::Step(n),
            Order::Set { path, value } => {
                let change = changes::change(&path, &value)?;
                return self.changes.give(client, change, |change| remote.send(Command::Change(change)));
            }
        };
        remote.send(command);
        Ok(())
    }

    fn refuse(&self, client: u64, reason: &str) {
        if let Some(server) = self.server.get().and_then(Weak::upgrade) {
            server.refuse(client, reason);
        }
    }

    fn begin_if_complete(&self) {
        let Some(remote) = self.remote.get() else { return };
        if self.here.load(Ordering::Acquire) >= self.wait && self.waits.swap(false, Ordering::AcqRel) {
            remote.send(Command::Resume);
        }
    }
}
