//! All tests of this crate that see it from outside, in one binary.

mod analyse_jacksboro;
mod analyse_synthetic;
mod by_rock;
mod common;
mod conformance;
mod contours;
mod determinism;
mod directions;
mod drainage_jacksboro;
mod drainage_process;
mod generate_drainage;
mod generate_filters;
mod generate_noise;
mod generate_schema;
mod generate_shapes;
mod generate_sources;
mod generate_windows;
mod hydraulic_conservation;

mod hydraulic_waves;
mod islands;
mod motu;
mod reef;
mod streampower;
mod symmetry;
mod thermal;
