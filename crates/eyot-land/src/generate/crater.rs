//! Crater: what is above a level is folded down.
//!
//! # Equations
//! 1. `h' = 2 l - h` where `h > l`, with a rounded crest: `h' = l - sqrt((h - l)^2 + r^2) + r` for `h > l`.
//!
//! # Source
//! The island thesis, I4. Rounding is ours: a fold alone leaves a razor's edge.

use eyot_core::process::{Generator, Site};
use eyot_core::{Field, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Folds down what is above a level: a volcano gets its crater. A filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Crater {
    /// Level of the fold as a share of the highest point: 0.8 makes a crater, 0.4 a caldera.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub level: f32,
    /// The crater is at most this deep, as a share of the level; below lies a flat floor.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub depth: f32,
    /// Rounding of the crest, as a share of the level.
    #[schemars(range(min = 0.0, max = 0.5), extend("unit" = "1"))]
    pub round: f32,
}

impl Default for Crater {
    fn default() -> Self {
        Self { level: 0.8, depth: 1.0, round: 0.01 }
    }
}

impl Generator for Crater {
    fn generate(&self, _site: &Site<'_>, base: &Field) -> Result<Field> {
        let level = self.level * base.min_max().1;
        let (floor, r) = (level * (1.0 - self.depth), (self.round * level).abs());
        let mut out = base.clone();
        out.map_in_place(|h| {
            let above = h - level;
            if above > 0.0 { (level - ((above * above + r * r).sqrt() - r)).max(floor.min(h)) } else { h }
        });
        Ok(out)
    }

    fn is_filter(&self) -> bool {
        true
    }
}
