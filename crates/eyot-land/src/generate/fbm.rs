//! Fractal noise: hills upon hills, each octave finer and lower than the one before.
//!
//! # Equations
//! `n_o` noise of octave `o` within -1..=1, looked up at places in metres; `g` gain.
//! 1. `h = offset + amplitude * sum(g^o n_o) / sum(g^o)`.
//! 2. Octave `o` has features of the size `scale / lacunarity^o`.
//! 3. With `warp`: `n_o` is looked up at `p + warp * scale * (u, v)`, where `u` and `v` are two further noises of up to 4 octaves.
//!
//! Both bases have a unit gradient at each lattice point, at an angle that a hash of the point chooses, and are zero there.
//! `perlin`: a square lattice; in a cell the four planes through the corners are blended with the fade `6 t^5 - 15 t^4 + 10 t^3`.
//! `simplex`: a lattice of equilateral triangles; each corner within reach adds `(3/4 - r^2)^4` times its plane.
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

use super::noise::{Basis, Noise, Sum};
use super::{check, scale_m};
use eyot_core::isa::Isa;
use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fractal noise: hills upon hills.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fbm {
    /// The noise that is summed.
    pub basis: Basis,
    /// Noises that are summed. Few give smooth hills; octaves finer than the grid cost and change nothing.
    #[schemars(range(min = 1, max = 16), extend("unit" = "1"))]
    pub octaves: u32,
    /// Size of the largest features as a share of the grid's longer side: about the distance from a hill to the next valley.
    #[schemars(range(min = 0.0001, max = 10.0), extend("unit" = "1"))]
    pub scale: f32,
    /// Size of the largest features in metres. 0 takes `scale` instead.
    #[schemars(range(min = 0.0, max = 1e7), extend("unit" = "m"))]
    pub scale_m: f32,
    /// How many times smaller the features of an octave are than those of the one before.
    #[schemars(range(min = 1.1, max = 4.0), extend("unit" = "1"))]
    pub lacunarity: f32,
    /// Height of an octave relative to the one before. 0.5 is the classic; larger is rougher, at 1 all are equally high.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub gain: f32,
    /// Height that nothing exceeds above and below the offset. With the default gain the
    /// standard deviation is a third of it with simplex noise, a fifth with Perlin's.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub amplitude: f32,
    /// Added to the noise.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub offset: f32,
    /// Displaces the places at which the noise is looked up by up to this many feature sizes, which bends and folds the
    /// hills. 0 leaves them straight, above 1 they turn to marble.
    #[schemars(range(min = 0.0, max = 4.0), extend("unit" = "1"))]
    pub warp: f32,
}

impl Default for Fbm {
    fn default() -> Self {
        Self {
            basis: Basis::Simplex,
            octaves: 8,
            scale: 0.25,
            scale_m: 0.0,
            lacunarity: 2.0,
            gain: 0.5,
            amplitude: 300.0,
            offset: 0.0,
            warp: 0.0,
        }
    }
}

impl Generator for Fbm {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        check("fbm", self)?;
        let noise = Noise {
            basis: self.basis,
            sum: Sum::Fbm,
            octaves: self.octaves,
            scale_m: scale_m(&site.grid, self.scale, self.scale_m),
            lacunarity: f64::from(self.lacunarity),
            gain: f64::from(self.gain),
            seed: site.seed,
        };
        let strength_m = f64::from(self.warp) * noise.scale_m;
        let mut field = noise.warped_field(strength_m, &site.grid, Isa::best(), site.control)?;
        field.map_in_place(|n| self.offset + self.amplitude * n);
        Ok(field)
    }
}
