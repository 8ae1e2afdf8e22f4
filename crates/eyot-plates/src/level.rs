//! Heights from the crust, and the level of the sea that keeps the asked share of land.
//!
//! The level is a number for the whole world. The share of land that is aimed at follows the wish by half a point a step, and waits for
//! the level: so a changed wish, or land that others raised, floods no world at once. After each step the level moves to where the cells
//! around the coast that it would drown or lay bare give that share, at most by `FASTEST_M`: so the coast is steady. Where that is not enough, as
//! where the whole side of a continent collides within one step on a coarse grid, the level becomes the one, from the distribution of
//! all heights, at which the share is `FARTHEST` from the aim. Continents themselves keep their area: collisions shorten them, rivers,
//! stretching and arcs widen them.

use crate::geometry::rows_at_once;
use crate::isostasy::{dry_m, height_above, heights_m};
use rayon::prelude::*;

/// The level moves no faster, m a step.
const FASTEST_M: f64 = 25.0;
/// The share of land is never farther from the one that is aimed at.
const FARTHEST: f64 = 0.02;
/// That one moves no faster, per step.
const FASTEST_AIM: f64 = 0.005;

/// Rises of the level, m, for which the land that is left is counted.
const RISES_M: [f32; 9] = [-25.0, -12.0, -5.0, -2.0, 0.0, 2.0, 5.0, 12.0, 25.0];
/// Where among them there is no rise.
const NO_RISE: usize = 4;
/// None of them brings ground that is farther from the sea to it, m.
const NEAR_M: f32 = 40.0;

/// Cells that would stand above the sea after each of [`RISES_M`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct Coast([u64; RISES_M.len()]);

impl Coast {
    fn of(height: &[f32]) -> Self {
        let above = |part: &[f32], bottom: f32| u64::from(part.iter().map(|&h| u32::from(h > bottom)).sum::<u32>());
        let mut counts = [0; RISES_M.len()];
        // Most ground is far from the sea.
        for part in height.chunks(64) {
            if part.iter().fold(false, |near, h| near | (h.abs() < NEAR_M)) {
                counts.iter_mut().zip(RISES_M).for_each(|(c, rise)| *c += above(part, height_above(rise)));
            } else {
                let land = above(part, 0.0);
                counts.iter_mut().for_each(|c| *c += land);
            }
        }
        Self(counts)
    }

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
            age.iter_mut().for_each(|a| *a += myr);
            for ((crust, age), height) in crust.chunks(64).zip(age.chunks(64)).zip(height.chunks_mut(64)) {
                heights_m(crust, age, level, height);
            }
            Coast::of(height)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn coast(height: &[f32]) -> Coast {
        let all = Coast(RISES_M.map(|r| height.iter().filter(|&&h| h > height_above(r)).count() as u64));
        assert_eq!(Coast::of(height), all);
        all
    }

    #[test]
    fn the_level_finds_the_share_also_where_heights_crowd() {
        // A ramp, and one with most cells within two metres of the sea.
        for crowd in [0.0, 0.8] {
            let ramp = |i: usize| -400.0 + 0.8 * i as f32;
            let height = (0..1000).map(|i| if i as f32 / 1000.0 < crowd { 0.004 * i as f32 - 1.6 } else { ramp(i) });
            let height: Vec<f32> = height.collect();
            let land = |level: f64| -> (Vec<f32>, f64) {
                let h: Vec<f32> = height.iter().map(|h| h - level as f32).collect();
                let land = coast(&h).land() as f64 / 1000.0;
                (h, land)
            };
            let wanted = land(0.0).1 - 0.1;
            let mut level = 0.0;
            for _ in 0..8 {
                let (h, before) = land(level);
                level += correction(coast(&h), 1000, wanted);
                let after = land(level).1;
                assert!((after - wanted).abs() <= (before - wanted).abs() + 0.01, "{crowd}: from {before} to {after}");
            }
            assert!((land(level).1 - wanted).abs() < 0.01, "{crowd}: {} of {wanted}", land(level).1);
        }
        assert_eq!(correction(coast(&[5000.0; 8]), 8, 0.5), FASTEST_M);
        assert_eq!(correction(coast(&[-5000.0; 8]), 8, 0.5), -FASTEST_M);
    }

    #[test]
    fn too_far_is_mended_at_once_and_the_aim_waits() {
        let height: Vec<f32> = (0..1000).map(|i| 3.0 * (i as f32 - 600.0)).collect();
        assert_eq!(at_once(coast(&height), &height, 0.39), None);
        for aim in [0.3, 0.6] {
            let rise = at_once(coast(&height), &height, aim).unwrap();
            let left = height.iter().filter(|&&h| f64::from(dry_m(h)) > rise).count() as f64 / 1000.0;
            assert!((left - aim).abs() <= FARTHEST + 1e-9 && (left - aim).abs() > 0.015, "{aim}: {left}");
        }
        assert!((aim(0.3, 0.302, 0.4) - 0.305).abs() < 1e-12 && aim(0.3, 0.27, 0.4) == 0.3);
    }
}
