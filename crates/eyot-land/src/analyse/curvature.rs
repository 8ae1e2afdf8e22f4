//! Curvature: the Laplacian of the height, positive where the ground is hollow, negative where it bulges.
//!
//! # Equation
//! `L = (z_e - 2 z + z_w) / dx^2 + (z_s - 2 z + z_n) / dy^2`, in 1/m, from the five-point stencil.
//!
//! # Reading
//! The skewness of `L` compares ridges with valleys. Where rivers and slopes shaped the land, ridges are the sharper ones
//! and the skewness is negative (-0.03..-0.72 in five real tiles); Gaussian noise is symmetric and has none.

use super::check_fits;
use eyot_core::{Field, Grid, Result};
use eyot_drainage::Neighbours;

/// Laplacian of the height in 1/m of all cells that are not cut off by the rim and that `keep` accepts by number (row by
/// row), in that order.
///
/// # Errors
/// If `height` has another size than `grid`.
pub fn curvatures(height: &Field, grid: &Grid, keep: impl Fn(usize) -> bool) -> Result<Vec<f32>> {
    check_fits(height, grid)?;
    let z = height.to_vec();
    let around = Neighbours::new(grid);
    let (per_x2, per_y2) = (grid.cell_x_m.powi(-2), grid.cell_y_m.powi(-2));
    let value = |i: Option<usize>, own: f64| i.map_or(own, |i| f64::from(z[i]));
    Ok((0..z.len())
        .filter(|&i| around.is_interior(i) && keep(i))
        .map(|i| {
            let c = f64::from(z[i]);
            // A ring of one cell is its own neighbour: no curvature.
            let (n, e, s, w) = (
                value(around.at(i, 0), c),
                value(around.at(i, 2), c),
                value(around.at(i, 4), c),
                value(around.at(i, 6), c),
            );
            ((e - 2.0 * c + w) * per_x2 + (s - 2.0 * c + n) * per_y2) as f32
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Limits};

    #[test]
    fn a_paraboloid_has_constant_curvature() {
        let grid =
            Grid { cell_x_m: 2.0, cell_y_m: 3.0, ..Grid::new(8, 6, 1.0, Boundary::OPEN, &Limits::default()).unwrap() };
        let z = Field::from_fn(8, 6, |x, y| {
            let (e, s) = (x as f32 * 2.0, y as f32 * 3.0);
            0.5 * e * e + 0.25 * s * s
        });
        let c = curvatures(&z, &grid, |_| true).unwrap();
        assert_eq!(c.len(), 6 * 4);
        assert!(c.iter().all(|c| (c - 1.5).abs() < 1e-5));
    }

    #[test]
    fn rims_cut_off_and_rings_do_not() {
        let z = Field::new(1, 5, 3.0);
        let grid = Grid::new(1, 5, 1.0, Boundary::CLOSED, &Limits::default()).unwrap();
        assert!(curvatures(&z, &grid, |_| true).unwrap().is_empty());
        assert_eq!(curvatures(&z, &Grid { rim: Boundary::WRAP, ..grid }, |i| i != 2).unwrap(), [0.0; 4]);
    }
}
