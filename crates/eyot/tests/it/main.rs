//! All tests of this crate that see it from outside, in one binary.

mod climates;
mod common;
mod conversions;
mod corals;
mod documents;
mod drift;
mod engines;
mod exports;
mod film;
mod fingerprints;
mod mountains;
mod own_rules;
mod printed_recipes;
mod recipe_docs;
mod recipes;
mod recordings;
mod registry;
mod rivers;
mod runs;
mod scale;
mod serving;
mod streaming;
mod stubs;
mod terms;
mod validation;
