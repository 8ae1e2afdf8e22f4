//! Mask of patches.
//!
//! # Equations
//! `n` noise within -1..=1 as for `fbm`, `R` as for `mask_height`, `e` half of `edge`.
//! 1. `m = R(level - e, level + e, n)`; `1 - m` with `invert`.
//!
//! # Source
//! Noise as for `fbm`.

use super::super::check;
use super::super::fractal::Octaves;
use super::super::noise::Sum;
use super::rise;
use eyot_core::isa::Isa;
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// 1 where a noise is high, 0 elsewhere: patches without a cause.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MaskNoise {
    /// The noise.
    #[serde(flatten)]
    pub noise: Octaves,
    /// The noise, which lies within -1..=1, must exceed this: 0 covers about half of the land, higher less.
    #[schemars(range(min = -1.0, max = 1.0), extend("unit" = "1"))]
    pub level: f32,
    /// Difference of the noise over which the mask fades, half of it above the level.
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "1"))]
    pub edge: f32,
    /// 0 where it would be 1, and 1 where it would be 0.
    pub invert: bool,
}

impl Default for MaskNoise {
    fn default() -> Self {
        let noise = Octaves { octaves: 5, scale: 0.15, ..Octaves::default() };
        Self { noise, level: 0.05, edge: 0.15, invert: false }
    }
}

impl Generator for MaskNoise {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let noise = self.noise.noise(Sum::Fbm, &site.grid, site.seed);
        let mut field = noise.field(&site.grid, site.rows.clone(), Isa::best(), site.control)?;
        let (low, high) = (self.level - 0.5 * self.edge, self.level + 0.5 * self.edge);
        field.map_in_place(|n| {
            let inside = rise(low, high, n);
            if self.invert { 1.0 - inside } else { inside }
        });
        Ok(field)
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("mask_noise", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
