//! Fractal noise: hills upon hills, each octave finer and lower than the one before.
//!
//! # Equations
//! `n_o` noise of octave `o` within -1..=1, looked up at places in metres; `g` gain.
//! 1. `h = offset + amplitude * sum(g^o n_o) / sum(g^o)`.
//! 2. Octave `o` has features of the size `scale / lacunarity^o`.
//! 3. With `warp`: `n_o` is looked up at `p + warp * scale * (u, v)`, where `u` and `v` are two further noises of up to 4 octaves.
//!
//! `perlin` and `simplex` have a unit gradient at each lattice point, at an angle that a hash of the point chooses, and are zero there.
//! `perlin`: a square lattice; in a cell the four planes through the corners are blended with the fade `6 t^5 - 15 t^4 + 10 t^3`.
//! `simplex`: a lattice of equilateral triangles; each corner within reach adds `(3/4 - r^2)^4` times its plane.
//! `value`: a number at each point of a square lattice, blended with the same fade. The cellular bases are distances to strewn
//! points, as for `worley`; their mean is not 0.
//!
//! # Source
//! Perlin 1985 and 2002 (gradient noise, fade), 2001 (simplex); sums of octaves as in Ebert et al. 2003; noise that tiles after
//! Gustavson and McEwan 2022.
//!
//! # Differences
//! - The sum is divided by the sum of the weights, so `amplitude` is a bound that nothing exceeds. Octaves finer than two cells
//!   are faded out without changing the divisor: a finer grid shows the same land with more detail.
//! - Gradients may have any angle instead of one of eight or twelve, each octave is turned against the others, and its lattice is
//!   moved by a fraction of a cell: no direction adds up, and no point is zero in all octaves.
//! - On wrapping rims every octave repeats with the extent, without a seam in value or slope.
//!
//! # Layers
//! Makes a new field from its parameters and the seed of its step.

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
