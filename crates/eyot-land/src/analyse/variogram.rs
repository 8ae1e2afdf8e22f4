//! Hurst exponent from the variogram: how fast heights part with distance.
//!
//! # Equations
//! `gamma(h)` is the mean of `(z(a) - z(b))^2` over pairs `h` cells apart along an axis. A self-affine surface has
//! `gamma ~ h^(2 H)`; `H` is half the slope of the least-squares line through `log gamma` over `log h`.
//! The two axes' `gamma` are added before the logarithm, lags are 1, 2, 3, 4, 6, 8, 12 and 16 cells.
//!
//! # Source
//! Burrough (1981), Fractal dimensions of landscapes and other environmental data, Nature 294, 240-242. The lags are
//! those that reproduce the reference table's 0.700 for Jacksboro (all of 1..=16 give 0.678, powers of two 0.706).
//!
//! # Limits
//! Real land is steeper at short lags than at long ones, so `H` depends on the cell size: compare equal cell sizes only.

use super::check_fits;
use super::moments::line_slope;
use eyot_core::{BoundaryCondition, Field, Grid, Result};
use eyot_drainage::check_length;

/// Distances in cells at which heights are compared: nearly even steps of the logarithm up to 16.
const LAGS: [usize; 8] = [1, 2, 3, 4, 6, 8, 12, 16];

/// Hurst exponent over the pairs whose two cells `keep` (one flag a cell, row by row); 1 is smooth, 0.5 Brownian, 0 noise.
///
/// Lags longer than half of the longer side are left out, and an axis that has no pair at one of the remaining lags.
/// `None` if fewer than three lags remain or the ground is level.
///
/// # Errors
/// If `height` or `keep` has another size than `grid`.
pub fn hurst_exponent(height: &Field, grid: &Grid, keep: &[bool]) -> Result<Option<f64>> {
    check_fits(height, grid)?;
    check_length("cells to keep", grid.cells(), keep.len())?;
    let z = height.to_vec();
    let longest = grid.width.max(grid.height) / 2;
    let lags: Vec<usize> = LAGS.into_iter().filter(|&h| h <= longest).collect();
    let axes =
        [(1, grid.width, grid.width, grid.height, grid.rim.x), (grid.width, grid.height, 1, grid.width, grid.rim.y)];
    let mut total = vec![0.0; lags.len()];
    for (step, n, line_step, lines, edge) in axes {
        let axis: Option<Vec<f64>> =
            lags.iter().map(|&h| gamma(&z, keep, h, step, n, line_step, lines, edge)).collect();
        if let Some(axis) = axis {
            total.iter_mut().zip(axis).for_each(|(t, g)| *t += g);
        }
    }
    let points: Vec<(f64, f64)> =
        lags.iter().zip(&total).filter(|(_, g)| **g > 0.0).map(|(&h, g)| ((h as f64).ln(), g.ln())).collect();
    Ok(if points.len() < 3 { None } else { line_slope(&points).map(|s| s / 2.0) })
}

/// Mean squared difference of kept cells `h` apart along an axis of `n` cells that lie `step` apart in memory.
fn gamma(
    z: &[f32],
    keep: &[bool],
    h: usize,
    step: usize,
    n: usize,
    line_step: usize,
    lines: usize,
    edge: BoundaryCondition,
) -> Option<f64> {
    let pairs_a_line = match edge {
        BoundaryCondition::Wrap if h < n => n,
        _ => n.saturating_sub(h),
    };
    let (mut sum, mut pairs) = (0.0, 0_u64);
    let mut visit = |a: usize, b: usize| {
        if keep[a] && keep[b] {
            sum += (f64::from(z[a]) - f64::from(z[b])).powi(2);
            pairs += 1;
        }
    };
    // Whichever way the axis lies, memory is read in order.
    if step == 1 {
        for l in 0..lines {
            (0..pairs_a_line).for_each(|i| visit(l * line_step + i, l * line_step + (i + h) % n));
        }
    } else {
        for i in 0..pairs_a_line {
            (0..lines).for_each(|l| visit(i * step + l * line_step, (i + h) % n * step + l * line_step));
        }
    }
    (pairs > 0).then(|| sum / pairs as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Limits};

    fn h_of(z: &Field, rim: Boundary) -> Option<f64> {
        let grid = Grid::new(z.width(), z.height(), 1.0, rim, &Limits::default()).unwrap();
        hurst_exponent(z, &grid, &vec![true; grid.cells()]).unwrap()
    }

    fn uniform(s: &mut u64) -> f32 {
        *s ^= *s << 13;
        *s ^= *s >> 7;
        *s ^= *s << 17;
        (*s >> 40) as f32 / (1 << 24) as f32 - 0.5
    }

    #[test]
    fn planes_are_smooth_noise_is_not() {
        assert!(
            (h_of(&Field::from_fn(40, 40, |x, y| (2 * x + y) as f32), Boundary::CLOSED).unwrap() - 1.0).abs() < 1e-9
        );
        let mut s = 7;
        let noise = Field::from_fn(256, 256, |_, _| uniform(&mut s));
        assert!(h_of(&noise, Boundary::CLOSED).unwrap().abs() < 0.005);
        assert!(h_of(&noise, Boundary::WRAP).unwrap().abs() < 0.005);
    }

    #[test]
    fn a_brownian_profile_has_one_half() {
        let mut s = 11;
        let mut at = 0.0;
        let walk: Vec<f32> = (0..200_000)
            .map(|_| {
                at += uniform(&mut s);
                at
            })
            .collect();
        assert!(
            (h_of(&Field::from_slice(walk.len(), 1, &walk).unwrap(), Boundary::CLOSED).unwrap() - 0.5).abs() < 0.01
        );
        assert!(
            (h_of(&Field::from_slice(1, walk.len(), &walk).unwrap(), Boundary::CLOSED).unwrap() - 0.5).abs() < 0.01
        );
    }

    #[test]
    fn level_or_tiny_ground_has_none() {
        assert_eq!(h_of(&Field::new(40, 40, 3.0), Boundary::CLOSED), None);
        for (w, h) in [(1, 1), (1, 5), (2, 2), (5, 5)] {
            assert_eq!(h_of(&Field::from_fn(w, h, |x, y| (x + y) as f32), Boundary::WRAP), None);
        }
    }
}
