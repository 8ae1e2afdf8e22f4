//! A ramp: a plane that rises in one direction.
//!
//! # Equations
//! 1. `h = low + (high - low) s` with `s` from 0 to 1 along the direction, over the grid's extent in that direction.

use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Result, math};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A plane that rises in one direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Ramp {
    /// Height where the ramp begins.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub low: f32,
    /// Height where it ends.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub high: f32,
    /// Compass direction in which it rises: 0 north, 90 east.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub direction: f32,
}

impl Default for Ramp {
    fn default() -> Self {
        Self { low: 0.0, high: 500.0, direction: 0.0 }
    }
}

impl Generator for Ramp {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        let g = site.grid;
        let (w, h) = g.extent_m();
        let angle = self.direction.to_radians();
        let (east, north) = (f64::from(math::sin(angle)), f64::from(math::cos(angle)));
        let half = 0.5 * (w * east.abs() + h * north.abs());
        Ok(Field::from_fn(g.width, g.height, |x, y| {
            let along =
                ((x as f64 + 0.5) * g.cell_x_m - 0.5 * w) * east - ((y as f64 + 0.5) * g.cell_y_m - 0.5 * h) * north;
            let s = (0.5 * (along / half + 1.0)) as f32;
            self.low + (self.high - self.low) * s
        }))
    }
}
