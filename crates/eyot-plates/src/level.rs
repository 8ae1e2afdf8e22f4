//! Heights from the crust, and the level of the sea that keeps the asked share of land.
//!
//! The level is a number for the whole world. The share of land that is aimed at follows the wish by half a point a step, and waits for
//! the level: so a changed wish, or land that others raised, floods no world at once. After each step the level moves to where the cells
//! around the coast that it would drown or lay bare give that share, at most by `FASTEST_M`: so the coast is steady. Where that is not enough, as
//! where the whole side of a continent collides within one step on a coarse grid, the level becomes the one, from the distribution of
//! all heights, at which the share is `FARTHEST` from the aim. Continents themselves keep their area: collisions shorten them, rivers,
//! stretching and arcs widen them.

use crate::crust::metres;
use crate::geometry::rows_at_once;
use crate::isostasy::{dry_m, height_above, height_m};
use rayon::prelude::*;

/// The level moves no faster, m a step.
const FASTEST_M: f64 = 25.0;
/// The share of land is never farther from the one that is aimed at.
const FARTHEST: f64 = 0.02;
/// That one moves no faster, per step.
const FASTEST_AIM: f64 = 0.005;

/// Rises of the level, m, for which the land that is left is counted.
const RISES_M: [f32; 5] = [-25.0, -6.0, 0.0, 6.0, 25.0];
/// Where among them there is no rise.
const NO_RISE: usize = 2;

/// Cells that would stand above the sea after each of [`RISES_M`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct Coast([u64; RISES_M.len()]);

impl Coast {
    /// Cells above the sea.
    pub(crate) fn land(&self) -> u64 {
        self.0[NO_RISE]
    }
}

/// Ages the crust by `myr` and computes the heights above the sea.
pub(crate) fn heights(width: usize, crust: &[i32], age: &mut [f32], myr: f32, level: f64, height: &mut [f32]) -> Coast {
    let level = level as f32;
    let rows = crust.par_chunks(width).zip(age.par_chunks_mut(width)).zip(height.par_chunks_mut(width));
    rows.with_min_len(rows_at_once(width))
        .map(|((crust, age), height)| {
            for ((c, a), h) in crust.iter().zip(age.iter_mut()).zip(height.iter_mut()) {
                *a += myr;
                *h = height_m(metres(*c), *a, level);
            }
            Coast(RISES_M.map(|rise| {
                let bottom = height_above(rise);
                u64::from(height.iter().map(|&h| u32::from(h > bottom)).sum::<u32>())
            }))
        })
        .reduce(Coast::default, |a, b| Coast(std::array::from_fn(|i| a.0[i] + b.0[i])))
}

/// By how much the level should rise for the asked share of land, m: between two of the rises in proportion.
pub(crate) fn correction(coast: Coast, cells: usize, share: f64) -> f64 {
    let wanted = share * cells as f64;
    let rise = |i: usize| f64::from(RISES_M[i]);
    // The first rise after which too little is left, and the one before it.
    let Some(after) = (0..RISES_M.len()).find(|&i| (coast.0[i] as f64) < wanted) else { return FASTEST_M };
    let Some(before) = after.checked_sub(1) else { return -FASTEST_M };
    let (more, less) = (coast.0[before] as f64, coast.0[after] as f64);
    rise(before) + (more - wanted) / (more - less) * (rise(after) - rise(before))
}

/// The share of land to aim at after a step that ended with so much of it.
pub(crate) fn aim(aim: f64, land: f64, wish: f64) -> f64 {
    // Heights may have a gap that the level has to cross first.
    let follows = (land - aim).abs() < 0.5 * FARTHEST;
    if follows { aim + (wish - aim).clamp(-FASTEST_AIM, FASTEST_AIM) } else { aim }
}

/// By how much the level has to rise at once for a share of land within [`FARTHEST`] of `aim`, m; `None` if it is.
pub(crate) fn at_once(coast: Coast, height: &[f32], aim: f64) -> Option<f64> {
    let cells = height.len() as f64;
    let (least, most) = ((aim - FARTHEST) * cells, (aim + FARTHEST) * cells);
    let land = coast.land() as f64;
    if (least..=most).contains(&land) {
        return None;
    }
    // So many cells are to be land: the next lower one lies at the new coast.
    let wanted = if land < least { least.ceil() } else { most.floor() }.clamp(0.0, cells - 1.0) as usize;
    let mut dry: Vec<f32> = height.iter().map(|&h| dry_m(h)).collect();
    Some(f64::from(*dry.select_nth_unstable_by(wanted, |a, b| b.total_cmp(a)).1))
}
