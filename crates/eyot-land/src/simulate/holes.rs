//! Holes: missing cells of an imported height map as an open rim, over which water and ground leave.
//!
//! # Equations
//! 1. Where `missing > 1/2`: `h' = f`, `d' = 0` and `s' = 0`, with `f` the height that was filled in, `d` the water and `s` the sediment.
//!
//! # Source
//! Ours: what an open rim does to the cells beyond it, for cells inside the grid.
//!
//! # Layers
//! Reads `missing` (1), which an import of a file with missing cells makes; reads and writes `height`, `water` and `sediment` (m). Keeps
//! the heights that were filled in as `hole_floor` (m).
//!
//! # Differences
//! List it in `simulate` after the processes that move water and ground. Without it missing cells stay land like other land, filled in
//! from around. The filled surface is kept to the bit, and what the other processes see next to a hole is that surface, dry: water leaves
//! over it as over a sill.
//!
//! # Limits
//! Stable for any state. Stream power and drainage find their ways over the filled surface, as they do without it: only what they change
//! in those cells is taken back.
//!
//! # Conserves
//! What leaves has accounts: `water.drained`, and `ground.holes` for ground and sediment (test `holes_are_an_open_rim`).

use eyot_core::layer::known::{HEIGHT, MISSING, SEDIMENT, WATER};
use eyot_core::ledger::known::DRAINED;
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, TallyUnit, read};
use eyot_core::{LayerSpec, Result, World, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Start value of the layer below: the floor is not known yet.
const UNKNOWN: f32 = 12_000.0;
/// Heights that were filled in where a height map has no value.
pub const HOLE_FLOOR: LayerSpec =
    LayerSpec::new("hole_floor", "m", "Height of the ground when its holes began to be held", (-12000.0, 12000.0));

/// Makes the missing cells of an imported height map an open rim: water and ground that reach them leave, and they keep their height.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Holes {}

impl Process for Holes {
    fn layers(&self) -> Vec<LayerUse> {
        vec![
            HEIGHT.changed(0.0),
            MISSING.read(0.0),
            WATER.changed(0.0),
            SEDIMENT.changed(0.0),
            HOLE_FLOOR.changed(UNKNOWN),
        ]
    }

    fn needs(&self) -> Vec<&'static str> {
        vec!["missing"]
    }

    fn prepare(&self, world: &mut World) -> Result<()> {
        if !world.layer(&HOLE_FLOOR.name)?.field.iter().any(|f| f >= UNKNOWN) {
            return Ok(());
        }
        let height = world.layer(&HEIGHT.name)?.field.clone();
        let floor = &mut world.layer_mut(&HOLE_FLOOR.name)?.field;
        for (floor, height) in floor.rows_mut().zip(height.rows()) {
            for (f, h) in floor.iter_mut().zip(height).filter(|(f, _)| **f >= UNKNOWN) {
                *f = *h;
            }
        }
        Ok(())
    }

    fn plan(&self, _: &Moment, plan: &mut Plan) {
        plan.push::<Hold>(HoldParams { half: 0.5 });
    }
}

rule_params! {
    /// Parameters of [`Hold`].
    pub struct HoldParams {
        /// Mark from which on a cell is missing, 1.
        half,
    }
}

/// Equation (1).
pub struct Hold;

impl Rule for Hold {
    const NAME: &'static str = "holes_hold";
    const READS: &'static [Read] =
        &[read("height", 0), read("missing", 0), read("water", 0), read("sediment", 0), read("hole_floor", 0)];
    const WRITES: &'static [&'static str] = &["height", "water", "sediment"];
    const TALLIES: &'static [Tally] = &[
        DRAINED,
        Tally {
            account: "ground.holes",
            unit: TallyUnit::Thickness,
            sign: -1,
            meaning: "Ground and sediment that left through missing cells, less what was dug out of these",
        },
    ];
    type Params = HoldParams<()>;
    type Out<R: Real> = [R; 3];
    type Sums<R: Real> = [R; 2];

    #[inline(always)]
    fn cell<R: Real>(p: &HoldParams<R>, c: &impl Cell<R>) -> ([R; 3], [R; 2]) {
        let [height, water, sediment, floor] = [c.here(0), c.here(2), c.here(3), c.here(4)];
        let (zero, gone) = (R::of(0.0), p.half.lt(c.here(1)));
        let left = (height - floor) + sediment;
        (
            [gone.pick(floor, height), gone.pick(zero, water), gone.pick(zero, sediment)],
            [gone.pick(water, zero), gone.pick(left, zero)],
        )
    }
}
