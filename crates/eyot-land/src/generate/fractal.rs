//! Parameters that all generators made of noise share.

use super::noise::{Basis, Noise, Sum};
use super::scale_m;
use eyot_core::isa::Isa;
use eyot_core::process::Site;
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which noise, how large, and how its octaves follow each other.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Octaves {
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
}

impl Default for Octaves {
    fn default() -> Self {
        Self { basis: Basis::Simplex, octaves: 8, scale: 0.25, scale_m: 0.0, lacunarity: 2.0, gain: 0.5 }
    }
}

impl Octaves {
    /// The noise on this grid.
    pub(super) fn noise(&self, sum: Sum, grid: &Grid, seed: u64) -> Noise {
        Noise {
            basis: self.basis,
            sum,
            octaves: self.octaves,
            scale_m: scale_m(grid, self.scale, self.scale_m),
            lacunarity: f64::from(self.lacunarity),
            gain: f64::from(self.gain),
            seed,
            ..Noise::default()
        }
    }
}

/// A sum of octaves as land.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Fractal {
    /// The octaves.
    #[serde(flatten)]
    pub noise: Octaves,
    /// Height that nothing exceeds above the offset and, unless the noise is ridged, below it.
    /// With the default gain the standard deviation is a third of it with simplex noise, a fifth with Perlin's.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub amplitude: f32,
    /// Added to the noise.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub offset: f32,
    /// Displaces the places at which the noise is looked up by up to this many feature sizes, which bends and folds the
    /// land. 0 leaves it straight, above 1 it turns to marble.
    #[schemars(range(min = 0.0, max = 4.0), extend("unit" = "1"))]
    pub warp: f32,
}

impl Default for Fractal {
    fn default() -> Self {
        Self { noise: Octaves::default(), amplitude: 300.0, offset: 0.0, warp: 0.0 }
    }
}

impl Fractal {
    /// `offset + amplitude noise`.
    pub(super) fn land(&self, sum: Sum, site: &Site<'_>) -> Result<Field> {
        let noise = self.noise.noise(sum, &site.grid, site.seed);
        let strength_m = f64::from(self.warp) * noise.scale_m;
        let mut field = noise.warped_field(strength_m, &site.grid, site.rows.clone(), Isa::best(), site.control)?;
        field.map_in_place(|n| self.offset + self.amplitude * n);
        Ok(field)
    }
}
