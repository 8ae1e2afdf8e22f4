//! Ice: snow and standing water freeze, glaciers flow downhill and melt into rivers, the sea wears a thin cover.
//!
//! # Equations
//! `i` thickness of ice as water, `d` water, head `H = max(g, sea) + i`, `T_f` the freezing point, on the sea
//! 5 degrees lower for the heat from below, `y` years of a step.
//! 1. `F = clamp(0.05 (H - H_n), -flow i_n, flow i)` through each face; `i1 = i - outflows + inflows`.
//! 2. freezing: on land `min(d, 0.625 m freeze y (T_f - T))`, on the sea what is missing to `sea_ice` at most; 0 where
//!    it is warmer.
//! 3. melting: `min(i1, 0.625 m melt y (T - T_f))`; 0 where it is colder. On land it becomes water.
//! 4. On the sea ice thicker than `sea_ice` breaks off.
//!
//! # Source
//! Gerteis 2017; melting in proportion to the degrees above freezing after Hock 2003.
//!
//! # Differences
//! - In the source ice freezes slower the colder it is, comes from nothing, and what it reports as melted is what
//!   remains. Here it takes its water from the ground and gives it back.
//! - It flows by the slope of its surface and not of its bed.
//! - The freezing point is -2 degrees and not -0.7 units (-4.8 degrees).
//!
//! # Layers
//! Reads `height` (m), `temperature` (degrees Celsius); reads and writes `ice`, `water` (m).
//!
//! # Limits
//! Stable for all values: four faces take at most all that a cell has.
//!
//! # Conserves
//! Ice and water together, with the sea's part and what breaks off in the ledger (`tests/it/conservation.rs`).

use crate::level::{Head, out};
use crate::temperature::TEMPERATURE;
use crate::units::{CELSIUS_AT_ZERO, ground_years_per_step};
use eyot_core::layer::known::{HEIGHT, WATER};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, check_ranges};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Side, Tally, TallyUnit, read};
use eyot_core::{Grid, LayerSpec, Result, given, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Glaciers, ice sheets and sea ice.
pub const ICE: LayerSpec =
    LayerSpec::new("ice", "m", "Thickness of ice, as the depth of its water", (0.0, 1e5)).empty_outside();

/// Snow and standing water freeze, glaciers flow downhill and melt into rivers, the sea wears a thin cover.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Ice {
    /// Temperature below which water freezes and above which ice melts (-4.8 degrees in the source).
    #[schemars(range(min = -12.0, max = 36.0), extend("unit" = "°C"))]
    pub ice_temperature: f32,
    /// How fast water freezes.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    pub freeze: f32,
    /// How fast ice melts.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    pub melt: f32,
    /// Share of the ice that flows through a face in a step at most. Little builds thick ice, much makes it run to the sea.
    #[schemars(range(min = 0.0, max = 0.25), extend("unit" = "1", "between_cells" = true))]
    pub flow: f32,
    /// Thickness of ice on the sea beyond which it breaks off.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub sea_ice: f32,
}

impl Default for Ice {
    fn default() -> Self {
        Self { ice_temperature: -2.0, freeze: 1.0, melt: 1.0, flow: 0.004, sea_ice: 2.0 }
    }
}

impl Process for Ice {
    fn layers(&self) -> Vec<LayerUse> {
        vec![HEIGHT.read(0.0), WATER.changed(0.0), ICE.changed(0.0), TEMPERATURE.read(CELSIUS_AT_ZERO)]
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("ice", self)
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let each_degree = PER_DEGREE * ground_years_per_step(&moment.grid) as f32;
        plan.push_given::<Glacier>(GlacierParams {
            freezing_point: given!(plan, self.ice_temperature),
            freeze: each_degree * given!(plan, self.freeze),
            melt: each_degree * given!(plan, self.melt),
            part: self.flow.into(),
            sea_ice: given!(plan, self.sea_ice),
            sea: (moment.sea_level_m as f32).into(),
        });
    }
}

rule_params! {
    /// Parameters of [`Glacier`].
    pub struct GlacierParams {
        /// The freezing point, degrees Celsius.
        freezing_point,
        /// Freezing of a step for each degree, m.
        freeze,
        /// Melting of a step for each degree, m.
        melt,
        /// Share that flows through a face at most, 1.
        part,
        /// Thickness on the sea at most, m.
        sea_ice,
        /// Level of the sea, m.
        sea,
    }
}

/// What freezes and melts in a year for each degree, m.
const PER_DEGREE: f32 = 0.625;
/// Heat from below keeps the sea open in so much colder air, degrees.
const SEA_WARMTH: f32 = 5.0;

/// Equations (1) to (4).
pub struct Glacier;

const ICE_SLOT: usize = 0;
const GROUND: usize = 1;

const fn thickness(account: &'static str, sign: i8, meaning: &'static str) -> Tally {
    Tally { account, unit: TallyUnit::Thickness, sign, meaning }
}

impl Rule for Glacier {
    const NAME: &'static str = "ice_glacier";
    const READS: &'static [Read] = &[read("ice", 1), read("height", 1), read("temperature", 0), read("water", 0)];
    const WRITES: &'static [&'static str] = &["ice", "water"];
    const TALLIES: &'static [Tally] = &[
        thickness("ice.frozen", 1, "Water that froze, on land and sea"),
        thickness("ice.melted", -1, "Ice that melted, on land and sea"),
        thickness("ice.calved", -1, "Ice that broke off into the sea or left over an open rim"),
        thickness("ice.clamped", 1, "Ice added where rounding had made a thickness negative"),
        thickness("water.frozen", -1, "Water on land that froze"),
        thickness("water.melted", 1, "Water from ice that melted on land"),
    ];
    type Params = GlacierParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 6];

    #[inline(always)]
    fn cell<R: Real>(p: &GlacierParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 6]) {
        let (zero, flow) = (R::of(0.0), head(p));
        let at_sea = c.here(GROUND).lt(p.sea);
        let flowed = c.here(ICE_SLOT) + ((flow.east(c, -1) - flow.east(c, 0)) + (flow.south(c, -1) - flow.south(c, 0)));
        let ice = flowed.named("(1) flowed").positive();
        let warmer = c.here(2) - (p.freezing_point - at_sea.pick(R::of(SEA_WARMTH), zero));
        let water = c.here(3);

        let wish = p.freeze * (-warmer).positive();
        let frozen = wish.min(at_sea.pick((p.sea_ice - ice).positive(), water)).named("(2) frozen");
        let melted = ice.min(p.melt * warmer.positive()).named("(3) melted");
        let left = (ice + frozen) - melted;
        let calved = at_sea.pick((left - p.sea_ice).positive(), zero).named("(4) calved");

        let (taken, given) = (at_sea.pick(zero, frozen), at_sea.pick(zero, melted));
        let sums = [frozen, melted, calved, ice - flowed, taken, given];
        ([(left - calved).flushed(), ((water - taken) + given).flushed()], sums)
    }

    #[inline(always)]
    fn boundary_outflow<R: Real>(p: &GlacierParams<R>, c: &impl Cell<R>, side: Side) -> Option<[R; 6]> {
        let (zero, flow) = (R::of(0.0), head(p));
        Some([zero, zero, out(side, |at| flow.east(c, at), |at| flow.south(c, at)), zero, zero, zero])
    }
}

/// What flows, by equation (1).
#[inline(always)]
fn head<R: Real>(p: &GlacierParams<R>) -> Head<R> {
    Head { ground: GROUND, thickness: ICE_SLOT, sea: p.sea, share: R::of(0.05), part: p.part }
}
