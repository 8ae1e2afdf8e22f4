//! Smoothing (filter), one axis after the other.
//!
//! # Equations
//! 1. Gaussian: `h'(i) = h(i) + sum_k w_k ((h(i-k) - h(i)) + (h(i+k) - h(i)))` for `k` from 1 to `4 sigma`, with
//!    `w_k = exp(-k^2 / (2 sigma^2)) / (1 + 2 sum_j exp(-j^2 / (2 sigma^2)))`.
//! 2. Binomial: `w_1 = 1/4` along both axes, together (1, 2, 1; 2, 4, 2; 1, 2, 1) / 16.
//! 3. Gentle: two thirds of the way there, `h + 2/3 (binomial - h)`, which is (1, 2, 1; 2, 12, 2; 1, 2, 1) / 24.
//!
//! Written as exchanges between pairs of cells, smoothing leaves a constant exactly as it is, and what one cell gives another
//! one gets. The effect of the kernels of 3x3 cells is counted in cells and passes: on a finer grid the same number of passes
//! smooths less land.
//!
//! # Source
//! The usual kernels of image processing.
//!
//! # Rims
//! Closed: the land is mirrored, so nothing is exchanged with the outside and the sum over the grid stays. Wrap: a ring, the sum
//! stays. Open: the border cell goes on outside, so the sum may change.

use super::check;
use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::{LaneBlock, WIDTH};
use eyot_core::process::{Around, Generator, Reach, Site};
use eyot_core::real::Real;
use eyot_core::{BoundaryCondition, Control, Field, Grid, Result};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Rows that are smoothed between two looks at the stop button.
const BAND: usize = 128;

/// What smooths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Kernel {
    /// A Gaussian of any width, in metres or cells.
    #[default]
    Gaussian,
    /// (1, 2, 1; 2, 4, 2; 1, 2, 1) / 16: about a Gaussian of 0.7 cells.
    Binomial,
    /// (1, 2, 1; 2, 12, 2; 1, 2, 1) / 24: keeps more of small features, about a Gaussian of 0.6 cells.
    Gentle,
}

/// Smooths the land.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Smooth {
    /// What smooths: a Gaussian, which can give the same land on a finer grid, or one of two kernels of 3x3 cells.
    pub kernel: Kernel,
    /// How often it smooths; n passes are as wide as one that is sqrt(n) times wider. Once they are together twice as wide
    /// as the grid, everything is level, and the rest is left out.
    #[schemars(range(min = 1, max = 1000), extend("unit" = "1"))]
    pub passes: u32,
    /// Standard deviation of the Gaussian in cells. Below a half it does next to nothing.
    #[schemars(range(min = 0.0, max = 1024.0), extend("unit" = "cells"))]
    pub sigma_cells: f32,
    /// Standard deviation of the Gaussian in metres, which gives the same land on a finer grid. 0 takes `sigma_cells`
    /// instead. What is larger than twice the grid counts as twice the grid: everything is level by then.
    #[schemars(range(min = 0.0, max = 1e7), extend("unit" = "m"))]
    pub sigma_m: f32,
}

impl Default for Smooth {
    fn default() -> Self {
        Self { kernel: Kernel::Gaussian, passes: 1, sigma_cells: 1.5, sigma_m: 0.0 }
    }
}

/// The widest Gaussian in lengths of the grid. It leaves `exp(-2 pi^2)`, 3 in a thousand million, of the longest wave that
/// fits between two walls, which is less than the digits of a height.
const WIDEST: f64 = 2.0;

/// Weights of the neighbours at distance 1, 2, ...; they and the middle sum to 1. Never more weights than cells: what lies
/// further than the grid is wide is one of its cells again, by what the rim says.
fn weights(sigma_cells: f64, cells: usize, edge: BoundaryCondition) -> Vec<f32> {
    let sigma = sigma_cells.min(WIDEST * cells as f64);
    let reach = if cells == 1 { 0 } else { (4.0 * sigma).ceil() as usize };
    let raw: Vec<f64> = (1..=reach)
        .map(|k| {
            let t = k as f64 / sigma;
            f64::from(Real::exp((-0.5 * t * t) as f32))
        })
        .collect();
    let total = 1.0 + 2.0 * raw.iter().rev().sum::<f64>();
    let distance = |k: usize| match edge {
        BoundaryCondition::Wrap => (k % cells).min(cells - k % cells),
        BoundaryCondition::Closed => (k % (2 * cells)).min(2 * cells - k % (2 * cells)),
        BoundaryCondition::Open => k.min(cells),
    };
    let mut folded = vec![0.0; (1..=reach).map(distance).max().unwrap_or(0)];
    for (k, w) in raw.iter().enumerate().rev() {
        // At distance 0 lies the cell itself, which exchanges nothing.
        if let Some(i) = distance(k + 1).checked_sub(1) {
            folded[i] += w;
        }
    }
    folded.iter().map(|w| (w / total) as f32).collect()
}

/// Passes after which nothing changes any more, because the land is level along this axis.
fn passes_until_level(sigma_cells: f64, cells: usize, edge: BoundaryCondition) -> f64 {
    let widest = WIDEST * cells as f64;
    let more = match edge {
        // Every pass brings the two border cells nearer to each other, by five times or so at the widest.
        BoundaryCondition::Open => 40.0,
        BoundaryCondition::Closed | BoundaryCondition::Wrap => 0.0,
    };
    if cells == 1 || sigma_cells <= 0.0 { 0.0 } else { (widest / sigma_cells.min(widest)).powi(2).ceil() + more }
}

/// The cell that stands for `i` outside `0..n`.
fn inside(i: isize, n: usize, edge: BoundaryCondition) -> usize {
    let n = n as isize;
    (match edge {
        BoundaryCondition::Wrap => i.rem_euclid(n),
        BoundaryCondition::Open => i.clamp(0, n - 1),
        BoundaryCondition::Closed => {
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

/// One pass over the rows `held` of a grid.
struct Pass<'a> {
    grid: &'a Grid,
    held: Range<isize>,
    /// Weights along both axes.
    weights: &'a [Vec<f32>; 2],
    /// How far the land goes towards the smoothed one.
    share: f32,
    isa: Isa,
}

impl Pass<'_> {
    /// The rows `made`, which must be among those held, of the smoothed `base`.
    fn over(&self, base: &Field, made: Range<isize>, control: &Control<'_>) -> Result<Field> {
        let g = self.grid;
        let [along, across] = self.weights;
        let stride = g.width.next_multiple_of(WIDTH);
        let reach = along.len() as isize;
        let mut smoothed = vec![0.0; stride * self.held.len()];
        for (band, rows) in smoothed.chunks_mut(stride * BAND).enumerate() {
            control.check()?;
            rows.par_chunks_mut(stride).enumerate().for_each_init(Vec::new, |cells: &mut Vec<f32>, (y, out)| {
                let row = base.row(band * BAND + y);
                cells.clear();
                cells.extend((-reach..0).map(|x| row[inside(x, g.width, g.rim.x)]));
                cells.extend_from_slice(row);
                let (end, padded) = (g.width as isize, stride as isize);
                cells.extend((end..padded + reach).map(|x| row[inside(x, g.width, g.rim.x)]));
                run_lanes(self.isa, Along { weights: along, cells, out });
            });
        }

        let index = |y: isize| {
            let at = if self.held.contains(&y) { y } else { inside(y, g.height, g.rim.y) as isize };
            // Rows that are not held are only asked for where the result will not be looked at.
            ((at - self.held.start).rem_euclid(g.height as isize) as usize).min(self.held.len() - 1)
        };
        let row = |y: isize| &smoothed[index(y) * stride..][..stride];
        Field::from_rows(g.width, 0..made.len(), control, |i, out| {
            let y = made.start + i as isize;
            let around: Vec<_> = (1..=across.len() as isize).map(|k| (row(y - k), row(y + k))).collect();
            run_lanes(self.isa, Across { weights: across, centre: row(y), around: &around, out });
            if self.share != 1.0 {
                for (v, &h) in out.iter_mut().zip(base.row(index(y))) {
                    *v = h + self.share * (*v - h);
                }
            }
        })
    }
}

impl Smooth {
    /// Standard deviation of the Gaussian in cells, west-east and north-south.
    fn sigma_cells(&self, g: &Grid) -> [f64; 2] {
        match f64::from(self.sigma_m) {
            metres if metres > 0.0 => [metres / g.cell_x_m, metres / g.cell_y_m],
            _ => [f64::from(self.sigma_cells); 2],
        }
    }

    /// Weights of the neighbours along both axes.
    fn weights(&self, g: &Grid) -> [Vec<f32>; 2] {
        let binomial = |cells: usize| if cells == 1 { Vec::new() } else { vec![0.25] };
        match self.kernel {
            Kernel::Gaussian => {
                let [x, y] = self.sigma_cells(g);
                [weights(x, g.width, g.rim.x), weights(y, g.height, g.rim.y)]
            }
            Kernel::Binomial | Kernel::Gentle => [g.width, g.height].map(binomial),
        }
    }

    /// Passes that change anything, at least one.
    fn passes_that_count(&self, g: &Grid) -> u32 {
        let until_level = match self.kernel {
            Kernel::Gaussian => {
                let [x, y] = self.sigma_cells(g);
                passes_until_level(x, g.width, g.rim.x).max(passes_until_level(y, g.height, g.rim.y))
            }
            Kernel::Binomial | Kernel::Gentle => f64::INFINITY,
        };
        self.passes.min(until_level as u32).max(1)
    }

    /// The smoothed layer.
    ///
    /// # Errors
    /// On a request to stop, or if `base` does not hold the rows that are needed.
    pub fn smoothed(&self, site: &Site<'_>, base: &Field, isa: Isa) -> Result<Field> {
        let reach = self.reach(&site.grid);
        Around::new(site, reach, base)?;
        let held = reach.around(&site.grid, &site.rows);
        let share = if self.kernel == Kernel::Gentle { 2.0 / 3.0 } else { 1.0 };
        let pass = Pass { grid: &site.grid, held: held.clone(), weights: &self.weights(&site.grid), share, isa };
        let last = u64::from(self.passes_that_count(&site.grid)) - 1;
        let mut before: Option<Field> = None;
        for i in 0..=last {
            let made = if i == last { site.rows.start as isize..site.rows.end as isize } else { held.clone() };
            let smooth = |control: &Control<'_>| pass.over(before.as_ref().unwrap_or(base), made, control);
            before = Some(site.control.stage(i, last + 1, smooth)?);
        }
        Ok(before.unwrap_or_else(|| base.clone()))
    }
}

impl Generator for Smooth {
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        self.smoothed(site, base, Isa::best())
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("smooth", self)
    }

    fn reach(&self, grid: &Grid) -> Reach {
        Reach::Rows(self.weights(grid)[1].len() * self.passes_that_count(grid) as usize)
    }

    fn bytes_per_cell(&self, grid: &Grid) -> usize {
        // What is smoothed along one axis and along both, and from the second pass on the pass before.
        if self.passes_that_count(grid) > 1 { 12 } else { 8 }
    }

    fn is_filter(&self) -> bool {
        true
    }
}
