//! The server: knows the last state, accepts clients, and never waits for any of them.

use crate::control::Control;
use crate::door::{Handshakes, accept};
use crate::frame;
use crate::line::{Line, Next, Patience};
use crate::record::{Body, Changed, Ending, Hello, Order, Permission, Record, Status};
use crate::scene::Scene;
use std::collections::VecDeque;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What a server allows.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where it listens; port 0 is any that is free.
    pub listen: SocketAddr,
    /// Whether it may listen to other machines.
    pub public: bool,
    /// Most clients at a time.
    pub max_clients: usize,
    /// Origins of web pages that may connect beside those of this machine.
    pub allow_origins: Vec<String>,
    /// Time for the handshake.
    pub handshake: Duration,
    /// Bytes of changes that may wait for a client before they are dropped and a whole state takes their place; also of states that wait
    /// to be compared with those before them.
    pub queue_bytes: usize,
    /// Changes that have waited for a client for so long are dropped, too.
    pub lag: Duration,
    /// A client that takes no byte for so long is cut off, and so is one that does not answer a ping.
    pub stall: Duration,
    /// A client that was sent nothing for so long gets a ping.
    pub ping: Duration,
    /// Who may pause and step the run.
    pub control: Control,
    /// Whether those may change it, too.
    pub changes: bool,
    /// Messages of a client in a second; twice as many at once. Whoever sends more is closed.
    pub messages_per_s: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            listen: SocketAddr::from((Ipv4Addr::LOCALHOST, 0)),
            public: false,
            max_clients: 32,
            allow_origins: Vec::new(),
            handshake: Duration::from_secs(5),
            queue_bytes: 16 << 20,
            lag: Duration::from_secs(1),
            stall: Duration::from_secs(30),
            ping: Duration::from_secs(10),
            control: Control::Nobody,
            changes: false,
            messages_per_s: 20,
        }
    }
}

/// Why a server cannot begin.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Other machines could connect, and nobody asked for that.
    #[error("{0} is no address of this machine alone: other machines could watch the run")]
    Public(SocketAddr),
    /// The system refuses.
    #[error("cannot listen at {address}: {source}")]
    Listen {
        /// Where.
        address: SocketAddr,
        /// The system's reason.
        source: io::Error,
    },
}

/// What a server tells its owner.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Notice {
    /// A client has connected.
    Joined {
        /// Its number, from 1.
        client: u64,
        /// Where it is.
        address: SocketAddr,
    },
    /// A client is gone.
    Left {
        /// Its number.
        client: u64,
        /// Where it was.
        address: SocketAddr,
        /// Why, in words.
        reason: String,
    },
    /// Somebody was not let in.
    Refused {
        /// Where it is.
        address: SocketAddr,
        /// Why, in words.
        reason: String,
    },
    /// A client asks for something.
    Order {
        /// Its number.
        client: u64,
        /// What.
        order: Order,
    },
}

/// A server. Dropping it cuts all connections.
pub struct Server {
    hub: Arc<Hub>,
    address: SocketAddr,
    accepting: Mutex<Option<JoinHandle<()>>>,
    comparing: Option<JoinHandle<()>>,
}

/// What all threads of a server share.
pub(crate) struct Hub {
    pub(crate) options: Options,
    state: Mutex<State>,
    /// Somebody came or went.
    crowd: Condvar,
    has_hello: AtomicBool,
    has_scene: AtomicBool,
    closing: AtomicBool,
    pub(crate) handshakes: Handshakes,
    published: Mutex<Published>,
    /// A scene was published, or all of them are compared.
    progress: Condvar,
    clients: AtomicU64,
    notice: Box<dyn Fn(Notice) + Send + Sync>,
}

/// Scenes that wait to be compared with those before them.
#[derive(Default)]
struct Published {
    scenes: VecDeque<Scene>,
    bytes: usize,
    /// Whether one is being compared.
    busy: bool,
    ends: bool,
}

#[derive(Default)]
struct State {
    /// The hello; its frames for each permission.
    hello: Option<(Hello, [Arc<Vec<u8>>; 3])>,
    scene: Option<Arc<Scene>>,
    /// The frames of the whole scene, once somebody needed them.
    snapshot: Option<Arc<Vec<u8>>>,
    status: Status,
    end: Option<Arc<Vec<u8>>>,
    lines: Vec<Arc<Line>>,
    /// Places that are taken: clients, and handshakes that have been let in.
    places: usize,
}

impl Server {
    /// Listens. `notice` is called by threads of the server and must not wait for it.
    ///
    /// # Errors
    /// If the address is open to other machines and `public` is not set, or the system refuses it.
    pub fn bind(options: Options, notice: impl Fn(Notice) + Send + Sync + 'static) -> Result<Self, Error> {
        let address = options.listen;
        if !options.public && !address.ip().is_loopback() {
            return Err(Error::Public(address));
        }
        let fail = |source| Error::Listen { address, source };
        let listener = TcpListener::bind(address).map_err(fail)?;
        let address = listener.local_addr().map_err(fail)?;
        let hub = Arc::new(Hub {
            options,
            state: Mutex::default(),
            crowd: Condvar::new(),
            has_hello: AtomicBool::new(false),
            has_scene: AtomicBool::new(false),
            closing: AtomicBool::new(false),
            handshakes: Handshakes::default(),
            published: Mutex::default(),
            progress: Condvar::new(),
            clients: AtomicU64::new(1),
            notice: Box::new(notice),
        });
        let theirs = hub.clone();
        let accepting = std::thread::Builder::new()
            .name("eyot-accept".to_owned())
            .spawn(move || accept(&listener, &theirs))
            .map_err(fail)?;
        let mut server = Self { hub: hub.clone(), address, accepting: Mutex::new(Some(accepting)), comparing: None };
        let comparing = std::thread::Builder::new().name("eyot-compare".to_owned()).spawn(move || hub.compare());
        server.comparing = Some(comparing.map_err(fail)?);
        Ok(server)
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What the stream is about; to be said once, before the first state. What it says that a client may do is up to
    /// [`Options::control`] and [`Options::changes`].
    pub fn hello(&self, hello: Hello) {
        let frames = [Permission::Watch, Permission::Pause, Permission::Change].map(|may| {
            let hello = Hello { may, ..hello.clone() };
            Arc::new(frame::messages(&[Body::Hello(hello).into()]))
        });
        let mut state = self.hub.lock();
        let status = status_frames(state.status);
        for line in &state.lines {
            line.greet(&frames);
            line.note(&status);
        }
        state.hello = Some((hello, frames));
        self.hub.has_hello.store(true, Ordering::Release);
    }

    /// The state is this now. Waits neither for a client nor for anything to be made for them. Nothing happens before the hello. Where
    /// states come faster than they can be compared, clients miss some of them.
    pub fn publish(&self, scene: Scene) {
        if !self.hub.has_hello.load(Ordering::Acquire) {
            return;
        }
        let bytes = scene.bytes();
        let mut published = self.hub.published();
        if !published.scenes.is_empty() && published.bytes + bytes > self.hub.options.queue_bytes {
            let dropped = published.scenes.pop_back().map_or(0, |s| s.bytes());
            published.bytes -= dropped;
        }
        published.bytes += bytes;
        published.scenes.push_back(scene);
        self.hub.progress.notify_all();
    }

    /// Says whether the run works, after the states that were published so far.
    pub fn status(&self, status: Status) {
        self.hub.catch_up();
        let mut state = self.hub.lock();
        if state.status != status {
            state.status = status;
            if state.hello.is_some() {
                let frames = status_frames(status);
                state.lines.iter().for_each(|l| l.note(&frames));
            }
        }
    }

    /// Tells all clients that the run was changed by hand.
    pub fn changed(&self, changed: Changed) {
        let frames = Arc::new(frame::messages(&[Body::Changed(changed).into()]));
        let state = self.hub.lock();
        if state.hello.is_some() {
            state.lines.iter().for_each(|l| l.note(&frames));
        }
    }

    /// Tells one client that its order is not taken.
    pub fn refuse(&self, client: u64, message: &str) {
        let frames = Arc::new(frame::messages(&[Body::Refused(message.to_owned()).into()]));
        self.hub.lock().lines.iter().filter(|l| l.number == client).for_each(|l| l.note(&frames));
    }

    /// Says that the run has ended, after the states that were published so far; those who come later hear it as well.
    pub fn end(&self, how: Ending, message: &str) {
        let frames = Arc::new(frame::messages(&[Body::End { how, message: message.to_owned() }.into()]));
        self.hub.catch_up();
        let mut state = self.hub.lock();
        if state.hello.is_some() {
            state.lines.iter().for_each(|l| l.note(&frames));
        }
        state.end = Some(frames);
    }

    /// Clients that are connected.
    pub fn clients(&self) -> usize {
        self.hub.lock().lines.len()
    }

    /// Takes no more clients, sends what waits, closes all connections with this code and reason, and cuts those that are not
    /// closed in time.
    pub fn close(&self, code: u16, reason: &str, patience: Duration) {
        self.stop_accepting();
        let until = Instant::now() + patience;
        self.hub.catch_up();
        let mut state = self.hub.lock();
        state.lines.iter().for_each(|l| l.finish(code, reason));
        while !state.lines.is_empty() {
            let Some(left) = until.checked_duration_since(Instant::now()) else { break };
            state = self.hub.crowd.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn stop_accepting(&self) {
        self.hub.closing.store(true, Ordering::Release);
        let Some(thread) = self.accepting.lock().unwrap_or_else(PoisonError::into_inner).take() else { return };
        // Whoever accepts waits for somebody to come.
        let here = match self.address.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => IpAddr::V4(Ipv4Addr::LOCALHOST),
            IpAddr::V6(ip) if ip.is_unspecified() => IpAddr::V6(Ipv6Addr::LOCALHOST),
            ip => ip,
        };
        if TcpStream::connect_timeout(&SocketAddr::new(here, self.address.port()), Duration::from_secs(1)).is_ok() {
            // A thread that has broken has nothing left to say.
            let _ = thread.join();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop_accepting();
        self.hub.published().ends = true;
        self.hub.progress.notify_all();
        if let Some(thread) = self.comparing.take() {
            // As above.
            let _ = thread.join();
        }
        self.hub.lock().lines.iter().for_each(|l| l.cut("the server ended"));
    }
}

fn status_frames(status: Status) -> Arc<Vec<u8>> {
    Arc::new(frame::messages(&[Record::from(Body::Status(status))]))
}

/// A client's place among those that are allowed; free again when it is dropped.
pub(crate) struct Place(Arc<Hub>);

impl Drop for Place {
    fn drop(&mut self) {
        self.0.lock().places -= 1;
    }
}

impl Hub {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn published(&self) -> MutexGuard<'_, Published> {
        self.published.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn is_closing(&self) -> bool {
        self.closing.load(Ordering::Acquire)
    }

    /// Compares scenes as they are published, until the server ends.
    fn compare(&self) {
        let mut published = self.published();
        loop {
            let Some(scene) = published.scenes.pop_front() else {
                published.busy = false;
                self.progress.notify_all();
                if published.ends {
                    return;
                }
                published = self.progress.wait(published).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            published.bytes -= scene.bytes();
            published.busy = true;
            drop(published);
            self.advance(scene);
            published = self.published();
        }
    }

    /// Waits until everything that was published has been put into the queues of the clients.
    fn catch_up(&self) {
        let mut published = self.published();
        while (published.busy || !published.scenes.is_empty()) && !published.ends {
            published = self.progress.wait(published).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Makes this the present state, and sends what is different to those who have the one before.
    fn advance(&self, mut scene: Scene) {
        scene.tidy();
        let state = self.lock();
        let Some(hello) = state.hello.as_ref().map(|(hello, _)| hello.clone()) else { return };
        let before = state.scene.clone();
        let is_wanted = state.lines.iter().any(|l| l.is_current());
        drop(state);
        let changes = before.filter(|_| is_wanted).map(|before| {
            scene.moment.number = before.moment.number + 1;
            Arc::new(frame::messages(&scene.changes(&before, &hello)))
        });
        let mut guard = self.lock();
        let state = &mut *guard;
        state.snapshot = None;
        match (&changes, &state.scene) {
            (Some(frames), _) => state.lines.iter().for_each(|l| l.moment(frames, self.options.lag)),
            (None, Some(before)) => {
                scene.moment.number = before.moment.number + 1;
                // Whoever got the state before in the meantime needs this one whole.
                state.lines.iter().for_each(|l| l.miss());
            }
            (None, None) => {
                // Whoever waited for the first moment misses none.
                let frames = Arc::new(frame::messages(&scene.snapshot(&hello)));
                state.lines.iter().for_each(|l| l.begin(&frames));
                state.snapshot = Some(frames);
                self.has_scene.store(true, Ordering::Release);
            }
        }
        state.scene = Some(Arc::new(scene));
    }

    pub(crate) fn tell(&self, notice: Notice) {
        (self.notice)(notice);
    }

    /// A place for a client, if there is one.
    pub(crate) fn place(self: &Arc<Self>) -> Option<Place> {
        let mut state = self.lock();
        let has_room = state.places < self.options.max_clients && !self.is_closing();
        has_room.then(|| {
            state.places += 1;
            Place(self.clone())
        })
    }

    /// A client that has shaken hands. `None` if the server is about to end.
    pub(crate) fn join(&self, stream: TcpStream, address: SocketAddr, may: Permission) -> Option<Arc<Line>> {
        let mut state = self.lock();
        if self.is_closing() {
            return None;
        }
        let number = self.clients.fetch_add(1, Ordering::Relaxed);
        let line = Arc::new(Line::new(number, address, stream, may, self.options.queue_bytes));
        if let Some((_, hello)) = &state.hello {
            line.greet(hello);
            line.note(&status_frames(state.status));
        }
        if let Some(end) = &state.end {
            line.note(end);
        }
        state.lines.push(line.clone());
        drop(state);
        self.tell(Notice::Joined { client: number, address });
        Some(line)
    }

    pub(crate) fn leave(&self, line: &Arc<Line>) {
        self.lock().lines.retain(|l| !Arc::ptr_eq(l, line));
        self.tell(Notice::Left { client: line.number, address: line.address, reason: line.reason() });
        self.crowd.notify_all();
    }

    /// What to send to a client next; waits for it. `None` if it does not answer any more.
    pub(crate) fn next(&self, line: &Line) -> Option<crate::line::Item> {
        let patience = Patience { ping: self.options.ping, stall: self.options.stall };
        loop {
            match line.next(patience, || self.has_scene.load(Ordering::Acquire)) {
                Next::Send(item) => return Some(item),
                Next::Silent => return None,
                Next::Snapshot => {
                    let mut guard = self.lock();
                    let state = &mut *guard;
                    if let (Some((hello, _)), Some(scene)) = (&state.hello, &state.scene) {
                        let frames = state
                            .snapshot
                            .get_or_insert_with(|| Arc::new(frame::messages(&scene.snapshot(hello))))
                            .clone();
                        // Under the lock: the next moment is the first change to this state.
                        line.refreshed();
                        return Some(crate::line::Item::Note(frames));
                    }
                }
            }
        }
    }
}
