//! Domain warp: moves the land sideways by a field of noise.
//!
//! # Equations
//! 1. `h'(x) = h(x + amplitude (n_1(x), n_2(x)))`, sampled with cubic convolution (Catmull-Rom) between cell centres.

use super::fbm::feature_m;
use super::noise::{Basis, Octaves, Sum};
use eyot_core::isa::Isa;
use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Grid, Result};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Moves the land sideways by noise: bent ridges, winding coasts. A filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Warp {
    /// Largest shift as a share of the grid's longer side.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub amplitude: f64,
    /// Size of the largest bends as a share of the grid's longer side.
    #[schemars(range(min = 0.0001, max = 100.0), extend("unit" = "1"))]
    pub scale: f64,
    /// Number of octaves of the bends.
    #[schemars(range(min = 1, max = 24), extend("unit" = "1"))]
    pub octaves: u32,
    /// How strong each octave is in terms of the one before.
    #[schemars(range(min = 0.01, max = 1.0), extend("unit" = "1"))]
    pub gain: f64,
}

impl Default for Warp {
    fn default() -> Self {
        Self { amplitude: 0.05, scale: 0.25, octaves: 4, gain: 0.45 }
    }
}

impl Generator for Warp {
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field> {
        let g = &site.grid;
        let shift = |stream: u64| {
            let octaves = Octaves {
                basis: Basis::Simplex,
                sum: Sum::Plain,
                octaves: self.octaves,
                lacunarity: 2.0,
                gain: self.gain,
                feature_m: feature_m(g, self.scale),
                seed: eyot_core::rng::mix64(site.seed ^ stream),
            };
            octaves.field(g, Isa::best(), site.control)
        };
        let (east, south) = (shift(1)?, shift(2)?);
        let reach = feature_m(g, self.amplitude);
        let (cells_x, cells_y) = ((reach / g.cell_x_m) as f32, (reach / g.cell_y_m) as f32);
        let mut out = Field::new(g.width, g.height, 0.0);
        let rows: Vec<&mut [f32]> = out.rows_mut().collect();
        rows.into_par_iter().enumerate().for_each(|(y, row)| {
            for (x, v) in row.iter_mut().enumerate() {
                let (dx, dy) = (cells_x * east.get(x, y), cells_y * south.get(x, y));
                *v = sample(base, g, x, y, dx, dy);
            }
        });
        Ok(out)
    }

    fn is_filter(&self) -> bool {
        true
    }
}

/// Value of the field (dx, dy) cells from the centre of (x, y).
fn sample(f: &Field, g: &Grid, x: usize, y: usize, dx: f32, dy: f32) -> f32 {
    let (i, j) = (dx.floor(), dy.floor());
    let (wx, wy) = (weights(dx - i), weights(dy - j));
    let (x0, y0) = (x as isize + i as isize - 1, y as isize + j as isize - 1);
    let mut sum = 0.0;
    for (k, wy) in wy.iter().enumerate() {
        let row = f.row(g.wrap_y(y0 + k as isize));
        let mut across = 0.0;
        for (l, wx) in wx.iter().enumerate() {
            across += wx * row[g.wrap_x(x0 + l as isize)];
        }
        sum += wy * across;
    }
    sum
}

/// Catmull-Rom weights of the four neighbours at `t` between the middle two.
fn weights(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [-0.5 * t + t2 - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, -0.5 * t2 + 0.5 * t3]
}
