//! Rock cycle: deposits that rest harden, stage by stage, and lose half of their thickness each time.
//!
//! # Equations
//! `s = h - r` loose ground on the rock, `n_1 .. n_6` the layers `new_rock_1` to `new_rock_6`, `a_0` the age of the loose ground and
//! `a_1 .. a_5` those of new rock, `T` years of a turn.
//! 1. Ground is disturbed where the height above the beds changed by more than `disturbance` since the last turn. Its uppermost
//!    material that is there has then the age 0; all others grow older by `T`.
//! 2. What has rested for `wait 4^k` years in stage `k` hardens to the next one and loses the share `compaction` of its thickness:
//!    `n_(k+1) += (1 - compaction) n_k`, `h -= compaction n_k`, `n_k = 0`.
//! 3. What joins a stage shares its age: `a = a n / (n + joined)`.
//!
//! # Source
//! The stages regolith, sand, sandstone, limestone, schist, marble, granite with waiting times that grow as powers of four and
//! thickness that halves are those of a teaching model of the rock cycle, made to be watched and not measured: six stages last 1365 `wait`.
//!
//! # Differences
//! - What joins a stage makes it younger in proportion instead of lying above it as a bed of its own, so that a column needs no more
//!   than one bed of each stage and their order is always that of hardness.
//! - Only what lies uppermost can be disturbed.
//!
//! # Layers
//! Reads `bed_datum` (m); reads and writes `height`, `bedrock`, `new_rock_1` to `new_rock_6` (m), which the process `strata` with `new_rock`
//! makes, `rested_0` to `rested_5` (yr) and `rested_height` (m).
//!
//! # Limits
//! Stable for all parameters.
//!
//! # Conserves
//! Ground with what compaction takes, in the ledger (`tests/it/rock_cycle.rs`).

use eyot_core::given::Given;
use eyot_core::layer::known::{BEDROCK, HEIGHT};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, SECONDS_PER_YEAR, check_ranges};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, TallyUnit, read};
use eyot_core::{Grid, LayerSpec, Result, given, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::strata::{BED_DATUM, NEW_ROCK};

const fn rested(name: &'static str) -> LayerSpec {
    LayerSpec::new(name, "yr", "Time for which this stage of the rock cycle has rested", (0.0, 1e12))
}
/// How long each stage has rested.
pub const RESTED: [LayerSpec; 6] = [
    rested("rested_0"),
    rested("rested_1"),
    rested("rested_2"),
    rested("rested_3"),
    rested("rested_4"),
    rested("rested_5"),
];
/// Where the ground lay at the last turn.
pub const RESTED_HEIGHT: LayerSpec = LayerSpec::new(
    "rested_height",
    "m",
    "Height above the beds' datum at the last turn of the rock cycle",
    (-1e6, 1e6),
);
const DISTURBED: LayerSpec =
    LayerSpec::new("disturbed", "1", "1 where something moves what lies uppermost", (0.0, 1.0));

const COMPACTED: LayerSpec =
    LayerSpec::new("compacted", "m", "Thickness that hardening took in this turn", (0.0, 12000.0));

/// Deposits that rest become sand, sandstone, limestone, schist, marble and granite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RockCycle {
    /// Years from one turn to the next.
    #[schemars(range(min = 0.001, max = 100000000.0), extend("unit" = "yr"))]
    pub years_per_turn: f32,
    /// Years that loose ground rests before it becomes sand; each further stage takes four times as long as the one before.
    #[schemars(range(min = 0.001, max = 1000000000.0), extend("unit" = "yr"))]
    pub wait: f32,
    /// Share of its thickness that a stage loses when it hardens.
    #[schemars(range(min = 0.0, max = 0.99), extend("unit" = "1"))]
    pub compaction: f32,
    /// Change of height between two turns that disturbs what lies uppermost.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub disturbance: f32,
}

impl Default for RockCycle {
    fn default() -> Self {
        Self { years_per_turn: 1000.0, wait: 1000.0, compaction: 0.5, disturbance: 0.01 }
    }
}

impl Process for RockCycle {
    fn layers(&self) -> Vec<LayerUse> {
        let mut layers = vec![HEIGHT.changed(0.0), BEDROCK.changed(-12000.0), BED_DATUM.read(0.0)];
        layers.extend(NEW_ROCK.map(|s| s.changed(0.0)));
        layers.extend(RESTED.map(|s| s.changed(0.0)));
        // The first turn finds everything disturbed, and begins to count.
        layers.push(RESTED_HEIGHT.changed(1e6));
        layers
    }

    fn needs(&self) -> Vec<&'static str> {
        // Without new rock what hardens would be lost in the beds.
        vec!["new_rock_1"]
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("rock_cycle", self)
    }

    fn seconds_per_step(&self, _grid: &Grid) -> Option<f64> {
        Some(f64::from(self.years_per_turn) * SECONDS_PER_YEAR)
    }

    fn plan(&self, _moment: &Moment, plan: &mut Plan) {
        [&DISTURBED, &COMPACTED].into_iter().for_each(|s| plan.scratch(s));
        let mut p = HardenParams::<Given> {
            years: given!(plan, self.years_per_turn),
            wait: given!(plan, self.wait),
            kept: 1.0 - given!(plan, self.compaction),
            disturbance: given!(plan, self.disturbance),
        };
        let mut next = || {
            let now = p;
            p.wait = p.wait * 16.0;
            now
        };
        plan.push_given::<HardenUpper>(next());
        plan.push_given::<HardenMiddle>(next());
        plan.push_given::<HardenLower>(next());
    }
}

rule_params! {
    /// Parameters of the three rules, each of which lets two stages harden.
    pub struct HardenParams {
        /// Years of a turn, yr.
        years,
        /// Years that the first of two stages rests; the second takes four times as long, yr.
        wait,
        /// Share of the thickness that is left, 1.
        kept,
        /// Change of height that disturbs, m.
        disturbance,
    }
}

/// A stage: its thickness, m, and its age, yr.
#[derive(Clone, Copy)]
struct Stage<R> {
    thickness: R,
    age: R,
}

/// What a turn did to a stage.
struct Turn<R> {
    /// 1 where something moves what lies uppermost, and that is none of those before.
    disturbed: R,
    hardened: R,
    lost: R,
}

/// Ground thinner than this is not seen, m.
const SEEN: f32 = 0.001;

/// Equations (1) to (3) for a stage that rests for `wait` years and becomes the next one.
#[inline(always)]
fn harden<R: Real>(p: &HardenParams<R>, wait: R, this: &mut Stage<R>, next: &mut Stage<R>, disturbed: R) -> Turn<R> {
    let (zero, one) = (R::of(0.0), R::of(1.0));
    let there = R::of(SEEN).lt(this.thickness).one();
    // What is not there has no age.
    let age = there * ((this.age + p.years) * (one - disturbed));
    let ripe = there * (one - age.lt(wait).one());
    let hardened = ripe * this.thickness;
    let joins = p.kept * hardened;
    let both = next.thickness + joins;
    // What joins is as old as nothing once the next stage has grown older in this turn.
    let shared = (next.age + p.years) * (next.thickness / both.max(R::of(1e-9))) - p.years;
    *this = Stage { thickness: this.thickness - hardened, age: (one - ripe) * age };
    *next = Stage { thickness: both, age: zero.lt(joins).pick(shared, next.age) };
    Turn { disturbed: disturbed * (one - there), hardened, lost: hardened - joins }
}

const fn hardened(account: &'static str) -> Tally {
    let meaning = "What hardened to this stage, before it lost thickness";
    Tally { account, unit: TallyUnit::Thickness, sign: 0, meaning }
}
const COMPACTION: Tally = Tally {
    account: "ground.compacted",
    unit: TallyUnit::Thickness,
    sign: -1,
    meaning: "Thickness that hardening took",
};

/// Loose ground and the first stage harden.
pub struct HardenUpper;

impl Rule for HardenUpper {
    const NAME: &'static str = "rock_cycle_upper";
    const READS: &'static [Read] = &[
        read("height", 0),
        read("bedrock", 0),
        read("bed_datum", 0),
        read("rested_height", 0),
        read("rested_0", 0),
        read("new_rock_1", 0),
        read("rested_1", 0),
        read("new_rock_2", 0),
        read("rested_2", 0),
    ];
    const WRITES: &'static [&'static str] =
        &["height", "bedrock", "rested_0", "new_rock_1", "rested_1", "new_rock_2", "rested_2", "disturbed"];
    const TALLIES: &'static [Tally] = &[hardened("rock.hardened_1"), hardened("rock.hardened_2"), COMPACTION];
    type Params = HardenParams<()>;
    type Out<R: Real> = [R; 8];
    type Sums<R: Real> = [R; 3];

    #[inline(always)]
    fn cell<R: Real>(p: &HardenParams<R>, c: &impl Cell<R>) -> ([R; 8], [R; 3]) {
        let (height, bedrock) = (c.here(0), c.here(1));
        let moved = p.disturbance.lt(((height - c.here(2)) - c.here(3)).abs()).one();
        let mut loose = Stage { thickness: height - bedrock, age: c.here(4) };
        let mut first = Stage { thickness: c.here(5), age: c.here(6) };
        let mut second = Stage { thickness: c.here(7), age: c.here(8) };
        let a = harden(p, p.wait, &mut loose, &mut first, moved);
        // All of the loose ground or nothing hardens, so that what is left lies on the rock to the bit.
        let ground = (height - a.lost).no_contract();
        let rock = R::of(0.0).lt(a.hardened).pick(ground, bedrock);
        let b = harden(p, R::of(4.0) * p.wait, &mut first, &mut second, a.disturbed);
        let [ground, rock] = sunk(ground, rock, b.lost);
        let out = [ground, rock, loose.age, first.thickness, first.age, second.thickness, second.age, b.disturbed];
        (out, [a.hardened, b.hardened, height - ground])
    }
}

/// The second and the third stage harden.
pub struct HardenMiddle;

impl Rule for HardenMiddle {
    const NAME: &'static str = "rock_cycle_middle";
    const READS: &'static [Read] = &[
        read("new_rock_2", 0),
        read("rested_2", 0),
        read("new_rock_3", 0),
        read("rested_3", 0),
        read("new_rock_4", 0),
        read("rested_4", 0),
        read("disturbed", 0),
    ];
    const WRITES: &'static [&'static str] =
        &["new_rock_2", "rested_2", "new_rock_3", "rested_3", "new_rock_4", "rested_4", "disturbed", "compacted"];
    const TALLIES: &'static [Tally] = &[hardened("rock.hardened_3"), hardened("rock.hardened_4")];
    type Params = HardenParams<()>;
    type Out<R: Real> = [R; 8];
    type Sums<R: Real> = [R; 2];

    #[inline(always)]
    fn cell<R: Real>(p: &HardenParams<R>, c: &impl Cell<R>) -> ([R; 8], [R; 2]) {
        let mut upper = Stage { thickness: c.here(0), age: c.here(1) };
        let mut middle = Stage { thickness: c.here(2), age: c.here(3) };
        let mut lower = Stage { thickness: c.here(4), age: c.here(5) };
        let a = harden(p, p.wait, &mut upper, &mut middle, c.here(6));
        let b = harden(p, R::of(4.0) * p.wait, &mut middle, &mut lower, a.disturbed);
        let out = [
            upper.thickness,
            upper.age,
            middle.thickness,
            middle.age,
            lower.thickness,
            lower.age,
            b.disturbed,
            a.lost + b.lost,
        ];
        (out, [a.hardened, b.hardened])
    }
}

/// The fourth and the fifth stage harden; the last one stays as it is. Where the ground lies then is kept.
pub struct HardenLower;

impl Rule for HardenLower {
    const NAME: &'static str = "rock_cycle_lower";
    const READS: &'static [Read] = &[
        read("height", 0),
        read("bedrock", 0),
        read("bed_datum", 0),
        read("new_rock_4", 0),
        read("rested_4", 0),
        read("new_rock_5", 0),
        read("rested_5", 0),
        read("new_rock_6", 0),
        read("disturbed", 0),
        read("compacted", 0),
    ];
    const WRITES: &'static [&'static str] =
        &["height", "bedrock", "new_rock_4", "rested_4", "new_rock_5", "rested_5", "new_rock_6", "rested_height"];
    const TALLIES: &'static [Tally] = &[hardened("rock.hardened_5"), hardened("rock.hardened_6"), COMPACTION];
    type Params = HardenParams<()>;
    type Out<R: Real> = [R; 8];
    type Sums<R: Real> = [R; 3];

    #[inline(always)]
    fn cell<R: Real>(p: &HardenParams<R>, c: &impl Cell<R>) -> ([R; 8], [R; 3]) {
        let height = c.here(0);
        let mut upper = Stage { thickness: c.here(3), age: c.here(4) };
        let mut lower = Stage { thickness: c.here(5), age: c.here(6) };
        let mut last = Stage { thickness: c.here(7), age: R::of(0.0) };
        let a = harden(p, p.wait, &mut upper, &mut lower, c.here(8));
        let b = harden(p, R::of(4.0) * p.wait, &mut lower, &mut last, a.disturbed);
        let [ground, rock] = sunk(height, c.here(1), c.here(9) + (a.lost + b.lost));
        let out =
            [ground, rock, upper.thickness, upper.age, lower.thickness, lower.age, last.thickness, ground - c.here(2)];
        (out, [a.hardened, b.hardened, height - ground])
    }
}

/// Ground and rock below it, `lost` metres lower.
#[inline(always)]
fn sunk<R: Real>(height: R, bedrock: R, lost: R) -> [R; 2] {
    // By what the height really sinks by, so that nothing loose comes or goes by rounding.
    let ground = (height - lost).no_contract();
    [ground, bedrock - (height - ground)]
}
