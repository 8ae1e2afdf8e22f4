//! Which of several equally good ways is taken, and other choices that a cell makes by lot.
//!
//! # Rule
//! Of equally good ways the shortest; of those the one with the lowest number, which is a hash of where the cell lies and where the
//! way leads, both as seen from the middle of the grid. On a grid that is mirrored or turned by right angles the same cells draw
//! the same numbers, so that the drainage of a turned land is the turned drainage; and no direction comes first everywhere, as it
//! does where cells are scanned in some order. Only on the lines of symmetry of the grid can two ways have one number; then the
//! first clockwise from north is taken.

use super::neighbours::{Neighbours, STEPS};
use eyot_core::Grid;
use eyot_core::rng::mix64;
use std::cmp::Ordering;

/// Draws numbers for the cells of a grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    width: usize,
    /// Twice the place of the middle.
    middle: [i64; 2],
    /// Whether columns count before rows, because there are more of them or they are wider; on square grids the axis does along which
    /// a cell lies farther out.
    columns_first: Option<bool>,
}

impl Places {
    pub(super) fn new(grid: &Grid) -> Self {
        let order = (grid.width.cmp(&grid.height)).then(grid.cell_x_m.total_cmp(&grid.cell_y_m));
        Self {
            width: grid.width,
            middle: [grid.width as i64 - 1, grid.height as i64 - 1],
            columns_first: (order != Ordering::Equal).then_some(order == Ordering::Greater),
        }
    }

    /// How cell `i` lies.
    #[inline]
    pub(super) fn of(&self, i: usize) -> Place {
        let [x, y] = self.off_middle(i);
        let mut at = [x.abs(), y.abs()];
        let swapped = self.columns_first.map_or(at[1] > at[0], |first| !first);
        if swapped {
            at.swap(0, 1);
        }
        Place { signs: [x.signum(), y.signum()], swapped, diagonal: self.columns_first.is_none() && at[0] == at[1], at }
    }

    /// Twice the steps from the middle of the grid to cell `i`.
    #[inline]
    fn off_middle(&self, i: usize) -> [i64; 2] {
        [2 * (i % self.width) as i64 - self.middle[0], 2 * (i / self.width) as i64 - self.middle[1]]
    }

    /// Number of cell `i` for searches that begin at `start`.
    #[inline]
    pub(super) fn number(&self, start: &Place, i: usize) -> u64 {
        start.number(self.off_middle(i))
    }

    /// One of the `ways` (one bit a direction of [`STEPS`], at least one) of cell `i`.
    #[inline]
    pub(super) fn choose(&self, i: usize, ways: u8, near: &Neighbours) -> usize {
        let first = ways.trailing_zeros() as usize;
        if ways & (ways - 1) == 0 {
            return first;
        }
        let place = self.of(i);
        let (mut best, mut chosen) = ((f64::INFINITY, 0), first);
        for (d, (dx, dy)) in STEPS.into_iter().enumerate().filter(|(d, _)| ways & (1 << d) != 0) {
            let rank = (near.distance_m[d], place.number([dx as i64, dy as i64]));
            if rank < best {
                (best, chosen) = (rank, d);
            }
        }
        chosen
    }
}

/// A cell as seen from the middle of its grid: turned and mirrored so that it lies to the south-east, on square grids nearer to east.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Twice its distances from the middle along the axes.
    at: [i64; 2],
    signs: [i64; 2],
    swapped: bool,
    /// On a line of symmetry between the axes.
    diagonal: bool,
}

impl Place {
    /// Number of what lies at `vector`, from the cell or from the middle.
    #[inline]
    pub(super) fn number(&self, vector: [i64; 2]) -> u64 {
        // On a line of symmetry both sides of it are alike.
        let side = |k: usize| if self.signs[k] == 0 { vector[k].abs() } else { vector[k] * self.signs[k] };
        let mut turned = [side(0), side(1)];
        if self.swapped || (self.diagonal && turned[1] > turned[0]) {
            turned.swap(0, 1);
        }
        let [x, y] = turned.map(|v| v as u64);
        mix64(self.lot() ^ mix64(x ^ mix64(y)))
    }

    /// The cell's own number, in 0..1.
    #[inline]
    pub(super) fn unit(&self) -> f64 {
        (self.lot() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The cell's own number.
    #[inline]
    pub(super) fn lot(&self) -> u64 {
        let [x, y] = self.at.map(|v| v as u64);
        mix64(x << 32 | y)
    }
}
