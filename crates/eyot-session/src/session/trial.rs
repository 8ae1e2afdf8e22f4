//! How long a run will take, from its own first steps: nothing is computed for it, so that it changes no byte.

use crate::event::Event;
use eyot_recipe::{SimulateStep, Step, Work};
use std::time::Duration;

/// So long the first steps are timed: some of those that take long, and enough of quick ones.
const TRIAL: Duration = Duration::from_secs(1);
/// What takes longer is announced, s.
const LONG: f64 = 60.0;

/// Timed steps at the beginning of a simulation.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Trial {
    /// The first chunk also makes layers and wakes threads, so that it does not count.
    warm: bool,
    steps: u64,
    time: Duration,
    told: bool,
}

impl Trial {
    /// Counts a chunk of steps. Once enough were timed, and if the rest will take long, says so.
    pub(super) fn count(&mut self, did: u64, time: Duration, left: u64, after: &After) -> Option<Event> {
        if !std::mem::replace(&mut self.warm, true) || self.told {
            return None;
        }
        self.steps += did;
        self.time += time;
        if self.time < TRIAL || self.steps == 0 {
            return None;
        }
        self.told = true;
        let seconds = self.time.as_secs_f64() / self.steps as f64 * (left + after.steps) as f64;
        let timed = self.steps;
        (seconds >= LONG).then_some(Event::Long { seconds, timed, at_least: after.others })
    }
}

/// The simulations after one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct After {
    /// Steps of those with the same processes.
    steps: u64,
    /// Whether there are some with others.
    others: bool,
}

impl After {
    /// Those after the step number `number`, which does `work`.
    pub(super) fn of(steps: &[Step], number: usize, work: &SimulateStep) -> Self {
        let names = |w: &SimulateStep| {
            w.processes.iter().filter(|u| u.enabled).map(|u| (u.actor.name(), u.every)).collect::<Vec<_>>()
        };
        let mut after = Self::default();
        for step in steps.iter().filter(|s| s.enabled && s.number > number) {
            match &step.work {
                Work::Simulate(w) if names(w) == names(work) => after.steps += w.steps,
                Work::Simulate(_) => after.others = true,
                Work::Generate(_) => {}
            }
        }
        after
    }
}
