//! Hillslope creep that speeds up towards a critical slope: `dz/dt = D div(grad z / (1 - (|grad z| / S_c)^2))`.
//!
//! Gentle slopes creep as in `creep.rs`; near `S_c` the soil slides, so that no slope gets much steeper, and crests are sharp
//! instead of round.
//!
//! # Steps
//! Implicit along rows, then along columns. A line solves `z'_i - z_i = D T / d (q_(i+1/2) - q_(i-1/2))` for its new heights by
//! Newton's method, with `q = S / (1 - (S^2 + S_t^2) / S_c^2)` at each face: `S` the new slope along the line, `S_t` the
//! slope across it before the step. Beyond a share of the critical slope `q` goes on along its tangent, so that ground that
//! starts too steep slides within its first steps. What one cell gives another one gets, in every turn.
//!
//! # Source
//! Roering, Kirchner and Dietrich (1999), Evidence for nonlinear, diffusive sediment transport on hillslopes and implications
//! for landscape morphology, Water Resources Research 35, 853-870. Lines by elimination, rings with one correction, as in
//! `creep.rs`.

use eyot_core::{BoundaryCondition, Grid};
use rayon::prelude::*;

/// `1 - (S / S_c)^2` at which `q` turns into its tangent: 0.99 of the critical slope.
const LEAST: f64 = 0.02;
/// Newton's method overshoots once at most and doubles the correct digits afterwards.
const MAX_TURNS: usize = 40;
/// A turn that changes no slope by more than this share of the critical one is the last.
const SMALL: f64 = 1e-9;

/// Lets the ground creep for a step. `z`: heights, m, row by row; `diffusion_m2`: diffusivity times the years of the step;
/// `critical`: critical slope, above 0.
pub(super) fn creep(z: &mut [f64], grid: &Grid, diffusion_m2: f64, critical: f64) {
    let along_rows = Lines { edge: grid.rim.x, across: grid.rim.y, d: grid.cell_x_m, d_across: grid.cell_y_m };
    let along_columns = Lines { edge: grid.rim.y, across: grid.rim.x, d: grid.cell_y_m, d_across: grid.cell_x_m };
    along_rows.creep(z, grid.width, diffusion_m2, critical);
    let mut turned = transposed(z, grid.width);
    along_columns.creep(&mut turned, grid.height, diffusion_m2, critical);
    z.copy_from_slice(&transposed(&turned, grid.height));
}

/// Rows of `width` cells as columns.
fn transposed(z: &[f64], width: usize) -> Vec<f64> {
    let height = z.len() / width;
    let mut turned = vec![0.0; z.len()];
    turned.par_chunks_exact_mut(height).enumerate().for_each(|(x, column)| {
        column.iter_mut().enumerate().for_each(|(y, v)| *v = z[y * width + x]);
    });
    turned
}

/// Lines of cells, stored one after the other.
struct Lines {
    edge: BoundaryCondition,
    across: BoundaryCondition,
    /// Distance of cells along and across the lines, m.
    d: f64,
    d_across: f64,
}

impl Lines {
    fn creep(&self, z: &mut [f64], length: usize, diffusion_m2: f64, critical: f64) {
        let lines = z.len() / length;
        let inner = if self.edge == BoundaryCondition::Open { 1..length.saturating_sub(1) } else { 0..length };
        if inner.is_empty() || length == 1 {
            return;
        }
        let before = z.to_vec();
        let held = |line: usize| self.across == BoundaryCondition::Open && (line == 0 || line + 1 == lines);
        z.par_chunks_exact_mut(length).enumerate().filter(|(line, _)| !held(*line)).for_each_init(
            || Line::new(length),
            |work, (line, z)| {
                self.room_across(&before, length, line, critical, &mut work.room);
                work.solve(z, inner.clone(), self, diffusion_m2, critical);
            },
        );
    }

    /// At the face before each cell: `1 - (S_t / S_c)^2`.
    fn room_across(&self, z: &[f64], length: usize, line: usize, critical: f64, room: &mut [f64]) {
        let lines = z.len() / length;
        let ring = self.across == BoundaryCondition::Wrap;
        let next = if line + 1 < lines || ring { (line + 1) % lines } else { line };
        let last = if line > 0 || ring { (line + lines - 1) % lines } else { line };
        let steps = if ring { 2 } else { next - last };
        let per_m = if steps > 0 { 0.5 / (steps as f64 * self.d_across) } else { 0.0 };
        let rise = |i: usize| z[next * length + i] - z[last * length + i];
        for (i, room) in room.iter_mut().enumerate() {
            let slope = per_m * (rise(i % length) + rise((i + length - 1) % length)) / critical;
            *room = (1.0 - slope * slope).max(LEAST);
        }
    }
}

/// The flux `x / (room - x^2)` of a relative slope `x`, and its derivative.
fn flux(x: f64, room: f64) -> (f64, f64) {
    let steepest = (room - LEAST).sqrt();
    let at = x.clamp(-steepest, steepest);
    let left = room - at * at;
    let derivative = (room + at * at) / (left * left);
    (at / left + derivative * (x - at), derivative)
}

/// The memory of a line. Face `i` lies before cell `i`; there is one more face than cells.
struct Line {
    room: Vec<f64>,
    start: Vec<f64>,
    /// What a metre of fall moves through each face in a step, m.
    a: Vec<f64>,
    right: Vec<f64>,
    pivot: Vec<f64>,
    unit: Vec<f64>,
}

impl Line {
    fn new(length: usize) -> Self {
        let zeros = || vec![0.0; length + 1];
        Self { room: zeros(), start: zeros(), a: zeros(), right: zeros(), pivot: zeros(), unit: zeros() }
    }

    fn solve(&mut self, z: &mut [f64], inner: std::ops::Range<usize>, lines: &Lines, diffusion_m2: f64, critical: f64) {
        let (n, length) = (inner.len(), z.len());
        self.start[..n].copy_from_slice(&z[inner.clone()]);
        // Beyond this a line is level to a millionth, and rounding would take over.
        let reach = (diffusion_m2 / (lines.d * lines.d)).min(1e6 * (length * length) as f64);
        let fall = critical * lines.d;
        for _ in 0..MAX_TURNS {
            self.right[..n].copy_from_slice(&self.start[..n]);
            for face in 0..=n {
                let at = inner.start + face;
                if lines.edge == BoundaryCondition::Closed && (face == 0 || face == n) {
                    self.a[face] = 0.0;
                    continue;
                }
                let (low, high) = ((at + length - 1) % length, at % length);
                let x = (z[high] - z[low]) / fall;
                let (q, derivative) = flux(x, self.room[at]);
                self.a[face] = reach * derivative;
                // What the tangent at this slope moves besides.
                let rest = reach * fall * (q - derivative * x);
                if face > 0 {
                    self.right[face - 1] += rest;
                }
                if face < n {
                    self.right[face] -= rest;
                }
            }
            if lines.edge == BoundaryCondition::Open {
                self.right[0] += self.a[0] * z[inner.start - 1];
                self.right[n - 1] += self.a[n] * z[inner.end];
            }
            self.eliminate(n, lines.edge == BoundaryCondition::Wrap);
            let change = |(z, new): (&f64, &f64)| (z - new).abs();
            let largest = z[inner.clone()].iter().zip(&self.right).map(change).fold(0.0, f64::max);
            z[inner.clone()].copy_from_slice(&self.right[..n]);
            if largest <= SMALL * fall {
                break;
            }
        }
    }

    /// Solves `(1 + a_i + a_(i+1)) z_i - a_i z_(i-1) - a_(i+1) z_(i+1) = right_i` in place.
    fn eliminate(&mut self, n: usize, ring: bool) {
        // On rings the corner entries are taken out as a rank-one matrix, which adds their size to both ends.
        let corner = if ring { self.a[0] } else { 0.0 };
        // Pivots are `a_(i+1) + e`: written with `e`, long steps cancel nothing.
        let mut e = 1.0 + self.a[0] + corner;
        for i in 0..n {
            if i > 0 {
                e = 1.0 + self.a[i] * e / (self.a[i] + e);
            }
            self.pivot[i] = 1.0 / (self.a[i + 1] + e + if i + 1 == n { corner } else { 0.0 });
        }
        substitute(&self.a, &self.pivot, &mut self.right[..n]);
        if ring {
            let unit = &mut self.unit[..n];
            unit.fill(0.0);
            unit[0] += 1.0;
            unit[n - 1] += 1.0;
            substitute(&self.a, &self.pivot, unit);
            let share = corner * (self.right[0] + self.right[n - 1]) / (1.0 - corner * (unit[0] + unit[n - 1]));
            self.right.iter_mut().zip(unit).for_each(|(z, u)| *z += share * *u);
        }
    }
}

fn substitute(a: &[f64], pivot: &[f64], v: &mut [f64]) {
    let n = v.len();
    v[0] *= pivot[0];
    for i in 1..n {
        v[i] = (v[i] + a[i] * v[i - 1]) * pivot[i];
    }
    for i in (0..n - 1).rev() {
        v[i] += a[i + 1] * pivot[i] * v[i + 1];
    }
}
