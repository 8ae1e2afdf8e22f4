//! Which part of the grid is held: all of it, or a window of it with the neighbours' cells around.
//!
//! Rules ask for the place of their cell and for random numbers, and plans for the size of the world. These are always those of the
//! whole grid, wherever the cells lie in memory, so a part of the world that is computed by itself has the same bytes.
//!
//! Around the window lies a **halo** of cells that belong to somebody else. They are computed with the others, but since what lies
//! beyond them is not known, each pass makes as many more of them wrong as it looks far. The inside is right as long as
//! [`Plan::reach`](crate::plan::Plan::reach) of all that has run is no more than the halo; then its owner fills it anew.

use crate::error::{Error, Result};
use crate::grid::{BoundaryCondition, Grid};
use std::ops::Range;

/// The part of a grid that is held: a window and its halo. Most often it is the whole grid.
///
/// *Held* columns and rows are counted from 0 where the halo begins, as the cells of fields are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    global: Grid,
    halo: usize,
    x: Axis,
    y: Axis,
}

/// What lies beyond an end of the cells that are held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// The rim of the grid; a ring closes here only if all of it is held once.
    Boundary(BoundaryCondition),
    /// More of the grid.
    Cut,
}

/// A part of one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Axis {
    /// Cells of the whole axis, and how it ends.
    total: usize,
    edge: BoundaryCondition,
    /// First cell of the window, and how many it has.
    start: usize,
    len: usize,
    /// Cells held before and behind them.
    before: usize,
    behind: usize,
}

impl Axis {
    fn new(total: usize, edge: BoundaryCondition, window: &Range<usize>, halo: usize) -> Self {
        let (start, len) = (window.start, window.len());
        let (before, behind) = match edge {
            _ if len == total => (0, 0),
            BoundaryCondition::Wrap => (halo, halo),
            BoundaryCondition::Closed | BoundaryCondition::Open => (halo.min(start), halo.min(total - window.end)),
        };
        Self { total, edge, start, len, before, behind }
    }

    const fn held(&self) -> usize {
        self.before + self.len + self.behind
    }

    const fn first(&self) -> isize {
        self.start as isize - self.before as isize
    }

    /// True if the far side of a ring comes after its last cell among those that are held.
    fn crosses_seam(&self) -> bool {
        let outside = self.first() < 0 || self.first() + self.held() as isize > self.total as isize;
        self.len < self.total && self.edge == BoundaryCondition::Wrap && outside
    }

    /// The number of a held cell in the whole axis. The one before the first of an open rim, which only faces have, is -1.
    fn place(&self, held: isize) -> isize {
        let place = self.first() + held;
        if self.crosses_seam() { place.rem_euclid(self.total as isize) } else { place }
    }

    fn ends(&self) -> [End; 2] {
        let rim = End::Boundary(self.edge);
        if self.len == self.total {
            return [rim; 2];
        }
        let at_rim = |reached: bool| if reached && self.edge != BoundaryCondition::Wrap { rim } else { End::Cut };
        [at_rim(self.first() == 0), at_rim(self.first() + self.held() as isize == self.total as isize)]
    }

    const fn inside(&self) -> Range<usize> {
        self.before..self.before + self.len
    }
}

impl Domain {
    /// The whole grid.
    pub fn whole(global: Grid) -> Self {
        let axis = |total, edge| Axis { total, edge, start: 0, len: total, before: 0, behind: 0 };
        Self { global, halo: 0, x: axis(global.width, global.rim.x), y: axis(global.height, global.rim.y) }
    }

    /// Some columns and rows of a grid, with a halo of up to `halo` cells on each side: less where the grid ends at a closed or open
    /// rim, and none along an axis of which all cells are in the window.
    ///
    /// # Errors
    /// If the window holds no cell or some that the grid does not have.
    pub fn window(global: Grid, columns: Range<usize>, rows: Range<usize>, halo: usize) -> Result<Self> {
        if columns.is_empty() || rows.is_empty() || columns.end > global.width || rows.end > global.height {
            return Err(Error::BadGrid(format!(
                "the columns {columns:?} and rows {rows:?} are no window of {}x{} cells",
                global.width, global.height
            )));
        }
        let x = Axis::new(global.width, global.rim.x, &columns, halo);
        Ok(Self { global, halo, x, y: Axis::new(global.height, global.rim.y, &rows, halo) })
    }

    /// The whole grid.
    pub const fn global(&self) -> &Grid {
        &self.global
    }

    /// True if every cell of the grid is in the window.
    pub const fn is_whole(&self) -> bool {
        self.x.len == self.x.total && self.y.len == self.y.total
    }

    /// How far passes may look in all until the halo has to be filled anew; as far as they like if the halo reaches all rims.
    pub fn halo(&self) -> usize {
        let cut = self.ends_x().contains(&End::Cut) || self.ends_y().contains(&End::Cut);
        if cut { self.halo } else { usize::MAX }
    }

    /// Columns of the grid in the window.
    pub const fn columns(&self) -> Range<usize> {
        self.x.start..self.x.start + self.x.len
    }

    /// Rows of the grid in the window.
    pub const fn rows(&self) -> Range<usize> {
        self.y.start..self.y.start + self.y.len
    }

    /// The cells that are held as a grid of their own: its width and height are those of fields. An axis that is cut has a closed rim
    /// there unless the grid's own is open.
    pub fn held(&self) -> Grid {
        let mut grid = self.global;
        (grid.width, grid.height) = (self.x.held(), self.y.held());
        for (edge, axis) in [(&mut grid.rim.x, &self.x), (&mut grid.rim.y, &self.y)] {
            if *edge == BoundaryCondition::Wrap && axis.len < axis.total {
                *edge = BoundaryCondition::Closed;
            }
        }
        grid
    }

    /// Columns and rows that are held.
    pub(crate) const fn held_size(&self) -> (usize, usize) {
        (self.x.held(), self.y.held())
    }

    /// Held columns of the window.
    pub const fn inside_columns(&self) -> Range<usize> {
        self.x.inside()
    }

    /// Held rows of the window.
    pub const fn inside_rows(&self) -> Range<usize> {
        self.y.inside()
    }

    /// Column of the grid that is held as column `x`; -1 stays -1 at a rim.
    pub fn column(&self, x: isize) -> isize {
        self.x.place(x)
    }

    /// Row of the grid that is held as row `y`; -1 stays -1 at a rim.
    pub fn row(&self, y: isize) -> isize {
        self.y.place(y)
    }

    /// Number of a held cell in the whole grid, for random numbers.
    pub(crate) fn cell_number(&self, x: isize, y: isize) -> u32 {
        cell_number(self.column(x), self.row(y), self.global.width)
    }

    /// True if columns of the far side of a ring follow on its last one.
    pub(crate) fn crosses_seam(&self) -> bool {
        self.x.crosses_seam()
    }

    /// What lies to the west and to the east.
    pub(crate) fn ends_x(&self) -> [End; 2] {
        self.x.ends()
    }

    /// What lies to the north and to the south.
    pub(crate) fn ends_y(&self) -> [End; 2] {
        self.y.ends()
    }
}

/// Number of a cell of the whole grid for random numbers.
#[inline(always)]
pub(crate) fn cell_number(x: isize, y: isize, width: usize) -> u32 {
    (y as u32).wrapping_mul(width as u32).wrapping_add(x as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Boundary;

    fn grid(x: BoundaryCondition, y: BoundaryCondition) -> Grid {
        Grid { width: 10, height: 6, cell_x_m: 1.0, cell_y_m: 1.0, rim: Boundary { x, y } }
    }

    #[test]
    fn a_window_numbers_its_cells_as_the_whole_grid_does() {
        let d = Domain::window(grid(BoundaryCondition::Closed, BoundaryCondition::Wrap), 3..5, 0..2, 2).unwrap();
        assert_eq!((d.held().width, d.held().height), (6, 6));
        assert_eq!((d.inside_columns(), d.inside_rows()), (2..4, 2..4));
        assert_eq!((0..6).map(|y| d.row(y)).collect::<Vec<_>>(), [4, 5, 0, 1, 2, 3]);
        assert_eq!(d.cell_number(2, 2), 3);
        assert_eq!(d.cell_number(0, 0), 41);
        assert_eq!((d.ends_x(), d.ends_y()), ([End::Cut; 2], [End::Cut; 2]));
        assert!(!d.is_whole() && d.halo() == 2);
    }

    #[test]
    fn halos_end_at_rims_that_do_not_wrap() {
        let d = Domain::window(grid(BoundaryCondition::Open, BoundaryCondition::Closed), 0..4, 0..6, 3).unwrap();
        assert_eq!(d.ends_x(), [End::Boundary(BoundaryCondition::Open), End::Cut]);
        assert_eq!(d.ends_y(), [End::Boundary(BoundaryCondition::Closed); 2]);
        assert_eq!((d.held().width, d.held().height, d.column(-1)), (7, 6, -1));
    }

    #[test]
    fn the_whole_grid_is_a_window_of_itself() {
        let g = grid(BoundaryCondition::Wrap, BoundaryCondition::Open);
        let (whole, all) = (Domain::whole(g), Domain::window(g, 0..10, 0..6, 4).unwrap());
        assert_eq!((whole.held(), all.held()), (g, g));
        assert!(all.is_whole() && all.ends_x() == whole.ends_x() && all.ends_y() == whole.ends_y());
        assert_eq!(whole.halo(), usize::MAX);
        for (columns, rows) in [(0..0, 0..6), (0..11, 0..6), (0..10, 5..7)] {
            assert!(Domain::window(g, columns, rows, 1).is_err());
        }
    }
}
