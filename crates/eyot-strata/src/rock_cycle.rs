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

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("rock_cycle", self)
    }

    fn seconds_per_step(&self, _grid: &Grid) -> Option<f64> {
        Some(f64::from(self.years_per_turn) * SECONDS_PER_YEAR)
    }

    fn plan(&self, _moment: &Moment, plan: &mut Plan) {
        plan.scratch(&DISTURBED);
        let mut p = HardenParams::<Given> {
            years: given!(plan, self.years_per_turn),
            wait: given!(plan, self.wait),
            kept: 1.0 - given!(plan, self.compaction),
            disturbance: given!(plan, self.disturbance),
        };
        let mut next = || {
            let now = p;
            p.wait = p.wait * 4.0;
            now
        };
        plan.push_given::<HardenLoose>(next());
        plan.push_given::<Harden<1>>(next());
        plan.push_given::<Harden<2>>(next());
        plan.push_given::<Harden<3>>(next());
        plan.push_given::<Harden<4>>(next());
        plan.push_given::<HardenLast>(next());
    }
}

rule_params! {
    /// Parameters of [`Harden`].
    pub struct HardenParams {
        /// Years of a turn, yr.
        years,
        /// Years that this stage rests, yr.
        wait,
        /// Share of the thickness that is left, 1.
        kept,
        /// Change of height that disturbs, m.
        disturbance,
    }
}

macro_rules! stage {
    ($here:literal, $age:literal, $next:literal, $next_age:literal) => {
        &[
            read("height", 0),
            read("bedrock", 0),
            read($here, 0),
            read($age, 0),
            read($next, 0),
            read($next_age, 0),
            read("disturbed", 0),
        ]
    };
}

/// What a turn does to a stage and to the next one.
struct Turn<R> {
    thickness: R,
    age: R,
    next: R,
    next_age: R,
    /// 1 where something moves what lies uppermost, and that is not this stage.
    disturbed: R,
    hardened: R,
    lost: R,
}

/// Equations (1) to (3).
#[inline(always)]
fn turn<R: Real>(p: &HardenParams<R>, thickness: R, age: R, next: R, next_age: R, disturbed: R) -> Turn<R> {
    let (zero, one) = (R::of(0.0), R::of(1.0));
    let there = R::of(SEEN).lt(thickness).one();
    let age = (age + p.years) * (one - there * disturbed);
    // What is not there has no age.
    let age = there * age;
    let ripe = there * (one - age.lt(p.wait).one());
    let hardened = ripe * thickness;
    let joins = p.kept * hardened;
    let both = next + joins;
    Turn {
        thickness: thickness - hardened,
        age: (one - ripe) * age,
        next: both,
        // What joins is as old as nothing once the next stage has grown older in this turn.
        next_age: zero.lt(joins).pick((next_age + p.years) * (next / both.max(R::of(1e-9))) - p.years, next_age),
        disturbed: disturbed * (one - there),
        hardened,
        lost: hardened - joins,
    }
}

/// Ground thinner than this is not seen, m.
const SEEN: f32 = 0.001;

const fn hardened(account: &'static str) -> [Tally; 2] {
    let unit = TallyUnit::Thickness;
    [
        Tally { account, unit, sign: 0, meaning: "What hardened to this stage, before it lost thickness" },
        Tally { account: "ground.compacted", unit, sign: -1, meaning: "Thickness that hardening took" },
    ]
}

/// Loose ground hardens to the first stage.
pub struct HardenLoose;

impl Rule for HardenLoose {
    const NAME: &'static str = "rock_cycle_loose";
    const READS: &'static [Read] = &[
        read("height", 0),
        read("bedrock", 0),
        read("rested_0", 0),
        read("new_rock_1", 0),
        read("rested_1", 0),
        read("bed_datum", 0),
        read("rested_height", 0),
    ];
    const WRITES: &'static [&'static str] = &["height", "bedrock", "rested_0", "new_rock_1", "rested_1", "disturbed"];
    const TALLIES: &'static [Tally] = &hardened("rock.hardened_1");
    type Params = HardenParams<()>;
    type Out<R: Real> = [R; 6];
    type Sums<R: Real> = [R; 2];

    #[inline(always)]
    fn cell<R: Real>(p: &HardenParams<R>, c: &impl Cell<R>) -> ([R; 6], [R; 2]) {
        let (height, bedrock) = (c.here(0), c.here(1));
        let moved = ((height - c.here(5)) - c.here(6)).abs();
        let t = turn(p, height - bedrock, c.here(2), c.here(3), c.here(4), p.disturbance.lt(moved).one());
        let ground = height - t.lost;
        // All of it or nothing hardens, so that what is left lies on the rock to the bit.
        let rock = R::of(0.0).lt(t.hardened).pick(ground, bedrock);
        ([ground, rock, t.age, t.next, t.next_age, t.disturbed], [t.hardened, height - ground])
    }
}

/// Stage `FROM`, 1 to 4, hardens to the next.
pub struct Harden<const FROM: usize>;

impl<const FROM: usize> Rule for Harden<FROM> {
    const NAME: &'static str = ["", "rock_cycle_1", "rock_cycle_2", "rock_cycle_3", "rock_cycle_4"][FROM];
    const READS: &'static [Read] = match FROM {
        1 => stage!["new_rock_1", "rested_1", "new_rock_2", "rested_2"],
        2 => stage!["new_rock_2", "rested_2", "new_rock_3", "rested_3"],
        3 => stage!["new_rock_3", "rested_3", "new_rock_4", "rested_4"],
        _ => stage!["new_rock_4", "rested_4", "new_rock_5", "rested_5"],
    };
    const WRITES: &'static [&'static str] = match FROM {
        1 => &["height", "bedrock", "new_rock_1", "rested_1", "new_rock_2", "rested_2", "disturbed"],
        2 => &["height", "bedrock", "new_rock_2", "rested_2", "new_rock_3", "rested_3", "disturbed"],
        3 => &["height", "bedrock", "new_rock_3", "rested_3", "new_rock_4", "rested_4", "disturbed"],
        _ => &["height", "bedrock", "new_rock_4", "rested_4", "new_rock_5", "rested_5", "disturbed"],
    };
    const TALLIES: &'static [Tally] = match FROM {
        1 => &hardened("rock.hardened_2"),
        2 => &hardened("rock.hardened_3"),
        3 => &hardened("rock.hardened_4"),
        _ => &hardened("rock.hardened_5"),
    };
    type Params = HardenParams<()>;
    type Out<R: Real> = [R; 7];
    type Sums<R: Real> = [R; 2];

    #[inline(always)]
    fn cell<R: Real>(p: &HardenParams<R>, c: &impl Cell<R>) -> ([R; 7], [R; 2]) {
        let (height, bedrock) = (c.here(0), c.here(1));
        let t = turn(p, c.here(2), c.here(3), c.here(4), c.here(5), c.here(6));
        let [ground, rock] = sunk(height, bedrock, t.lost);
        ([ground, rock, t.thickness, t.age, t.next, t.next_age, t.disturbed], [t.hardened, height - ground])
    }
}

/// The fifth stage hardens to the last one, which stays as it is; where the ground lies then is kept.
pub struct HardenLast;

impl Rule for HardenLast {
    const NAME: &'static str = "rock_cycle_last";
    const READS: &'static [Read] = &[
        read("height", 0),
        read("bedrock", 0),
        read("new_rock_5", 0),
        read("rested_5", 0),
        read("new_rock_6", 0),
        read("disturbed", 0),
        read("bed_datum", 0),
    ];
    const WRITES: &'static [&'static str] =
        &["height", "bedrock", "new_rock_5", "rested_5", "new_rock_6", "rested_height"];
    const TALLIES: &'static [Tally] = &hardened("rock.hardened_6");
    type Params = HardenParams<()>;
    type Out<R: Real> = [R; 6];
    type Sums<R: Real> = [R; 2];

    #[inline(always)]
    fn cell<R: Real>(p: &HardenParams<R>, c: &impl Cell<R>) -> ([R; 6], [R; 2]) {
        let (height, bedrock) = (c.here(0), c.here(1));
        let t = turn(p, c.here(2), c.here(3), c.here(4), R::of(0.0), c.here(5));
        let [ground, rock] = sunk(height, bedrock, t.lost);
        ([ground, rock, t.thickness, t.age, t.next, ground - c.here(6)], [t.hardened, height - ground])
    }
}

/// Ground and rock below it, `lost` metres lower.
#[inline(always)]
fn sunk<R: Real>(height: R, bedrock: R, lost: R) -> [R; 2] {
    // By what the height really sinks by, so that nothing loose comes or goes by rounding.
    let ground = (height - lost).no_contract();
    [ground, bedrock - (height - ground)]
}
