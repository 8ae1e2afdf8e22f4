//! The same value everywhere.
//!
//! # Equations
//! 1. `h = value`.
//!
//! # Source
//! None is needed.

use super::check;
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The same value everywhere: a sea floor to build on, or a number to merge with.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Constant {
    /// The value, in the unit of the layer that it is made for; metres for heights.
    #[schemars(range(min = -1e6, max = 1e6), extend("unit" = "m"))]
    pub value: f32,
}

impl Generator for Constant {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        Ok(Field::new(site.grid.width, site.rows.len(), self.value))
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("constant", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
