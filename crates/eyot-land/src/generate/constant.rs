//! The same height everywhere.

use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The same height everywhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Constant {
    /// The height (or whatever the layer holds).
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub value: f32,
}

impl Default for Constant {
    fn default() -> Self {
        Self { value: 0.0 }
    }
}

impl Generator for Constant {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        Ok(Field::new(site.grid.width, site.grid.height, self.value))
    }
}
