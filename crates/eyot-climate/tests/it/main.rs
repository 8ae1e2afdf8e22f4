//! All tests of this crate that see it from outside, in one binary.

mod common;
mod conformance;
mod conservation;
mod wind;
mod worlds;
mod zones;
