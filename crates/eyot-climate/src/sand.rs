//! Sand: running water makes it from rock, carries it downstream and drops it where it slows; heaps slump.
//!
//! # Equations
//! `g` ground, of which `s` is sand, `d` depth of water, `F` the part of `d` that leaves through a face in a step.
//! 1. Through each face `S = s min(0.002 erode |F| / (d + 0.001 m), 1/8)` from the cell that the water leaves.
//! 2. `L = clamp(0.01 slump (g - g_n), -s_n / 25, s / 25)` through each face.
//! 3. rock to sand: `0.002 erode max |F| / (1 + s / 5 m + d / 20 m)`, `max` over the four faces; 0 in the sea.
//! 4. `s' = s + inflows - outflows + (3)`; the ground changes by the inflows less the outflows.
//!
//! # Source
//! Gerteis 2017.
//!
//! # Differences
//! - The printed transport and slumping have their signs turned: sand would climb. Both are mended, and every face has
//!   one flow, so that sand is conserved.
//! - The share that water carries is that of the water that leaves, and not of a speed that has no unit.
//!
//! # Layers
//! Reads `water` (m), `flow_x`, `flow_y` (m3/s); reads and writes `height`, `sand` (m).
//!
//! # Limits
//! Stable for all values: four faces take at most two thirds of a cell's sand, and no slope turns round.
//!
//! # Conserves
//! Sand with what becomes of rock in the ledger; the ground to rounding (`tests/it/conservation.rs`).

use crate::level::{flow, out};
use crate::units::discharge_per_metre;
use crate::water::{FLOW_X, FLOW_Y};
use eyot_core::layer::known::{HEIGHT, SAND, WATER};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, check_ranges};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Side, Tally, TallyUnit, read};
use eyot_core::{Grid, Result, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Running water makes sand from rock, carries it downstream and drops it where it slows; heaps slump.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Sand {
    /// How much running water makes and carries.
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "1", "between_cells" = true))]
    pub erode: f32,
    /// How much sand slumps downhill.
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "1", "between_cells" = true))]
    pub slump: f32,
}

impl Default for Sand {
    fn default() -> Self {
        Self { erode: 1.0, slump: 1.0 }
    }
}

impl Process for Sand {
    fn layers(&self) -> Vec<LayerUse> {
        vec![HEIGHT.changed(0.0), SAND.changed(0.0), WATER.read(0.0), FLOW_X.read(0.0), FLOW_Y.read(0.0)]
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("sand", self)
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let metres = (1.0 / discharge_per_metre(&moment.grid)) as f32;
        plan.push::<Wash>(WashParams {
            carry: 0.002 * self.erode * metres,
            erode: 0.002 * self.erode * metres,
            slump: 0.01 * self.slump,
            sea: moment.sea_level_m as f32,
        });
    }
}

rule_params! {
    /// Parameters of [`Wash`].
    pub struct WashParams {
        /// Share of the sand that moves with a discharge, by the depth, m s/m3.
        carry,
        /// Rock that a discharge turns to sand, m s/m3.
        erode,
        /// Share of a difference in height that slumps, 1.
        slump,
        /// Level of the sea, m.
        sea,
    }
}

/// Equations (1) to (4).
pub struct Wash;

const GROUND: usize = 0;
const SAND_SLOT: usize = 1;
const DEPTH: usize = 2;
const X: usize = 3;
const Y: usize = 4;

impl Rule for Wash {
    const NAME: &'static str = "sand_wash";
    const READS: &'static [Read] =
        &[read("height", 1), read("sand", 1), read("water", 1), read("flow_x", 1), read("flow_y", 1)];
    const WRITES: &'static [&'static str] = &["height", "sand"];
    const TALLIES: &'static [Tally] = &[
        Tally {
            account: "sand.eroded",
            unit: TallyUnit::Thickness,
            sign: 1,
            meaning: "Rock that water turned to sand",
        },
        Tally {
            account: "sand.left",
            unit: TallyUnit::Thickness,
            sign: -1,
            meaning: "Sand that left over an open rim",
        },
        Tally {
            account: "sand.clamped",
            unit: TallyUnit::Thickness,
            sign: 1,
            meaning: "Sand added where rounding had made a thickness negative",
        },
    ];
    type Params = WashParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 3];

    #[inline(always)]
    fn cell<R: Real>(p: &WashParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 3]) {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let gain = (east(p, c, -1) - east(p, c, 0)) + (south(p, c, -1) - south(p, c, 0));
        let sand = c.here(SAND_SLOT) + gain;
        let kept = sand.positive();
        let strongest = c.here(X).abs().max(c.at(X, -1, 0).abs()).max(c.here(Y).abs().max(c.at(Y, 0, -1).abs()));
        let shelter = one + R::of(0.2) * kept + R::of(0.05) * c.here(DEPTH);
        let eroded = c.here(GROUND).lt(p.sea).pick(zero, p.erode * strongest / shelter).named("(3) eroded");
        ([c.here(GROUND) + gain, (kept + eroded).flushed()], [eroded, zero, kept - sand])
    }

    #[inline(always)]
    fn boundary_outflow<R: Real>(p: &WashParams<R>, c: &impl Cell<R>, side: Side) -> Option<[R; 3]> {
        let zero = R::of(0.0);
        Some([zero, out(side, |at| east(p, c, at), |at| south(p, c, at)), zero])
    }
}

#[inline(always)]
fn east<R: Real>(p: &WashParams<R>, c: &impl Cell<R>, at: isize) -> R {
    crossing(p, c, c.at(X, at, 0), (at, 0), (at + 1, 0))
}

#[inline(always)]
fn south<R: Real>(p: &WashParams<R>, c: &impl Cell<R>, at: isize) -> R {
    crossing(p, c, c.at(Y, 0, at), (0, at), (0, at + 1))
}

/// Equations (1) and (2) through the face between two cells.
#[inline(always)]
fn crossing<R: Real>(p: &WashParams<R>, c: &impl Cell<R>, discharge: R, a: (isize, isize), b: (isize, isize)) -> R {
    let (s, next_s) = (c.at(SAND_SLOT, a.0, a.1), c.at(SAND_SLOT, b.0, b.1));
    let forth = R::of(0.0).lt(discharge);
    let giver = forth.pick(s, next_s);
    let depth = R::of(0.0).lt(discharge).pick(c.at(DEPTH, a.0, a.1), c.at(DEPTH, b.0, b.1));
    let eighth = R::of(0.125);
    let washed = giver * (p.carry * discharge / (depth + R::of(0.001))).clamp(-eighth, eighth);
    let slump = flow(p.slump, R::of(0.04), c.at(GROUND, a.0, a.1), c.at(GROUND, b.0, b.1), s, next_s);
    washed + slump
}
