//! Weathering: steep rock crumbles towards its lower neighbours, but not under water.
//!
//! # Equations
//! 1. `g' = g + 0.005 strength (sum of D over 4 neighbours + 1/4 sum of D over 4 diagonal ones)`, `D = g_n - g` where
//!    `min_difference < |D| < max_difference` and both cells are dry, else 0.
//!
//! # Source
//! Gerteis 2017.
//!
//! # Differences
//! - The printed rule adds heights where differences are meant; this is what its program does.
//! - There the cell alone must be dry. Here both must be, so that both do the same and rock is conserved.
//! - It is off by default there (strength 0).
//!
//! # Layers
//! Reads `water` (m); reads and writes `height` (m).
//!
//! # Limits
//! Stable for every strength within 0..=5: the shares sum to an eighth.
//!
//! # Conserves
//! Ground, to rounding (`tests/it/conservation.rs`).

use eyot_core::layer::known::{HEIGHT, WATER};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, check_ranges};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::{Grid, Result, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Steep rock crumbles towards its lower neighbours, but not under water.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Weathering {
    /// Differences in height between neighbours that stay, because they are too small.
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m", "between_cells" = true))]
    pub min_difference: f32,
    /// Differences that stay, because so steep a wall is hard rock.
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m", "between_cells" = true))]
    pub max_difference: f32,
    /// How much crumbles (0 in the source).
    #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "1", "between_cells" = true))]
    pub strength: f32,
}

impl Default for Weathering {
    fn default() -> Self {
        Self { min_difference: 300.0, max_difference: 3000.0, strength: 0.05 }
    }
}

impl Process for Weathering {
    fn layers(&self) -> Vec<LayerUse> {
        vec![HEIGHT.changed(0.0), WATER.read(0.0)]
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("weathering", self)
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        plan.push::<Crumble>(CrumbleParams {
            share: 0.005 * self.strength,
            least: self.min_difference,
            most: self.max_difference,
            sea: moment.sea_level_m as f32,
        });
    }
}

rule_params! {
    /// Parameters of [`Crumble`].
    pub struct CrumbleParams {
        /// Share of a difference that moves, 1.
        share,
        /// Differences below stay, m.
        least,
        /// Differences above stay, m.
        most,
        /// Level of the sea, m.
        sea,
    }
}

/// Equation (1).
pub struct Crumble;

/// Water in which rock counts as covered, m.
const COVERED: f32 = 0.05;

impl Rule for Crumble {
    const NAME: &'static str = "weathering_crumble";
    const READS: &'static [Read] = &[read("height", 1), read("water", 1)];
    const WRITES: &'static [&'static str] = &["height"];
    type Params = CrumbleParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &CrumbleParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let axes = (given(p, c, 1, 0) + given(p, c, -1, 0)) + (given(p, c, 0, 1) + given(p, c, 0, -1));
        // Opposite neighbours first, so that mirrored worlds stay mirrored: a mirror swaps the brackets' members or the
        // brackets.
        let falling = given(p, c, 1, 1) + given(p, c, -1, -1);
        let rising = given(p, c, -1, 1) + given(p, c, 1, -1);
        let diagonals = R::of(0.25) * (falling + rising);
        let moved = dry(p, c, 0, 0) * (p.share * (axes + diagonals));
        ([c.here(0) + moved], [])
    }
}

#[inline(always)]
fn given<R: Real>(p: &CrumbleParams<R>, c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    let (zero, d) = (R::of(0.0), c.at(0, dx, dy) - c.here(0));
    let inside = d.abs().lt(p.most).pick(d, zero);
    dry(p, c, dx, dy) * d.abs().gt(p.least).pick(inside, zero)
}

/// 1 where neither sea nor fresh water covers the rock, else 0.
#[inline(always)]
fn dry<R: Real>(p: &CrumbleParams<R>, c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    let uncovered = c.at(1, dx, dy).lt(R::of(COVERED)).one();
    c.at(0, dx, dy).lt(p.sea).pick(R::of(0.0), uncovered)
}
