//! The server: knows the last state, accepts clients, and never waits for any of them.

use crate::frame;
use crate::line::{Line, Next};
use crate::record::{Body, Ending, Hello, Order, Record, Status};
use crate::scene::Scene;
use crate::visit;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Connections whose handshake is not done yet; when one more comes, the oldest is cut: whoever says nothing keeps nobody out.
const MAX_HANDSHAKES: usize = 16;
/// After a failure to accept, such as too many open files.
const PAUSE: Duration = Duration::from_millis(50);

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
    /// Bytes of changes that may wait for a client before they are dropped and a whole state takes their place.
    pub queue_bytes: usize,
    /// A client that takes no byte for so long is cut off.
    pub stall: Duration,
    /// Whether clients may pause and step the run.
    pub orders: bool,
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
            stall: Duration::from_secs(30),
            orders: true,
            messages_per_s: 20,
        }
    }
}

/// Why a server cannot begin.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Other machines could connect, and nobody asked for that.
    #[error("{0} is no address of this machine alone: other machines could watch the run and pause it")]
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
}

/// What all threads of a server share.
pub(crate) struct Hub {
    pub(crate) options: Options,
    state: Mutex<State>,
    /// Somebody came or went.
    crowd: Condvar,
    has_scene: AtomicBool,
    closing: AtomicBool,
    /// Handshakes under way, oldest first, each with a way to cut it.
    handshakes: Mutex<Vec<(u64, TcpStream)>>,
    numbers: AtomicU64,
    clients: AtomicU64,
    notice: Box<dyn Fn(Notice) + Send + Sync>,
}

#[derive(Default)]
struct State {
    hello: Option<(Hello, Arc<Vec<u8>>)>,
    scene: Option<Scene>,
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
            has_scene: AtomicBool::new(false),
            closing: AtomicBool::new(false),
            handshakes: Mutex::default(),
            numbers: AtomicU64::new(0),
            clients: AtomicU64::new(1),
            notice: Box::new(notice),
        });
        let theirs = hub.clone();
        let accepting = std::thread::Builder::new()
            .name("eyot-accept".to_owned())
            .spawn(move || accept(&listener, &theirs))
            .map_err(fail)?;
        Ok(Self { hub, address, accepting: Mutex::new(Some(accepting)) })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What the stream is about; to be said once, before the first state.
    pub fn hello(&self, hello: Hello) {
        let frames = Arc::new(frame::messages(&[Body::Hello(hello.clone()).into()]));
        let mut state = self.hub.lock();
        let status = status_frames(state.status);
        for line in &state.lines {
            line.greet(&frames);
            line.note(&status);
        }
        state.hello = Some((hello, frames));
    }

    /// The state is this now. Never waits for a client. Nothing happens before the hello.
    pub fn publish(&self, mut scene: Scene) {
        scene.tidy();
        let mut guard = self.hub.lock();
        let state = &mut *guard;
        let Some((hello, _)) = &state.hello else { return };
        if let Some(before) = &state.scene {
            scene.moment.number = before.moment.number + 1;
            if !state.lines.is_empty() {
                let frames = Arc::new(frame::messages(&scene.changes(before, hello)));
                state.lines.iter().for_each(|l| l.moment(&frames));
            }
        }
        state.snapshot = None;
        if state.scene.is_none() {
            // Whoever waited for the first moment misses none.
            let frames = Arc::new(frame::messages(&scene.snapshot(hello)));
            state.lines.iter().for_each(|l| l.begin(&frames));
            state.snapshot = Some(frames);
            self.hub.has_scene.store(true, Ordering::Release);
        }
        state.scene = Some(scene);
    }

    /// Says whether the run works.
    pub fn status(&self, status: Status) {
        let mut state = self.hub.lock();
        if state.status != status {
            state.status = status;
            if state.hello.is_some() {
                let frames = status_frames(status);
                state.lines.iter().for_each(|l| l.note(&frames));
            }
        }
    }

    /// Says that the run has ended; those who come later hear it as well.
    pub fn end(&self, how: Ending, message: &str) {
        let frames = Arc::new(frame::messages(&[Body::End { how, message: message.to_owned() }.into()]));
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
        self.hub.lock().lines.iter().for_each(|l| l.cut("the server ended"));
    }
}

fn status_frames(status: Status) -> Arc<Vec<u8>> {
    Arc::new(frame::messages(&[Record::from(Body::Status(status))]))
}

fn accept(listener: &TcpListener, hub: &Arc<Hub>) {
    loop {
        let (stream, address) = match listener.accept() {
            _ if hub.closing.load(Ordering::Acquire) => return,
            Ok(found) => found,
            Err(_) => {
                std::thread::sleep(PAUSE);
                continue;
            }
        };
        let Some(handshake) = Handshake::begin(hub, &stream) else { continue };
        let hub = hub.clone();
        // Without a thread the connection is dropped.
        let _ = std::thread::Builder::new()
            .name("eyot-client".to_owned())
            .spawn(move || visit::receive(&hub, stream, address, handshake));
    }
}

/// A handshake under way, by its number; ends when it is dropped.
pub(crate) struct Handshake(Arc<Hub>, u64);

impl Handshake {
    fn begin(hub: &Arc<Hub>, stream: &TcpStream) -> Option<Self> {
        let cutter = stream.try_clone().ok()?;
        let number = hub.numbers.fetch_add(1, Ordering::Relaxed);
        let mut waiting = hub.waiting();
        waiting.push((number, cutter));
        if waiting.len() > MAX_HANDSHAKES {
            // What is gone already needs no cut.
            let _ = waiting.remove(0).1.shutdown(Shutdown::Both);
        }
        Some(Self(hub.clone(), number))
    }
}

impl Drop for Handshake {
    fn drop(&mut self) {
        self.0.waiting().retain(|(number, _)| *number != self.1);
    }
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

    fn waiting(&self) -> MutexGuard<'_, Vec<(u64, TcpStream)>> {
        self.handshakes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn tell(&self, notice: Notice) {
        (self.notice)(notice);
    }

    /// A place for a client, if there is one.
    pub(crate) fn place(self: &Arc<Self>) -> Option<Place> {
        let mut state = self.lock();
        let has_room = state.places < self.options.max_clients && !self.closing.load(Ordering::Acquire);
        has_room.then(|| {
            state.places += 1;
            Place(self.clone())
        })
    }

    /// A client that has shaken hands. `None` if the server is about to end.
    pub(crate) fn join(&self, stream: TcpStream, address: SocketAddr) -> Option<Arc<Line>> {
        let mut state = self.lock();
        if self.closing.load(Ordering::Acquire) {
            return None;
        }
        let number = self.clients.fetch_add(1, Ordering::Relaxed);
        let line = Arc::new(Line::new(number, address, stream, self.options.queue_bytes));
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

    /// What to send to a client next; waits for it.
    pub(crate) fn next(&self, line: &Line) -> crate::line::Item {
        loop {
            match line.next(|| self.has_scene.load(Ordering::Acquire)) {
                Next::Send(item) => return item,
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
                        return crate::line::Item::Note(frames);
                    }
                }
            }
        }
    }
}
