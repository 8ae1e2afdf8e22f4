//! What writers may be told, and what they have in common.

use crate::error::{Error, Result};
use crate::sample::{ByteOrder, RowOrder};
use std::path::Path;

/// What a writer may be told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WriteOptions {
    /// Values that 0 and 65535 stand for in 16-bit formats; the smallest and the largest value if not given.
    pub scale: Option<(f64, f64)>,
    /// Order of the bytes of a number in headerless files.
    pub byte_order: ByteOrder,
    /// Order of the rows in headerless files.
    pub row_order: RowOrder,
    /// The value that a GeoTIFF declares as missing; must not occur. A free one is chosen if not given.
    pub nodata: Option<f32>,
}

/// Width and height as the 32-bit numbers that PNG and TIFF store.
pub(crate) fn size_u32(path: &Path, width: usize, height: usize) -> Result<(u32, u32)> {
    // PNG allows 2^31 - 1 and TIFF readers commonly the same.
    let fit = |n: usize| u32::try_from(n).ok().filter(|&n| n <= i32::MAX as u32);
    fit(width).zip(fit(height)).ok_or_else(|| {
        Error::format(path, format!("{width}x{height} cells are too many for this format"), "write R32 or fewer cells")
    })
}
