//! Mask of a band of heights.
//!
//! # Equations
//! `R(a, b, x)` rises smoothly from 0 at `a` to 1 at `b` (`3 t^2 - 2 t^3`), `e` half of `edge`.
//! 1. `m = R(from - e, from + e, h) (1 - R(to - e, to + e, h))`; `1 - m` with `invert`.
//!
//! # Source
//! Elementary.

use super::super::check;
use super::{looked_at, rise};
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Error, Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// 1 where a layer's value lies in a band, 0 elsewhere: a snow line, a beach, a zone of forest.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MaskHeight {
    /// The layer that is looked at.
    #[schemars(length(min = 1, max = 64))]
    pub of: String,
    /// Lower end of the band.
    #[schemars(range(min = -1e6, max = 1e6), extend("unit" = "m"))]
    pub from: f32,
    /// Upper end of the band.
    #[schemars(range(min = -1e6, max = 1e6), extend("unit" = "m"))]
    pub to: f32,
    /// Height over which the mask fades at both ends, half of it inside the band.
    #[schemars(range(min = 0.0, max = 1e6), extend("unit" = "m"))]
    pub edge: f32,
    /// 0 where it would be 1, and 1 where it would be 0.
    pub invert: bool,
}

impl Default for MaskHeight {
    fn default() -> Self {
        Self { of: "height".into(), from: 100.0, to: 12000.0, edge: 50.0, invert: false }
    }
}

impl Generator for MaskHeight {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let land = looked_at(self, site, &self.of)?;
        let half = 0.5 * self.edge;
        Field::from_rows(site.grid.width, site.rows.clone(), site.control, |y, row| {
            for (v, &h) in row.iter_mut().zip(land.row(y)) {
                let inside =
                    rise(self.from - half, self.from + half, h) * (1.0 - rise(self.to - half, self.to + half, h));
                *v = if self.invert { 1.0 - inside } else { inside };
            }
        })
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("mask_height", self)?;
        if self.to < self.from {
            let reason = format!("{} is below `from`, {}; for all but a band set `invert`", self.to, self.from);
            return Err(Error::BadParameter { owner: "mask_height".into(), field: "to".into(), reason });
        }
        Ok(())
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }

    fn reads(&self) -> Vec<&str> {
        vec![&self.of]
    }
}
