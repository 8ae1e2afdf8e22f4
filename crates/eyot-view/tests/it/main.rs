//! All tests of this crate that see it from outside, in one binary.

mod card;
// One device for the tests of both crates.
#[path = "../../../eyot-gpu/tests/it/common.rs"]
mod common;
mod draw;
mod noise;
mod wgsl;
