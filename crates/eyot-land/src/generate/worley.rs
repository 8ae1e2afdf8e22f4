//! Cellular noise: distances to points that are strewn over the land, one in each square of a lattice.
//!
//! # Equations
//! `F1`, `F2` distance to the nearest and second nearest point, in squares of the lattice; a point lies up to `jitter / 2` from
//! the middle of its square along each axis.
//! 1. `h = offset + amplitude F / F_max`, where `F` is `F1`, `F2` or `F2 - F1`, looked up at displaced places as for `fbm`.
//! 2. `F_max = (1 + jitter) / sqrt(2)` for `F1`, `2 - jitter / 2` for the others.
//!
//! # Source
//! Worley 1996.
//!
//! # Differences
//! One point in each square instead of a Poisson number of them: no gaps and no clusters, and sixteen squares around a place are
//! enough.

use super::noise::{Basis, Noise};
use super::{check, scale_m};
use eyot_core::isa::Isa;
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Distance {
    /// To the nearest point: round pits, sharp ridges between them.
    F1,
    /// To the second nearest point: leaf-like facets.
    F2,
    /// Second nearest minus nearest: plates with cracks where two points are equally near (Voronoi).
    #[default]
    #[serde(rename = "f2_f1")]
    F2MinusF1,
}

/// Cells around strewn points: plates, cracks, pits or, with a negative amplitude, cones.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Worley {
    /// Which distance is the height.
    pub distance: Distance,
    /// Distance between points as a share of the grid's longer side.
    #[schemars(range(min = 0.0001, max = 10.0), extend("unit" = "1"))]
    pub scale: f32,
    /// Distance between points in metres. 0 takes `scale` instead.
    #[schemars(range(min = 0.0, max = 1e7), extend("unit" = "m"))]
    pub scale_m: f32,
    /// How far a point may lie from the middle of its square: 0 is a chessboard, 1 anywhere in the square.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub jitter: f32,
    /// Height at a distance of 1.5 lattice squares (1.41 for `f1`) above the offset; at the points, or in the cracks, it is 0.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub amplitude: f32,
    /// Added to the noise.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub offset: f32,
    /// Displaces the places at which the noise is looked up by up to this many feature sizes, which bends the borders.
    #[schemars(range(min = 0.0, max = 4.0), extend("unit" = "1"))]
    pub warp: f32,
}

impl Default for Worley {
    fn default() -> Self {
        Self {
            distance: Distance::F2MinusF1,
            scale: 0.15,
            scale_m: 0.0,
            jitter: 1.0,
            amplitude: 400.0,
            offset: 0.0,
            warp: 0.25,
        }
    }
}

impl Generator for Worley {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let basis = match self.distance {
            Distance::F1 => Basis::WorleyF1,
            Distance::F2 => Basis::WorleyF2,
            Distance::F2MinusF1 => Basis::WorleyF2F1,
        };
        let scale_m = scale_m(&site.grid, self.scale, self.scale_m);
        let noise = Noise { basis, octaves: 1, scale_m, jitter: self.jitter, seed: site.seed, ..Noise::default() };
        let strength_m = f64::from(self.warp) * scale_m;
        let mut field = noise.warped_field(strength_m, &site.grid, site.rows.clone(), Isa::best(), site.control)?;
        field.map_in_place(|n| self.offset + self.amplitude * (0.5 + 0.5 * n));
        Ok(field)
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("worley", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
