//! Mask of a band of slopes.
//!
//! # Equations
//! `R` as for `mask_height`, `e` half of `edge`, angles as tangents, `d` the distance over which the slope is measured.
//! 1. `g = sqrt(((h_east - h_west) / 2 d)^2 + ((h_south - h_north) / 2 d)^2)`.
//! 2. `m = R(from - e, from + e, g) (1 - R(to - e, to + e, g))`, without the second factor if `to` is 90; `1 - m` with `invert`.
//!
//! # Source
//! Central differences.

use super::super::check;
use super::{cells, looked_at, rise};
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Error, Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use eyot_core::real::Real;

/// 1 where the land is as steep as a band says, 0 elsewhere: bare rock, or meadows.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MaskSlope {
    /// The layer that is looked at.
    #[schemars(length(min = 1, max = 64))]
    pub of: String,
    /// Slope at which the band begins.
    #[schemars(range(min = 0.0, max = 89.0), extend("unit" = "degree"))]
    pub from: f32,
    /// Slope at which it ends; 90 never.
    #[schemars(range(min = 0.0, max = 90.0), extend("unit" = "degree"))]
    pub to: f32,
    /// Angle over which the mask fades at both ends, half of it inside the band.
    #[schemars(range(min = 0.0, max = 45.0), extend("unit" = "degree"))]
    pub edge: f32,
    /// Distance over which the slope is measured, as a share of the grid's longer side; at least a cell.
    #[schemars(range(min = 0.0, max = 0.5), extend("unit" = "1"))]
    pub scale: f32,
    /// Distance over which the slope is measured in metres. 0 takes `scale` instead.
    #[schemars(range(min = 0.0, max = 1e6), extend("unit" = "m"))]
    pub scale_m: f32,
    /// 0 where it would be 1, and 1 where it would be 0.
    pub invert: bool,
}

impl Default for MaskSlope {
    fn default() -> Self {
        Self { of: "height".into(), from: 30.0, to: 90.0, edge: 10.0, scale: 0.004, scale_m: 0.0, invert: false }
    }
}

/// Tangent of an angle, clamped to 0..=89.9 degrees.
fn tangent(degrees: f32) -> f32 {
    let a = degrees.clamp(0.0, 89.9).to_radians();
    Real::sin(a) / Real::cos(a)
}

impl Generator for MaskSlope {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let g = site.grid;
        let land = looked_at(self, site, &self.of)?;
        let half = 0.5 * self.edge;
        let [low0, low1, high0, high1] =
            [self.from - half, self.from + half, self.to - half, self.to + half].map(tangent);
        let (nx, ny) = cells(&g, self.scale, self.scale_m);
        let (nx, ny) = (nx as isize, ny as isize);
        Field::from_rows(g.width, site.rows.clone(), site.control, |y, row| {
            let at = |y: isize| g.wrap_y(y);
            let y = y as isize;
            let (north, here, south) = (land.row(at(y - ny)), land.row(at(y)), land.row(at(y + ny)));
            // Beyond closed and open rims the border cell stands in, nearer by what is missing.
            let span = |a: usize, b: usize, n: isize| if b > a { (b - a) as f64 } else { 2.0 * n as f64 };
            let dy = (span(at(y - ny), at(y + ny), ny) * g.cell_y_m) as f32;
            for (x, v) in row.iter_mut().enumerate() {
                let (west, east) = (g.wrap_x(x as isize - nx), g.wrap_x(x as isize + nx));
                let dx = (span(west, east, nx) * g.cell_x_m) as f32;
                let (a, b) = ((here[east] - here[west]) / dx, (south[x] - north[x]) / dy);
                let slope = (a * a + b * b).sqrt();
                let inside =
                    rise(low0, low1, slope) * if self.to >= 90.0 { 1.0 } else { 1.0 - rise(high0, high1, slope) };
                *v = if self.invert { 1.0 - inside } else { inside };
            }
        })
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("mask_slope", self)?;
        if self.to < self.from {
            let reason = format!("{} is below `from`, {}; for all but a band set `invert`", self.to, self.from);
            return Err(Error::BadParameter { owner: "mask_slope".into(), field: "to".into(), reason });
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
