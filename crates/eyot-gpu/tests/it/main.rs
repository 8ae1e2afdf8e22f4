//! All tests of this crate that see it from outside, in one binary.

mod common;
mod conformance;
mod device;
mod engine;
mod polled;
mod texts;
mod wgsl;
