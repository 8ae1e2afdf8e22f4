//! All tests of this crate that see it from outside, in one binary.

mod card;
mod common;
mod draw;
mod noise;
mod wgsl;
