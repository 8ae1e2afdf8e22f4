//! Plants: where they stand, how they grow, and the trees that pictures and files show.
//!
//! [`Forest`] makes groves by a cellular automaton between two tree lines: cheap, and good enough for pictures.
//!
//! All are rules of single cells and their neighbours, and run on every engine.

pub mod forest;

pub use forest::{FOREST, Forest, GROVE, TREE_SIZE};

use eyot_core::about;
use eyot_core::process::{Entry, Process};

/// All processes that recipes can name.
pub const PROCESSES: &[Entry<dyn Process>] =
    &[Entry::<dyn Process>::process::<Forest>("forest", about!("forest.rs"), &["gardner1970"])];
