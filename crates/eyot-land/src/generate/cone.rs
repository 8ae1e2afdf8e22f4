//! A cone: `h = height (1 - (r / radius)^exponent)` inside the radius, 0 outside.

use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Result, math};
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
    /// Centre as shares of width (from the west) and height (from the north).
    #[schemars(inner(range(min = -10.0, max = 10.0)), extend("unit" = "1"))]
    pub centre: [f32; 2],
}

impl Default for Cone {
    fn default() -> Self {
        Self { height: 900.0, radius: 0.42, exponent: 1.0, centre: [0.5, 0.5] }
    }
}

impl Generator for Cone {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        let g = site.grid;
        let (w_m, h_m) = g.extent_m();
        let radius_m = f64::from(self.radius) * w_m.min(h_m);
        let centre = (f64::from(self.centre[0]) * w_m, f64::from(self.centre[1]) * h_m);
        Ok(Field::from_fn(g.width, g.height, |x, y| {
            let dx = (x as f64 + 0.5) * g.cell_x_m - centre.0;
            let dy = (y as f64 + 0.5) * g.cell_y_m - centre.1;
            let r = (dx.hypot(dy) / radius_m) as f32;
            if r < 1.0 { self.height * (1.0 - math::pow(r, self.exponent)) } else { 0.0 }
        }))
    }
}
