//! A cone, with a straight, concave or convex flank and an apex that may be rounded off.
//!
//! # Equations
//! `r` distance from the centre over `radius`, `p` exponent, `a` apex.
//! 1. `h = height (1 - r^p)` for `r < 1`, 0 outside.
//! 2. Within the apex, `r < a`: `h = height (1 - a^p + p a^p (1 - (r / a)^2) / 2)`, a paraboloid with the flank's height and slope
//!    at `r = a`.
//!
//! # Source
//! Elementary geometry.
//!
//! # Layers
//! Makes a new field from its parameters; random numbers are not used.

use super::check;
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::real::Real;
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A cone, the start of a volcano.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Cone {
    /// Height of the top above the base. Default: a volcanic island of middling size.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub height: f32,
    /// Distance from the centre to the foot, as a share of the grid's shorter side. 0.5 touches the rim.
    #[schemars(range(min = 0.001, max = 10.0), extend("unit" = "1"))]
    pub radius: f32,
    /// Shape of the flank: 1 is straight, below 1 concave like a stratovolcano, above 1 a shield.
    #[schemars(range(min = 0.05, max = 16.0), extend("unit" = "1"))]
    pub exponent: f32,
    /// Centre as shares of width and height, from the north-west corner.
    #[schemars(inner(range(min = -10.0, max = 11.0)), extend("unit" = "1"))]
    pub centre: [f32; 2],
    /// Share of the radius over which the apex is rounded off (a paraboloid that meets the flank with the same slope);
    /// 0 leaves the tip, 0.1 takes away the needle that erosion would otherwise make of it.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub apex: f32,
}

impl Default for Cone {
    fn default() -> Self {
        Self { height: 900.0, radius: 0.42, exponent: 1.0, centre: [0.5, 0.5], apex: 0.0 }
    }
}

impl Cone {
    /// Height at the distance `r` from the centre, in radii.
    fn flank(&self, r: f32) -> f32 {
        let a = self.apex;
        if r >= 1.0 {
            0.0
        } else if r < a {
            // Same height and slope at r = a as the flank: 1 - a^p + (a^2 - r^2) p a^(p - 2) / 2.
            let at = power(a, self.exponent);
            self.height * (1.0 - at + 0.5 * self.exponent * at * (1.0 - (r / a) * (r / a)))
        } else {
            self.height * (1.0 - power(r, self.exponent))
        }
    }
}

/// r^p, exactly r for p = 1.
fn power(r: f32, p: f32) -> f32 {
    if p == 1.0 { r } else { Real::pow(r, p) }
}

impl Generator for Cone {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let g = site.grid;
        let (w_m, h_m) = g.extent_m();
        let radius_m = f64::from(self.radius) * w_m.min(h_m);
        let centre = (f64::from(self.centre[0]) * w_m, f64::from(self.centre[1]) * h_m);
        Field::from_rows(g.width, site.rows.clone(), site.control, |y, row| {
            let dy = (y as f64 + 0.5) * g.cell_y_m - centre.1;
            for (x, v) in row.iter_mut().enumerate() {
                let dx = (x as f64 + 0.5) * g.cell_x_m - centre.0;
                *v = self.flank(((dx * dx + dy * dy).sqrt() / radius_m) as f32);
            }
        })
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("cone", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
