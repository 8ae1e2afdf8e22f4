//! Cancellation and progress, handed down as arguments.

use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::stopwatch::Stopwatch;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that many may hold and anyone may raise.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Asks for a stop.
    pub fn raise(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// True once someone asked for a stop.
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}

/// What long work needs from its caller: a way to stop, someone to tell how far it is, and how much memory it may take.
pub struct Control<'a> {
    cancel: Cancel,
    limits: Limits,
    progress: &'a (dyn Fn(u64, u64) + Sync),
    start: Stopwatch,
}

impl<'a> Control<'a> {
    /// `progress(done, total)` is called now and then, from one thread at a time.
    pub fn new(cancel: Cancel, progress: &'a (dyn Fn(u64, u64) + Sync)) -> Self {
        Self { cancel, limits: Limits::default(), progress, start: Stopwatch::start() }
    }

    /// The same within other limits.
    #[must_use]
    pub fn within(&self, limits: Limits) -> Control<'_> {
        Control { cancel: self.cancel.clone(), limits, progress: self.progress, start: self.start }
    }

    /// What the work must keep to; the default ones if nobody has said others.
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Never stops, tells nobody.
    pub fn none() -> Control<'static> {
        Control::new(Cancel::default(), &|_, _| {})
    }

    /// Reports progress, and fails if a stop was asked for.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn tick(&self, done: u64, total: u64) -> Result<()> {
        (self.progress)(done, total);
        self.check()
    }

    /// Does a part of longer work: the `i`-th of `n` that take about as long as each other.
    pub fn stage<T>(&self, i: u64, n: u64, work: impl FnOnce(&Control<'_>) -> T) -> T {
        let report = |done: u64, total: u64| (self.progress)(i * total + done, n * total);
        work(&Control { cancel: self.cancel.clone(), limits: self.limits, progress: &report, start: self.start })
    }

    /// Fails if a stop was asked for.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn check(&self) -> Result<()> {
        if self.cancel.is_raised() { Err(Error::Cancelled(self.start.elapsed())) } else { Ok(()) }
    }
}
