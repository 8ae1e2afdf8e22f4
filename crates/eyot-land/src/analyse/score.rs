//! The erosion score of a landscape: how much its steps differ.
//!
//! `s_i` is the largest of `|h_i - h_j|` over the up to four neighbours `j` that share an edge with cell `i`; the score is the
//! standard deviation of all `s_i` over their mean (Olsen 2004, section 2: valleys with flat floors below steep sides, which people
//! can use, raise it, and slopes that are alike everywhere lower it). It has no unit and does not change when all heights
//! are multiplied.
//!
//! It depends on the size of cells: compare landscapes on the same grid, or one with itself as it ages.

use super::moments::{finite, moments};
use eyot_core::{BoundaryCondition, Field, Grid, Result};

/// The erosion score of the cells that `counts` says; `None` if there are none, or they are all level.
///
/// Neighbours that do not count are looked at, too. On a wrapping axis they go round, other rims end.
///
/// # Errors
/// If `height` has another size than `grid`.
pub fn erosion_score(height: &Field, grid: &Grid, counts: impl Fn(usize) -> bool) -> Result<Option<f64>> {
    super::check_fits(height, grid)?;
    let (width, rows) = (grid.width, grid.height);
    let beside = |at: usize, n: usize, rim: BoundaryCondition| {
        let wraps = rim == BoundaryCondition::Wrap && n > 1;
        let before = if at > 0 { Some(at - 1) } else { wraps.then(|| n - 1) };
        let after = if at + 1 < n { Some(at + 1) } else { wraps.then_some(0) };
        [before, after]
    };
    let mut steps = Vec::new();
    for y in 0..rows {
        let beside_y = beside(y, rows, grid.rim.y);
        for x in (0..width).filter(|x| counts(y * width + x)) {
            let here = height.get(x, y);
            let along = beside(x, width, grid.rim.x).into_iter().flatten().map(|x| height.get(x, y));
            let across = beside_y.into_iter().flatten().map(|y| height.get(x, y));
            steps.push(along.chain(across).map(|there| (there - here).abs()).fold(0.0, f32::max));
        }
    }
    Ok(moments(&steps).filter(|m| m.mean > 0.0).and_then(|m| finite(m.deviation / m.mean)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Limits};

    fn score(rim: Boundary, width: usize, heights: &[f32], counts: impl Fn(usize) -> bool) -> Option<f64> {
        let rows = heights.len() / width;
        let grid = Grid::new(width, rows, 10.0, rim, &Limits::default()).unwrap();
        let field = Field::from_slice(width, rows, heights).unwrap();
        erosion_score(&field, &grid, counts).unwrap()
    }

    /// Steps by hand. Of a row, 0 1 3 3 7: 1, 2, 2, 4, 4; mean 13/5, squares 41/5.
    #[test]
    fn scores_are_those_of_fields_made_by_hand() {
        let near = |a: Option<f64>, b: f64| a.is_some_and(|a| (a - b).abs() < 1e-12);
        let row = [0.0, 1.0, 3.0, 3.0, 7.0];
        let of_row = (41.0f64 / 5.0 - (13.0f64 / 5.0).powi(2)).sqrt() / (13.0 / 5.0);
        assert!(near(score(Boundary::CLOSED, 5, &row, |_| true), of_row));
        // Downwards as along, and the same for heights that are three times as large.
        assert!(near(score(Boundary::CLOSED, 1, &row, |_| true), of_row));
        assert!(near(score(Boundary::CLOSED, 5, &row.map(|h| -3.0 * h), |_| true), of_row));
        // A ring: 7, 2, 2, 4, 7; mean 22/5, squares 122/5.
        let ring = (122.0f64 / 5.0 - (22.0f64 / 5.0).powi(2)).sqrt() / (22.0 / 5.0);
        assert!(near(score(Boundary::WRAP, 5, &row, |_| true), ring));
        // The diagonal does not count: steps of 0 5 / 1 2 are 5, 5, 1, 3.
        let square = (60.0f64 / 4.0 - 3.5f64.powi(2)).sqrt() / 3.5;
        assert!(near(score(Boundary::CLOSED, 2, &[0.0, 5.0, 1.0, 2.0], |_| true), square));
        // Two of them: 5 and 3, though the neighbours of both do not count.
        assert!(near(score(Boundary::CLOSED, 2, &[0.0, 5.0, 1.0, 2.0], |i| i == 0 || i == 3), 0.25));
        // A plane has equal steps; what is level has no score.
        let plane: Vec<f32> = (0..12).map(|i| 2.0 * (i % 4) as f32).collect();
        assert!(near(score(Boundary::CLOSED, 4, &plane, |_| true), 0.0));
        assert_eq!(score(Boundary::CLOSED, 4, &[3.0; 8], |_| true), None);
        assert_eq!(score(Boundary::CLOSED, 5, &row, |_| false), None);
        let grid = Grid::new(4, 4, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
        assert!(erosion_score(&Field::new(4, 3, 0.0), &grid, |_| true).is_err());
    }
}
