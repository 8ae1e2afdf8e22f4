//! Plants: where they stand, how they grow, and the trees that pictures and files show.
//!
//! [`Forest`] makes groves by a cellular automaton between two tree lines: cheap, and good enough for pictures.
//!
//! [`Plants`] grows cohorts of up to thirteen [`types`] year by year, in the climate that is given or that a world has.
//!
//! [`trees`] makes single trees of the layers that either leaves, each at its own place, for files and pictures.
//!
//! Processes are rules of single cells and their neighbours, and run on every engine.

pub mod forest;
pub mod layers;
pub mod plants;
mod stands;
pub mod trees;
pub mod types;

pub use forest::{FOREST, Forest, GROVE, TREE_SIZE};
pub use plants::{ClimateFrom, Plants};
pub use types::classes;

use eyot_core::about;
use eyot_core::process::{Entry, Process};

/// All processes that recipes can name.
pub const PROCESSES: &[Entry<dyn Process>] = &[
    Entry::<dyn Process>::process::<Forest>("forest", about!("forest.rs"), &["gardner1970"]),
    Entry::<dyn Process>::process::<Plants>(
        "plants",
        about!("plants/mod.rs"),
        &[
            "botkin1972",
            "schaphoff2018",
            "paulsen2014",
            "sankaran2005",
            "yoda1963",
            "staver2011",
            "chave2009",
            "whittaker1975",
            "holdridge1967",
            "cordonnier2017",
        ],
    ),
];
