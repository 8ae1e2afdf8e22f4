//! The eight neighbours of a cell, by cell index, with their distances in metres and the rim respected.

use eyot_core::{BoundaryCondition, Grid};

/// Column and row steps to the eight neighbours: north first, then clockwise. Odd ones are diagonal.
pub const STEPS: [(isize, isize); 8] = [(0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1)];

/// Finds neighbours. Cells are numbered row by row from the north-west; a wrapping axis is a ring, other rims end.
#[derive(Clone, Copy, Debug)]
pub struct Neighbours {
    width: usize,
    height: usize,
    wrap_x: bool,
    wrap_y: bool,
    /// Distance to the neighbour in each direction of [`STEPS`], m.
    pub distance_m: [f64; 8],
}

impl Neighbours {
    /// The neighbourhood of `grid`'s cells.
    pub fn new(grid: &Grid) -> Self {
        Self {
            width: grid.width,
            height: grid.height,
            wrap_x: grid.rim.x == BoundaryCondition::Wrap,
            wrap_y: grid.rim.y == BoundaryCondition::Wrap,
            distance_m: STEPS.map(|(dx, dy)| {
                let (x, y) = (dx as f64 * grid.cell_x_m, dy as f64 * grid.cell_y_m);
                (x * x + y * y).sqrt()
            }),
        }
    }

    /// Calls `f(direction, neighbour)` for each of the up to eight neighbours of cell `i`.
    ///
    /// A ring of one cell has no neighbour along itself; in a ring of two the same neighbour comes twice.
    #[inline]
    pub fn each(&self, i: usize, mut f: impl FnMut(usize, usize)) {
        let (x, y) = (i % self.width, i / self.width);
        if x > 0 && y > 0 && x + 1 < self.width && y + 1 < self.height {
            for (d, (dx, dy)) in STEPS.into_iter().enumerate() {
                f(d, i.wrapping_add_signed(dy * self.width as isize + dx));
            }
            return;
        }
        for (d, (dx, dy)) in STEPS.into_iter().enumerate() {
            if let (Some(nx), Some(ny)) = (step(x, dx, self.width, self.wrap_x), step(y, dy, self.height, self.wrap_y))
            {
                let j = ny * self.width + nx;
                if j != i {
                    f(d, j);
                }
            }
        }
    }

    /// The neighbour of cell `i` in direction `d` of [`STEPS`], if there is one.
    #[inline]
    pub fn at(&self, i: usize, d: usize) -> Option<usize> {
        let (dx, dy) = STEPS[d];
        let x = step(i % self.width, dx, self.width, self.wrap_x)?;
        let y = step(i / self.width, dy, self.height, self.wrap_y)?;
        Some(y * self.width + x).filter(|&j| j != i)
    }

    /// True if an axis is a ring.
    pub fn wraps(&self) -> bool {
        self.wrap_x || self.wrap_y
    }

    /// True if cell `i` has a neighbour on every side, so that nothing is cut off by the rim.
    #[inline]
    pub fn is_interior(&self, i: usize) -> bool {
        let (x, y) = (i % self.width, i / self.width);
        (self.wrap_x || (x > 0 && x + 1 < self.width)) && (self.wrap_y || (y > 0 && y + 1 < self.height))
    }
}

#[inline]
fn step(i: usize, by: isize, n: usize, wrap: bool) -> Option<usize> {
    let j = i as isize + by;
    if wrap { Some(j.rem_euclid(n as isize) as usize) } else { (0..n as isize).contains(&j).then_some(j as usize) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Limits};

    fn all(grid: &Grid, i: usize) -> Vec<usize> {
        let mut v = Vec::new();
        Neighbours::new(grid).each(i, |d, j| {
            assert_eq!(Neighbours::new(grid).at(i, d), Some(j));
            v.push(j);
        });
        v.sort_unstable();
        v
    }

    #[test]
    fn corners_have_three_and_rings_eight() {
        let closed = Grid::new(4, 3, 1.0, Boundary::CLOSED, &Limits::default()).unwrap();
        assert_eq!(all(&closed, 0), [1, 4, 5]);
        assert_eq!(all(&closed, 5), [0, 1, 2, 4, 6, 8, 9, 10]);
        let ring = Grid { rim: Boundary::WRAP, ..closed };
        assert_eq!(all(&ring, 0), [1, 3, 4, 5, 7, 8, 9, 11]);
    }

    #[test]
    fn a_single_cell_has_none() {
        for rim in [Boundary::CLOSED, Boundary::OPEN, Boundary::WRAP] {
            assert!(all(&Grid::new(1, 1, 1.0, rim, &Limits::default()).unwrap(), 0).is_empty());
        }
    }

    #[test]
    fn distances_follow_the_cell_size() {
        let grid = Grid {
            cell_x_m: 3.0,
            cell_y_m: 4.0,
            ..Grid::new(4, 3, 1.0, Boundary::CLOSED, &Limits::default()).unwrap()
        };
        assert_eq!(Neighbours::new(&grid).distance_m, [4.0, 5.0, 3.0, 5.0, 4.0, 5.0, 3.0, 5.0]);
    }
}
