//! Heights from the crust, and the level of the sea that keeps the asked share of land.
//!
//! The level is a number for the whole world. After each step it moves by the missing share of land over how densely the heights lie
//! around the coast, so the share is right again one step later; at most by `FASTEST_M` a step, so that a changed wish floods no
//! world at once. Continents themselves keep their area: collisions shorten them, rivers, stretching and arcs widen them.

use crate::crust::metres;
use crate::geometry::rows_at_once;
use crate::isostasy::height_m;
use rayon::prelude::*;

/// Half the band around the coast in which heights are counted, m.
const BAND_M: f32 = 150.0;
/// The level moves no faster, m a step.
const FASTEST_M: f64 = 25.0;

/// Cells above the sea, and cells in the band around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct Coast {
    pub(crate) land: u64,
    pub(crate) band: u64,
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
            let land = height.iter().map(|&h| u32::from(h > 0.0)).sum::<u32>();
            let band = height.iter().map(|&h| u32::from(h.abs() < BAND_M)).sum::<u32>();
            Coast { land: u64::from(land), band: u64::from(band) }
        })
        .reduce(Coast::default, |a, b| Coast { land: a.land + b.land, band: a.band + b.band })
}

/// By how much the level should rise for the asked share of land, m.
pub(crate) fn correction(coast: Coast, cells: usize, share: f64) -> f64 {
    let cells = cells as f64;
    // Where hardly any height is near the sea the band says nothing.
    let per_m = (coast.band as f64).max(0.002 * cells) / (2.0 * f64::from(BAND_M));
    ((coast.land as f64 - share * cells) / per_m).clamp(-FASTEST_M, FASTEST_M)
}
