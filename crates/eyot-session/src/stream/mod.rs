//! Streamed runs: worlds that are never in memory as a whole.
//!
//! Where every step is a generator that can be cut ([`eyot_core::process::Reach`]), any rows of any layer can be made by
//! running all steps on a window of rows, grown by as much as the steps look around. Exports are written while the
//! rows are made; a survey before them finds the ranges of the layers, the world's fingerprint and an overview in coarser
//! cells, of which the pictures are drawn. Files are the same, byte by byte, as those of a run in one piece. Only the
//! pictures of grids beyond [`OVERVIEW`] are not: they see means of cells. There is no `world.eyot`.

mod plan;
mod stages;
mod survey;
#[cfg(test)]
mod tests;
mod world;

pub(crate) use plan::chosen;
pub use plan::streamed_memory;
pub(crate) use survey::Survey;
pub(crate) use world::StreamedWorld;

/// Most cells along the longer side of a streamed world's overview: more than pictures have pixels.
pub const OVERVIEW: usize = 2048;
/// Grids of more cells are streamed wherever that is possible.
const LARGE: usize = 1 << 26;

/// Whether a run makes its world in one piece or streams it. Does not change a byte of the exports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stream {
    /// Streamed if the recipe allows it and the grid is large (more than 8192 x 8192 cells) or beyond the memory limit.
    #[default]
    Auto,
    /// Streamed; recipes that need the whole grid are refused.
    Always,
    /// In one piece.
    Never,
}
