//! Fixtures that the tests of several crates share. Not published; only ever a dev-dependency.

pub mod climate;
pub mod counting;
pub mod land;
pub mod plants;
pub mod strata;

use eyot_core::process::{Process, Scheduled};

/// A process that runs in every step.
pub fn one(process: impl Process + 'static) -> Scheduled {
    Scheduled { name: "test", process: Box::new(process), every: 1 }
}
