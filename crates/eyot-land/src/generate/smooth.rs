//! Gaussian smoothing (filter), one axis after the other.
//!
//! # Equations
//! 1. `h'(i) = h(i) + sum_k w_k ((h(i-k) - h(i)) + (h(i+k) - h(i)))` for `k` from 1 to `4 sigma`.
//! 2. `w_k = exp(-k^2 / (2 sigma^2)) / (1 + 2 sum_j exp(-j^2 / (2 sigma^2)))`.
//!
//! Written as exchanges between pairs of cells, it leaves a constant exactly as it is, and what one cell gives another one gets.
//!
//! # Source
//! The Gaussian kernel of image processing.
//!
//! # Rims
//! Closed: the land is mirrored, so nothing is exchanged with the outside and the sum over the grid stays. Wrap: a ring, the sum
//! stays. Open: the border cell goes on outside, so the sum may change.

use super::{BAND, check, fill};
use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::{LaneBlock, WIDTH};
use eyot_core::process::{Generator, Site};
use eyot_core::real::Real;
use eyot_core::{Control, Edge, Field, Grid, Result};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Smooths the land with a Gaussian.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Smooth {
    /// Standard deviation of the Gaussian in cells. Below a half it does next to nothing.
    #[schemars(range(min = 0.0, max = 1024.0), extend("unit" = "cells"))]
    pub sigma_cells: f32,
    /// Standard deviation in metres, which gives the same land on a finer grid. 0 takes `sigma_cells` instead. What is
    /// larger than twice the grid counts as twice the grid: everything is level by then.
    #[schemars(range(min = 0.0, max = 1e7), extend("unit" = "m"))]
    pub sigma_m: f32,
}

impl Default for Smooth {
    fn default() -> Self {
        Self { sigma_cells: 1.5, sigma_m: 0.0 }
    }
}

/// Weights of the neighbours at distance 1, 2, ...; they and the middle sum to 1.
fn weights(sigma_cells: f64, cells: usize) -> Vec<f32> {
    let sigma = sigma_cells.min(2.0 * cells as f64);
    let reach = if cells == 1 { 0 } else { (4.0 * sigma).ceil() as usize };
    let raw: Vec<f64> = (1..=reach)
        .map(|k| {
            let t = k as f64 / sigma;
            f64::from(Real::exp((-0.5 * t * t) as f32))
        })
        .collect();
    let total = 1.0 + 2.0 * raw.iter().rev().sum::<f64>();
    raw.iter().map(|w| (w / total) as f32).collect()
}

/// The cell that stands for `i` outside `0..n`.
fn inside(i: isize, n: usize, edge: Edge) -> usize {
    let n = n as isize;
    (match edge {
        Edge::Wrap => i.rem_euclid(n),
        Edge::Open => i.clamp(0, n - 1),
        Edge::Closed => {
            let k = i.rem_euclid(2 * n);
            k.min(2 * n - 1 - k)
        }
    }) as usize
}

/// Sixteen cells from `at` on.
#[inline(always)]
fn load<L: LaneBlock>(cells: &[f32], at: usize) -> L {
    match cells[at..].first_chunk::<WIDTH>() {
        Some(block) => L::from_array(*block),
        None => L::of(0.0),
    }
}

/// West and east neighbours of a row that has been lengthened by the reach on both sides.
struct Along<'a> {
    weights: &'a [f32],
    cells: &'a [f32],
    out: &'a mut [f32],
}

impl LaneTask for Along<'_> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let reach = self.weights.len();
        let mut at = reach;
        for out in self.out.as_chunks_mut::<WIDTH>().0 {
            let centre: L = load(self.cells, at);
            let mut given = L::of(0.0);
            for k in 0..reach {
                let west: L = load(self.cells, at - 1 - k);
                let east: L = load(self.cells, at + 1 + k);
                given = given + L::of(self.weights[k]) * ((west - centre) + (east - centre));
            }
            *out = (centre + given).to_array();
            at += WIDTH;
        }
    }
}

/// North and south neighbours of a row; all rows are whole blocks long.
struct Across<'a> {
    weights: &'a [f32],
    centre: &'a [f32],
    around: &'a [(&'a [f32], &'a [f32])],
    out: &'a mut [f32],
}

impl LaneTask for Across<'_> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let mut at = 0;
        for out in self.out.chunks_mut(WIDTH) {
            let centre: L = load(self.centre, at);
            let mut given = L::of(0.0);
            for (weight, (north, south)) in self.weights.iter().zip(self.around) {
                let (north, south): (L, L) = (load(north, at), load(south, at));
                given = given + L::of(*weight) * ((north - centre) + (south - centre));
            }
            out.copy_from_slice(&(centre + given).to_array()[..out.len()]);
            at += WIDTH;
        }
    }
}

impl Smooth {
    /// The smoothed layer.
    ///
    /// # Errors
    /// On a request to stop.
    pub fn smoothed(&self, base: &Field, g: &Grid, isa: Isa, control: &Control<'_>) -> Result<Field> {
        let (mut sigma_x, mut sigma_y) = (f64::from(self.sigma_cells), f64::from(self.sigma_cells));
        if self.sigma_m > 0.0 {
            (sigma_x, sigma_y) = (f64::from(self.sigma_m) / g.cell_x_m, f64::from(self.sigma_m) / g.cell_y_m);
        }
        let (along, across) = (weights(sigma_x, g.width), weights(sigma_y, g.height));

        let stride = g.width.next_multiple_of(WIDTH);
        let reach = along.len() as isize;
        let mut smoothed = vec![0.0; stride * g.height];
        for (band, rows) in smoothed.chunks_mut(stride * BAND).enumerate() {
            control.check()?;
            rows.par_chunks_mut(stride).enumerate().for_each_init(Vec::new, |cells: &mut Vec<f32>, (y, out)| {
                let row = base.row(band * BAND + y);
                cells.clear();
                cells.extend((-reach..0).map(|x| row[inside(x, g.width, g.rim.x)]));
                cells.extend_from_slice(row);
                let (end, padded) = (g.width as isize, stride as isize);
                cells.extend((end..padded + reach).map(|x| row[inside(x, g.width, g.rim.x)]));
                run_lanes(isa, Along { weights: &along, cells, out });
            });
        }

        let row = |y: isize| {
            let y = inside(y, g.height, g.rim.y);
            &smoothed[y * stride..(y + 1) * stride]
        };
        fill(g, control, |y, out| {
            let y = y as isize;
            let around: Vec<_> = (1..=across.len() as isize).map(|k| (row(y - k), row(y + k))).collect();
            run_lanes(isa, Across { weights: &across, centre: row(y), around: &around, out });
        })
    }
}

impl Generator for Smooth {
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field> {
        check("smooth", self)?;
        self.smoothed(base, &site.grid, Isa::best(), site.control)
    }

    fn is_filter(&self) -> bool {
        true
    }
}
