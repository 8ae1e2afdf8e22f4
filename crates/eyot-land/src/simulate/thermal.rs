//! Thermal erosion: what is steeper than its talus angle slumps.
//!
//! # Equations
//! 1. `h' = h + sum over 8 neighbours of k_n (D - clamp(D, -T_n, T_n))` with `D = h_n - h`, `T_n` the talus angle's tangent
//!    times the distance, `k = rate / 12` for neighbours that share an edge and half of it for diagonal ones.
//! 2. Inverted: a cell whose largest drop `m` among its 4 neighbours is not above `T` gives `rate m / 2` to that
//!    neighbour (in equal parts if several are lowest): flats become flat and cliffs stay.
//! 3. By rock each pair moves `min(1, E)` of that, with `E` the layer `erodibility` at the cell that gives.
//!
//! # Source
//! Musgrave, Kolb and Mace 1989; the inverted form after Olsen 2004.
//!
//! # Differences
//! - Usually half the height above the lowest neighbour moves, shared among all that are too low. Here each pair
//!   exchanges only what exceeds the talus, so slopes end at the angle and not below it, one pass is enough, and both
//!   cells of a pair compute the same amount (`tests/it/thermal.rs`).
//! - By rock, hard rock comes down more slowly, at the one angle. The process `rockfall` lets each bed stand at its own.
//! - Olsen's form is applied to all cells at once and not in scanning order, which would favour one direction.
//!
//! # Layers
//! Reads and writes `height` (m); reads `erodibility` (1) by rock.
//!
//! # Limits
//! Stable for every rate within 0..=1: the shares of the 8 neighbours sum to `rate / 2`.
//!
//! # Conserves
//! Ground with what rounding of heights makes or loses, which is in the ledger (`ground.rounded`; `tests/it/thermal.rs`). Both
//! cells of a pair compute the same amount, but each adds it to another height, whose last place is lost: 7.6e-5 of the
//! volume in 20,000 steps.

use eyot_core::layer::known::{ERODIBILITY, HEIGHT};
use eyot_core::ledger::known::GROUND_ROUNDED;
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, read};
use eyot_core::rule_params;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is steeper than its talus angle slumps: scree, soft ridges, no spikes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Thermal {
    /// Steepest slope that stays: about 33 degrees for dry sand, 35 to 40 for scree, more for rock.
    #[schemars(range(min = 0.0, max = 89.0), extend("unit" = "degree", "between_cells" = true))]
    pub talus: f32,
    /// How much of the excess moves in a step. 1 is the stable limit.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1", "between_cells" = true))]
    pub rate: f32,
    /// Olsen's inverted form: flattens what is flatter than the talus angle and leaves cliffs alone.
    pub inverted: bool,
    /// Does rock move by its kind, as the layer `erodibility` has it, which `strata` writes? Off, all ground counts as loose.
    pub by_rock: bool,
}

impl Default for Thermal {
    fn default() -> Self {
        Self { talus: 36.0, rate: 0.5, inverted: false, by_rock: false }
    }
}

impl Process for Thermal {
    fn layers(&self) -> Vec<LayerUse> {
        let mut layers = vec![HEIGHT.changed(0.0)];
        if self.by_rock {
            layers.push(ERODIBILITY.read(1.0));
        }
        layers
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let (dx, dy) = (moment.grid.cell_x_m, moment.grid.cell_y_m);
        let angle = self.talus.to_radians();
        let tangent = f64::from(eyot_core::math::sin(angle) / eyot_core::math::cos(angle));
        let (stay_x, stay_y) = ((tangent * dx) as f32, (tangent * dy) as f32);
        if self.inverted {
            let p = FlattenParams { stay_x, stay_y, half_rate: 0.5 * self.rate };
            if self.by_rock {
                plan.push::<Flatten<true>>(p);
            } else {
                plan.push::<Flatten>(p);
            }
        } else {
            let stay_d = (tangent * (dx * dx + dy * dy).sqrt()) as f32;
            let p = SlumpParams { stay_x, stay_y, stay_d, rate: self.rate / 12.0, rate_d: self.rate / 24.0 };
            if self.by_rock {
                plan.push::<Slump<true>>(p);
            } else {
                plan.push::<Slump>(p);
            }
        }
    }
}

rule_params! {
    /// Parameters of [`Slump`].
    pub struct SlumpParams {
        /// Height difference to an eastern or western neighbour that stays, m.
        stay_x,
        /// To a northern or southern one, m.
        stay_y,
        /// To a diagonal one, m.
        stay_d,
        /// Share of the excess that moves between neighbours that share an edge, 1.
        rate,
        /// Share of the excess that moves between diagonal neighbours, 1.
        rate_d,
    }
}

/// Equation (1), with `BY_ROCK` (3).
pub struct Slump<const BY_ROCK: bool = false>;

/// What the rule reads; the last one only by rock.
const SLUMP: [Read; 2] = [read("height", 1), read("erodibility", 1)];

impl<const BY_ROCK: bool> Rule for Slump<BY_ROCK> {
    const NAME: &'static str = if BY_ROCK { "thermal_slump_by_rock" } else { "thermal_slump" };
    const READS: &'static [Read] = if BY_ROCK { &SLUMP } else { SLUMP.split_at(1).0 };
    const WRITES: &'static [&'static str] = &["height"];
    const TALLIES: &'static [Tally] = &[GROUND_ROUNDED];
    type Params = SlumpParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &SlumpParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 1]) {
        // Opposite neighbours are added first, so that mirrored worlds stay mirrored to the bit.
        let x = excess::<BY_ROCK, R>(c, 1, 0, p.stay_x) + excess::<BY_ROCK, R>(c, -1, 0, p.stay_x);
        let y = excess::<BY_ROCK, R>(c, 0, 1, p.stay_y) + excess::<BY_ROCK, R>(c, 0, -1, p.stay_y);
        let d = (excess::<BY_ROCK, R>(c, 1, 1, p.stay_d) + excess::<BY_ROCK, R>(c, -1, -1, p.stay_d))
            + (excess::<BY_ROCK, R>(c, -1, 1, p.stay_d) + excess::<BY_ROCK, R>(c, 1, -1, p.stay_d));
        // Rounded in turn, so that no shader compiler makes nothing of the account below.
        let gain = ((p.rate * (x + y)).no_contract() + (p.rate_d * d).no_contract()).named("(1) gain");
        let slumped = (c.here(0) + gain).no_contract().named("(1) slumped");
        ([slumped], [(slumped - c.here(0)) - gain])
    }
}

/// What the neighbour sends here, negative if it is sent there: the part of the difference beyond what stays.
#[inline(always)]
fn excess<const BY_ROCK: bool, R: Real>(c: &impl Cell<R>, dx: isize, dy: isize, stay: R) -> R {
    let d = c.at(0, dx, dy) - c.here(0);
    let excess = d - d.clamp(-stay, stay);
    if BY_ROCK {
        return excess * share(d.lt(R::of(0.0)).pick(c.here(1), c.at(1, dx, dy)));
    }
    excess
}

/// Equation (3): how much of rock of this erodibility moves.
#[inline(always)]
fn share<R: Real>(erodibility: R) -> R {
    erodibility.clamp(R::of(0.0), R::of(1.0))
}

rule_params! {
    /// Parameters of [`Flatten`].
    pub struct FlattenParams {
        /// Largest drop to an eastern or western neighbour that is flattened, m.
        stay_x,
        /// To a northern or southern one, m.
        stay_y,
        /// Share of the drop that moves, 1.
        half_rate,
    }
}

/// Equation (2), with `BY_ROCK` (3).
pub struct Flatten<const BY_ROCK: bool = false>;

/// What the rule reads; the last one only by rock.
const FLATTEN: [Read; 2] = [read("height", 2), read("erodibility", 1)];

impl<const BY_ROCK: bool> Rule for Flatten<BY_ROCK> {
    const NAME: &'static str = if BY_ROCK { "thermal_flatten_by_rock" } else { "thermal_flatten" };
    const READS: &'static [Read] = if BY_ROCK { &FLATTEN } else { FLATTEN.split_at(1).0 };
    const WRITES: &'static [&'static str] = &["height"];
    const TALLIES: &'static [Tally] = &[GROUND_ROUNDED];
    type Params = FlattenParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &FlattenParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 1]) {
        let gains = (given::<BY_ROCK, R>(p, c, -1, 0, 1, 0) + given::<BY_ROCK, R>(p, c, 1, 0, -1, 0))
            + (given::<BY_ROCK, R>(p, c, 0, -1, 0, 1) + given::<BY_ROCK, R>(p, c, 0, 1, 0, -1));
        let losses = (given::<BY_ROCK, R>(p, c, 0, 0, 1, 0) + given::<BY_ROCK, R>(p, c, 0, 0, -1, 0))
            + (given::<BY_ROCK, R>(p, c, 0, 0, 0, 1) + given::<BY_ROCK, R>(p, c, 0, 0, 0, -1));
        let gain = (gains - losses).no_contract();
        let flattened = (c.here(0) + gain).no_contract();
        ([flattened], [(flattened - c.here(0)) - gain])
    }
}

/// What the cell at (x, y) gives to its neighbour in direction (dx, dy).
#[inline(always)]
fn given<const BY_ROCK: bool, R: Real>(
    p: &FlattenParams<R>,
    c: &impl Cell<R>,
    x: isize,
    y: isize,
    dx: isize,
    dy: isize,
) -> R {
    let (zero, h) = (R::of(0.0), c.at(0, x, y));
    let (w, e) = (c.at(0, x - 1, y), c.at(0, x + 1, y));
    let (n, s) = (c.at(0, x, y - 1), c.at(0, x, y + 1));
    let lowest = w.min(e).min(n.min(s));
    let lowest_count = (lowest.lt(w).pick(zero, R::of(1.0)) + lowest.lt(e).pick(zero, R::of(1.0)))
        + (lowest.lt(n).pick(zero, R::of(1.0)) + lowest.lt(s).pick(zero, R::of(1.0)));
    let target = c.at(0, x + dx, y + dy);
    let drop = h - target;
    let stay = if dx != 0 { p.stay_x } else { p.stay_y };
    let amount = stay.lt(drop).pick(zero, p.half_rate * drop.positive() / lowest_count);
    let amount = if BY_ROCK { amount * share(c.at(1, x, y)) } else { amount };
    lowest.lt(target).pick(zero, amount)
}
