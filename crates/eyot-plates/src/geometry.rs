//! Cells and their neighbours under the rim of a grid.

use eyot_core::{BoundaryCondition, Grid};

/// The grid as plates see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Geometry {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) cell_m: (f64, f64),
    pub(crate) rim: (BoundaryCondition, BoundaryCondition),
}

impl Geometry {
    pub(crate) fn new(grid: &Grid) -> Self {
        let Grid { width, height, cell_x_m, cell_y_m, rim } = *grid;
        Self { width, height, cell_m: (cell_x_m, cell_y_m), rim: (rim.x, rim.y) }
    }

    pub(crate) const fn cells(&self) -> usize {
        self.width * self.height
    }

    /// Side of a square of a cell's area, m.
    pub(crate) fn cell_side_m(&self) -> f64 {
        (self.cell_m.0 * self.cell_m.1).sqrt()
    }

    pub(crate) fn cell_area_m2(&self) -> f64 {
        self.cell_m.0 * self.cell_m.1
    }

    /// Column `x`, on the far side where the axis is a ring; `None` beyond a rim.
    #[inline]
    pub(crate) fn column(&self, x: isize) -> Option<usize> {
        resolve(x, self.width, self.rim.0)
    }

    /// Row `y`, as [`Geometry::column`].
    #[inline]
    pub(crate) fn row(&self, y: isize) -> Option<usize> {
        resolve(y, self.height, self.rim.1)
    }

    /// The cell in column `x` and row `y`.
    #[inline]
    pub(crate) fn cell(&self, x: isize, y: isize) -> Option<usize> {
        Some(self.row(y)? * self.width + self.column(x)?)
    }

    /// Column and row of a cell.
    #[inline]
    pub(crate) fn place(&self, cell: usize) -> (isize, isize) {
        // 32 bits divide several times faster.
        let (cell, width) = (cell as u32, self.width as u32);
        ((cell % width) as isize, (cell / width) as isize)
    }

    /// The cell that lies `(dx, dy)` from another one.
    #[inline]
    pub(crate) fn beside(&self, cell: usize, dx: isize, dy: isize) -> Option<usize> {
        let (x, y) = self.place(cell);
        self.cell(x + dx, y + dy)
    }

    /// The neighbours that share a side with a cell.
    pub(crate) fn sides(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        let (x, y) = self.place(cell);
        [(-1, 0), (1, 0), (0, -1), (0, 1)].into_iter().filter_map(move |(dx, dy)| self.cell(x + dx, y + dy))
    }

    /// All eight neighbours.
    pub(crate) fn ring(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        const RING: [(isize, isize); 8] = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];
        let (x, y) = self.place(cell);
        RING.into_iter().filter_map(move |(dx, dy)| self.cell(x + dx, y + dy))
    }

    /// Shortest way from `a` to `b` in cells, `(x, y)`.
    pub(crate) fn way(&self, a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
        let along = |d: f64, n: usize, edge: BoundaryCondition| {
            let n = n as f64;
            if edge == BoundaryCondition::Wrap { d - (d / n).round() * n } else { d }
        };
        (along(b.0 - a.0, self.width, self.rim.0), along(b.1 - a.1, self.height, self.rim.1))
    }
}

/// Rows that a thread takes at once: below some ten thousand cells, handing them out takes longer than the work.
pub(crate) fn rows_at_once(width: usize) -> usize {
    (16_384 / width.max(1)).max(1)
}

#[inline]
fn resolve(i: isize, n: usize, edge: BoundaryCondition) -> Option<usize> {
    if (0..n as isize).contains(&i) {
        Some(i as usize)
    } else if edge == BoundaryCondition::Wrap {
        Some(i.rem_euclid(n as isize) as usize)
    } else {
        None
    }
}
