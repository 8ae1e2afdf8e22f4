//! Gaussian smoothing.
//!
//! # Equations
//! 1. `h' = G_sigma * h`, separable, cut at 4 sigma and normalised. Beyond closed and open rims the land is mirrored, so that
//!    nothing is lost: the sum of the heights stays the same.

use eyot_core::process::{Generator, Site};
use eyot_core::{Edge, Field, Result};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Gaussian smoothing of what is there. A filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Smooth {
    /// Standard deviation of the bell as a share of the grid's longer side. Features much smaller vanish.
    #[schemars(range(min = 0.0, max = 0.25), extend("unit" = "1"))]
    pub radius: f64,
}

impl Default for Smooth {
    fn default() -> Self {
        Self { radius: 0.004 }
    }
}

impl Generator for Smooth {
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field> {
        let g = &site.grid;
        let sigma_m = super::fbm::feature_m(g, self.radius);
        let across = blur(base, &kernel(sigma_m / g.cell_x_m), g.rim.x);
        site.control.check()?;
        // Columns are rows of the transposed field, which is faster than walking down columns.
        let turned = transpose(&across);
        let down = blur(&turned, &kernel(sigma_m / g.cell_y_m), g.rim.y);
        Ok(transpose(&down))
    }

    fn is_filter(&self) -> bool {
        true
    }
}

/// Weights 0..=n of one side of the bell; the middle first. They sum to 1 with both sides.
fn kernel(sigma: f64) -> Vec<f32> {
    if sigma < 1e-3 {
        return vec![1.0];
    }
    let n = (4.0 * sigma).ceil() as i32;
    let bell: Vec<f64> =
        (0..=n).map(|i| f64::from(eyot_core::math::exp((-0.5 * (f64::from(i) / sigma).powi(2)) as f32))).collect();
    let sum: f64 = bell[0] + 2.0 * bell[1..].iter().sum::<f64>();
    bell.into_iter().map(|b| (b / sum) as f32).collect()
}

fn blur(f: &Field, kernel: &[f32], edge: Edge) -> Field {
    let (w, reach) = (f.width(), kernel.len() - 1);
    let mut out = Field::new(w, f.height(), 0.0);
    let rows: Vec<&mut [f32]> = out.rows_mut().collect();
    rows.into_par_iter().enumerate().for_each(|(y, row)| {
        let source = f.row(y);
        // The row with what lies beyond its ends, so that the loop below needs no cases.
        let wide: Vec<f32> = (-(reach as isize)..(w + reach) as isize).map(|x| source[beyond(x, w, edge)]).collect();
        for (x, v) in row.iter_mut().enumerate() {
            let centre = x + reach;
            let mut sum = kernel[0] * wide[centre];
            for (k, weight) in kernel.iter().enumerate().skip(1) {
                sum += weight * (wide[centre - k] + wide[centre + k]);
            }
            *v = sum;
        }
    });
    out
}

/// Mirrored at the ends, half a cell beyond the last centre, or wrapped around.
fn beyond(x: isize, n: usize, edge: Edge) -> usize {
    let n = n as isize;
    match edge {
        Edge::Wrap => x.rem_euclid(n) as usize,
        Edge::Closed | Edge::Open => {
            let k = x.rem_euclid(2 * n);
            (if k < n { k } else { 2 * n - 1 - k }) as usize
        }
    }
}

fn transpose(f: &Field) -> Field {
    let mut out = Field::new(f.height(), f.width(), 0.0);
    let rows: Vec<&mut [f32]> = out.rows_mut().collect();
    rows.into_par_iter().enumerate().for_each(|(x, row)| {
        for (y, v) in row.iter_mut().enumerate() {
            *v = f.get(x, y);
        }
    });
    out
}
