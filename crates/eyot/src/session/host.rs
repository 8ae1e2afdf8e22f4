//! What the host of a session gives it: the time, somebody who hears its events, and where its files go.

use crate::event::Event;
use std::collections::VecDeque;
use std::fmt;
use std::path::PathBuf;
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
    /// Into a queue: [`Session::events`](super::Session::events) hands them out.
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

/// What the host of a session gives it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Host {
    /// The time.
    pub clock: Clock,
    /// Who hears what happens.
    pub events: Events,
    /// Folder for checkpoints, the recording and the results. Without one nothing is written.
    pub out: Option<PathBuf>,
}

impl Host {
    /// A host that writes nothing and asks for the events.
    pub fn new(clock: Clock) -> Self {
        Self { clock, events: Events::queue(), out: None }
    }
}
