//! Terraces: heights are drawn together into steps (filter).
//!
//! # Equations
//! `n` a noise times `jitter`, `k = floor(t)`.
//! 1. `t = (h - low) / step + n`.
//! 2. `h' = low + step (k + S(t - k) - n)`, where `S` rises from 0 to 1 around one half, within `softness` of the step.
//!
//! # Source
//! A common remapping of heights; the noise that bends the steps is ours.

use super::noise::Noise;
use super::{check, scale_m};
use eyot_core::isa::Isa;
use eyot_core::math::smoothstep;
use eyot_core::process::{Around, Generator, Reach, Site};
use eyot_core::{Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Draws heights together into steps, as layers of hard rock or old shorelines do.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Terraces {
    /// Number of steps between the lowest and the highest place.
    #[schemars(range(min = 1, max = 1000), extend("unit" = "1"))]
    pub count: u32,
    /// Height of a step, counted from height 0. 0 takes `count` instead.
    #[schemars(range(min = 0.0, max = 12000.0), extend("unit" = "m"))]
    pub step_m: f32,
    /// Share of a step's height over which one tread passes into the next: 0 makes walls, 1 hardly visible waves.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub softness: f32,
    /// How much the treads rise and fall along their way, in steps. 0 makes them level.
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "1"))]
    pub jitter: f32,
    /// Distance from rise to fall as a share of the grid's longer side.
    #[schemars(range(min = 0.0001, max = 10.0), extend("unit" = "1"))]
    pub scale: f32,
    /// Distance from rise to fall in metres. 0 takes `scale` instead.
    #[schemars(range(min = 0.0, max = 1e7), extend("unit" = "m"))]
    pub scale_m: f32,
}

impl Default for Terraces {
    fn default() -> Self {
        Self { count: 8, step_m: 0.0, softness: 0.5, jitter: 0.3, scale: 0.15, scale_m: 0.0 }
    }
}

/// S: exactly 0 and 1 away from the middle.
fn tread(t: f32, softness: f32) -> f32 {
    if softness < 1e-6 { f32::from(t >= 0.5) } else { smoothstep(0.5 - 0.5 * softness, 0.5 + 0.5 * softness, t) }
}

impl Generator for Terraces {
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let (low, step) = if self.step_m > 0.0 {
            (0.0, self.step_m)
        } else {
            let (low, high) = base.min_max();
            (low, (high - low) / self.count as f32)
        };
        let base = Around::new(site, self.reach(&site.grid), base)?;
        let noise = Noise {
            octaves: 4,
            scale_m: scale_m(&site.grid, self.scale, self.scale_m),
            seed: site.seed,
            ..Noise::default()
        };
        let mut field = noise.field(&site.grid, site.rows.clone(), Isa::best(), site.control)?;
        for (y, row) in site.rows.clone().zip(field.rows_mut()) {
            for (v, &h) in row.iter_mut().zip(base.row(y)) {
                // On level ground there is nothing to step.
                *v = if step > 0.0 {
                    let n = self.jitter * *v;
                    let t = (h - low) / step + n;
                    low + step * (t.floor() + tread(t - t.floor(), self.softness) - n)
                } else {
                    h
                };
            }
        }
        Ok(field)
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("terraces", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        if self.step_m > 0.0 { Reach::Cell } else { Reach::Whole }
    }

    fn is_filter(&self) -> bool {
        true
    }
}
