//! All tests of this crate that see it from outside, in one binary.

mod checkpoints;
mod common;
mod hostile;
mod hostile_formats;
mod hostile_headers;
mod hostile_stores;
mod hostile_tiff;
mod jacksboro;
mod missing;
mod mutations;
mod round_trips;
mod streams;
mod tables;
mod timelines;
mod vectors;
