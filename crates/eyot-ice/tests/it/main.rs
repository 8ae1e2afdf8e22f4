//! All tests of this crate that see it from outside, in one binary.

mod carving;
mod common;
mod conformance;
mod flow;
mod ledger;
