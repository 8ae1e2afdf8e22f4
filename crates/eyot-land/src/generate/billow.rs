//! Billow: fractal noise of folded octaves.
//!
//! # Equations
//! `n_o` noise of octave `o` within -1..=1, `g` gain; octaves and bases as for `fbm`.
//! 1. `h = offset + amplitude * sum(g^o (2 |n_o| - 1)) / sum(g^o)`: what was a zero crossing is a sharp valley.
//!
//! # Source
//! Turbulence as in Ebert et al. 2003, on the noise of Perlin 2002.

use super::check;
use super::fractal::{Fractal, Octaves};
use super::noise::{Basis, Sum};
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Folded fractal noise: round hills with sharp valleys between them, like clouds or dunes.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub struct Billow {
    /// The noise and its heights.
    #[serde(flatten)]
    pub fractal: Fractal,
}

impl Default for Billow {
    fn default() -> Self {
        // The folds of simplex noise run from lattice point to lattice point; with Perlin's that shows less.
        let noise = Octaves { basis: Basis::Perlin, octaves: 7, ..Octaves::default() };
        Self { fractal: Fractal { noise, warp: 0.15, ..Fractal::default() } }
    }
}

impl Generator for Billow {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        self.fractal.land(Sum::Billow, site)
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("billow", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
