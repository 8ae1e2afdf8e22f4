//! Cancellation and progress, handed down as arguments.

use crate::error::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

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

/// What long work needs from its caller: a way to stop and someone to tell how far it is.
pub struct Control<'a> {
    cancel: Cancel,
    progress: &'a (dyn Fn(u64, u64) + Sync),
    start: Instant,
}

impl<'a> Control<'a> {
    /// `progress(done, total)` is called now and then, from one thread at a time.
    pub fn new(cancel: Cancel, progress: &'a (dyn Fn(u64, u64) + Sync)) -> Self {
        Self { cancel, progress, start: Instant::now() }
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
        work(&Control { cancel: self.cancel.clone(), progress: &report, start: self.start })
    }

    /// Fails if a stop was asked for.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn check(&self) -> Result<()> {
        if self.cancel.is_raised() { Err(Error::Cancelled(self.start.elapsed())) } else { Ok(()) }
    }
}
