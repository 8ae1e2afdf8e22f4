//! Bands of rows: what one thread works on at a time.

use eyot_core::Grid;

/// Cells of a band: heights and labels of so many stay in the second cache.
const CELLS: usize = 1 << 16;

/// Cells of a band, in whole rows. Depends on the grid alone, so that the number of threads changes nothing.
pub(super) fn band_cells(grid: &Grid) -> usize {
    CELLS.div_ceil(grid.width).clamp(8, grid.height.max(8)) * grid.width
}

/// Bands of work that follows rivers: few of them cross so few borders.
const BROAD: usize = 32;

/// Cells of a broad band, in whole rows; depends on the grid alone, too.
pub(super) fn broad_band_cells(grid: &Grid) -> usize {
    (grid.height.div_ceil(BROAD) * grid.width).max(band_cells(grid))
}

/// The rows north of, at and south of row `y`, if there are such rows without wrapping.
#[inline(always)]
pub(super) fn three_rows<'a, T>(values: &'a [T], grid: &Grid, y: usize) -> Option<[&'a [T]; 3]> {
    let w = grid.width;
    (w > 2 && y > 0 && y + 1 < grid.height).then(|| [y - 1, y, y + 1].map(|y| &values[y * w..][..w]))
}

/// The eight values around each inner cell of three rows, in the order of [`STEPS`](super::STEPS).
#[inline(always)]
pub(super) fn around<T: Copy>([north, here, south]: [&[T]; 3], x: usize) -> [T; 8] {
    [north[x + 1], north[x + 2], here[x + 2], south[x + 2], south[x + 1], south[x], here[x], north[x]]
}
