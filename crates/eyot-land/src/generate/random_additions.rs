//! Successive random additions: a lattice is refined again and again, and a Gaussian number is added to all of its points, old
//! places and new ones, each time.
//!
//! # Equations
//! 1. Level `l` has points `ratio^l` times as far apart as the first. Its lattice is moved by a random part of the spacing, so
//!    a point comes to lie anywhere on the way between two points of the level before and not in the middle.
//! 2. A point takes the height of a quadratic B-spline through the level before, and `sigma_l = ratio^(H l)` times a Gaussian number
//!    is added.
//!
//! That the ratio is free is what distinguishes the method from midpoint displacement: near 1 the levels melt into each other.
//!
//! # Source
//! Voss 1985; Saupe 1988.
//!
//! # Scale
//! Spacings are shares of the extent; levels finer than the cells are left out, the last one fades in.

use super::subdivide::{Axis, Blend, Level, Random, cells_m, surface};
use super::{check, scale_m};
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::real::Real;
use eyot_core::rng::mix64;
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Successive random additions: land of any roughness without a trace of the lattice.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RandomAdditions {
    /// Distance of the first points as a share of the grid's longer side.
    #[schemars(range(min = 0.0001, max = 10.0), extend("unit" = "1"))]
    pub scale: f32,
    /// Distance of the first points in metres. 0 takes `scale` instead.
    #[schemars(range(min = 0.0, max = 1e7), extend("unit" = "m"))]
    pub scale_m: f32,
    /// Distance of the points of a level relative to the level before.
    #[schemars(range(min = 0.3, max = 0.9), extend("unit" = "1"))]
    pub ratio: f32,
    /// Hurst exponent H: how fast heights calm down from level to level. 0.5 is rugged, 1 gentle.
    #[schemars(range(min = 0.05, max = 2.0), extend("unit" = "1"))]
    pub hurst: f32,
    /// Standard deviation of the heights on a land much larger than `scale`.
    #[schemars(range(min = 0.0, max = 12000.0), extend("unit" = "m"))]
    pub amplitude: f32,
    /// Mean of the heights on such a land.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub offset: f32,
}

impl Default for RandomAdditions {
    fn default() -> Self {
        Self { scale: 0.25, scale_m: 0.0, ratio: 0.6, hurst: 0.9, amplitude: 350.0, offset: 0.0 }
    }
}

/// Mean of the sum of squared weights of a quadratic B-spline, 11/20 along each axis.
const SPREAD: f32 = 0.3025;

impl RandomAdditions {
    fn levels(&self, g: &Grid, seed: u64) -> Vec<Level> {
        let (extent, cell) = (<[f64; 2]>::from(g.extent_m()), cells_m(g));
        let coarsest_cell = cell[0].max(cell[1]);
        let fall = Real::pow(self.ratio, self.hurst);
        let mut range = self.amplitude * ((1.0 - fall * fall) / SPREAD).sqrt();
        let mut spacing_m = scale_m(g, self.scale, self.scale_m).max(coarsest_cell);
        let mut levels = Vec::new();
        loop {
            let visible = (2.0 * spacing_m / coarsest_cell - 1.0).clamp(0.0, 1.0) as f32;
            let lattice = [(0, g.rim.x), (1, g.rim.y)].map(|(a, edge)| {
                let bits = mix64(seed ^ mix64(2 * levels.len() as u64 + a as u64));
                let shift = (bits >> 40) as f64 / f64::from(1 << 24);
                Axis::new(extent[a], edge, spacing_m.max(cell[a]), shift)
            });
            levels.push(Level { lattice, range: range * visible });
            range *= fall;
            spacing_m *= f64::from(self.ratio);
            if 2.0 * spacing_m <= coarsest_cell || spacing_m < 0.7 * cell[0].min(cell[1]) {
                return levels;
            }
        }
    }
}

impl Generator for RandomAdditions {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let mut field = surface(site, &self.levels(&site.grid, site.seed), Blend::Spline, Random::Bell)?;
        field.map_in_place(|h| self.offset + h);
        Ok(field)
    }

    fn bytes_per_cell(&self, _grid: &Grid) -> usize {
        10
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("random_additions", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
