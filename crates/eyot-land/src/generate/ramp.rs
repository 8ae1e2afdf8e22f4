//! A plane that rises in one direction.
//!
//! # Equations
//! `e` unit vector of the compass direction, `p` place from the middle of the grid, `l` length of the grid's shadow on `e`.
//! 1. `h = low + (high - low) (1/2 + p . e / l)`: `low` at the rim or corner where the ramp begins, `high` where it ends.
//!
//! # Source
//! Elementary geometry.

use super::check;
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::real::Real;
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An inclined plane: the valley floor that water runs down, or a mask that fades from side to side.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Ramp {
    /// Compass direction in which the land rises: 0 north, 90 east. On a rim that wraps there is a cliff at the seam.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub direction: f32,
    /// Value at the rim or corner where the ramp begins.
    #[schemars(range(min = -1e6, max = 1e6), extend("unit" = "m"))]
    pub low: f32,
    /// Value at the rim or corner where it ends.
    #[schemars(range(min = -1e6, max = 1e6), extend("unit" = "m"))]
    pub high: f32,
}

impl Default for Ramp {
    fn default() -> Self {
        Self { direction: 0.0, low: 0.0, high: 100.0 }
    }
}

/// Eastward and southward part of a step of length 1 in a compass direction; exact for multiples of 90 degrees.
fn heading(degrees: f32) -> (f64, f64) {
    let turn = degrees.rem_euclid(360.0);
    let quarter = (turn / 90.0).floor();
    let rest = (turn - 90.0 * quarter).to_radians();
    let (s, c) = (f64::from(Real::sin(rest)), f64::from(Real::cos(rest)));
    // Clockwise from north, y to the south.
    match quarter as u32 % 4 {
        0 => (s, -c),
        1 => (c, s),
        2 => (-s, c),
        _ => (-c, -s),
    }
}

impl Generator for Ramp {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let g = site.grid;
        let (w_m, h_m) = g.extent_m();
        let (east, south) = heading(self.direction);
        // Length of the grid's shadow on the direction, and the middle of the grid at one half.
        let length = (east * w_m).abs() + (south * h_m).abs();
        let (low, rise) = (f64::from(self.low), f64::from(self.high) - f64::from(self.low));
        Field::from_rows(g.width, site.rows.clone(), site.control, |y, row| {
            let dy = (y as f64 + 0.5) * g.cell_y_m - 0.5 * h_m;
            for (x, v) in row.iter_mut().enumerate() {
                let dx = (x as f64 + 0.5) * g.cell_x_m - 0.5 * w_m;
                *v = (low + rise * (0.5 + (dx * east + dy * south) / length)) as f32;
            }
        })
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("ramp", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
