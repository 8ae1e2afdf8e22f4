//! Spill levels: how high water must rise in each basin before it runs off.
//!
//! Neighbouring basins are joined by their lowest pass. Joining them in the order of the passes (Kruskal 1956), a basin
//! spills at the pass by which its group first meets the outside: the lowest possible highest pass on the way out.

use super::bands::{around as around_cell, band_cells, three_rows};
use super::descent::{Basins, OUTSIDE};
use super::{Height, Neighbours, STEPS};
use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::LaneBlock;
use eyot_core::{Control, Grid, Result};
use rayon::prelude::*;

/// A way from one basin to another over a cell of this height.
#[derive(Clone, Copy)]
pub(super) struct Pass<T, M> {
    pub(super) height: T,
    /// The smaller label first.
    pub(super) basins: [u32; 2],
    /// What is known of the cell.
    pub(super) mark: M,
}

/// What a pass keeps of its cell: nothing, for those who ask for levels alone and sort many passes, or its number.
pub(super) trait Mark: Copy + Default + Send {
    fn of(cell: usize) -> Self;
}

impl Mark for () {
    fn of(_: usize) {}
}

impl Mark for u32 {
    fn of(cell: usize) -> Self {
        cell as Self
    }
}

/// Of each label the level at which its basin spills; minus infinity for the outside and for labels that no cell has.
pub(super) fn spill_levels<T: Height>(z: &[T], grid: &Grid, basins: &Basins, control: &Control<'_>) -> Result<Vec<T>> {
    let mut passes = passes::<_, ()>(z, grid, basins, control)?;
    passes.par_sort_unstable_by_key(|p| p.height.key());
    control.check()?;
    Ok(join(&passes, basins.labels))
}

/// The lowest passes between neighbouring basins, of some more than one.
pub(super) fn passes<T: Height, M: Mark>(
    z: &[T],
    grid: &Grid,
    basins: &Basins,
    control: &Control<'_>,
) -> Result<Vec<Pass<T, M>>> {
    let (around, isa, rows) = (Neighbours::new(grid), Isa::best(), band_cells(grid) / grid.width);
    let bands: Vec<Vec<Pass<T, M>>> = (0..grid.height.div_ceil(rows))
        .into_par_iter()
        .map(|band| {
            control.check()?;
            let mut cache = Cache::new(grid.width);
            let mut uphill = vec![0; grid.width];
            for y in band * rows..grid.height.min((band + 1) * rows) {
                passes_in_row(z, grid, &basins.label, &around, y, isa, &mut uphill, &mut cache);
            }
            Ok(cache.finish())
        })
        .collect::<Result<_>>()?;
    Ok(bands.concat())
}

fn join<T: Height>(passes: &[Pass<T, ()>], labels: usize) -> Vec<T> {
    let mut level = vec![T::of(f64::NEG_INFINITY); labels];
    let mut group: Vec<u32> = (0..labels as u32).collect();
    // Groups are rings, so that two of them join by swapping two successors.
    let mut next = group.clone();
    let mut size = vec![1_u32; labels];
    for pass in passes {
        let [mut a, mut b] = pass.basins.map(|l| find(&mut group, l));
        if a == b {
            continue;
        }
        let outside = find(&mut group, OUTSIDE);
        if a == outside || b == outside {
            let inside = if a == outside { b } else { a };
            let mut member = inside;
            loop {
                level[member as usize] = pass.height;
                member = next[member as usize];
                if member == inside {
                    break;
                }
            }
        }
        next.swap(a as usize, b as usize);
        if size[a as usize] < size[b as usize] {
            std::mem::swap(&mut a, &mut b);
        }
        group[b as usize] = a;
        size[a as usize] += size[b as usize];
    }
    level
}

pub(super) fn find(group: &mut [u32], mut l: u32) -> u32 {
    while group[l as usize] != l {
        let up = group[group[l as usize] as usize];
        group[l as usize] = up;
        l = up;
    }
    l
}

/// The lowest passes seen lately, each pair of basins at its own place; those that lose their place move to `out`.
struct Cache<T, M> {
    recent: Vec<Pass<T, M>>,
    out: Vec<Pass<T, M>>,
}

impl<T: Height, M: Mark> Cache<T, M> {
    fn new(width: usize) -> Self {
        let nothing = Pass { height: T::default(), basins: [OUTSIDE; 2], mark: M::default() };
        Self { recent: vec![nothing; (2 * width).next_power_of_two().clamp(64, 1 << 14)], out: Vec::new() }
    }

    #[inline]
    fn add(&mut self, a: u32, b: u32, height: T, cell: usize) {
        let basins = [a.min(b), a.max(b)];
        let hash = (u64::from(basins[0]) << 32 | u64::from(basins[1])).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let at = (hash >> 40) as usize & (self.recent.len() - 1);
        let old = &mut self.recent[at];
        if old.basins == basins {
            if height < old.height {
                (old.height, old.mark) = (height, M::of(cell));
            }
        } else {
            let evicted = std::mem::replace(old, Pass { height, basins, mark: M::of(cell) });
            if evicted.basins != [OUTSIDE; 2] {
                self.out.push(evicted);
            }
        }
    }

    fn finish(mut self) -> Vec<Pass<T, M>> {
        self.out.extend(self.recent.into_iter().filter(|p| p.basins != [OUTSIDE; 2]));
        self.out
    }
}

/// Finds the passes over the cells of row `y` to lower neighbours in other basins.
fn passes_in_row<T: Height, M: Mark>(
    z: &[T],
    grid: &Grid,
    label: &[u32],
    around: &Neighbours,
    y: usize,
    isa: Isa,
    lower: &mut [u8],
    cache: &mut Cache<T, M>,
) {
    let w = grid.width;
    let mut slowly = |x: usize| {
        let i = y * w + x;
        around.each(i, |_, j| {
            if label[j] != label[i] && z[j] <= z[i] {
                cache.add(label[i], label[j], z[i], i);
            }
        });
    };
    match (three_rows(z, grid, y), three_rows(label, grid, y)) {
        (Some(heights), Some(labels)) => {
            slowly(0);
            slowly(w - 1);
            run_lanes(isa, Lower { heights, labels, out: &mut lower[1..w - 1] });
            let step = STEPS.map(|(dx, dy)| dy * w as isize + dx);
            for x in (1..w - 1).filter(|&x| lower[x] != 0) {
                let (i, mut left, mut last) = (y * w + x, lower[x], OUTSIDE);
                while left != 0 {
                    let other = label[i.wrapping_add_signed(step[left.trailing_zeros() as usize])];
                    // Neighbours side by side are mostly in the same basin.
                    if other != last || other == OUTSIDE {
                        cache.add(label[i], other, z[i], i);
                        last = other;
                    }
                    left &= left - 1;
                }
            }
        }
        _ => (0..w).for_each(slowly),
    }
}

/// For the inner cells of a row, the neighbours that are not higher and lie in another basin, one bit each.
struct Lower<'a, T> {
    heights: [&'a [T]; 3],
    labels: [&'a [u32]; 3],
    out: &'a mut [u8],
}

impl<T: Height> LaneTask for Lower<'_, T> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let n = self.out.len();
        let (heights, labels) = (self.heights.map(|r| &r[..n + 2]), self.labels.map(|r| &r[..n + 2]));
        for x in 0..n {
            let (z, l) = (heights[1][x + 1], labels[1][x + 1]);
            let (others, theirs) = (around_cell(heights, x), around_cell(labels, x));
            let mut bits = 0_u32;
            for k in 0..8 {
                bits |= if (others[k] <= z) & (theirs[k] != l) { 1 << k } else { 0 };
            }
            self.out[x] = bits as u8;
        }
    }
}
