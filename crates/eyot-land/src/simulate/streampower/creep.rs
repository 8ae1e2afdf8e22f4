//! Hillslope creep: linear diffusion of the height, `dz/dt = D (d2z/dx2 + d2z/dy2)`, by implicit steps along rows and then
//! along columns.
//!
//! Each step solves `(1 - a delta) z' = z` on every line, with `a = D T / spacing^2` and `delta` the second difference: it is
//! stable for every `a`, never overshoots, and gives one cell exactly what it takes from another. On rims that are closed
//! nothing flows, on rings the ends are neighbours, and at open rims the border cells hold their height.
//!
//! # Source
//! Locally one-dimensional splitting (Yanenko 1971); the lines by elimination (Thomas 1949), rings with one correction
//! (Sherman and Morrison 1950).

use eyot_core::{BoundaryCondition, Grid};
use rayon::prelude::*;

/// Columns that are solved together: their rows are read as whole cache lines.
const COLUMNS: usize = 64;

/// Lets the ground creep for a step. `z`: heights, m, row by row; `diffusion_m2`: diffusivity times the years of the step.
pub(super) fn creep(z: &mut [f64], grid: &Grid, diffusion_m2: f64) {
    let (w, h) = (grid.width, grid.height);
    // Where a whole border is held, the lines along it are held too.
    let held = |edge: BoundaryCondition| usize::from(edge == BoundaryCondition::Open);
    let x = Line::new(w, grid.rim.x, diffusion_m2 / (grid.cell_x_m * grid.cell_x_m));
    let y = Line::new(h, grid.rim.y, diffusion_m2 / (grid.cell_y_m * grid.cell_y_m));
    let mut rows: Vec<&mut [f64]> = z.chunks_exact_mut(w).collect();
    let (first, last) = (held(grid.rim.y), h.saturating_sub(held(grid.rim.y)));
    if let (Some(x), true) = (&x, first < last) {
        rows[first..last].par_iter_mut().for_each(|row| x.solve_row(row));
    }
    let Some(y) = y else { return };
    let (first, last) = (held(grid.rim.x), w.saturating_sub(held(grid.rim.x)));
    if first >= last {
        return;
    }
    // Bundle k holds the columns from `first + k COLUMNS` of all rows.
    let mut bundles: Vec<Vec<&mut [f64]>> =
        (0..(last - first).div_ceil(COLUMNS)).map(|_| Vec::with_capacity(h)).collect();
    for row in rows {
        for (bundle, part) in bundles.iter_mut().zip(row[first..last].chunks_mut(COLUMNS)) {
            bundle.push(part);
        }
    }
    bundles.par_iter_mut().for_each(|bundle| y.solve_columns(bundle));
}

/// The elimination of one line, which is the same for all lines of an axis.
struct Line {
    /// The part of the line that is solved for; border cells of open rims lie outside it.
    inner: std::ops::Range<usize>,
    a: f64,
    /// Reciprocals of the pivots.
    pivot: Vec<f64>,
    /// On rings: the solution for a unit source that couples both ends, and the divisor of its correction.
    ring: Option<(Vec<f64>, f64)>,
}

impl Line {
    /// `None` if nothing moves along this axis.
    fn new(cells: usize, edge: BoundaryCondition, a: f64) -> Option<Self> {
        let inner = if edge == BoundaryCondition::Open { 1..cells.saturating_sub(1) } else { 0..cells };
        // A single cell has nobody to give to.
        if a <= 0.0 || inner.is_empty() || cells == 1 {
            return None;
        }
        let n = inner.len();
        // Beyond this a line is level to a millionth, and rounding would take over.
        let a = a.min(1e6 * (n * n) as f64);
        // Pivots are `a + e`: written with `e`, long steps cancel nothing.
        let mut e = match edge {
            BoundaryCondition::Closed => 1.0,
            BoundaryCondition::Open => 1.0 + a,
            // The ring's corner entries `-a` are taken out as a rank-one matrix, which adds `a` to both ends.
            BoundaryCondition::Wrap => 1.0 + 2.0 * a,
        };
        let mut pivot = Vec::with_capacity(n);
        pivot.push(1.0 / (a + e));
        for i in 1..n {
            e = 1.0 + a * e / (a + e);
            let last = if edge == BoundaryCondition::Closed { 0.0 } else { a };
            let ring = if edge == BoundaryCondition::Wrap { a } else { 0.0 };
            pivot.push(1.0 / if i + 1 == n { last + ring + e } else { a + e });
        }
        let mut line = Self { inner, a, pivot, ring: None };
        if edge == BoundaryCondition::Wrap {
            let mut unit = vec![0.0; n];
            unit[0] = -a;
            unit[n - 1] += -a;
            line.eliminate(&mut unit);
            let divisor = 1.0 + unit[0] + unit[n - 1];
            line.ring = Some((unit, divisor));
        }
        Some(line)
    }

    fn eliminate(&self, v: &mut [f64]) {
        let n = v.len();
        v[0] *= self.pivot[0];
        for i in 1..n {
            v[i] = (v[i] + self.a * v[i - 1]) * self.pivot[i];
        }
        for i in (0..n - 1).rev() {
            v[i] += self.a * self.pivot[i] * v[i + 1];
        }
    }

    fn solve_row(&self, row: &mut [f64]) {
        if self.inner.start > 0 {
            let (first, last) = (row[0], row[self.inner.end]);
            row[self.inner.start] += self.a * first;
            row[self.inner.end - 1] += self.a * last;
        }
        let v = &mut row[self.inner.clone()];
        self.eliminate(v);
        if let Some((unit, divisor)) = &self.ring {
            let share = (v[0] + v[v.len() - 1]) / divisor;
            v.iter_mut().zip(unit).for_each(|(v, u)| *v -= share * u);
        }
    }

    /// As [`Line::solve_row`] for columns side by side; `rows[y]` holds their cells in row `y`.
    fn solve_columns(&self, rows: &mut [&mut [f64]]) {
        if self.inner.start > 0 {
            let (start, end) = (self.inner.start, self.inner.end);
            add(rows, start, 0, self.a);
            add(rows, end - 1, end, self.a);
        }
        let v = &mut rows[self.inner.clone()];
        let n = v.len();
        v[0].iter_mut().for_each(|z| *z *= self.pivot[0]);
        for i in 1..n {
            let (before, here) = v.split_at_mut(i);
            let (before, pivot) = (&before[i - 1], self.pivot[i]);
            here[0].iter_mut().zip(before.iter()).for_each(|(z, b)| *z = (*z + self.a * b) * pivot);
        }
        for i in (0..n - 1).rev() {
            add(v, i, i + 1, self.a * self.pivot[i]);
        }
        if let Some((unit, divisor)) = &self.ring {
            let share: Vec<f64> = v[0].iter().zip(v[n - 1].iter()).map(|(a, b)| (a + b) / divisor).collect();
            for (row, u) in v.iter_mut().zip(unit) {
                row.iter_mut().zip(&share).for_each(|(z, s)| *z -= s * u);
            }
        }
    }
}

/// Adds `factor` times row `from` to row `to`.
fn add(rows: &mut [&mut [f64]], to: usize, from: usize, factor: f64) {
    let (low, high) = rows.split_at_mut(to.max(from));
    let (target, source): (&mut [f64], &[f64]) = if to < from { (low[to], high[0]) } else { (high[0], low[from]) };
    target.iter_mut().zip(source).for_each(|(t, s)| *t += factor * s);
}
