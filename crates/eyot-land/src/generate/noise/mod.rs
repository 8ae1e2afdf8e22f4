//! Noise: Perlin and simplex gradient noise, summed over octaves, computed in lanes.
//!
//! # Source
//! Perlin 1985 and 2002; Gustavson and McEwan 2022 for simplex noise that tiles; Musgrave in Ebert et al. 2003 for the
//! ridged sum.
//!
//! # Differences
//! - Gradients come from an integer hash of seed and lattice point, not from a table of 256, so nothing repeats.
//! - On rims that do not wrap each octave is turned against the one before and moved, so that the axes of the lattices
//!   and their zeros never line up.

mod lattice;

use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::{LaneBlock, WIDTH};
use eyot_core::rng::mix64;
use eyot_core::{Control, Edge, Field, Grid, Result};
use lattice::{Place, ROW, perlin, simplex};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which gradient noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// On triangles: round forms, no preferred axes.
    #[default]
    Simplex,
    /// On squares: the classic.
    Perlin,
}

/// How octaves become one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sum {
    /// `sum gain^i n_i / sum gain^i`.
    Plain,
    /// Sharp crests: `sum of w_i gain^i (1 - |n_i|)^2` with `w_i = clamp(sharpness * signal_(i-1), 0, 1)`, within 0..=1.
    Ridged {
        /// How much a crest of one octave invites crests of the next.
        sharpness: f32,
    },
}

/// A sum of octaves of noise over a grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Octaves {
    pub(super) basis: Basis,
    pub(super) sum: Sum,
    pub(super) octaves: u32,
    pub(super) lacunarity: f64,
    pub(super) gain: f64,
    /// Size of the largest features, m.
    pub(super) feature_m: f64,
    pub(super) seed: u64,
}

/// One octave: an affine map from (column, row) to its lattice, its weight and its seed.
#[derive(Clone, Copy, Default)]
struct Octave {
    /// Lattice position of cell (0, 0), change per column, change per row.
    x: [f32; 3],
    y: [f32; 3],
    period: [f32; 2],
    weight: f32,
    seed: u32,
}

/// Most octaves; beyond 24 doublings single precision has nothing left to add.
pub(super) const MAX_OCTAVES: usize = 24;

impl Octaves {
    /// The field of sums: within -1..=1 for [`Sum::Plain`], 0..=1 for [`Sum::Ridged`].
    ///
    /// # Errors
    /// On a request to stop.
    pub(super) fn field(&self, grid: &Grid, isa: Isa, control: &Control<'_>) -> Result<Field> {
        let octaves = self.octaves(grid);
        let wraps = octaves.iter().any(|o| o.period != [0.0; 2]);
        let mut field = Field::new(grid.width, grid.height, 0.0);
        let mut rows: Vec<&mut [f32]> = field.rows_mut().collect();
        // Rows go out in slices so that a stop takes effect soon.
        let slice = ((1 << 20) / grid.width).max(16);
        for (i, rows) in rows.chunks_mut(slice).enumerate() {
            control.check()?;
            rows.par_iter_mut().enumerate().for_each(|(k, row)| {
                let y = i * slice + k;
                run_lanes(isa, Row { row, y: y as f32, octaves: &octaves, basis: self.basis, sum: self.sum, wraps });
            });
        }
        Ok(field)
    }

    fn octaves(&self, grid: &Grid) -> Vec<Octave> {
        let (wrap_x, wrap_y) = (grid.rim.x == Edge::Wrap, grid.rim.y == Edge::Wrap);
        let rows = if self.basis == Basis::Simplex { 1.0 / f64::from(ROW) } else { 1.0 };
        let (width_m, height_m) = grid.extent_m();
        let count = (self.octaves.max(1) as usize).min(MAX_OCTAVES);
        let total: f64 = (0..count).map(|i| self.gain.powi(i as i32)).sum();
        (0..count)
            .map(|i| {
                let per_m = self.lacunarity.powi(i as i32) / self.feature_m;
                // 36.87 degrees: the angle of the 3-4-5 triangle, whose multiples never come back to the axes.
                let (cos, sin) = if wrap_x || wrap_y { (1.0, 0.0) } else { turn(i) };
                let key = mix64(self.seed ^ mix64(i as u64));
                let offset = |k: u64| (mix64(key ^ k) >> 40) as f64 / f64::from(1u32 << 24) * 64.0;
                let (mut mx, mut my) = (per_m, per_m * rows);
                let mut period = [0.0; 2];
                if wrap_x {
                    period[0] = (width_m * mx).round().max(1.0);
                    mx = period[0] / width_m;
                }
                if wrap_y {
                    // An even number of rows, so that the shifted rows of simplex noise meet again.
                    period[1] = ((height_m * my / 2.0).round() * 2.0).max(2.0);
                    my = period[1] / height_m;
                }
                let (dx, dy) = (grid.cell_x_m, grid.cell_y_m);
                let at = |col: f64, row: f64| {
                    let (x, y) = ((col + 0.5) * dx, (row + 0.5) * dy);
                    [(cos * x - sin * y) * mx + offset(1), (sin * x + cos * y) * my + offset(2)]
                };
                let [origin, east, south] = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
                let affine = |k: usize| [origin[k] as f32, (east[k] - origin[k]) as f32, (south[k] - origin[k]) as f32];
                let weight = match self.sum {
                    Sum::Plain => self.gain.powi(i as i32) / total,
                    Sum::Ridged { .. } => self.gain.powi(i as i32),
                };
                Octave {
                    x: affine(0),
                    y: affine(1),
                    period: [period[0] as f32, period[1] as f32],
                    weight: weight as f32,
                    seed: (key >> 32) as u32,
                }
            })
            .collect()
    }
}

/// Cosine and sine of `i` times the angle of the 3-4-5 triangle.
fn turn(i: usize) -> (f64, f64) {
    (0..i).fold((1.0, 0.0), |(c, s), _| (0.8 * c - 0.6 * s, 0.6 * c + 0.8 * s))
}

/// A row to fill.
struct Row<'a> {
    row: &'a mut [f32],
    y: f32,
    octaves: &'a [Octave],
    basis: Basis,
    sum: Sum,
    wraps: bool,
}

impl LaneTask for Row<'_> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        match (self.basis, self.wraps) {
            (Basis::Simplex, false) => fill::<L, true, false>(self),
            (Basis::Simplex, true) => fill::<L, true, true>(self),
            (Basis::Perlin, false) => fill::<L, false, false>(self),
            (Basis::Perlin, true) => fill::<L, false, true>(self),
        }
    }
}

#[inline(always)]
fn fill<L: LaneBlock, const SIMPLEX: bool, const WRAP: bool>(r: Row<'_>) {
    let y = L::of(r.y);
    let total: f32 = r.octaves.iter().map(|o| o.weight).sum();
    let mut start = 0;
    while start < r.row.len() {
        let x = L::of(start as f32) + L::index();
        let value = match r.sum {
            Sum::Plain => {
                let mut sum = L::of(0.0);
                for o in r.octaves {
                    sum = sum + L::of(o.weight) * noise::<L, SIMPLEX, WRAP>(o, x, y);
                }
                sum
            }
            Sum::Ridged { sharpness } => {
                let (mut sum, mut weight) = (L::of(0.0), L::of(1.0));
                for o in r.octaves {
                    let crest = L::of(1.0) - noise::<L, SIMPLEX, WRAP>(o, x, y).abs();
                    let signal = crest * crest * weight;
                    weight = (signal * L::of(sharpness)).clamp(L::of(0.0), L::of(1.0));
                    sum = sum + L::of(o.weight) * signal;
                }
                sum * L::of(1.0 / total)
            }
        };
        let end = (start + WIDTH).min(r.row.len());
        r.row[start..end].copy_from_slice(&value.to_array()[..end - start]);
        start = end;
    }
}

#[inline(always)]
fn noise<L: LaneBlock, const SIMPLEX: bool, const WRAP: bool>(o: &Octave, x: L, y: L) -> L {
    let place = Place {
        x: L::of(o.x[0]) + (L::of(o.x[1]) * x + L::of(o.x[2]) * y),
        y: L::of(o.y[0]) + (L::of(o.y[1]) * x + L::of(o.y[2]) * y),
        period_x: L::of(o.period[0]),
        period_y: L::of(o.period[1]),
    };
    if SIMPLEX { simplex::<L, WRAP>(place, o.seed) } else { perlin::<L, WRAP>(place, o.seed) }
}
