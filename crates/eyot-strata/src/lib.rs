//! Rock in beds: what comes to light where the land is worn, how steep it stands, and how fast it wears.
//!
//! [`Strata`] keeps, for every cell, where the bedrock's surface lies and how its beds are displaced; what lies on the bedrock is
//! loose. Other processes change the height, as ever: what they take is taken from the loose ground first, what they lay down is
//! loose. [`Rockfall`] lets every material slide at its own angle, [`Soak`] softens what lies under standing water.
//!
//! All are rules of single cells and their neighbours, and run on every engine. [`Subsurface`] says what lies below a place,
//! [`Section`] what a line across the land cuts through.

pub mod materials;
pub mod rock_cycle;
pub mod rockfall;
pub mod section;
pub mod sequence;
pub mod soak;
pub mod strata;
pub mod subsurface;

pub use materials::{Material, classes, classes_of, standard};
pub use rock_cycle::RockCycle;
pub use rockfall::Rockfall;
pub use section::{Piece, Section};
pub use sequence::{Layered, SEQUENCE, STRATA, Sequence};
pub use soak::{SOAK_WATER, Soak};
pub use strata::{
    BED_DATUM, BED_SHIFT, BED_SURFACES, BEDROCK, Bed, ERODIBILITY, Fault, Fold, MATERIAL, NEW_ROCK, ROCK_SLOPE, SOAKED,
    Strata, Surfaces,
};
pub use subsurface::{Kind, Run, Subsurface};

use eyot_core::ComponentKind;
use eyot_core::about;
use eyot_core::process::{Entry, Process};

/// All processes that recipes can name.
pub const PROCESSES: &[Entry<dyn Process>] = &[
    Entry::<dyn Process>::process::<Strata>(
        "strata",
        about!("strata/mod.rs"),
        &["telford1990", "heimsath1997", "shobe2017"],
    ),
    Entry::<dyn Process>::process::<RockCycle>("rock_cycle", about!("rock_cycle.rs"), &[]),
    Entry::<dyn Process>::process::<Rockfall>("rockfall", about!("rockfall.rs"), &["musgrave1989", "benes2001"]),
    Entry::<dyn Process>::process::<Soak>("soak", about!("soak.rs"), &["stava2008"]),
];

/// Every kind of components that the processes of this crate keep in worlds.
pub const COMPONENTS: [&ComponentKind; 1] = [&sequence::SEQUENCE];
