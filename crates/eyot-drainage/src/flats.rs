//! Ways over flats: towards the lower edge and away from higher ground, so that water gathers in the middle.
//!
//! # Equations
//! `m = 2 t - a`, with `t` the fewest steps over the flat to one of its cells that has a lower neighbour, and `a` the fewest
//! steps from its cells beside higher ground (1 there, 0 everywhere on a flat without such cells). Water goes to the
//! neighbour on the flat with the lowest `m`, of equal ones `place.rs` chooses one. One of the neighbours has `t` less by one and `a` more or less by at most one, so `m` falls on every step and no cell is left over.
//!
//! # Source
//! Barnes, Lehman & Mulla (2014), An efficient assignment of drainage direction over flat surfaces in raster digital
//! elevation models, Computers & Geosciences 62, 128-135.
//!
//! # Differences
//! The paper inverts `a` within each flat; differences within a flat are all that counts, so flats need no labels.

use super::Height;
use super::bands::{around, band_cells, three_rows};
use super::neighbours::{Neighbours, STEPS};
use super::place::Places;
use super::routing::FlatRule;
use super::steepest::{FLAT, NOWHERE};
use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::LaneBlock;
use eyot_core::{Control, Grid, Result};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Gives the cells marked [`FLAT`] a direction; those of flats that nothing leaves become outlets.
pub(super) fn resolve_flats<T: Height>(
    z: &[T],
    grid: &Grid,
    rule: FlatRule,
    direction: &mut [u8],
    control: &Control<'_>,
) -> Result<()> {
    if !direction.contains(&FLAT) {
        return Ok(());
    }
    let flats = Flats::find(z, grid, direction);
    control.check()?;
    if rule == FlatRule::Shortest {
        flats.shortest(direction);
        return Ok(());
    }
    let (towards, away) = rayon::join(|| flats.steps_from(&flats.edges), || flats.steps_from(&flats.feet));
    control.check()?;
    let (cells, places) = (band_cells(grid), Places::new(grid));
    direction.par_chunks_mut(cells).enumerate().for_each(|(band, direction)| {
        for (k, direction) in direction.iter_mut().enumerate().filter(|(_, d)| **d == FLAT) {
            let i = band * cells + k;
            let m = |i: usize| 2 * i64::from(towards[i]) - i64::from(away[i]);
            let (mut best, mut ways) = (m(i), 0_u8);
            if towards[i] > 0 {
                flats.each(i, |d, j| {
                    let (lower, level) = (m(j) < best, m(j) == best && ways != 0);
                    ways = if lower { 1 << d } else { ways | u8::from(level) << d };
                    best = best.min(m(j));
                });
            }
            *direction = if ways == 0 { NOWHERE } else { places.choose(i, ways, &flats.near) as u8 };
        }
    });
    Ok(())
}

/// Cells of equal height and the ways between them.
struct Flats {
    near: Neighbours,
    wraps: bool,
    step: [isize; 8],
    /// One bit a direction: the neighbour has the same height, and it or the cell has no lower neighbour.
    linked: Vec<u8>,
    /// Cells of flats that have a lower neighbour.
    edges: Vec<u32>,
    /// Cells of flats that have a higher neighbour.
    feet: Vec<u32>,
}

impl Flats {
    fn find<T: Height>(z: &[T], grid: &Grid, direction: &[u8]) -> Self {
        let (near, isa, w, cells) = (Neighbours::new(grid), Isa::best(), grid.width, band_cells(grid));
        let slowly = |i: usize| {
            let (mut linked, mut higher) = (0, 0);
            near.each(i, |d, j| {
                linked |= u8::from(z[j] == z[i] && (direction[i] == FLAT || direction[j] == FLAT)) << d;
                higher |= u8::from(z[j] > z[i]);
            });
            (linked, higher)
        };
        let mut linked = vec![0; z.len()];
        let seeds: Vec<[Vec<u32>; 2]> = linked
            .par_chunks_mut(cells)
            .enumerate()
            .map(|(band, out)| {
                let (mut edges, mut feet, mut higher) = (Vec::new(), Vec::new(), vec![0; w]);
                for (k, out) in out.chunks_exact_mut(w).enumerate() {
                    let y = band * cells / w + k;
                    let first = y * w;
                    match (three_rows(z, grid, y), three_rows(direction, grid, y)) {
                        (Some(heights), Some(directions)) => {
                            let (linked, higher) = (&mut out[1..w - 1], &mut higher[1..w - 1]);
                            run_lanes(isa, Links { heights, directions, linked, higher });
                        }
                        _ => (1..w.max(2) - 1).for_each(|x| (out[x], higher[x]) = slowly(first + x)),
                    }
                    (out[0], higher[0]) = slowly(first);
                    (out[w - 1], higher[w - 1]) = slowly(first + w - 1);
                    for x in (0..w).filter(|&x| out[x] != 0) {
                        if direction[first + x] != FLAT {
                            edges.push((first + x) as u32);
                        }
                        if higher[x] != 0 {
                            feet.push((first + x) as u32);
                        }
                    }
                }
                [edges, feet]
            })
            .collect();
        Self {
            wraps: near.wraps(),
            near,
            step: STEPS.map(|(dx, dy)| dy * w as isize + dx),
            linked,
            edges: seeds.iter().flat_map(|s| &s[0]).copied().collect(),
            feet: seeds.iter().flat_map(|s| &s[1]).copied().collect(),
        }
    }

    /// Calls `f(direction, neighbour)` for the linked neighbours of cell `i`.
    #[inline]
    fn each(&self, i: usize, mut f: impl FnMut(usize, usize)) {
        let mut left = self.linked[i];
        while left != 0 {
            let d = left.trailing_zeros() as usize;
            // Links lead to existing neighbours.
            f(d, if self.wraps { self.near.at(i, d).unwrap_or(i) } else { i.wrapping_add_signed(self.step[d]) });
            left &= left - 1;
        }
    }

    /// Directions along which a search from the edges came first.
    fn shortest(&self, direction: &mut [u8]) {
        let mut queue = VecDeque::from(self.edges.clone());
        while let Some(i) = queue.pop_front() {
            self.each(i as usize, |d, j| {
                if direction[j] == FLAT {
                    direction[j] = (d as u8 + 4) % 8;
                    queue.push_back(j as u32);
                }
            });
        }
        direction.iter_mut().filter(|d| **d == FLAT).for_each(|d| *d = NOWHERE);
    }

    /// For each cell one more than the fewest links to one of `seeds`; 0 where there is no way.
    fn steps_from(&self, seeds: &[u32]) -> Vec<u32> {
        let mut steps = vec![0; self.linked.len()];
        let (mut frontier, mut next, mut n) = (seeds.to_vec(), Vec::new(), 1);
        seeds.iter().for_each(|&i| steps[i as usize] = n);
        while !frontier.is_empty() {
            n += 1;
            for i in frontier.drain(..) {
                self.each(i as usize, |_, j| {
                    if steps[j] == 0 {
                        steps[j] = n;
                        next.push(j as u32);
                    }
                });
            }
            std::mem::swap(&mut frontier, &mut next);
        }
        steps
    }
}

/// Links of the inner cells of a row, and whether a neighbour is higher.
struct Links<'a, T> {
    heights: [&'a [T]; 3],
    directions: [&'a [u8]; 3],
    linked: &'a mut [u8],
    higher: &'a mut [u8],
}

impl<T: Height> LaneTask for Links<'_, T> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let n = self.linked.len();
        let (heights, directions) = (self.heights.map(|r| &r[..n + 2]), self.directions.map(|r| &r[..n + 2]));
        let higher = &mut self.higher[..n];
        for x in 0..n {
            let (z, flat) = (heights[1][x + 1], directions[1][x + 1] == FLAT);
            let (others, theirs) = (around(heights, x), around(directions, x));
            let (mut linked, mut above) = (0_u32, 0_u32);
            for k in 0..8 {
                linked |= if (others[k] == z) & (flat | (theirs[k] == FLAT)) { 1 << k } else { 0 };
                above |= if others[k] > z { 1 } else { 0 };
            }
            self.linked[x] = linked as u8;
            higher[x] = above as u8;
        }
    }
}
