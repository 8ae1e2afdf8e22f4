//! Fractal noise: `h = offset + amplitude sum gain^o noise_o / sum gain^o`; see [`super::noise`].

use super::check;
use super::fractal::Fractal;
use super::noise::Sum;
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fractal noise: hills upon hills.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub struct Fbm {
    /// The noise and its heights.
    #[serde(flatten)]
    pub fractal: Fractal,
}

impl Generator for Fbm {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        self.fractal.land(Sum::Fbm, site)
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("fbm", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
