//! All tests of this crate that see it from outside, in one binary.

mod bodies;
mod common;
mod corals;
mod lsystem;
mod plots;
mod processes;
mod source;
