//! How far plates went in a step, so that what others do to the land in the meantime can follow.

use crate::geometry::Geometry;
use crate::runs::{self, Run};

/// The ways of all plates in a step.
pub(crate) struct Course {
    g: Geometry,
    /// Who owned each cell when the plates had moved, before any cell was given to another plate.
    rows: Vec<Vec<Run>>,
    /// Columns and rows that each plate went.
    ways: Vec<(isize, isize)>,
}

impl Course {
    /// `owner` after the plates went `ways`; `None` if all stayed.
    pub(crate) fn new(g: &Geometry, owner: &[u8], ways: Vec<(isize, isize)>) -> Option<Self> {
        let moved = ways.iter().any(|&w| w != (0, 0));
        moved.then(|| Self { g: *g, rows: runs::of_rows(owner, g.width), ways })
    }

    /// Calls `f` with each column of a row, and row and column from which its crust came. Not for crust that came from nowhere: over
    /// a rim, or up a ridge, where another plate was before (`owner`: before the plates moved).
    pub(crate) fn trace(&self, owner: &[u8], row: usize, mut f: impl FnMut(usize, (usize, usize))) {
        for run in &self.rows[row] {
            let (dx, dy) = self.ways[usize::from(run.owner)];
            let Some(y) = self.g.row(row as isize - dy) else { continue };
            let owner = &owner[y * self.g.width..][..self.g.width];
            for column in run.range() {
                let Some(x) = self.g.column(column as isize - dx) else { continue };
                if owner[x] == run.owner {
                    f(column, (y, x));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, BoundaryCondition, Grid, Limits};

    #[test]
    fn crust_is_traced_back_round_the_world_and_not_over_closed_rims() {
        let rim = Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Closed };
        let g = Geometry::new(&Grid::new(4, 3, 1.0, rim, &Limits::default()).unwrap());
        let before = [0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1];
        // Plate 0 went one column to the west and one row to the south, over plate 1; a gap opened behind it.
        let after = [0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 0];
        let course = Course::new(&g, &after, vec![(-1, 1), (0, 0)]).unwrap();
        let origin = |row, column| {
            let mut found = None;
            course.trace(&before, row, |c, from| found = if c == column { Some(from) } else { found });
            found
        };
        assert_eq!(origin(1, 3), Some((0, 0)));
        assert_eq!(origin(1, 0), Some((0, 1)));
        assert_eq!(origin(1, 1), None, "a gap");
        assert_eq!(origin(0, 0), None, "beyond the pole");
        assert_eq!(origin(2, 2), Some((2, 2)));
        assert!(Course::new(&g, &after, vec![(0, 0); 2]).is_none());
    }
}
