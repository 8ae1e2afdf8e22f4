//! Fills depressions up to where they run over (filter).
//!
//! Water leaves over open rims and into the sea. Where neither is, the lowest cells are where it gathers.
//!
//! # Equations
//! 1. `h'(c) = min over all ways from c to an outlet of the highest h on the way`: the least surface without depressions.
//! 2. With a slope, cell by cell upstream: `h'(c) = max(h'(c), h'(receiver of c) + slope * distance)`.
//!
//! # Source
//! Barnes, Lehman and Mulla 2014 for the surface; `eyot_drainage` says how it is found in parallel.
//!
//! # Differences
//! No queue of cells: basins of the rough surface are joined over their lowest passes (Cordonnier, Bovy and Braun 2019). The
//! result is the same to the bit.

use super::check;
use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Grid, Result};
use eyot_drainage::{Land, Routing, fill};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Raises the floors of all depressions to where they run over, so that all land drains.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fill {
    /// Least slope along the way of the water. 0 leaves the filled depressions level, 0.001 tilts them by a metre a kilometre;
    /// much more buries what lies beside them.
    #[schemars(range(min = 0.0, max = 0.1), extend("unit" = "1"))]
    pub slope: f32,
    /// Water leaves over closed rims too, as from a map that was cut out of a larger one.
    pub closed_rims: bool,
}

impl Generator for Fill {
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let (grid, control) = (&site.grid, site.control);
        let land = Land { height: base, grid, sea_level_m: site.world.sea_level_m, closed_rims: self.closed_rims };
        let (mut height, outlets) = land.heights_and_outlets()?;
        fill(&mut height, grid, &outlets, control)?;
        if self.slope > 0.0 {
            Routing::new(&height, grid, &outlets, control)?.tilt(&mut height, f64::from(self.slope))?;
        }
        Field::from_slice(grid.width, grid.height, &height)
    }

    fn bytes_per_cell(&self, _grid: &Grid) -> usize {
        34
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("fill", self)
    }

    fn is_filter(&self) -> bool {
        true
    }
}
