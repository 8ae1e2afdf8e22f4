//! The drainage of a world's land in one call: what generators and processes share.

use super::{Base, Routing, Spread, fill, outlets};
use eyot_core::{Control, Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How water goes from cell to cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum RoutingRule {
    /// To the steepest one of the eight neighbours.
    #[default]
    D8,
    /// To all lower neighbours, more to the steeper ones.
    Multiple,
    /// Straight down the slope (D-infinity), to the one or two neighbours beside the way.
    Dinf,
}

/// Land whose drainage is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Land<'a> {
    /// Heights, m.
    pub height: &'a Field,
    /// The grid.
    pub grid: &'a Grid,
    /// Cells at or below this level are outlets, m.
    pub sea_level_m: f64,
    /// Border cells of closed rims are outlets too.
    pub closed_rims: bool,
}

/// The drainage of a landscape.
#[derive(Clone, Debug)]
pub struct Drained {
    /// Heights with full depressions, m, row by row.
    pub filled: Vec<f32>,
    /// For each cell the area that drains through it, itself included, m2.
    pub area_m2: Vec<f64>,
}

impl Land<'_> {
    /// Heights row by row, and which cells are outlets.
    ///
    /// # Errors
    /// If the field has another size than the grid, or the grid has 2^32 cells or more.
    pub fn heights_and_outlets(&self) -> Result<(Vec<f32>, Vec<bool>)> {
        let base = Base { closed_rims: self.closed_rims, sea_level_m: Some(self.sea_level_m), mask: None };
        let height = self.height.to_vec();
        let outlets = outlets(&height, self.grid, &base)?;
        Ok((height, outlets))
    }

    /// Fills the depressions and gathers the areas; `exponent` belongs to [`RoutingRule::Multiple`].
    ///
    /// # Errors
    /// As [`Land::heights_and_outlets`], if the exponent is out of range, or on a request to stop.
    pub fn drain(&self, rule: RoutingRule, exponent: f64, control: &Control<'_>) -> Result<Drained> {
        let (mut filled, outlets) = self.heights_and_outlets()?;
        fill(&mut filled, self.grid, &outlets, control)?;
        let routing = Routing::new(&filled, self.grid, &outlets, control)?;
        let spread = match rule {
            RoutingRule::D8 => None,
            RoutingRule::Multiple => Some(Spread::Multiple { exponent }),
            RoutingRule::Dinf => Some(Spread::Dinf),
        };
        let area_m2 = match spread {
            None => routing.upstream_area_m2(self.grid),
            Some(spread) => routing.spread_area_m2(&filled, self.grid, spread, control)?,
        };
        Ok(Drained { filled, area_m2 })
    }
}
