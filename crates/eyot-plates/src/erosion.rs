//! Rivers and waves level the land, and crust that is too thick flows apart.
//!
//! # Equations
//! On each face between neighbours a and b, with `p = max(height, 0)`:
//! 1. rivers: `q = erosion dt / cell^2 (p_a - p_b) / A`: only land is worn, and its shelf receives what comes off the coast
//! 2. waves, where one is land and the other sea: `q += coast dt / cell^2 min(p, 200 m) / A`
//! 3. flow of thick crust: `q += 0.2 (max(crust_a - max_crust, 0) - max(crust_b - max_crust, 0))`
//! 4. denudation: `dh/dt = -denudation (p / 1 km)^2`, and what it takes from the land of a plate its coasts get, all the same
//!
//! Relief grows with height, and rivers cut the faster the steeper it is (Ahnert 1970 found both), so high plateaus wear down in tens of
//! millions of years and lowlands hardly. The last term makes continents that collisions have shortened grow at their margins.
//!
//! `A` is the rise of land for each metre of crust, so heights diffuse with the given diffusivity. A face has one flux in whole units of
//! crust, so nothing is lost. The flow has no noise, so it leaves no grain; it moves crust instead of taking it, so mountains do not wear
//! away into nothing; and waves take narrow islands, which have four coasts, before wide ones.

use crate::crust::{UNITS_PER_M, metres};
use crate::geometry::{Geometry, rows_at_once};
use crate::isostasy::RISE;
use crate::parameters::Tectonics;
use crate::runs;
use rayon::prelude::*;

/// Largest share of a height difference that one pass may move through a face.
const STABLE: f64 = 0.12;
/// What waves reach, m.
const WAVES_M: f32 = 200.0;
const FLOW: f32 = 0.2;

/// Rates of one pass for faces to the east and to the south.
#[derive(Clone, Copy)]
struct Rates {
    rivers: f32,
    waves: f32,
    max_crust: f32,
}

/// What a cell at the coast can be given at most, m of crust per million years.
const DELTA_M: f64 = 500.0;

/// Carries crust from the land of each plate to its coasts for `years`.
pub(crate) fn denude(
    g: &Geometry,
    p: &Tectonics,
    years: f64,
    plates: usize,
    owner: &[u8],
    height: &[f32],
    crust: &mut [i32],
) {
    if p.denudation <= 0.0 {
        return;
    }
    let w = g.width;
    let per_m2 = (f64::from(p.denudation) * years * 1e-12 * f64::from(UNITS_PER_M) / f64::from(RISE)) as f32;
    let taken = |h: f32, factor: f32| (factor * h.max(0.0) * h.max(0.0)) as i32;
    // What each plate would lose, and the sea beside its land.
    let row = |y: usize| {
        let (heights, owners) = (&height[y * w..][..w], &owner[y * w..][..w]);
        let mut lost = vec![0i64; plates];
        for run in runs::of_row(owners) {
            let sum: i64 = heights[run.range()].iter().map(|&h| i64::from(taken(h, per_m2))).sum();
            lost[usize::from(run.owner)] += sum;
        }
        let beside =
            [g.row(y as isize - 1), g.row(y as isize + 1)].map(|r| r.map_or(heights, |r| &height[r * w..][..w]));
        let any = |x: usize| {
            g.column(x as isize - 1).is_some_and(|x| heights[x] > 0.0)
                || g.column(x as isize + 1).is_some_and(|x| heights[x] > 0.0)
        };
        let coast = |&x: &usize| heights[x] <= 0.0 && (beside[0][x] > 0.0 || beside[1][x] > 0.0 || any(x));
        let coasts: Vec<u32> = (0..w).filter(coast).map(|x| (y * w + x) as u32).collect();
        (lost, coasts)
    };
    let rows: Vec<(Vec<i64>, Vec<u32>)> =
        (0..g.height).into_par_iter().with_min_len(rows_at_once(w)).map(row).collect();
    let mut lost = vec![0i64; plates];
    let mut coasts = vec![0i64; plates];
    for (row, cells) in &rows {
        lost.iter_mut().zip(row).for_each(|(l, r)| *l += r);
        cells.iter().for_each(|&c| coasts[usize::from(owner[c as usize])] += 1);
    }
    // What finds no coast stays where it is.
    let delta = DELTA_M * years * 1e-6 * f64::from(UNITS_PER_M);
    let factor: Vec<f32> = lost
        .iter()
        .zip(&coasts)
        .map(|(&l, &n)| per_m2 * (delta * n as f64 / l.max(1) as f64).min(1.0) as f32)
        .collect();
    let carried: Vec<Vec<i64>> = crust
        .par_chunks_mut(w)
        .enumerate()
        .with_min_len(rows_at_once(w))
        .map(|(y, crust)| {
            let mut carried = vec![0i64; plates];
            for run in runs::of_row(&owner[y * w..][..w]) {
                let factor = factor[usize::from(run.owner)];
                let heights = &height[y * w..][run.range()];
                let sum: i64 = crust[run.range()]
                    .iter_mut()
                    .zip(heights)
                    .map(|(c, &h)| {
                        let q = taken(h, factor);
                        *c -= q;
                        i64::from(q)
                    })
                    .sum();
                carried[usize::from(run.owner)] += sum;
            }
            carried
        })
        .collect();
    let mut left = vec![0i64; plates];
    carried.iter().for_each(|row| left.iter_mut().zip(row).for_each(|(l, r)| *l += r));
    for &cell in rows.iter().flat_map(|r| &r.1) {
        let plate = usize::from(owner[cell as usize]);
        let share = left[plate] / coasts[plate];
        crust[cell as usize] += share as i32;
        left[plate] -= share;
        coasts[plate] -= 1;
    }
}

/// Passes that `years` need.
pub(crate) fn passes(g: &Geometry, p: &Tectonics, years: f64) -> u32 {
    let side = g.cell_m.0.min(g.cell_m.1);
    let share = f64::from(p.erosion.max(p.coast)) * years / (side * side);
    (share / STABLE).ceil().clamp(1.0, 1e6) as u32
}

/// Moves crust from `crust` to `next` for `years`, one pass.
pub(crate) fn pass(g: &Geometry, p: &Tectonics, years: f64, height: &[f32], crust: &[i32], next: &mut [i32]) {
    let rates = |cell: f64| {
        let per = years / (cell * cell);
        Rates {
            rivers: (f64::from(p.erosion) * per) as f32,
            waves: (f64::from(p.coast) * per) as f32,
            max_crust: p.max_crust,
        }
    };
    let (east, south) = (rates(g.cell_m.0), rates(g.cell_m.1));
    let w = g.width;
    next.par_chunks_mut(w).enumerate().with_min_len(rows_at_once(w)).for_each(|(y, out)| {
        let row = |y: usize| (&height[y * w..][..w], &crust[y * w..][..w]);
        let (h, c) = row(y);
        out.copy_from_slice(c);
        for other in [g.row(y as isize - 1), g.row(y as isize + 1)].into_iter().flatten() {
            let (oh, oc) = row(other);
            for x in 0..w {
                out[x] -= flux(south, (h[x], c[x]), (oh[x], oc[x]));
            }
        }
        for x in 0..w - 1 {
            let q = flux(east, (h[x], c[x]), (h[x + 1], c[x + 1]));
            out[x] -= q;
            out[x + 1] += q;
        }
        if let Some(first) = g.column(w as isize) {
            let q = flux(east, (h[w - 1], c[w - 1]), (h[first], c[first]));
            out[w - 1] -= q;
            out[first] += q;
        }
    });
}

/// Crust from cell a to cell b, units; the other way round with the other sign.
#[inline(always)]
fn flux(r: Rates, a: (f32, i32), b: (f32, i32)) -> i32 {
    let (pa, pb) = (a.0.max(0.0), b.0.max(0.0));
    let at_coast = if (a.0 > 0.0) != (b.0 > 0.0) { r.waves } else { 0.0 };
    let levelling = r.rivers * (pa - pb) + at_coast * (pa.min(WAVES_M) - pb.min(WAVES_M));
    let thick = |c: i32| (metres(c) - r.max_crust).max(0.0);
    ((levelling * (1.0 / RISE) + FLOW * (thick(a.1) - thick(b.1))) * UNITS_PER_M as f32) as i32
}
