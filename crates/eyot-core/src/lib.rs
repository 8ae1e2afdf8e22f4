//! Core of Eyot: grid, layers, world, rules written once, plans and the CPU engine.
//!
//! This crate knows no process, no file format, no GPU and no window; everything else builds on it.

pub mod about;
pub mod component;
pub mod conformance;
pub mod control;
mod domain;
pub mod engine;
mod erased;
mod error;
mod field;
mod fingerprint;
pub mod given;
pub mod graph;
mod grid;
pub mod isa;
mod kernel;
pub mod lanes;
pub mod layer;
pub mod ledger;
mod limits;
pub mod math;
pub mod math64;
mod names;
pub mod plan;
pub mod process;
pub mod program;
pub mod real;
pub mod reference;
pub mod remedy;
pub mod rng;
pub mod rule;
mod schedule;
pub mod stepper;
mod stopwatch;
pub mod text;
pub mod vec3;
mod world;

pub use component::{Component, ComponentKind, ComponentKinds, Components};
pub use control::{Cancel, Control};
pub use domain::Domain;
pub use error::{Error, Result};
pub use field::Field;
pub use fingerprint::Fingerprint;
pub use grid::{Boundary, BoundaryCondition, Grid};
pub use layer::{Centering, GhostFill, Layer, LayerSpec};
pub use ledger::{Account, Ledger};
pub use limits::{Limits, MAX_STEP};
pub use names::intern;
pub use remedy::Remedy;
pub use stopwatch::Stopwatch;
pub use world::{CoordinateSystem, Georeference, World, check_clock};
