//! Seabed smoothing: waves and currents level loose ground under the sea.
//!
//! # Equations
//! 1. `h' = h + rate / 4 sum over 4 neighbours of (h_n - h)`, over pairs of cells that both lie under the sea and of which
//!    neither carries reef limestone nor lies on a rim: cells on the rim stay as they are. With `rate = 1` and all neighbours under
//!    the sea this is the mean of the four.
//! 2. By rock each pair moves `min(1, E)` of that, with `E` the layer `erodibility` at the higher cell: waves move what is loose, and
//!    wear rock by its kind.
//!
//! # Source
//! The mean of the four neighbours (Jacobi), as height-map editors smooth.
//!
//! # Differences
//! - Replacing a cell by the mean of its neighbours, land included, makes ground out of nothing along the shore. Exchanging between pairs conserves it.
//! - A rate of 1 leaves checkerboards undamped (their factor is -1), so the range ends at 0.9.
//!
//! # Layers
//! Reads and writes `height` (m); reads `limestone` (m), and `erodibility` (1) by rock.
//!
//! # Limits
//! Stable for every rate in the range.
//!
//! # Conserves
//! Ground with what rounding of heights makes or loses, which is in the ledger (`ground.rounded`; `tests/it/reef.rs`).

use super::ends;
use eyot_core::layer::known::{ERODIBILITY, HEIGHT, LIMESTONE};
use eyot_core::ledger::known::GROUND_ROUNDED;
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, read};
use eyot_core::rule_params;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Waves and currents level loose ground under the sea.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Seabed {
    /// How much of the difference to the neighbours' mean goes in a step.
    #[schemars(range(min = 0.0, max = 0.9), extend("unit" = "1", "between_cells" = true))]
    pub rate: f32,
    /// Is rock worn by its kind, as the layer `erodibility` has it, which `strata` writes? Off, all ground counts as loose.
    pub by_rock: bool,
}

impl Default for Seabed {
    fn default() -> Self {
        Self { rate: 0.2, by_rock: false }
    }
}

impl Process for Seabed {
    fn layers(&self) -> Vec<LayerUse> {
        let mut layers = vec![HEIGHT.changed(0.0), LIMESTONE.read(0.0)];
        if self.by_rock {
            layers.push(ERODIBILITY.read(1.0));
        }
        layers
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let [first_x, last_x] = ends(moment.grid.width, moment.grid.rim.x);
        let [first_y, last_y] = ends(moment.grid.height, moment.grid.rim.y);
        let (share, sea) = (0.25 * self.rate, moment.sea_level_m as f32);
        let p = LevelParams { share, sea, first_x, last_x, first_y, last_y };
        if self.by_rock {
            plan.push::<Level<true>>(p);
        } else {
            plan.push::<Level>(p);
        }
    }
}

rule_params! {
    /// Parameters of [`Level`].
    pub struct LevelParams {
        /// Share of the difference that moves between two cells, 1.
        share,
        /// Level of the sea, m.
        sea,
        /// First column; before all columns where the rim wraps.
        first_x,
        /// Last column; behind all columns where the rim wraps.
        last_x,
        /// First row.
        first_y,
        /// Last row.
        last_y,
    }
}

/// Equation (1), with `BY_ROCK` (2).
pub struct Level<const BY_ROCK: bool = false>;

/// What the rule reads; the last one only by rock.
const LEVEL: [Read; 3] = [read("height", 1), read("limestone", 1), read("erodibility", 1)];

impl<const BY_ROCK: bool> Rule for Level<BY_ROCK> {
    const NAME: &'static str = if BY_ROCK { "seabed_level_by_rock" } else { "seabed_level" };
    const READS: &'static [Read] = if BY_ROCK { &LEVEL } else { LEVEL.split_at(2).0 };
    const WRITES: &'static [&'static str] = &["height"];
    const TALLIES: &'static [Tally] = &[GROUND_ROUNDED];
    type Params = LevelParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &LevelParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 1]) {
        let x = pull::<BY_ROCK, R>(p, c, 1, 0) + pull::<BY_ROCK, R>(p, c, -1, 0);
        let y = pull::<BY_ROCK, R>(p, c, 0, 1) + pull::<BY_ROCK, R>(p, c, 0, -1);
        let gain = (p.share * loose(p, c, 0, 0) * (x + y)).no_contract();
        let levelled = (c.here(0) + gain).no_contract();
        ([levelled], [(levelled - c.here(0)) - gain])
    }
}

#[inline(always)]
fn pull<const BY_ROCK: bool, R: Real>(p: &LevelParams<R>, c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    let drop = c.at(0, dx, dy) - c.here(0);
    let pull = drop * loose(p, c, dx, dy);
    if BY_ROCK {
        let giver = drop.lt(R::of(0.0)).pick(c.here(2), c.at(2, dx, dy));
        return pull * giver.clamp(R::of(0.0), R::of(1.0));
    }
    pull
}

/// 1 under the sea where no limestone covers the ground and no rim is, else 0.
#[inline(always)]
fn loose<R: Real>(p: &LevelParams<R>, c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    let (x, y) = (c.x() + R::of(dx as f32), c.y() + R::of(dy as f32));
    let inner_x = p.first_x.lt(x).one() * x.lt(p.last_x).one();
    let inner_y = p.first_y.lt(y).one() * y.lt(p.last_y).one();
    let under = c.at(0, dx, dy).lt(p.sea).one();
    c.at(1, dx, dy).gt(R::of(0.01)).pick(R::of(0.0), under * (inner_x * inner_y))
}
