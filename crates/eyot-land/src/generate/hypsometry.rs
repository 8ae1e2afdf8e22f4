//! Gives the land a planet's heights: so much of it ocean, shelves, plains and few high mountains (filter).
//!
//! # Equations
//! `r` rank of a cell among all, 0 the lowest to 1 the highest; `o` share of the ocean.
//! 1. Land, `t = (r - o) / (1 - o)`: `h = sea level + highest (0.1 t + 0.24 t^6 + 0.66 t^40)`.
//! 2. Ocean, `t = (o - r) / o`: `h = sea level - deepest (0.5 min(t / 0.12, 1)^4 + 0.18 t + 0.32 t^20)`.
//!
//! # Source
//! The share of the ocean as a quantile, which Gerteis 2017 finds by trial. The curves were fitted by eye to that of
//! the Earth: half of the land below 500 m, a twentieth above 2400 m, most of the sea floor below 2700 m.
//!
//! # Differences
//! - The source raises all land by a step at the shore. Here a shelf leads down to the deep.
//!
//! # Layers
//! Makes a new field from the ranks of the old one; equal heights take their ranks from the north-west to the south-east.

use super::check;
use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Grid, Result};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Gives the land a planet's heights: so much of it ocean, shelves, plains and few high mountains.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Hypsometry {
    /// Share of the cells below the level of the sea: 0.71 on Earth, 0.56 in the source.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub ocean: f32,
    /// Highest mountain above the sea.
    #[schemars(range(min = 0.0, max = 12000.0), extend("unit" = "m"))]
    pub highest: f32,
    /// Deepest trench below the sea.
    #[schemars(range(min = 0.0, max = 12000.0), extend("unit" = "m"))]
    pub deepest: f32,
}

impl Default for Hypsometry {
    fn default() -> Self {
        Self { ocean: 0.68, highest: 7000.0, deepest: 8000.0 }
    }
}

/// A power by plain products, which give the same bits everywhere.
fn power(t: f64, n: u32) -> f64 {
    (0..n).fold(1.0, |product, _| product * t)
}

impl Hypsometry {
    /// Height above the sea at a rank, m.
    fn height(&self, rank: f64) -> f64 {
        let ocean = f64::from(self.ocean);
        if rank >= ocean {
            let t = (rank - ocean) / (1.0 - ocean).max(1e-9);
            f64::from(self.highest) * (0.1 * t + 0.24 * power(t, 6) + 0.66 * power(t, 40))
        } else {
            let t = (ocean - rank) / ocean;
            let shelf = power((t / 0.12).min(1.0), 4);
            -f64::from(self.deepest) * (0.5 * shelf + 0.18 * t + 0.32 * power(t, 20))
        }
    }
}

impl Generator for Hypsometry {
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let values = base.to_vec();
        let mut order: Vec<u32> = (0..values.len() as u32).collect();
        order.par_sort_unstable_by(|&a, &b| values[a as usize].total_cmp(&values[b as usize]).then(a.cmp(&b)));
        let mut heights = vec![0.0; values.len()];
        for (rank, &cell) in order.iter().enumerate() {
            let share = (rank as f64 + 0.5) / values.len() as f64;
            heights[cell as usize] = (site.world.sea_level_m + self.height(share)) as f32;
        }
        Field::from_slice(base.width(), base.height(), &heights)
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("hypsometry", self)
    }

    /// Values, order and heights.
    fn bytes_per_cell(&self, _grid: &Grid) -> usize {
        16
    }

    fn is_filter(&self) -> bool {
        true
    }
}
