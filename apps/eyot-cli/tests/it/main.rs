//! All tests of this crate that see it from outside, in one binary.

mod cli;
mod common;
mod film;
mod kill;
mod memory;
mod recording;
mod streaming;
mod sweeps;
mod unlucky;
