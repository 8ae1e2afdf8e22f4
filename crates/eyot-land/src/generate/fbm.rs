//! Fractal noise: octaves of gradient noise, each finer and weaker than the one before.
//!
//! # Equations
//! 1. `h = offset + amplitude sum_i gain^i n(x lacunarity^i / scale) / sum_i gain^i` over `octaves`.
//!
//! # Source
//! The island thesis, I2 (simplex, lacunarity 2, gain 1/2); Perlin 1985.

use super::noise::{Basis, Octaves, Sum};
use eyot_core::isa::Isa;
use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fractal noise: hills of all sizes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fbm {
    /// The noise of an octave.
    pub basis: Basis,
    /// Height of the sum where all octaves are at their top; typical heights are a third of it.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub amplitude: f32,
    /// Added everywhere.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub offset: f32,
    /// Size of the largest hills as a share of the grid's longer side, so that the land stays the same at any resolution.
    #[schemars(range(min = 0.0001, max = 100.0), extend("unit" = "1"))]
    pub scale: f64,
    /// Number of octaves. Few are smooth, many are rough; those finer than two cells only add noise.
    #[schemars(range(min = 1, max = 24), extend("unit" = "1"))]
    pub octaves: u32,
    /// How much finer each octave is than the one before.
    #[schemars(range(min = 1.1, max = 8.0), extend("unit" = "1"))]
    pub lacunarity: f64,
    /// How strong each octave is in terms of the one before. Above 0.6 land turns to spikes, below 0.4 to dunes.
    #[schemars(range(min = 0.01, max = 1.0), extend("unit" = "1"))]
    pub gain: f64,
}

impl Default for Fbm {
    fn default() -> Self {
        Self {
            basis: Basis::Simplex,
            amplitude: 500.0,
            offset: 0.0,
            scale: 0.3,
            octaves: 8,
            lacunarity: 2.0,
            gain: 0.5,
        }
    }
}

/// Size of features given as a share of the grid's longer side, m.
pub(super) fn feature_m(grid: &Grid, share: f64) -> f64 {
    let (w, h) = grid.extent_m();
    share * w.max(h)
}

impl Generator for Fbm {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.compute(site, Isa::best())
    }
}

impl Fbm {
    /// As [`Generator::generate`], with a given instruction set (which does not change a bit).
    ///
    /// # Errors
    /// On a request to stop.
    pub fn compute(&self, site: &Site<'_>, isa: Isa) -> Result<Field> {
        let octaves = Octaves {
            basis: self.basis,
            sum: Sum::Plain,
            octaves: self.octaves,
            lacunarity: self.lacunarity,
            gain: self.gain,
            feature_m: feature_m(&site.grid, self.scale),
            seed: site.seed,
        };
        let mut field = octaves.field(&site.grid, isa, site.control)?;
        field.map_in_place(|v| self.offset + self.amplitude * v);
        Ok(field)
    }
}
