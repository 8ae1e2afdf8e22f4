//! A crater: what is higher than a level is folded down (filter).
//!
//! # Equations
//! `L` level in metres, `D = |h - L|`, `c` half the height of the rounded crest.
//! 1. `h' = L - D`, so ground at the level above goes to the level below: `h' = 2 L - h` where `h > L`, else `h' = h`.
//! 2. Where `D < c`: `h' = L - (D^2 / c + c) / 2`, a parabola that meets both sides with their slope; the crest sinks by `c / 2`.
//! 3. `h' = max(h', L - depth)` where `h > L`: a flat floor.
//!
//! # Source
//! A fold at a level, as in the height-map literature; the rounded crest and the floor are ours.
//!
//! # Differences
//! A sharp fold leaves a razor's edge along the whole crest, which erosion turns into needles; `crest_m` takes it away.

use super::check;
use eyot_core::process::{Around, Generator, Reach, Site};
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Folds the land above a level down, so that a summit becomes a crater or the lagoon of an atoll.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Crater {
    /// The level as a share of the highest value; 1 leaves everything, 0.5 puts the floor of the crater at 0.
    #[schemars(range(min = -2.0, max = 1.0), extend("unit" = "1"))]
    pub level: f32,
    /// The level in metres. 0 takes `level` instead.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub level_m: f32,
    /// Half the height of the zone below and above the level in which the crest is rounded, so that it is no razor's edge;
    /// the crest sinks by half of this. 0 folds sharply.
    #[schemars(range(min = 0.0, max = 2000.0), extend("unit" = "m"))]
    pub crest_m: f32,
    /// The crater is at most this deep below the level; deeper down its floor is flat.
    #[schemars(range(min = 0.0, max = 12000.0), extend("unit" = "m"))]
    pub depth_m: f32,
}

impl Default for Crater {
    fn default() -> Self {
        Self { level: 0.8, level_m: 0.0, crest_m: 0.0, depth_m: 12000.0 }
    }
}

/// `level - |h - level|`, the point of `|.|` replaced by a parabola that meets it with the same slope at +-crest.
#[inline(always)]
fn fold(h: f32, level: f32, crest: f32) -> f32 {
    let d = (h - level).abs();
    if d < crest {
        level - 0.5 * (d * d / crest + crest)
    } else if h > level {
        2.0 * level - h
    } else {
        h
    }
}

impl Generator for Crater {
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let level = if self.level_m == 0.0 { self.level * base.min_max().1 } else { self.level_m };
        let base = Around::new(site, self.reach(&site.grid), base)?;
        Field::from_rows(site.grid.width, site.rows.clone(), site.control, |y, row| {
            for (v, &h) in row.iter_mut().zip(base.row(y)) {
                let floor = if h > level { level - self.depth_m } else { f32::NEG_INFINITY };
                *v = fold(h, level, self.crest_m).max(floor);
            }
        })
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("crater", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        // A share of the highest value needs the highest value.
        if self.level_m == 0.0 { Reach::Whole } else { Reach::Cell }
    }

    fn is_filter(&self) -> bool {
        true
    }
}
