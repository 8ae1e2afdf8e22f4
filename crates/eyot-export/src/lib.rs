//! **Files and pictures of landscapes**: what a recipe's exports write, conversion from file to file, and the import of height
//! maps.
//!
//! [`write()`] makes the files of an export, [`convert`](convert::convert) turns height maps and runs into other formats, [`open`](open::open)
//! finds the world in a file or a run's folder, [`draw`](pictures::draw) makes pictures of it. [`IMPORT`] is the generator that
//! takes height maps into recipes, [`Files`] resolves the files that recipes name, [`Costs`] says what outputs cost, and [`RunFiles`] writes
//! what a run has come to.

mod below;
mod chart;
pub mod convert;
pub mod corals;
mod dive;
mod error;
pub mod estimate;
mod files;
mod fit;
mod import;
mod masks;
mod materials;
pub mod open;
mod open_water;
mod outputs;
pub mod pictures;
mod plots;
mod preset;
pub mod section;
mod terrain;
mod terrain_plots;
mod tree_bodies;
mod trees;
mod views;

/// Sheets of small pictures.
pub mod sheets {
    pub use eyot_render::{Picture, SheetCell, contact_sheet};
}

pub use error::ExportError;
pub use estimate::Costs;
pub use eyot_io::{Source, write_text};
pub use files::{Job, write};
pub use import::{Files, IMPORT, Import, read_raster};
pub use outputs::RunFiles;
pub use pictures::Subject;
pub use terrain_plots::terrain_plots;
