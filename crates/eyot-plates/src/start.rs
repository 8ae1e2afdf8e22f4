//! The first crust: from noise, or from a given height.

use crate::crust::{LOWLAND_M, OCEANIC_M, units};
use crate::geometry::Geometry;
use crate::isostasy::{age_of_depth, buoyancy, crust_m};
use crate::noise::{Fractal, quantile};
use eyot_core::BoundaryCondition;
use eyot_core::rng::mix64;

/// What a world of plates begins with.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Start<'a> {
    /// Continents from noise.
    Noise,
    /// A height for each cell, m above the sea, row by row from the north.
    Height(&'a [f32]),
}

/// Thickness (units), age (Myr), and the level of the sea in buoyancy (m).
pub(crate) struct Crust {
    pub(crate) thickness: Vec<i32>,
    pub(crate) age: Vec<f32>,
    pub(crate) level: f64,
}

/// Continental crust is this much more than land: the rest are shelves, as on Earth (0.41 to 0.29).
const SHELVES: f64 = 1.4;
/// Age of old crust, Myr.
const OLD: f32 = 90.0;
/// Level at which crust of 36 km stands 500 m above the sea, m.
pub(crate) fn usual_level() -> f64 {
    f64::from(buoyancy(LOWLAND_M, OLD) - 500.0)
}

/// Continents of fractal outline, thicker inside and uneven, in an ocean of patches of different age.
pub(crate) fn from_noise(g: &Geometry, seed: u64, land: f64, gather: f32) -> Crust {
    let mut shape = Fractal { scale: 0.55, octaves: 9, gain: 0.55, warp: 0.25 }.field(g, mix64(seed ^ 0x5eed));
    let uneven = Fractal { scale: 0.12, octaves: 6, gain: 0.6, warp: 0.4 }.field(g, mix64(seed ^ 0x0e));
    let belts = Fractal { scale: 0.45, octaves: 6, gain: 0.5, warp: 0.5 }.field(g, mix64(seed ^ 0xbe17));
    let ages = Fractal { scale: 0.5, octaves: 3, gain: 0.4, warp: 0.3 }.field(g, mix64(seed ^ 0xa9e));
    if gather > 0.0 {
        let middle = (g.width as f64 / 2.0, g.height as f64 / 2.0);
        let half = half_axes(g, land * SHELVES);
        for (cell, v) in shape.iter_mut().enumerate() {
            let (x, y) = g.way(middle, ((cell % g.width) as f64, (cell / g.width) as f64));
            // In units of the half axes of an ellipse of the asked area.
            let far = (x * x / (half.0 * half.0) + y * y / (half.1 * half.1)).sqrt() as f32;
            *v = *v * (1.0 - 0.45 * gather) - gather * far;
        }
    }
    fade_at_rims(g, &mut shape);
    let coast = quantile(&shape, 1.0 - (land * SHELVES).min(0.95));
    let spread = (quantile(&shape, 0.9) - quantile(&shape, 0.1)).max(1e-3);
    let thickness: Vec<i32> = shape
        .iter()
        .zip(&uneven)
        .zip(&belts)
        .map(|((&s, &u), &b)| {
            let inland = (s - coast) / spread;
            let t = ((inland + 0.04) / 0.12).clamp(0.0, 1.0);
            let rise = t * t * (3.0 - 2.0 * t);
            // Old ranges where the third noise changes its sign.
            let range = (1.0 - 6.0 * b.abs()).max(0.0);
            let high =
                LOWLAND_M - 1500.0 + 5000.0 * inland.clamp(0.0, 0.8) + (3000.0 + 3000.0 * range) * u + 7000.0 * range;
            units(OCEANIC_M + rise * (high - OCEANIC_M).max(0.0))
        })
        .collect();
    let age: Vec<f32> = ages.iter().map(|a| (OLD + 60.0 * a).max(5.0)).collect();
    let stand: Vec<f32> = thickness.iter().zip(&age).map(|(&t, &a)| buoyancy(crate::crust::metres(t), a)).collect();
    let level = f64::from(quantile(&stand, 1.0 - land));
    Crust { thickness, age, level }
}

/// Half axes, cells, of the roundest ellipse of a share of the grid that keeps away from rims that are no rings.
fn half_axes(g: &Geometry, share: f64) -> (f64, f64) {
    let area = g.cells() as f64 * g.cell_area_m2() * share / std::f64::consts::PI;
    let most = |n: usize, cell_m: f64, edge: BoundaryCondition| {
        if edge == BoundaryCondition::Wrap { f64::INFINITY } else { 0.36 * n as f64 * cell_m }
    };
    let (x, y) = (most(g.width, g.cell_m.0, g.rim.0), most(g.height, g.cell_m.1, g.rim.1));
    // The one that is short makes the other one long.
    let a = area.sqrt().min(x);
    let b = (area / a).min(y);
    ((area / b) / g.cell_m.0, b / g.cell_m.1)
}

/// Keeps continents away from rims that are no rings: what leaves such a rim has a straight coast.
fn fade_at_rims(g: &Geometry, shape: &mut [f32]) {
    let depth = 0.12 * g.width.min(g.height) as f64;
    let near = |i: usize, n: usize, edge: BoundaryCondition| {
        let from_rim = i.min(n - 1 - i) as f64;
        if edge == BoundaryCondition::Wrap { 0.0 } else { (1.0 - from_rim / depth).max(0.0) }
    };
    for (cell, v) in shape.iter_mut().enumerate() {
        let x = near(cell % g.width, g.width, g.rim.0);
        let y = near(cell / g.width, g.height, g.rim.1);
        *v -= 3.0 * (x * x + y * y) as f32;
    }
}

/// Crust that carries the given heights: depths below the ridges become age, everything else thickness.
pub(crate) fn from_height(height: &[f32]) -> Crust {
    let level = usual_level();
    let age: Vec<f32> = height.iter().map(|&h| if h < -2600.0 { age_of_depth(-h).max(1.0) } else { OLD }).collect();
    let thickness =
        height.iter().zip(&age).map(|(&h, &a)| units(crust_m(h, a, level as f32).min(crate::crust::HIGHEST_M)));
    Crust { thickness: thickness.collect(), age, level }
}
