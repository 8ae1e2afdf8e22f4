//! Breaching: cuts trenches from the bottoms of depressions to lower ground, where that is cheaper than filling.
//!
//! # Rule
//! 1. A pit is a cell without a lower neighbour, or a flat without one, which is no outlet.
//! 2. From each pit the cheapest way to a cell below it, or to an outlet at its level, is searched on the surface as it
//!    was (Dijkstra 1959). A step of length `s` from `i` to `j` costs `s ((d_i + d_j) / 2 + 1 mm)`, `d = max(0, z - z_pit)`:
//!    what must be dug for a metre of width, and of equally cheap ways the shortest. Cells with `d > max_depth` and ways
//!    longer than `max_length` are not taken.
//! 3. Along the way the ground is lowered to `l_i = max(z_pit + (z_end - z_pit) x_i / x_end, z_i - max_depth, l_next)`.
//!    Of equally cheap ways, and of the cells of a pit to begin at, one is drawn (`place.rs`), as on the turned land.
//! 4. Where trenches cross, the deeper one counts. From every cell of a trench the one that dug it goes on downwards, so no
//!    new pit can form: pits remain only where no way was within the bounds.
//!
//! Trenches do not know of each other, so they can be searched in parallel and in any order.
//!
//! # Source
//! Lindsay & Dhun (2015), Modelling surface drainage patterns in altered landscapes using LiDAR, International Journal of
//! Geographical Information Science 29, 397-411; Lindsay (2016), Efficient hybrid breaching-filling sink removal methods for
//! flow path enforcement in digital elevation models, Hydrological Processes 30, 846-857.
//!
//! # Differences
//! They dig one trench after the other, each on the surface that the last one left. Outlets keep their height, so a
//! depression that reaches below all outlets keeps a lake.

use super::bands::band_cells;
use super::flats::resolve_flats;
use super::neighbours::Neighbours;
use super::place::{Place, Places};
use super::routing::{Descent, FlatRule};
use super::steepest::{NOWHERE, descent};
use super::{Height, check_sizes};
use eyot_core::{Control, Error, Grid, Result};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::hash_map::Entry;
use std::collections::{BinaryHeap, HashMap};
use std::hash::{BuildHasherDefault, Hasher};

/// Bounds of the trenches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BreachLimits {
    /// No cell is lowered by more than this, m.
    pub max_depth_m: f64,
    /// No trench is longer than this, m.
    pub max_length_m: f64,
}

/// Pits between two looks at the stop button.
const BATCH: usize = 1 << 14;
/// What a metre of way costs besides the digging, m2.
const WAY: f64 = 0.001;

/// Breaches the depressions of `height` within `limits`; see [`fill`](super::fill()) for those that remain.
///
/// # Errors
/// If a bound is negative or not a number, `height` or `outlets` has another size than `grid`, the grid has 2^32 cells or
/// more, or on a request to stop; `height` is then as it was.
pub fn breach<T: Height>(
    height: &mut [T],
    grid: &Grid,
    outlets: &[bool],
    limits: &BreachLimits,
    control: &Control<'_>,
) -> Result<()> {
    check_sizes(grid, &[("height", height.len()), ("outlets", outlets.len())])?;
    for (field, bound) in [("max_depth", limits.max_depth_m), ("max_length", limits.max_length_m)] {
        if bound.is_nan() || bound < 0.0 {
            let reason = format!("is {bound} m, it must not be negative");
            return Err(Error::BadParameter { owner: "breach".into(), field: field.into(), reason });
        }
    }
    let (near, places) = (Neighbours::new(grid), Places::new(grid));
    let pits = pits(height, grid, &near, outlets, &places, control)?;
    let mut trenches: Vec<Vec<(u32, T)>> = Vec::with_capacity(pits.len());
    for batch in pits.chunks(BATCH) {
        control.tick(trenches.len() as u64, pits.len() as u64)?;
        let surface = &*height;
        trenches.par_extend(
            batch
                .par_iter()
                .map_init(Search::default, |search, &pit| search.trench(surface, &near, outlets, &places, limits, pit)),
        );
    }
    for (i, level) in trenches.into_iter().flatten() {
        let z = &mut height[i as usize];
        *z = if level < *z { level } else { *z };
    }
    Ok(())
}

/// One cell of each pit.
fn pits<T: Height>(
    z: &[T],
    grid: &Grid,
    near: &Neighbours,
    outlets: &[bool],
    places: &Places,
    control: &Control<'_>,
) -> Result<Vec<u32>> {
    let mut direction = descent(z, grid, outlets, Descent::D8, control)?;
    resolve_flats(z, grid, FlatRule::Shortest, &mut direction, control)?;
    let cells = band_cells(grid);
    let ends: Vec<Vec<u32>> = direction
        .par_chunks(cells)
        .enumerate()
        .map(|(band, d)| {
            let first = band * cells;
            let ends = (first..first + d.len()).filter(|&i| d[i - first] == NOWHERE && !outlets[i]);
            ends.map(|i| i as u32).collect()
        })
        .collect();
    // One cell stands for all that are level with it, by lot.
    let (mut pits, mut group) = (Vec::new(), Vec::new());
    for i in ends.into_iter().flatten() {
        if std::mem::replace(&mut direction[i as usize], 0) != NOWHERE {
            continue;
        }
        let mut chosen = (places.of(i as usize).lot(), i);
        group.push(i as usize);
        while let Some(i) = group.pop() {
            chosen = chosen.min((places.of(i).lot(), i as u32));
            near.each(i, |_, j| {
                if direction[j] == NOWHERE && z[j] == z[i] && !outlets[j] {
                    direction[j] = 0;
                    group.push(j);
                }
            });
        }
        pits.push(chosen.1);
    }
    Ok(pits)
}

/// A cell that a search has come to.
struct Reached {
    cost: f64,
    length_m: f64,
    from: u32,
    done: bool,
}

/// The memory of a search.
#[derive(Default)]
struct Search {
    reached: HashMap<u32, Reached, BuildHasherDefault<Mix>>,
    /// Cost, number by lot, cell.
    open: BinaryHeap<Reverse<(u64, u64, u32)>>,
}

impl Search {
    /// The cells of the trench from `pit` with their new heights; empty if there is no way.
    fn trench<T: Height>(
        &mut self,
        z: &[T],
        near: &Neighbours,
        outlets: &[bool],
        places: &Places,
        limits: &BreachLimits,
        pit: u32,
    ) -> Vec<(u32, T)> {
        self.reached.clear();
        self.open.clear();
        let bottom = z[pit as usize];
        let depth = |i: usize| (z[i].to_f64() - bottom.to_f64()).max(0.0);
        self.reached.insert(pit, Reached { cost: 0.0, length_m: 0.0, from: pit, done: false });
        self.open.push(Reverse((0, 0, pit)));
        let start: Place = places.of(pit as usize);
        while let Some(Reverse((_, _, cell))) = self.open.pop() {
            let Some(here) = self.reached.get_mut(&cell).filter(|r| !r.done) else { continue };
            here.done = true;
            let (cost, length_m, i) = (here.cost, here.length_m, cell as usize);
            if z[i] < bottom || (outlets[i] && z[i] == bottom) {
                return self.dig(z, limits, cell);
            }
            if outlets[i] {
                continue;
            }
            near.each(i, |d, j| {
                let step_m = near.distance_m[d];
                let length_m = length_m + step_m;
                if depth(j) > limits.max_depth_m || length_m > limits.max_length_m {
                    return;
                }
                let cost = cost + step_m * (0.5 * (depth(i) + depth(j)) + WAY);
                let new = Reached { cost, length_m, from: cell, done: false };
                let better = match self.reached.entry(j as u32) {
                    Entry::Occupied(mut old) => {
                        let better = cost < old.get().cost;
                        if better {
                            old.insert(new);
                        }
                        better
                    }
                    Entry::Vacant(place) => {
                        place.insert(new);
                        true
                    }
                };
                if better {
                    // The bits of positive numbers sort as they do.
                    self.open.push(Reverse((cost.to_bits(), places.number(&start, j), j as u32)));
                }
            });
        }
        Vec::new()
    }

    /// Levels along the way to `end`, from there back to the pit.
    fn dig<T: Height>(&self, z: &[T], limits: &BreachLimits, end: u32) -> Vec<(u32, T)> {
        let whole_m = self.reached[&end].length_m;
        let low = z[end as usize].to_f64();
        let mut trench = Vec::new();
        let (mut cell, mut level) = (self.reached[&end].from, low);
        let start = loop {
            let here = &self.reached[&cell];
            if here.from == cell {
                break cell;
            }
            trench.push((cell, here.length_m));
            cell = here.from;
        };
        let high = z[start as usize].to_f64();
        let dug = trench.into_iter().map(|(i, x)| {
            let even = high + (low - high) * (x / whole_m);
            level = level.max(even).max(z[i as usize].to_f64() - limits.max_depth_m);
            (i, T::of(level))
        });
        dug.collect()
    }
}

/// Spreads cell numbers over a hash table.
#[derive(Default)]
struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.write_u32(u32::from(*b)));
    }
    fn write_u32(&mut self, v: u32) {
        let mixed = (self.0 ^ u64::from(v)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ (mixed >> 32);
    }
}
