//! Soaking: standing water softens the rock below it, and what is loose under it levels out.
//!
//! # Equations
//! `h` height, `r` surface of the bedrock, `s = h - r` loose ground, `w` depth of fresh water, `d` that of all water, of the sea, too,
//! `E` the layer `erodibility`.
//! 1. Water stands where `d >= depth`, where `|w - w0| <= change` since the step before (as much flows in as out), and where the surface
//!    of no neighbouring water of that depth lies higher or lower by more than `slope` times the distance.
//! 2. Under it `r' = r - rate E e^(-s / cover)`: the height stays, and what was rock is loose.
//! 3. Of two neighbours under standing water the higher gives the lower `min(k D, m s)`, with `D` the difference of heights, `s` its loose
//!    ground, `k = level / 12` for neighbours that share an edge and half of it for diagonal ones, and `m` 1/12 and 1/24.
//!
//! # Source
//! Stava, Benes, Brisbin and Krivanek 2008: water that stands soaks into the uppermost layer, makes regolith of it down to a depth that the
//! material decides, and levels the bottom.
//!
//! # Differences
//! - There water stands where inflow and outflow differ by less than a threshold, which is also true of a river in balance. Here its
//!   surface has to be level, too.
//! - There rock is soaked down to a depth at once; here a little in each step, ever slower as loose ground covers it.
//! - The water that soaks in stays in the lake: it would be a few per mille of it. Ground that moves lifts the water on it, which the
//!   process that moves the water evens out.
//!
//! # Layers
//! Reads `water` (m) and `erodibility` (1); reads and writes `height` and `bedrock` (m), which the process `strata` makes. Keeps the depth
//! of fresh water that it saw last as `soak_water` (m), and what it softened as `soaked` (m), until the process `strata` with `soaked` has
//! taken that from new rock and beds.
//!
//! # Limits
//! Stable for every `level` within 0..=1: the shares of the 8 neighbours sum to `level / 2`. What it calls still depends on the waves that
//! the process which moves the water leaves in a lake: after rain has ended they die out with its friction.
//!
//! # Conserves
//! Ground, with what rounding of heights makes or loses (`ground.rounded`). Rock that became loose is reported as `rock.soaked`
//! (`tests/it/soak.rs`).

use crate::strata::SOAKED;
use eyot_core::given;
use eyot_core::layer::known::{BEDROCK, ERODIBILITY, HEIGHT, WATER};
use eyot_core::ledger::known::GROUND_ROUNDED;
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, TallyUnit, read};
use eyot_core::{LayerSpec, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Standing water softens rock, and the ground of lakes becomes level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Soak {
    /// Depth from which on water counts.
    #[schemars(range(min = 0.001, max = 1000.0), extend("unit" = "m"))]
    pub depth: f32,
    /// By how much the depth of standing fresh water changes at most between two steps of this process.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "m"))]
    pub change: f32,
    /// How steep the surface of standing water is at most, as a tangent. Rivers are steeper.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1", "between_cells" = true))]
    pub slope: f32,
    /// Bare rock of erodibility 1 that becomes loose in a step.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "m"))]
    pub rate: f32,
    /// Loose ground of this thickness slows that to a third.
    #[schemars(range(min = 0.01, max = 100.0), extend("unit" = "m"))]
    pub cover: f32,
    /// How much of the unevenness of loose ground goes in a step. 1 is the stable limit.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1", "between_cells" = true))]
    pub level: f32,
    /// Does the sea count as standing water?
    pub sea: bool,
}

impl Default for Soak {
    fn default() -> Self {
        Self { depth: 0.2, change: 0.01, slope: 0.002, rate: 0.001, cover: 0.5, level: 0.2, sea: true }
    }
}

/// The water that was seen last.
pub const SOAK_WATER: LayerSpec =
    LayerSpec::new("soak_water", "m", "Depth of fresh water when it was last asked whether it stands", (0.0, 24000.0));
const STILL: LayerSpec = LayerSpec::new("still", "1", "1 where water stands", (0.0, 1.0)).empty_outside();
/// Height of the sea where there is none.
const NO_SEA: f32 = -1e30;

impl Process for Soak {
    fn layers(&self) -> Vec<LayerUse> {
        vec![
            HEIGHT.changed(0.0),
            WATER.read(0.0),
            BEDROCK.changed(-12000.0),
            ERODIBILITY.read(1.0),
            SOAK_WATER.changed(0.0),
            SOAKED.changed(0.0),
        ]
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let (dx, dy) = (moment.grid.cell_x_m as f32, moment.grid.cell_y_m as f32);
        plan.scratch(&STILL);
        let find = FindParams {
            depth: given!(plan, self.depth),
            change: given!(plan, self.change),
            level_x: (self.slope * dx).into(),
            level_y: (self.slope * dy).into(),
            sea: if self.sea { moment.sea_level_m as f32 } else { NO_SEA }.into(),
        };
        plan.push_given::<Find>(find);
        plan.push_given::<Soften>(SoftenParams {
            rate: given!(plan, self.rate),
            per_cover: 1.0 / given!(plan, self.cover),
            level: (self.level / 12.0).into(),
            share: (1.0 / 12.0).into(),
        });
    }
}

rule_params! {
    /// Parameters of [`Find`].
    pub struct FindParams {
        /// Depth from which on water counts, m.
        depth,
        /// Largest change of the depth of standing water, m.
        change,
        /// Largest difference of its surface to an eastern or western neighbour, m.
        level_x,
        /// To a northern or southern one, m.
        level_y,
        /// Level of the sea, m; far below the ground where it does not count.
        sea,
    }
}

/// Equation (1): where water stands.
pub struct Find;

impl Rule for Find {
    const NAME: &'static str = "soak_find";
    const READS: &'static [Read] = &[read("height", 1), read("water", 1), read("soak_water", 0)];
    const WRITES: &'static [&'static str] = &["soak_water", "still"];
    type Params = FindParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &FindParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 0]) {
        let zero = R::of(0.0);
        let water = c.here(1);
        let level_x = level(p, c, 1, 0, p.level_x) * level(p, c, -1, 0, p.level_x);
        let level_y = level(p, c, 0, 1, p.level_y) * level(p, c, 0, -1, p.level_y);
        let steady = p.change.lt((water - c.here(2)).abs()).pick(zero, level_x * level_y);
        let still = depth(p, c, 0, 0).lt(p.depth).pick(zero, steady).named("(1) still");
        ([water, still], [])
    }
}

/// Depth of fresh and salt water, m.
#[inline(always)]
fn depth<R: Real>(p: &FindParams<R>, c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    (p.sea - c.at(0, dx, dy)).positive() + c.at(1, dx, dy)
}

/// 1 unless the water of a neighbour lies higher or lower by more than `most`.
#[inline(always)]
fn level<R: Real>(p: &FindParams<R>, c: &impl Cell<R>, dx: isize, dy: isize, most: R) -> R {
    let (zero, one) = (R::of(0.0), R::of(1.0));
    let surface = c.here(0).max(p.sea) + c.here(1);
    let other = c.at(0, dx, dy).max(p.sea) + c.at(1, dx, dy);
    let tilted = most.lt((other - surface).abs()).pick(zero, one);
    depth(p, c, dx, dy).lt(p.depth).pick(one, tilted)
}

rule_params! {
    /// Parameters of [`Soften`].
    pub struct SoftenParams {
        /// Bare rock that becomes loose in a step, m.
        rate,
        /// `1 / cover`, 1/m.
        per_cover,
        /// Share of a difference of heights that moves between neighbours that share an edge, 1.
        level,
        /// Share of the loose ground that can go to one of them, 1.
        share,
    }
}

/// Equations (2) and (3).
pub struct Soften;

impl Rule for Soften {
    const NAME: &'static str = "soak_soften";
    const READS: &'static [Read] =
        &[read("height", 1), read("bedrock", 1), read("still", 1), read("erodibility", 0), read("soaked", 0)];
    const WRITES: &'static [&'static str] = &["height", "bedrock", "soaked"];
    const TALLIES: &'static [Tally] = &[
        Tally {
            account: "rock.soaked",
            unit: TallyUnit::Thickness,
            sign: 0,
            meaning: "Bedrock that standing water made loose",
        },
        GROUND_ROUNDED,
    ];
    type Params = SoftenParams<()>;
    type Out<R: Real> = [R; 3];
    type Sums<R: Real> = [R; 2];

    #[inline(always)]
    fn cell<R: Real>(p: &SoftenParams<R>, c: &impl Cell<R>) -> ([R; 3], [R; 2]) {
        let (height, rock, still) = (c.here(0), c.here(1), c.here(2));
        let loose = (height - rock).positive();
        let soaked = still * p.rate * c.here(3).positive() * (-(loose * p.per_cover)).exp();
        let softened = (rock - soaked).named("(2) rock");
        let one = R::of(1.0);
        // Opposite neighbours are added first, so that mirrored worlds stay mirrored to the bit.
        let x = comes(p, c, 1, 0, one) + comes(p, c, -1, 0, one);
        let y = comes(p, c, 0, 1, one) + comes(p, c, 0, -1, one);
        let half = R::of(0.5);
        let d = (comes(p, c, 1, 1, half) + comes(p, c, -1, -1, half))
            + (comes(p, c, -1, 1, half) + comes(p, c, 1, -1, half));
        let gain = (still * ((x + y) + d)).no_contract().named("(3) gain");
        let levelled = (height + gain).no_contract().named("(3) levelled");
        // By what the rock really sank.
        let sunk = rock - softened;
        ([levelled, softened, c.here(4) + sunk], [sunk, (levelled - height) - gain])
    }
}

/// Equation (3): what comes from a neighbour, below 0 if it goes there. Both cells compute the same.
#[inline(always)]
fn comes<R: Real>(p: &SoftenParams<R>, c: &impl Cell<R>, dx: isize, dy: isize, part: R) -> R {
    let (here, there) = (c.here(0), c.at(0, dx, dy));
    let from_there = here.lt(there);
    let drop = (there - here).abs();
    let loose = from_there.pick(there - c.at(1, dx, dy), here - c.here(1)).positive();
    let moved = part * (p.level * drop).min(p.share * loose) * c.at(2, dx, dy);
    from_there.pick(moved, R::of(0.0) - moved)
}
