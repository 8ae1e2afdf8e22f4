//! Ridged noise: fractal noise folded at its zeros, so that it has crests.
//!
//! # Equations
//! 1. `signal_i = w_i (1 - |n_i|)^2`, `w_0 = 1`, `w_i = clamp(sharpness signal_(i-1), 0, 1)`.
//! 2. `h = offset + amplitude sum_i gain^i signal_i / sum_i gain^i`.
//!
//! # Source
//! Musgrave's ridged multifractal in Ebert et al. 2003.

use super::fbm::feature_m;
use super::noise::{Basis, Octaves, Sum};
use eyot_core::isa::Isa;
use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Ridged noise: mountain chains with sharp crests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Ridged {
    /// The noise of an octave.
    pub basis: Basis,
    /// Height of the highest crests above the offset.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub amplitude: f32,
    /// Added everywhere.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub offset: f32,
    /// Distance of the largest chains as a share of the grid's longer side.
    #[schemars(range(min = 0.0001, max = 100.0), extend("unit" = "1"))]
    pub scale: f64,
    /// Number of octaves.
    #[schemars(range(min = 1, max = 24), extend("unit" = "1"))]
    pub octaves: u32,
    /// How much finer each octave is than the one before.
    #[schemars(range(min = 1.1, max = 8.0), extend("unit" = "1"))]
    pub lacunarity: f64,
    /// How strong each octave is in terms of the one before.
    #[schemars(range(min = 0.01, max = 1.0), extend("unit" = "1"))]
    pub gain: f64,
    /// How much a crest invites finer crests: 0 leaves valleys and crests alike, 2 is classic.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    pub sharpness: f32,
}

impl Default for Ridged {
    fn default() -> Self {
        Self {
            basis: Basis::Simplex,
            amplitude: 1000.0,
            offset: 0.0,
            scale: 0.35,
            octaves: 8,
            lacunarity: 2.0,
            gain: 0.5,
            sharpness: 2.0,
        }
    }
}

impl Generator for Ridged {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        let octaves = Octaves {
            basis: self.basis,
            sum: Sum::Ridged { sharpness: self.sharpness },
            octaves: self.octaves,
            lacunarity: self.lacunarity,
            gain: self.gain,
            feature_m: feature_m(&site.grid, self.scale),
            seed: site.seed,
        };
        let mut field = octaves.field(&site.grid, Isa::best(), site.control)?;
        field.map_in_place(|v| self.offset + self.amplitude * v);
        Ok(field)
    }
}
