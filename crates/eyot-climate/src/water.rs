//! Water: rain fills rivers and lakes, which run to the sea and dry in the sun.
//!
//! # Equations
//! `g` ground, `d` depth of fresh water, head `H = max(g, sea) + d`, `P` precipitation, `y` years of a step.
//! 1. `F = clamp(levelling (H - H_n), -d_n / 4, d / 4)` through each face.
//! 2. `d1 = d - sum of outflows + sum of inflows`.
//! 3. `d' = d1 + rain P y - min(d1 + rain P y, evaporate 0.059 m y (T - from))`, the last bracket where positive. In the
//!    sea `d' = 0`.
//! 4. `flow' = flow + 0.1 (F A / t - flow)`: a moving mean of the discharge, `A` the cell's area, `t` its duration.
//!
//! # Source
//! Gerteis 2017; what a degree evaporates in a year after Holdridge 1967.
//!
//! # Differences
//! - The printed flow runs uphill and evaporation below 0 makes water. Both are mended.
//! - There, speed adds up over steps; here it is the discharge that really passes, and levelling needs no momentum of
//!   its own.
//! - The sea is where the ground is below its level. Rivers end there, so that a changed level needs no water.
//! - Ice feeds melt water in its own process; see `ice`.
//!
//! # Layers
//! Reads `height` (m), `precipitation` (mm a year), `temperature` (degrees Celsius); reads and writes `water` (m),
//! `flow_x` and `flow_y` (m3/s, on faces).
//!
//! # Limits
//! Stable for all values: four faces take at most all that a cell has.
//!
//! # Conserves
//! Water with rain, evaporation and drainage in the ledger; with `ice`, what freezes and melts (`tests/it/conservation.rs`).

use crate::humidity::PRECIPITATION;
use crate::level::{Head, out};
use crate::temperature::TEMPERATURE;
use crate::units::{CELSIUS_AT_ZERO, discharge_per_metre, ground_years_per_step};
use eyot_core::layer::known::{HEIGHT, WATER};
use eyot_core::ledger::known::{DRAINED, EVAPORATED, RAIN, WATER_CLAMPED};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, check_ranges};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Side, Tally, read};
use eyot_core::{Centering, Grid, LayerSpec, Result, given, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a year evaporates for each degree, m: Holdridge's potential evapotranspiration. Plants and soil return it before it runs.
const DRY_PER_DEGREE: f32 = 0.05893;

/// Discharge through eastern faces.
pub const FLOW_X: LayerSpec =
    LayerSpec::new("flow_x", "m3/s", "Water that flows to the east through the eastern edge", (-1e12, 1e12))
        .on(Centering::FaceX);
/// Discharge through southern faces.
pub const FLOW_Y: LayerSpec =
    LayerSpec::new("flow_y", "m3/s", "Water that flows to the south through the southern edge", (-1e12, 1e12))
        .on(Centering::FaceY);

/// Rain fills rivers and lakes, which run to the sea and dry in the sun.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Water {
    /// How much of the rain reaches the ground.
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "1"))]
    pub rain: f32,
    /// How fast water dries: 1 is 20 mm a year for each degree.
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "1"))]
    pub evaporate: f32,
    /// Temperature from which water dries (-36 degrees in the source).
    #[schemars(range(min = -60.0, max = 30.0), extend("unit" = "°C"))]
    pub evaporate_from: f32,
    /// Share of the difference between two surfaces that flows in a step. More than 0.25 makes waves.
    #[schemars(range(min = 0.0, max = 0.25), extend("unit" = "1", "between_cells" = true))]
    pub levelling: f32,
}

impl Default for Water {
    fn default() -> Self {
        Self { rain: 1.0, evaporate: 1.0, evaporate_from: 0.0, levelling: 0.2 }
    }
}

impl Process for Water {
    fn layers(&self) -> Vec<LayerUse> {
        let own = [HEIGHT.read(0.0), WATER.changed(0.0), FLOW_X.changed(0.0), FLOW_Y.changed(0.0)];
        own.into_iter().chain([PRECIPITATION.read(0.0), TEMPERATURE.read(CELSIUS_AT_ZERO)]).collect()
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("water", self)
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let years = ground_years_per_step(&moment.grid) as f32;
        plan.push_given::<Run>(RunParams {
            rain: 1e-3 * given!(plan, self.rain) * years,
            dry: DRY_PER_DEGREE * given!(plan, self.evaporate) * years,
            from: given!(plan, self.evaporate_from),
            levelling: self.levelling.into(),
            discharge: (discharge_per_metre(&moment.grid) as f32).into(),
            sea: (moment.sea_level_m as f32).into(),
        });
    }
}

rule_params! {
    /// Parameters of [`Run`].
    pub struct RunParams {
        /// Rain of a step for each mm a year, m.
        rain,
        /// Evaporation of a step for each degree, m.
        dry,
        /// Temperature from which water dries, degrees Celsius.
        from,
        /// Share of a difference that flows, 1.
        levelling,
        /// Discharge of a metre in a step, m3/s.
        discharge,
        /// Level of the sea, m.
        sea,
    }
}

/// Equations (1) to (4).
pub struct Run;

const GROUND: usize = 0;
const DEPTH: usize = 1;

impl Rule for Run {
    const NAME: &'static str = "water_run";
    const READS: &'static [Read] = &[
        read("height", 1),
        read("water", 1),
        read("flow_x", 0),
        read("flow_y", 0),
        read("precipitation", 0),
        read("temperature", 0),
    ];
    const WRITES: &'static [&'static str] = &["water", "flow_x", "flow_y"];
    const TALLIES: &'static [Tally] = &[RAIN, EVAPORATED, DRAINED, WATER_CLAMPED];
    type Params = RunParams<()>;
    type Out<R: Real> = [R; 3];
    type Sums<R: Real> = [R; 4];

    #[inline(always)]
    fn cell<R: Real>(p: &RunParams<R>, c: &impl Cell<R>) -> ([R; 3], [R; 4]) {
        let (zero, flow) = (R::of(0.0), head(p));
        let (e, s) = (flow.east(c, 0).named("(1) east"), flow.south(c, 0).named("(1) south"));
        let moved = c.here(DEPTH) + ((flow.east(c, -1) - e) + (flow.south(c, -1) - s));
        let moved = moved.named("(2) moved");
        let wet = moved.positive();
        let at_sea = c.here(GROUND).lt(p.sea);

        let rain = at_sea.pick(zero, p.rain * c.here(4));
        let thirst = p.dry * (c.here(5) - p.from).positive();
        let full = wet + rain;
        let dried = at_sea.pick(zero, full.min(thirst)).named("(3) dried");
        let depth = at_sea.pick(zero, full - dried).flushed();

        let flow_x = c.here(2) + R::of(0.1) * (p.discharge * e - c.here(2));
        let flow_y = c.here(3) + R::of(0.1) * (p.discharge * s - c.here(3));
        let drained = at_sea.pick(wet, zero);
        ([depth, flow_x.flushed(), flow_y.flushed()], [rain, dried, drained, wet - moved])
    }

    #[inline(always)]
    fn boundary_outflow<R: Real>(p: &RunParams<R>, c: &impl Cell<R>, side: Side) -> Option<[R; 4]> {
        let (zero, flow) = (R::of(0.0), head(p));
        Some([zero, zero, out(side, |at| flow.east(c, at), |at| flow.south(c, at)), zero])
    }
}

/// What flows, by equation (1).
#[inline(always)]
fn head<R: Real>(p: &RunParams<R>) -> Head<R> {
    Head { ground: GROUND, thickness: DEPTH, sea: p.sea, share: p.levelling, part: R::of(0.25) }
}
