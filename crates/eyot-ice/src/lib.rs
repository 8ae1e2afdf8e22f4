//! Ice of mountains: glaciers that flow, slide, carve valleys, carry debris and leave moraines.
//!
//! [`Glaciers`] is the process that recipes name. The ice flows by [`sheet`], fed by [`balance`]; what it does to its bed is in [`bed`],
//! where the debris goes in [`debris`]. [`lines`] solves the systems along rows and columns.

pub mod balance;
pub mod bed;
pub mod debris;
pub mod glaciers;
pub mod lines;
pub mod padded;
pub mod sheet;

pub use glaciers::Glaciers;

use eyot_core::about;
use eyot_core::layer::LayerSpec;
use eyot_core::process::{Entry, Process};

/// Thickness of glaciers.
pub const GLACIER: LayerSpec =
    LayerSpec::new("glacier", "m", "Thickness of the glacier's ice on the ground", (0.0, 12000.0)).empty_outside();
/// Speed of sliding.
pub const GLACIER_SLIDING: LayerSpec =
    LayerSpec::new("glacier_sliding", "m/a", "How fast the glacier slides over its bed", (0.0, 1e5)).empty_outside();
/// What ice has carved.
pub const GLACIAL_EROSION: LayerSpec =
    LayerSpec::new("glacial_erosion", "m", "Thickness of rock that glaciers have taken away here", (0.0, 12000.0));
/// What ice has left.
pub const MORAINE: LayerSpec = LayerSpec::new(
    "moraine",
    "m",
    "Thickness of the debris that glaciers have left; part of the height",
    (0.0, 12000.0),
);

/// All processes that recipes can name.
pub const PROCESSES: &[Entry<dyn Process>] = &[Entry::<dyn Process>::process::<Glaciers>(
    "glaciers",
    about!("glaciers.rs"),
    &["halfar1983", "braun1999", "egholm2011", "herman2015", "ohmura1992", "iverson2012", "cordonnier2023"],
)];
