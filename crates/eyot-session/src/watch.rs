//! Looks at the world between the steps of a run, by the run's own thread: for those who must see it often, and whole.

use crate::error::RunError;
use eyot_core::{Cancel, Limits, World};
use eyot_recipe::{Recipe, Step, Work};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Somebody who looks at the world between steps. The run waits for them.
pub trait Watch: Send {
    /// Steps of simulation from one look to the next.
    fn every(&self) -> u64;

    /// Called before the first step.
    ///
    /// # Errors
    /// If there is nothing to watch in such a run; it does not begin then.
    fn begin(&mut self, recipe: &Recipe, limits: &Limits) -> Result<(), RunError>;

    /// The world as it is: after each step of the recipe, after so many steps of a simulation, and where it was set back.
    ///
    /// # Errors
    /// What could not be seen, in words: a warning of the run, which goes on.
    fn look(&mut self, look: &Look<'_>) -> Result<(), String>;
}

/// A look.
pub struct Look<'a> {
    /// The world.
    pub world: &'a World,
    /// Number of the recipe's step, from 1.
    pub recipe_step: usize,
    /// Steps done of it.
    pub step: u64,
    /// All steps of it; 1 for a generator.
    pub total: u64,
    /// Raised where the run is to stop: nobody should wait then.
    pub cancel: &'a Cancel,
}

/// A [`Watch`] that options can hold.
#[derive(Clone)]
pub struct Watcher(Arc<Mutex<dyn Watch>>);

impl Watcher {
    /// Wraps one.
    pub fn new(watch: impl Watch + 'static) -> Self {
        Self(Arc::new(Mutex::new(watch)))
    }

    fn lock(&self) -> MutexGuard<'_, dyn Watch + 'static> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl fmt::Debug for Watcher {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Watcher")
    }
}

/// Who watches a run at work.
pub(crate) struct Watching {
    watcher: Watcher,
    every: u64,
    /// Steps of each step of the recipe.
    totals: Vec<u64>,
    /// Whether the world is as it was at the last look.
    is_seen: bool,
    /// Once is enough until a look succeeds again.
    warned: bool,
}

impl Watching {
    pub(crate) fn new(watcher: Watcher) -> Self {
        let every = watcher.lock().every().max(1);
        Self { watcher, every, totals: Vec::new(), is_seen: false, warned: false }
    }

    pub(crate) fn begin(&mut self, recipe: &Recipe, limits: &Limits) -> Result<(), RunError> {
        let total = |s: &Step| if let Work::Simulate(w) = &s.work { w.steps } else { 1 };
        self.totals = recipe.steps.iter().map(total).collect();
        self.watcher.lock().begin(recipe, limits)
    }

    pub(crate) fn every(&self) -> u64 {
        self.every
    }

    pub(crate) fn totals(&self) -> &[u64] {
        &self.totals
    }

    pub(crate) fn is_seen(&self) -> bool {
        self.is_seen
    }

    pub(crate) fn unsee(&mut self) {
        self.is_seen = false;
    }

    /// Says what to warn of.
    pub(crate) fn look(&mut self, look: &Look<'_>) -> Option<String> {
        self.is_seen = true;
        let failed = self.watcher.lock().look(look).err();
        let silent = std::mem::replace(&mut self.warned, failed.is_some());
        failed.filter(|_| !silent)
    }
}
