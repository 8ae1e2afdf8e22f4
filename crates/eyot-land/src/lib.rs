//! Land of Eyot: generators, processes and analysis.
//!
//! `generate` and `simulate` do not know each other; recipes put them together.

pub mod analyse;
pub mod generate;
pub mod simulate;
