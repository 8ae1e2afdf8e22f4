//! Plate tectonics of Eyot: plates that drift, open oceans, sink, and fold mountains.
//!
//! [`Plates`] is a world of plates on a grid, to be used by itself or as the process `plates` of a recipe ([`PROCESSES`]), where others
//! may shape the land between its steps. Everything is deterministic: seed and parameters decide every byte, threads do not. Crust is
//! counted in whole units, so it is accounted for exactly ([`Budget`]).
//!
//! # How a step is made
//! 1. `motion`: slabs pull, collisions brake, and each plate finds out by how many whole cells it shifts.
//! 2. `drift`: crust is copied to where it goes; `meeting` says who stays on top where two plates meet.
//! 3. `ridge`, `subduction`, `collision`: gaps become sea floor, slabs sink and feed volcanoes, continents fold.
//! 4. `suture`, `parts`: continents grow together, cut-off parts go to a neighbour.
//! 5. `erosion`, `isostasy`, `level`: the land is levelled, crust floats, and the sea finds the level that keeps the share of land.
//! 6. `restart`: at the end of a cycle the world is divided anew, by `growth`.
//!
//! The process makes its next step ahead (`lookahead`) and adds what others did to the land meanwhile where the plate has carried it
//! (`course`).

mod analyse;
mod budget;
mod changes;
mod collision;
mod course;
pub mod crust;
mod drift;
mod erosion;
mod geometry;
mod growth;
pub mod isostasy;
mod level;
mod lookahead;
mod meeting;
mod motion;
mod noise;
mod pairs;
mod parameters;
mod parts;
mod plate;
mod plates;
mod process;
mod restart;
mod ridge;
mod runs;
mod start;
mod store;
mod subduction;
mod suture;

pub use analyse::{Hypsometry, Report, hypsometry};
pub use budget::Budget;
pub use parameters::Tectonics;
pub use plate::PlateInfo;
pub use plates::Plates;
pub use process::{CRUST, CRUST_AGE, Drift, PLATE, PROCESSES, STATE, report};
pub use start::Start;
pub use store::{PLATE_STATE, PlateState};

/// Every kind of components that the processes of this crate keep in worlds.
pub static COMPONENTS: [&eyot_core::ComponentKind; 1] = [&PLATE_STATE];
