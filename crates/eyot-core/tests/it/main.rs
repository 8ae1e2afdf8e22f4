//! All tests of this crate that see it from outside, in one binary.

mod actions;
mod components;
mod foundations;
mod polled;
mod programs;
mod rules;
mod windows;
