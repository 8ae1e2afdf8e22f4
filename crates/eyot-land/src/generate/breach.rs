//! Cuts outflows through the walls of depressions (filter).
//!
//! Water leaves over open rims and into the sea. Where neither is, the lowest cells are where it gathers.
//!
//! # Equations
//! 1. From each pit `p` the cheapest way to lower ground is searched. A step of length `s` from `i` to `j` costs
//!    `s ((d_i + d_j) / 2 + 1 mm)` with `d = max(0, h - h_p)`; cells with `d > max_depth` and ways longer than `max_length`
//!    are not taken.
//! 2. Along it the ground becomes `h'_i = max(h_p + (h_end - h_p) x_i / x_end, h_i - max_depth, h'_next)`.
//! 3. What that does not drain is filled, unless `fill` is off.
//!
//! # Source
//! Lindsay and Dhun 2015; Lindsay 2016.
//!
//! # Differences
//! Every trench is searched on the surface as it was, so that they can be searched in parallel and in any order.

use super::check;
use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Grid, Result};
use eyot_drainage::{BreachLimits, Land, breach, fill};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Cuts trenches from the bottoms of depressions to lower ground, and fills what that does not drain.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Breach {
    /// No cell is lowered by more than this. Little leaves large depressions to be filled, much cuts gorges.
    #[schemars(range(min = 0.0, max = 12000.0), extend("unit" = "m"))]
    pub max_depth: f32,
    /// No trench is longer than this. Time grows with its square where depressions are deep.
    #[schemars(range(min = 0.0, max = 1000000.0), extend("unit" = "m"))]
    pub max_length: f32,
    /// Fills the depressions that remain.
    pub fill: bool,
    /// Water leaves over closed rims too, as from a map that was cut out of a larger one.
    pub closed_rims: bool,
}

impl Default for Breach {
    fn default() -> Self {
        Self { max_depth: 50.0, max_length: 2000.0, fill: true, closed_rims: false }
    }
}

impl Generator for Breach {
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let (grid, control) = (&site.grid, site.control);
        let land = Land { height: base, grid, sea_level_m: site.world.sea_level_m, closed_rims: self.closed_rims };
        let (mut height, outlets) = land.heights_and_outlets()?;
        let limits = BreachLimits { max_depth_m: f64::from(self.max_depth), max_length_m: f64::from(self.max_length) };
        breach(&mut height, grid, &outlets, &limits, control)?;
        if self.fill {
            fill(&mut height, grid, &outlets, control)?;
        }
        Field::from_slice(grid.width, grid.height, &height)
    }

    fn bytes_per_cell(&self, _grid: &Grid) -> usize {
        24
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("breach", self)
    }

    fn is_filter(&self) -> bool {
        true
    }
}
