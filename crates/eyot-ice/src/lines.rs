//! Tridiagonal systems along all rows or all columns of a grid.
//!
//! What flows through the face between the cells `i - 1` and `i` of a line is `forward_i x_(i-1) - back_i x_i`: the system says
//! `x_i = rhs_i + (what comes in) - (what goes out)`. Sums along a line stay what they are, whatever the coefficients.
//!
//! # Source
//! Elimination (Thomas 1949), rings with one correction (Sherman and Morrison 1950).

use rayon::prelude::*;

/// Lines that are solved together, in the lanes of vectors.
const LANES: usize = 16;

/// Lines side by side: number `i` of all lines stands in `[i]`.
#[derive(Default)]
struct Tile {
    forward: Vec<[f32; LANES]>,
    back: Vec<[f32; LANES]>,
    x: Vec<[f32; LANES]>,
    share: Vec<[f32; LANES]>,
    /// Of rings: the solution for a unit source that couples both ends.
    unit: Vec<[f32; LANES]>,
}

impl Tile {
    fn new(cells: usize) -> Self {
        let zero = |n: usize| vec![[0.0; LANES]; n];
        Self { forward: zero(cells + 1), back: zero(cells + 1), x: zero(cells), share: zero(cells), unit: Vec::new() }
    }

    /// Solves for `x`, which holds the right-hand sides before.
    fn solve(&mut self, ring: bool) {
        let n = self.x.len();
        if ring && n > 1 {
            // The corners are taken out as a rank-one matrix, which adds to the first and the last pivot.
            let (mut ends, mut along) = ([[0.0; LANES]; 2], [0.0; LANES]);
            self.unit.clear();
            self.unit.resize(n, [0.0; LANES]);
            for l in 0..LANES {
                let pivot = 1.0 + self.forward[1][l] + self.back[0][l];
                (self.unit[0][l], self.unit[n - 1][l]) = (-pivot, -self.back[n][l]);
                along[l] = self.forward[0][l] / pivot;
                (ends[0][l], ends[1][l]) = (pivot, self.back[n][l] * along[l]);
            }
            eliminate(&self.forward, &self.back, &mut self.unit, &mut self.share, &ends);
            eliminate(&self.forward, &self.back, &mut self.x, &mut self.share, &ends);
            let mut factor = [0.0; LANES];
            for l in 0..LANES {
                let sum = |v: &[[f32; LANES]]| v[0][l] + along[l] * v[n - 1][l];
                factor[l] = sum(&self.x) / (1.0 + sum(&self.unit));
            }
            for (x, u) in self.x.iter_mut().zip(&self.unit) {
                (0..LANES).for_each(|l| x[l] -= factor[l] * u[l]);
            }
        } else {
            eliminate(&self.forward, &self.back, &mut self.x, &mut self.share, &[[0.0; LANES]; 2]);
        }
    }
}

/// Solves for `x`; `ends` is added to the first and the last pivot.
fn eliminate(
    forward: &[[f32; LANES]],
    back: &[[f32; LANES]],
    x: &mut [[f32; LANES]],
    share: &mut [[f32; LANES]],
    ends: &[[f32; LANES]; 2],
) {
    let n = x.len();
    let (mut before, mut kept) = ([0.0f32; LANES], [1.0f32; LANES]);
    for i in 0..n {
        let (in_, out, back, next) = (&forward[i], &forward[i + 1], &back[i], &back[i + 1]);
        let (first, last) = (f32::from(u8::from(i == 0)), f32::from(u8::from(i + 1 == n)));
        let inflow = 1.0 - first;
        for l in 0..LANES {
            // Pivots are `out + rest`: written so, long steps cancel nothing.
            let rest = 1.0 + back[l] * kept[l] + (first * ends[0][l] + last * ends[1][l]);
            let inverse = 1.0 / (out[l] + rest);
            before[l] = (x[i][l] + inflow * in_[l] * before[l]) * inverse;
            kept[l] = rest * inverse;
            share[i][l] = next[l] * inverse;
        }
        x[i] = before;
    }
    for i in (0..n - 1).rev() {
        let (here, next) = x.split_at_mut(i + 1);
        (0..LANES).for_each(|l| here[i][l] += share[i][l] * next[0][l]);
    }
}

/// Coefficients of the faces of a grid along one axis.
#[derive(Clone, Copy)]
pub struct Faces<'a> {
    /// What a unit in the cell before a face sends through it.
    pub forward: &'a [f32],
    /// What a unit in the cell after a face sends back.
    pub back: &'a [f32],
    /// Whether the first face is the last one too.
    pub ring: bool,
}

/// Solves along rows. `x`: right-hand sides, then the solution, `width` a row; faces: `width + 1` a row.
pub fn rows(x: &mut [f32], width: usize, faces: Faces<'_>) {
    x.par_chunks_mut(LANES * width).enumerate().for_each_init(
        || Tile::new(width),
        |tile, (k, x)| {
            for (l, row) in x.chunks_exact(width).enumerate() {
                let at = (k * LANES + l) * (width + 1);
                let forward = &faces.forward[at..=at + width];
                let back = &faces.back[at..=at + width];
                forward.iter().zip(&mut tile.forward).for_each(|(v, t)| t[l] = *v);
                back.iter().zip(&mut tile.back).for_each(|(v, t)| t[l] = *v);
                row.iter().zip(&mut tile.x).for_each(|(v, t)| t[l] = *v);
            }
            tile.solve(faces.ring);
            for (l, row) in x.chunks_exact_mut(width).enumerate() {
                row.iter_mut().zip(&tile.x).for_each(|(v, t)| *v = t[l]);
            }
        },
    );
}

/// Solves along columns. `x` as in [`rows`]; faces: `width` a row, one row more than `x`.
pub fn columns(x: &mut [f32], width: usize, faces: Faces<'_>) {
    let height = x.len() / width;
    let mut bundles: Vec<Vec<&mut [f32]>> = (0..width.div_ceil(LANES)).map(|_| Vec::with_capacity(height)).collect();
    for row in x.chunks_exact_mut(width) {
        for (bundle, part) in bundles.iter_mut().zip(row.chunks_mut(LANES)) {
            bundle.push(part);
        }
    }
    bundles.par_iter_mut().enumerate().for_each_init(
        || Tile::new(height),
        |tile, (k, bundle)| {
            let (first, lanes) = (k * LANES, bundle[0].len());
            for i in 0..=height {
                let at = i * width + first;
                tile.forward[i][..lanes].copy_from_slice(&faces.forward[at..at + lanes]);
                tile.back[i][..lanes].copy_from_slice(&faces.back[at..at + lanes]);
            }
            bundle.iter().zip(&mut tile.x).for_each(|(row, t)| t[..lanes].copy_from_slice(row));
            tile.solve(faces.ring);
            bundle.iter_mut().zip(&tile.x).for_each(|(row, t)| row.copy_from_slice(&t[..lanes]));
        },
    );
}
