//! Layers where they lie on the card, for shaders of others.

use wgpu::Buffer;

/// A layer on the card, as it was after the last call of the engine. Shaders that are submitted before the next call read it; nothing
/// is copied.
#[non_exhaustive]
pub struct LayerView<'a> {
    /// Columns of the grid.
    pub width: usize,
    /// Rows of the grid.
    pub height: usize,
    /// The layer's rows from north to south: one part, or several where the grid is cut.
    pub parts: Vec<LayerPart<'a>>,
}

/// Rows of a layer in one buffer of numbers of 32 bits.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct LayerPart<'a> {
    /// Holds them, among others. Can be bound as storage.
    pub buffer: &'a Buffer,
    /// The first row.
    pub first_row: usize,
    /// Rows.
    pub rows: usize,
    /// Rows below the last one that lie in the buffer, too: those that it shares with the next part.
    pub more_rows: usize,
    /// Where column 0 of the first row lies, in numbers from the begin of the buffer.
    pub offset: usize,
    /// Distance of two rows, in numbers.
    pub row_stride: usize,
}
