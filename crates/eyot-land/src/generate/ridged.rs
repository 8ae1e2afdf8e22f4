//! Ridged multifractal noise: crests where a noise passes zero, and finer crests on them.
//!
//! # Equations
//! `n_o` noise of octave `o` within -1..=1, `g` gain; octaves as for `fbm`.
//! 1. `s_o = (1 - |n_o|)^2 w_o`.
//! 2. `w_0 = 1`, `w_(o+1) = clamp(sharpness s_o, 0, 1)`: crests get detail, valleys stay smooth.
//! 3. `h = offset + amplitude * sum(g^o s_o) / sum(g^o)`.
//!
//! # Source
//! The ridged multifractal of Musgrave in Ebert et al. 2003; multifractals in Musgrave, Kolb and Mace 1989. Noise as for `fbm`.
//!
//! # Differences
//! - The sum is divided by the sum of the weights, so the result lies within `offset` and `offset + amplitude`.
//! - Gradient noise of Perlin is the default: simplex noise is zero at all points of its lattice, so that its crests run from
//!   point to point.
//!
//! # Layers
//! Makes a new field from its parameters and the seed of its step.

use super::check;
use super::fractal::{Fractal, Octaves};
use super::noise::{Basis, Sum};
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Ridged multifractal noise: chains of mountains.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub struct Ridged {
    /// The noise and its heights.
    #[serde(flatten)]
    pub fractal: Fractal,
    /// How much an octave's crests call for the next octave: its weight is the octave before times this, at most 1. Low
    /// values leave valleys and flanks smooth, high ones roughen everything. Default: Musgrave's.
    #[schemars(range(min = 0.0, max = 16.0), extend("unit" = "1"))]
    pub sharpness: f32,
}

impl Default for Ridged {
    fn default() -> Self {
        // Simplex noise is zero at all points of its lattice, so its crests run from point to point; with Perlin it shows less.
        let noise = Octaves { basis: Basis::Perlin, scale: 0.35, ..Octaves::default() };
        Self { fractal: Fractal { noise, amplitude: 1500.0, ..Fractal::default() }, sharpness: 2.0 }
    }
}

impl Generator for Ridged {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        self.fractal.land(Sum::Ridged(self.sharpness), site)
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("ridged", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
