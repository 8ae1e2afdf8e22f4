//! Ridged multifractal noise: crests where a noise passes zero, finer crests on them; see [`super::noise`].

use super::noise::{Basis, Noise, Sum};
use super::{check, scale_m};
use eyot_core::isa::Isa;
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Ridged multifractal noise: chains of mountains.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Ridged {
    /// The noise that is folded.
    pub basis: Basis,
    /// Noises that are summed. Octaves finer than the grid cost and change nothing.
    #[schemars(range(min = 1, max = 16), extend("unit" = "1"))]
    pub octaves: u32,
    /// Size of the largest features as a share of the grid's longer side: about the distance between crests.
    #[schemars(range(min = 0.0001, max = 10.0), extend("unit" = "1"))]
    pub scale: f32,
    /// Size of the largest features in metres. 0 takes `scale` instead.
    #[schemars(range(min = 0.0, max = 1e7), extend("unit" = "m"))]
    pub scale_m: f32,
    /// How many times smaller the features of an octave are than those of the one before.
    #[schemars(range(min = 1.1, max = 4.0), extend("unit" = "1"))]
    pub lacunarity: f32,
    /// Height of an octave relative to the one before. Larger is rougher.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub gain: f32,
    /// How much an octave's crests call for the next octave: its weight is the octave before times this, at most 1. Low
    /// values leave valleys and flanks smooth, high ones roughen everything. Default: Musgrave's.
    #[schemars(range(min = 0.0, max = 16.0), extend("unit" = "1"))]
    pub sharpness: f32,
    /// Height of the highest crest possible above the offset.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub amplitude: f32,
    /// Added to the noise: height of the deepest valley possible.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub offset: f32,
    /// Displaces the places at which the noise is looked up by up to this many feature sizes, which bends the crests.
    #[schemars(range(min = 0.0, max = 4.0), extend("unit" = "1"))]
    pub warp: f32,
}

impl Default for Ridged {
    fn default() -> Self {
        Self {
            // Simplex noise is zero at all points of its lattice, so its crests run from point to point; with Perlin it shows less.
            basis: Basis::Perlin,
            octaves: 8,
            scale: 0.35,
            scale_m: 0.0,
            lacunarity: 2.0,
            gain: 0.5,
            sharpness: 2.0,
            amplitude: 1500.0,
            offset: 0.0,
            warp: 0.0,
        }
    }
}

impl Generator for Ridged {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let noise = Noise {
            basis: self.basis,
            sum: Sum::Ridged(self.sharpness),
            octaves: self.octaves,
            scale_m: scale_m(&site.grid, self.scale, self.scale_m),
            lacunarity: f64::from(self.lacunarity),
            gain: f64::from(self.gain),
            seed: site.seed,
        };
        let strength_m = f64::from(self.warp) * noise.scale_m;
        let mut field = noise.warped_field(strength_m, &site.grid, site.rows.clone(), Isa::best(), site.control)?;
        field.map_in_place(|n| self.offset + self.amplitude * n);
        Ok(field)
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("ridged", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
