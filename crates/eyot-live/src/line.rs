//! What waits to be sent to one client: never more than a bound, never in the way of the others.

use crate::frame;
use crate::record::Permission;
use std::collections::VecDeque;
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Answers to pings and closes that may wait, bytes. Whoever does not read them has no use for more.
const MAX_ANSWERS: usize = 64 << 10;

/// What may be sent, already as frames of the WebSocket.
pub(crate) enum Item {
    /// A moment: dropped if the client is too slow, and made up for by a whole state.
    Moment(Arc<Vec<u8>>),
    /// Anything else that must arrive.
    Note(Arc<Vec<u8>>),
    /// An answer to a frame of the client's.
    Answer(Vec<u8>),
    /// The last thing that is sent.
    Last(Vec<u8>),
}

impl Item {
    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Moment(b) | Self::Note(b) => b,
            Self::Answer(b) | Self::Last(b) => b,
        }
    }
}

/// The queue of a client.
pub(crate) struct Line {
    /// Its number.
    pub(crate) number: u64,
    /// Where it is.
    pub(crate) address: SocketAddr,
    /// What it may do.
    pub(crate) may: Permission,
    stream: TcpStream,
    queue: Mutex<Queue>,
    ready: Condvar,
    /// Bytes of moments that may wait.
    most: usize,
}

struct Queue {
    /// The hello, once it is known and until it is sent.
    greeting: Option<Arc<Vec<u8>>>,
    items: VecDeque<Item>,
    /// Bytes of moments that wait.
    moments: usize,
    /// Since when the client has taken none of them.
    waiting: Instant,
    /// Bytes of answers that wait.
    answers: usize,
    /// Whether it needs a whole state before any change.
    stale: bool,
    /// Whether nothing more is taken: its last item waits or is sent.
    ends: bool,
    /// Why the connection ends, in words for whoever runs the server.
    reason: Option<String>,
    /// When it was sent a ping, until it sends anything.
    pinged: Option<Instant>,
}

impl Queue {
    /// Drops the moments that wait.
    fn lose_moments(&mut self) {
        self.items.retain(|i| !matches!(i, Item::Moment(_)));
        (self.moments, self.stale) = (0, true);
    }

    /// Drops everything and takes nothing more.
    fn clear(&mut self) {
        self.items.clear();
        self.greeting = None;
        (self.moments, self.answers, self.stale, self.ends) = (0, 0, false, true);
    }
}

/// What to do for a client next.
pub(crate) enum Next {
    /// Give it a whole state.
    Snapshot,
    /// Nothing: it does not answer.
    Silent,
    /// Send this.
    Send(Item),
}

/// How long a client may say nothing.
#[derive(Clone, Copy)]
pub(crate) struct Patience {
    /// When it was sent nothing for so long it gets a ping.
    pub(crate) ping: Duration,
    /// So long it may take to answer.
    pub(crate) stall: Duration,
}

impl Line {
    pub(crate) fn new(number: u64, address: SocketAddr, stream: TcpStream, may: Permission, most: usize) -> Self {
        let queue = Queue {
            greeting: None,
            items: VecDeque::new(),
            moments: 0,
            waiting: Instant::now(),
            answers: 0,
            stale: true,
            ends: false,
            reason: None,
            pinged: None,
        };
        Self { number, address, may, stream, queue: Mutex::new(queue), ready: Condvar::new(), most }
    }

    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The first record of all; what waits so far comes after it.
    pub(crate) fn greet(&self, hello: &[Arc<Vec<u8>>; 3]) {
        let mut q = self.lock();
        if !q.ends {
            q.greeting = Some(hello[self.may as usize].clone());
            self.ready.notify_all();
        }
    }

    /// Whether it has the present state, or all that leads there waits for it.
    pub(crate) fn is_current(&self) -> bool {
        let q = self.lock();
        !q.ends && !q.stale
    }

    /// A moment that was not made for this client: a whole state will follow.
    pub(crate) fn miss(&self) {
        let mut q = self.lock();
        if !q.ends {
            q.lose_moments();
            self.ready.notify_all();
        }
    }

    /// A moment for this client. If it does not fit any more, or the client has taken none for as long as `lag`, all that wait are
    /// dropped and a whole state will follow.
    pub(crate) fn moment(&self, frames: &Arc<Vec<u8>>, lag: Duration) {
        let mut q = self.lock();
        if q.ends || q.stale {
            return;
        }
        if q.moments > 0 && (q.moments + frames.len() > self.most || q.waiting.elapsed() > lag) {
            q.lose_moments();
        } else {
            if q.moments == 0 {
                q.waiting = Instant::now();
            }
            q.moments += frames.len();
            q.items.push_back(Item::Moment(frames.clone()));
        }
        self.ready.notify_all();
    }

    /// The whole state that was asked for: from here on, changes follow.
    pub(crate) fn refreshed(&self) {
        self.lock().stale = false;
    }

    /// The first state of all, for a client that was here before it.
    pub(crate) fn begin(&self, snapshot: &Arc<Vec<u8>>) {
        let mut q = self.lock();
        if !q.ends {
            q.stale = false;
            q.items.push_back(Item::Note(snapshot.clone()));
            self.ready.notify_all();
        }
    }

    pub(crate) fn note(&self, frames: &Arc<Vec<u8>>) {
        let mut q = self.lock();
        if !q.ends {
            q.items.push_back(Item::Note(frames.clone()));
            self.ready.notify_all();
        }
    }

    /// An answer to a ping or a close. False if too many wait.
    pub(crate) fn answer(&self, frame: &[u8]) -> bool {
        let mut q = self.lock();
        if q.ends {
            return true;
        }
        q.answers += frame.len();
        q.items.push_back(Item::Answer(frame.to_vec()));
        self.ready.notify_all();
        q.answers <= MAX_ANSWERS
    }

    /// Closes after everything that waits, a whole state included.
    pub(crate) fn finish(&self, code: u16, reason: &str) {
        let mut q = self.lock();
        if !q.ends {
            q.ends = true;
            q.reason.get_or_insert_with(|| reason.to_owned());
            q.items.push_back(Item::Last(frame::close(code, reason)));
            self.ready.notify_all();
        }
    }

    /// Closes as soon as the frame under way is sent.
    pub(crate) fn refuse(&self, code: u16, reason: &str) {
        let mut q = self.lock();
        q.clear();
        q.reason.get_or_insert_with(|| format!("closed with {code}: {reason}"));
        q.items.push_back(Item::Last(frame::close(code, reason)));
        self.ready.notify_all();
    }

    /// The client has closed: only answers are still sent.
    pub(crate) fn closed_by_client(&self) {
        let mut q = self.lock();
        if !q.ends {
            q.items.retain(|i| matches!(i, Item::Answer(_)));
            (q.greeting, q.stale, q.moments, q.ends) = (None, false, 0, true);
            q.reason.get_or_insert_with(|| "it went".to_owned());
            q.items.push_back(Item::Last(Vec::new()));
            self.ready.notify_all();
        }
    }

    /// Cuts the connection.
    pub(crate) fn cut(&self, reason: &str) {
        let mut q = self.lock();
        q.clear();
        q.reason.get_or_insert_with(|| reason.to_owned());
        q.items.push_back(Item::Last(Vec::new()));
        self.ready.notify_all();
        drop(q);
        // Whoever reads or writes at this moment comes back with an error. It may be cut already.
        let _ = self.stream.shutdown(Shutdown::Both);
    }

    pub(crate) fn reason(&self) -> String {
        self.lock().reason.clone().unwrap_or_else(|| "it went".to_owned())
    }

    /// It has sent something.
    pub(crate) fn heard(&self) {
        self.lock().pinged = None;
    }

    /// What to do next; waits for it. `there_is_a_state` says whether whole states can be had.
    pub(crate) fn next(&self, patience: Patience, there_is_a_state: impl Fn() -> bool) -> Next {
        let mut q = self.lock();
        loop {
            if let Some(hello) = q.greeting.take() {
                return Next::Send(Item::Note(hello));
            }
            if q.stale && there_is_a_state() {
                return Next::Snapshot;
            }
            if let Some(item) = q.items.pop_front() {
                match &item {
                    Item::Moment(b) => {
                        q.moments -= b.len();
                        q.waiting = Instant::now();
                    }
                    Item::Answer(b) => q.answers -= b.len(),
                    Item::Note(_) | Item::Last(_) => {}
                }
                return Next::Send(item);
            }
            let left = match q.pinged {
                None => patience.ping,
                Some(at) => patience.stall.saturating_sub(at.elapsed()),
            };
            if left.is_zero() {
                return Next::Silent;
            }
            let waited = self.ready.wait_timeout(q, left).unwrap_or_else(PoisonError::into_inner);
            q = waited.0;
            if waited.1.timed_out() && q.pinged.is_none() && q.items.is_empty() {
                q.pinged = Some(Instant::now());
                return Next::Send(Item::Answer(frame::ping()));
            }
        }
    }
}
