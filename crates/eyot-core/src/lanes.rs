//! Lanes (placeholder).
/// Cells per lane block.
pub const WIDTH: usize = 16;
