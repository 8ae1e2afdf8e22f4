//! Fields with a frame of ghost cells, so that what looks at neighbours needs no special case at rims.

use eyot_core::{BoundaryCondition, Grid};
use rayon::prelude::*;

/// A field with one more cell on each side, row by row.
#[derive(Clone, Debug, Default)]
pub struct Padded {
    /// Values, `stride` a row.
    pub values: Vec<f32>,
    /// Cells of a row with its ghosts.
    pub stride: usize,
    width: usize,
    height: usize,
}

impl Padded {
    /// All cells 0.
    pub fn new(grid: &Grid) -> Self {
        let (width, height, stride) = (grid.width, grid.height, grid.width + 2);
        Self { values: vec![0.0; stride * (height + 2)], stride, width, height }
    }

    /// Cells from a function of their column and row, and their ghosts.
    pub fn from_fn(grid: &Grid, f: impl Fn(usize, usize) -> f32 + Sync) -> Self {
        let mut new = Self::new(grid);
        new.rows_mut().for_each(|(y, row)| row.iter_mut().enumerate().for_each(|(x, v)| *v = f(x, y)));
        new.ghosts(grid);
        new
    }

    /// The row of ghosts and cells `y`, where row 0 is the ghosts north of the grid.
    #[inline]
    pub fn framed(&self, y: usize) -> &[f32] {
        &self.values[y * self.stride..(y + 1) * self.stride]
    }

    /// The cells of row `y` of the grid.
    #[inline]
    pub fn row(&self, y: usize) -> &[f32] {
        let at = (y + 1) * self.stride + 1;
        &self.values[at..at + self.width]
    }

    /// The value of a cell.
    #[inline]
    pub fn at(&self, x: usize, y: usize) -> f32 {
        self.values[(y + 1) * self.stride + x + 1]
    }

    /// The cells of all rows of the grid, to be changed; ghosts follow by [`Padded::ghosts`].
    pub fn rows_mut(&mut self) -> impl IndexedParallelIterator<Item = (usize, &mut [f32])> {
        let (stride, width, height) = (self.stride, self.width, self.height);
        let inner = &mut self.values[stride..stride * (height + 1)];
        inner.par_chunks_exact_mut(stride).enumerate().map(move |(y, row)| (y, &mut row[1..=width]))
    }

    /// Fills the frame: with the cells of the far side on rings, else with those next to it.
    pub fn ghosts(&mut self, grid: &Grid) {
        let (w, h, p) = (self.width, self.height, self.stride);
        let ring = |edge: BoundaryCondition| edge == BoundaryCondition::Wrap;
        let (left, right) = if ring(grid.rim.x) { (w, 1) } else { (1, w) };
        for row in self.values.chunks_exact_mut(p) {
            (row[0], row[w + 1]) = (row[left], row[right]);
        }
        let (above, below) = if ring(grid.rim.y) { (h, 1) } else { (1, h) };
        self.values.copy_within(above * p..(above + 1) * p, 0);
        self.values.copy_within(below * p..(below + 1) * p, (h + 1) * p);
    }

    /// Smooths by weights 1, 2, 1 along rows and columns, `times` over; mirrored worlds stay mirrored.
    pub fn smooth(&mut self, grid: &Grid, times: usize) {
        let mut next = Self::new(grid);
        for _ in 0..times {
            next.rows_mut().for_each(|(y, out)| {
                let (a, b, c) = (self.framed(y), self.framed(y + 1), self.framed(y + 2));
                for (x, out) in out.iter_mut().enumerate() {
                    let side = |k: usize| (a[k] + c[k]) + 2.0 * b[k];
                    *out = ((side(x) + side(x + 2)) + 2.0 * side(x + 1)) * 0.0625;
                }
            });
            next.ghosts(grid);
            std::mem::swap(self, &mut next);
        }
    }
}
