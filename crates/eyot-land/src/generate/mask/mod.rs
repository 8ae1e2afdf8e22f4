//! Masks: layers from 0 to 1 that say where something is, for the `mask` of other steps.
//!
//! Each looks at another layer (or at a noise) and belongs into a layer of its own. Masks meet by `merge`: `multiply` keeps
//! what both have, `max` what either has.

use super::scale_m;
use eyot_core::math::smoothstep;
use eyot_core::process::{Around, Generator, Site};
use eyot_core::{Grid, Result};

mod curvature;
mod height;
mod noise;
mod slope;

pub use curvature::{MaskCurvature, Shape};
pub use height::MaskHeight;
pub use noise::MaskNoise;
pub use slope::MaskSlope;

/// 0 below `low`, 1 above `high`, smooth between; a sharp step if they are the same.
fn rise(low: f32, high: f32, v: f32) -> f32 {
    if high > low { smoothstep(low, high, v) } else { f32::from(v >= low) }
}

/// The layer that a mask looks at.
fn looked_at<'a>(what: &dyn Generator, site: &Site<'a>, layer: &str) -> Result<Around<'a>> {
    Around::new(site, what.reach(&site.grid), &site.world.layer(layer)?.field)
}

/// A distance as columns and rows, at least one of each.
fn cells(grid: &Grid, share: f32, size_m: f32) -> (usize, usize) {
    let size_m = scale_m(grid, share, size_m);
    let whole = |cell_m: f64, most: usize| ((size_m / cell_m).round() as usize).clamp(1, most.max(1));
    (whole(grid.cell_x_m, grid.width), whole(grid.cell_y_m, grid.height))
}
