//! Mask of ridges or hollows.
//!
//! # Equations
//! `R` as for `mask_height`, `r` radius of a ring of eight cells.
//! 1. `c = (h - mean of the ring) / r`: how far a place stands out of its surroundings, as a slope; negative in hollows.
//! 2. `m = R(from, to, c)`, with `-c` for hollows; `1 - m` with `invert`.
//!
//! # Source
//! The topographic position of a place, in a discrete form of the Laplacian.

use super::super::check;
use super::{cells, looked_at, rise};
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Error, Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What stands out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Shape {
    /// Ridges and peaks.
    #[default]
    Convex,
    /// Valleys and hollows.
    Concave,
}

/// 1 on ridges, or in hollows, 0 elsewhere: wind-swept crests, or places where snow and soil gather.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MaskCurvature {
    /// The layer that is looked at.
    #[schemars(length(min = 1, max = 64))]
    pub of: String,
    /// Ridges or hollows.
    pub shape: Shape,
    /// How far a place must stand out before the mask begins, relative to the distance over which that is measured.
    #[schemars(range(min = -10.0, max = 10.0), extend("unit" = "1"))]
    pub from: f32,
    /// How far it must stand out for the full mask.
    #[schemars(range(min = -10.0, max = 10.0), extend("unit" = "1"))]
    pub to: f32,
    /// Distance over which the curvature is measured, as a share of the grid's longer side; at least a cell.
    #[schemars(range(min = 0.0, max = 0.5), extend("unit" = "1"))]
    pub scale: f32,
    /// Distance over which the curvature is measured in metres. 0 takes `scale` instead.
    #[schemars(range(min = 0.0, max = 1e6), extend("unit" = "m"))]
    pub scale_m: f32,
    /// 0 where it would be 1, and 1 where it would be 0.
    pub invert: bool,
}

impl Default for MaskCurvature {
    fn default() -> Self {
        Self {
            of: "height".into(),
            shape: Shape::Convex,
            from: 0.02,
            to: 0.15,
            scale: 0.01,
            scale_m: 0.0,
            invert: false,
        }
    }
}

impl Generator for MaskCurvature {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let g = site.grid;
        let land = looked_at(self, site, &self.of)?;
        let (nx, ny) = cells(&g, self.scale, self.scale_m);
        let (nx, ny) = (nx as isize, ny as isize);
        // The diagonal cells of a ring are sqrt(1/2) as far along both axes.
        let diagonal = |n: isize| ((n as f64 * std::f64::consts::FRAC_1_SQRT_2).round() as isize).max(1);
        let (mx, my) = (diagonal(nx), diagonal(ny));
        let radius_m = 0.5 * (nx as f64 * g.cell_x_m + ny as f64 * g.cell_y_m);
        let sign = if self.shape == Shape::Convex { 1.0 } else { -1.0 };
        let factor = (sign / radius_m) as f32;
        Field::from_rows(g.width, site.rows.clone(), site.control, |y, row| {
            let at = |dy: isize| land.row(g.wrap_y(y as isize + dy));
            let [north, north_m, here, south_m, south] = [-ny, -my, 0, my, ny].map(at);
            for (x, v) in row.iter_mut().enumerate() {
                let column = |dx: isize| g.wrap_x(x as isize + dx);
                let (west, east, west_m, east_m) = (column(-nx), column(nx), column(-mx), column(mx));
                let ring = ((north[x] + south[x]) + (here[west] + here[east]))
                    + ((north_m[west_m] + south_m[east_m]) + (north_m[east_m] + south_m[west_m]));
                let inside = rise(self.from, self.to, (here[x] - 0.125 * ring) * factor);
                *v = if self.invert { 1.0 - inside } else { inside };
            }
        })
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("mask_curvature", self)?;
        if self.to < self.from {
            let reason = format!("{} is below `from`, {}; to turn the mask round set `invert`", self.to, self.from);
            return Err(Error::BadParameter { owner: "mask_curvature".into(), field: "to".into(), reason });
        }
        Ok(())
    }

    fn reach(&self, grid: &Grid) -> Reach {
        Reach::Rows(cells(grid, self.scale, self.scale_m).1)
    }

    fn reads(&self) -> Vec<&str> {
        vec![&self.of]
    }
}
