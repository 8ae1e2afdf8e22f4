//! Midpoint displacement: a coarse lattice of random heights is refined by halves, and each level is displaced less.
//!
//! # Equations
//! `u_l` uniform within -1..=1, `S` the blend.
//! 1. `h_0 = start u_0`, `h_l = S h_(l-1) + roughness^l u_l`.
//! 2. `S`: a new point takes 9/16 of the nearest old one, 3/16 of each of two and 1/16 of the fourth.
//! 3. The sum is divided by its bound, `start + roughness / (1 - roughness)`. Hurst exponent `H = -log2 roughness`.
//!
//! # Source
//! Fournier, Fussell and Carpenter 1982; the points of each level are the middles of squares after Miller 1986.
//!
//! # Differences
//! The classical diamond-square algorithm interpolates linearly and leaves the old points where they are, which shows as creases
//! along the axes and as peaks at the points of coarse levels. Here all points are displaced; repeated, the blend is a quadratic
//! B-spline, which has no creases. The limit is looked up at the cells, so the grid may have any size, and on a wrapping rim the
//! lattice is a ring.

use super::subdivide::{Axis, Blend, Level, Random, cells_m, surface};
use super::{check, scale_m};
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Midpoint displacement (diamond-square): rough land from a coarse lattice of random heights.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DiamondSquare {
    /// Distance of the start heights as a share of the grid's longer side. 1 starts with one square, 0.1 with ten by ten
    /// heights, which makes many hills of the same size.
    #[schemars(range(min = 0.0001, max = 10.0), extend("unit" = "1"))]
    pub scale: f32,
    /// Distance of the start heights in metres. 0 takes `scale` instead.
    #[schemars(range(min = 0.0, max = 1e7), extend("unit" = "m"))]
    pub scale_m: f32,
    /// What remains of the random range from one level to the next, half as large one: 0.3 makes downs, 0.5 mountains, 0.7
    /// rubble.
    #[schemars(range(min = 0.0, max = 0.95), extend("unit" = "1"))]
    pub roughness: f32,
    /// Range of the start heights, relative to that of the level after them at a roughness of 1.
    #[schemars(range(min = 0.0, max = 16.0), extend("unit" = "1"))]
    pub start: f32,
    /// Height that nothing exceeds above and below the offset. The standard deviation is a fifth to a sixth of it.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub amplitude: f32,
    /// Added to the heights.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub offset: f32,
}

impl Default for DiamondSquare {
    fn default() -> Self {
        Self { scale: 0.3, scale_m: 0.0, roughness: 0.5, start: 1.0, amplitude: 2000.0, offset: 0.0 }
    }
}

impl DiamondSquare {
    fn levels(&self, g: &Grid) -> Vec<Level> {
        let (extent, cell) = (<[f64; 2]>::from(g.extent_m()), cells_m(g));
        let spacing_m = scale_m(g, self.scale, self.scale_m);
        let mut lattice =
            [(0, g.rim.x), (1, g.rim.y)].map(|(a, edge)| Axis::new(extent[a], edge, spacing_m.max(cell[a]), 0.5));
        let bound = self.start + self.roughness / (1.0 - self.roughness);
        let unit = if bound > 0.0 { self.amplitude / bound } else { 0.0 };
        let mut levels = vec![Level { lattice: lattice.clone(), range: unit * self.start }];
        let mut range = unit;
        // As near to the cells as halving comes.
        let coarse = |lattice: &[Axis; 2], a: usize| lattice[a].spacing_m > std::f64::consts::SQRT_2 * cell[a];
        while coarse(&lattice, 0) || coarse(&lattice, 1) {
            lattice = [0, 1].map(|a| if coarse(&lattice, a) { lattice[a].halved() } else { lattice[a].clone() });
            range *= self.roughness;
            levels.push(Level { lattice: lattice.clone(), range });
        }
        levels
    }
}

impl Generator for DiamondSquare {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let mut field = surface(site, &self.levels(&site.grid), Blend::Linear, Random::Uniform)?;
        field.map_in_place(|h| self.offset + h);
        Ok(field)
    }

    fn bytes_per_cell(&self, _grid: &Grid) -> usize {
        8
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("diamond_square", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
