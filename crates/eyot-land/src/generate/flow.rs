//! The area that drains through each cell.
//!
//! A source for a layer of its own: `generate = "flow"`, `layer = "drained_area"`. It looks at the layer `height`, whose
//! depressions it fills for itself; the height stays as it is.
//!
//! # Equations
//! 1. `A(c) = cell area + sum over cells u above c of w(u, c) A(u)`.
//! 2. d8: `w = 1` for the steepest of the eight neighbours, `(h - h_n) / distance`, else 0.
//! 3. multiple: `w_n = s_n^exponent / sum s_k^exponent` with `s = (h - h_n) / distance` over all lower neighbours.
//! 4. dinf: of the eight triangles between neighbours the steepest; with `r` the angle of its steepest way from the edge
//!    neighbour and `a` that of the corner neighbour, `w = r / a` for the corner and `1 - r / a` for the edge.
//!
//! # Source
//! O'Callaghan and Mark 1984 (d8); Freeman 1991 (multiple); Tarboton 1997 (dinf); Barnes, Lehman and Mulla 2014 for the way across flats.

use super::check;
use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Grid, Result};
use eyot_drainage::{Land, RoutingRule};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The area from which water flows through each cell of the land, in m2.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Flow {
    /// How water goes from cell to cell: to one neighbour (d8), to all lower ones (multiple), or straight down the slope, to one
    /// or two (dinf).
    pub routing: RoutingRule,
    /// With multiple routing, how much water prefers the steeper way: 1.1 suits cones, more gathers it in valleys.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "1"))]
    pub exponent: f32,
    /// Water leaves over closed rims too, as from a map that was cut out of a larger one.
    pub closed_rims: bool,
}

impl Default for Flow {
    fn default() -> Self {
        Self { routing: RoutingRule::D8, exponent: 1.1, closed_rims: false }
    }
}

impl Generator for Flow {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let grid = &site.grid;
        let height = &site.world.layer("height")?.field;
        let land = Land { height, grid, sea_level_m: site.world.sea_level_m, closed_rims: self.closed_rims };
        let drained = land.drain(self.routing, f64::from(self.exponent), site.control)?;
        let area: Vec<f32> = drained.area_m2.iter().map(|&a| a as f32).collect();
        Field::from_slice(grid.width, grid.height, &area)
    }

    fn bytes_per_cell(&self, _grid: &Grid) -> usize {
        34
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("flow", self)
    }

    fn reads(&self) -> Vec<&str> {
        vec!["height"]
    }
}
