//! Rivers and waves level the land, and crust that is too thick flows apart.
//!
//! # Equations
//! On each face between neighbours a and b, with `p = max(height, 0)`:
//! 1. rivers: `q = erosion dt / cell^2 (p_a - p_b) / A`: only land is worn, and its shelf receives what comes off the coast
//! 2. waves, where one is sea at least: `q += coast dt / cell^2 (s_a - s_b) / A`, with the height `s` no less than -100 m, no more than
//!    200 m
//! 3. spreading of thick crust: `q += min(150 m2/yr dt / cell^2, 0.1) (s_a - s_b)`, with
//!    `s = max(crust - 0.8 max_crust, 0)^2 / (0.4 max_crust)`
//! 4. denudation: `dh/dt = -denudation (p / 1 km)^3`, and what it takes from the land of a plate the edges of its shelves get, all the
//!    same: the first cells below -130 m
//!
//! Relief grows with height (Ahnert 1970), and slopes wear the faster than in proportion the steeper they are (Montgomery and Brandon 2002),
//! so high plateaus wear down in tens of millions of years and lowlands hardly. The last term makes continents that collisions have
//! shortened grow at their margins.
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
/// What waves reach above and below the sea, m.
const WAVES_M: f32 = 200.0;
const WAVES_DOWN_M: f32 = 100.0;
/// How fast thick crust spreads, m2/yr: a plateau becomes 300 km wider in forty million years.
const SPREAD: f64 = 150.0;

/// Rates of one pass for faces to the east and to the south.
#[derive(Clone, Copy)]
struct Rates {
    rivers: f32,
    waves: f32,
    spread: f32,
    max_crust: f32,
}

/// What a cell at the edge of a shelf can be given at most, m of crust per million years and at once.
const DELTA_M: (f64, f64) = (500.0, 4000.0);
/// Share of its height that land can lose at once.
const MAX_LOST: f32 = 0.25;
/// Height of the edge of the shelves, m.
const SHELF_M: f32 = -130.0;

/// Carries crust from the land of each plate to the edges of its shelves for `years`.
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
    let runs = runs::of_rows(owner, w);
    let per_m3 = (f64::from(p.denudation) * years * 1e-15 * f64::from(UNITS_PER_M) / f64::from(RISE)) as f32;
    let most = MAX_LOST * UNITS_PER_M as f32 / RISE;
    let taken = |h: f32, factor: f32| {
        let p = h.max(0.0);
        (factor * p * p * p).min(most * p) as i32
    };
    // What each plate would lose, and the sea beside its shelves.
    let row = |flags: &mut [Vec<bool>; 4], y: usize| {
        let heights = &height[y * w..][..w];
        let mut lost = vec![0i64; plates];
        for run in &runs[y] {
            let sum: i64 = heights[run.range()].iter().map(|&h| i64::from(taken(h, per_m3))).sum();
            lost[usize::from(run.owner)] += sum;
        }
        let [north, here, south, edge] = flags;
        let shelf = |flags: &mut [bool], y: usize| {
            flags.iter_mut().zip(&height[y * w..][..w]).for_each(|(f, &h)| *f = h > SHELF_M);
        };
        shelf(here, y);
        for (flags, dy) in [(&mut *north, -1), (&mut *south, 1)] {
            shelf(flags, g.row(y as isize + dy).unwrap_or(y));
        }
        let at = |x: isize| g.column(x).is_some_and(|x| here[x]);
        for x in 0..w {
            edge[x] = north[x] | south[x];
        }
        edge[0] |= at(-1);
        edge[w - 1] |= at(w as isize);
        for x in 1..w {
            edge[x] |= here[x - 1];
            edge[x - 1] |= here[x];
        }
        edge.iter_mut().zip(&*here).for_each(|(e, &h)| *e &= !h);
        let mut edges: Vec<u32> = Vec::new();
        for (i, part) in edge.chunks(64).enumerate().filter(|(_, p)| p.iter().fold(false, |any, &e| any | e)) {
            edges.extend((0..part.len()).filter(|&x| part[x]).map(|x| (y * w + 64 * i + x) as u32));
        }
        (lost, edges)
    };
    let flags: [Vec<bool>; 4] = std::array::from_fn(|_| vec![false; w]);
    let rows: Vec<(Vec<i64>, Vec<u32>)> =
        (0..g.height).into_par_iter().with_min_len(rows_at_once(w)).map_with(flags, row).collect();
    let mut lost = vec![0i64; plates];
    let mut edges = vec![0i64; plates];
    for (row, cells) in &rows {
        lost.iter_mut().zip(row).for_each(|(l, r)| *l += r);
        cells.iter().for_each(|&c| edges[usize::from(owner[c as usize])] += 1);
    }
    // What finds no room stays where it is.
    let delta = (DELTA_M.0 * years * 1e-6).min(DELTA_M.1) * f64::from(UNITS_PER_M);
    let factor: Vec<f32> =
        lost.iter().zip(&edges).map(|(&l, &n)| per_m3 * (delta * n as f64 / l.max(1) as f64).min(1.0) as f32).collect();
    let carried: Vec<Vec<i64>> = crust
        .par_chunks_mut(w)
        .enumerate()
        .with_min_len(rows_at_once(w))
        .map(|(y, crust)| {
            let mut carried = vec![0i64; plates];
            for run in &runs[y] {
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
        let share = left[plate] / edges[plate];
        crust[cell as usize] += share as i32;
        left[plate] -= share;
        edges[plate] -= 1;
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
            spread: (SPREAD * per).min(0.1) as f32,
            max_crust: p.max_crust,
        }
    };
    let (east, south) = (rates(g.cell_m.0), rates(g.cell_m.1));
    let w = g.width;
    let blocks = w.div_ceil(BLOCK);
    let still = still(w, p.max_crust, height, crust);
    // What flows through the western face of each cell, and through the eastern one of the last.
    let flows = vec![0i32; w + 1];
    next.par_chunks_mut(w).enumerate().with_min_len(rows_at_once(w)).for_each_with(flows, |flows, (y, out)| {
        let row = |y: usize| (&height[y * w..][..w], &crust[y * w..][..w], &still[y * blocks..][..blocks]);
        let (h, c, quiet) = row(y);
        out.copy_from_slice(c);
        for other in [g.row(y as isize - 1), g.row(y as isize + 1)].into_iter().flatten() {
            let (oh, oc, other_quiet) = row(other);
            for b in (0..blocks).filter(|&b| !(quiet[b] && other_quiet[b])) {
                for x in b * BLOCK..((b + 1) * BLOCK).min(w) {
                    out[x] -= flux(south, (h[x], c[x]), (oh[x], oc[x]));
                }
            }
        }
        for b in 0..blocks {
            let faces = b * BLOCK..((b + 1) * BLOCK).min(w - 1);
            let flows = &mut flows[faces.start + 1..=faces.end];
            if quiet[b] && quiet.get(b + 1).is_none_or(|&q| q) {
                flows.fill(0);
                continue;
            }
            let cells = |shift: usize| h[faces.start + shift..].iter().zip(&c[faces.start + shift..]);
            for ((flow, (&h, &c)), (&nh, &nc)) in flows.iter_mut().zip(cells(0)).zip(cells(1)) {
                *flow = flux(east, (h, c), (nh, nc));
            }
        }
        let round = g.column(w as isize).map_or(0, |first| flux(east, (h[w - 1], c[w - 1]), (h[first], c[first])));
        (flows[0], flows[w]) = (round, round);
        out.iter_mut().zip(flows.windows(2)).for_each(|(out, f)| *out += f[0] - f[1]);
    });
}

/// Cells of a row that are looked at together.
const BLOCK: usize = 64;

/// Which blocks of cells are below the reach of waves, on crust that does not spread: between two such nothing flows.
fn still(w: usize, max_crust: f32, height: &[f32], crust: &[i32]) -> Vec<bool> {
    let blocks = w.div_ceil(BLOCK);
    let mut still = vec![false; blocks * (height.len() / w)];
    let rows = still.par_chunks_mut(blocks).zip(height.par_chunks(w)).zip(crust.par_chunks(w));
    rows.with_min_len(rows_at_once(w)).for_each(|((still, h), c)| {
        for ((still, h), c) in still.iter_mut().zip(h.chunks(BLOCK)).zip(c.chunks(BLOCK)) {
            let deep = h.iter().fold(true, |all, &h| all & (h <= -WAVES_DOWN_M));
            *still = deep & c.iter().fold(true, |all, &c| all & (metres(c) <= 0.8 * max_crust));
        }
    });
    still
}

/// Crust from cell a to cell b, units; the other way round with the other sign.
#[inline(always)]
fn flux(r: Rates, a: (f32, i32), b: (f32, i32)) -> i32 {
    let (pa, pb) = (a.0.max(0.0), b.0.max(0.0));
    let waves = if a.0 > 0.0 && b.0 > 0.0 { 0.0 } else { r.waves };
    let reached = |h: f32| h.clamp(-WAVES_DOWN_M, WAVES_M);
    let levelling = r.rivers * (pa - pb) + waves * (reached(a.0) - reached(b.0));
    let spreads = |c: i32| {
        let over = (metres(c) - 0.8 * r.max_crust).max(0.0);
        over * over * (1.0 / (0.4 * r.max_crust))
    };
    let flow = r.spread * (spreads(a.1) - spreads(b.1));
    ((levelling * (1.0 / RISE) + flow) * UNITS_PER_M as f32) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crust::units;
    use crate::isostasy::height_m;
    use eyot_core::{Boundary, Grid, Limits};

    /// A ridge between two shelves: what it loses the edges of the shelves gain, however long the step and fast the rivers are.
    #[test]
    fn denudation_feeds_the_shelves_and_loses_nothing() {
        let g = Geometry::new(&Grid::new(64, 16, 78_125.0, Boundary::WRAP, &Limits::default()).unwrap());
        let level = 4900.0;
        let thick = |x: usize| {
            if (20..24).contains(&x) {
                60e3
            } else if (12..32).contains(&x) {
                30e3
            } else {
                7e3
            }
        };
        let crust: Vec<i32> = (0..64 * 16).map(|c| units(thick(c % 64))).collect();
        let height: Vec<f32> = crust.iter().map(|&c| height_m(metres(c), 90.0, level)).collect();
        assert!(height[22] > 3000.0 && (-2000.0..SHELF_M).contains(&height[14]), "{} {}", height[22], height[14]);
        let owner = vec![0u8; crust.len()];
        let mut last = 0;
        for (denudation, years) in [(0.2, 1e5), (0.6, 8e6), (1000.0, 8e7)] {
            let p = Tectonics { denudation, ..Tectonics::default() };
            let mut after = crust.clone();
            denude(&g, &p, years, 1, &owner, &height, &mut after);
            let sum = |c: &[i32]| c.iter().map(|&c| i64::from(c)).sum::<i64>();
            assert_eq!(sum(&after), sum(&crust));
            let (lost, gained) = (crust[22] - after[22], after[19] - crust[19]);
            assert!(lost > last && gained > 0 && after[18] == crust[18], "{lost} {gained}");
            assert!(after.iter().all(|&c| c > 0) && lost < crust[22] / 3, "{lost}");
            last = lost;
        }
        let none = Tectonics { denudation: 0.0, ..Tectonics::default() };
        let mut after = crust.clone();
        denude(&g, &none, 8e6, 1, &owner, &height, &mut after);
        assert_eq!(after, crust);
    }
}
