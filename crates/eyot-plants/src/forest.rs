//! Forest: groves by a cellular automaton, where the ground lets trees stand, and how large they grow.
//!
//! # Equations
//! `g` grove (0 or 1), `n` the sum of `g` over the 8 neighbours, `h` height, `z1` and `z2` the lower and the upper tree line, `u` a random
//! number of the cell.
//! 1. At the start `g = 1` where `u < share clamp((z2 - h) / belt, 0, 1)`, with `belt = 0` where `u < share`.
//! 2. In each step `g' = 0` where `n < 4`, `1 - g` where `n = 4`, `1` where `n > 4`.
//! 3. `forest = 1` where more than half of the `g'` around, with the weights 4 here, 2 across edges and 1 across corners, are 1, the slope is at
//!    most `slope`, `z1 <= h <= z2`, and neither lake, river nor sea covers the ground; else 0.
//! 4. `tree_size = min(1, (z2 - h) / fade + size)` for `z1 <= h <= z2`, else 0.
//!
//! # Source
//! A Blender add-on for mountain landscapes: a game of life (Gardner 1970) whose rule looks at the neighbours alone. Bays and clearings of
//! round groves come out of noise within some ten steps.
//!
//! # Differences
//! - There the groves end at the tree line as if cut. Here the share at the start falls within a belt below it, so that they thin out
//!   (`belt`; 0 is the source's way).
//! - There the distance to the tree line is a share of the whole range of heights. Here it is in metres (`fade`), so that trees at the same
//!   height have the same size in every landscape.
//! - There the groves are the automaton's. Its cells that flip with four neighbours leave stripes and checkerboards along clearings, which
//!   the weights of (3) clear away: both weigh just a half.
//! - Rivers are cells that drain at least `river_area`, those of which a river covers a tenth, and all that is under fresh water.
//!
//! # Layers
//! Reads `height`, `lake`, `water` (m), `drained_area` (m2), `river` (1). Keeps the automaton as `grove` (1), writes `forest` and `tree_size` (1).
//!
//! # Limits
//! `share` below a half dies out within some steps, and above two thirds closes to one forest, so that half is the least that is taken.
//! Groves are some cells wide whatever the size of a cell: the automaton is bound to the resolution.

use crate::layers::RIVER;
use eyot_core::layer::known::{DRAINED_AREA, HEIGHT, LAKE, WATER};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, check_ranges};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::{Error, Grid, LayerSpec, Result, given, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Groves by a cellular automaton, where the ground lets trees stand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Forest {
    /// Share of the cells with trees at the start. More makes fewer and smaller clearings.
    #[schemars(range(min = 0.5, max = 1.0), extend("unit" = "1"))]
    pub share: f32,
    /// Steepest ground on which trees stand.
    #[schemars(range(min = 0.0, max = 89.0), extend("unit" = "degree"))]
    pub slope: f32,
    /// Height of the lower tree line, over the sea.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub lower: f32,
    /// Height of the upper tree line, over the sea.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub upper: f32,
    /// Below the upper tree line, groves get rarer within so many metres of height.
    #[schemars(range(min = 0.0, max = 12000.0), extend("unit" = "m"))]
    pub belt: f32,
    /// Trees have their full size so many metres of height below the upper tree line.
    #[schemars(range(min = 1.0, max = 12000.0), extend("unit" = "m"))]
    pub fade: f32,
    /// Size of the smallest trees, over that of full-grown ones.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub size: f32,
    /// Fresh water of this depth keeps trees away.
    #[schemars(range(min = 0.001, max = 1000.0), extend("unit" = "m"))]
    pub wet: f32,
    /// Area that drains through a cell from which on it is a river.
    #[schemars(range(min = 1.0, max = 1e12), extend("unit" = "m2"))]
    pub river_area: f32,
}

impl Default for Forest {
    fn default() -> Self {
        Self {
            share: 0.55,
            slope: 38.0,
            lower: 2.0,
            upper: 1900.0,
            belt: 250.0,
            fade: 600.0,
            size: 0.25,
            wet: 0.3,
            river_area: 4e6,
        }
    }
}

/// The automaton.
pub const GROVE: LayerSpec =
    LayerSpec::new("grove", "1", "1 where the automaton of the process `forest` is alive, trees or not", (0.0, 1.0));
/// Where trees stand.
pub const FOREST: LayerSpec = LayerSpec::new("forest", "1", "Share of the ground that trees cover", (0.0, 1.0));
/// How large they grow.
pub const TREE_SIZE: LayerSpec =
    LayerSpec::new("tree_size", "1", "Size that trees reach here, over that of full-grown ones", (0.0, 1.0));

/// Stream of the random numbers of the start.
const START: u32 = 0x666f_7201;

impl Forest {
    /// Heights of the tree lines in the datum of the height, m.
    fn lines(&self, moment: &Moment) -> [f32; 2] {
        // Land without a sea counts from the datum.
        let sea = if moment.sea_level_m <= f64::from(HEIGHT.range.0) { 0.0 } else { moment.sea_level_m as f32 };
        [sea + self.lower, sea + self.upper]
    }
}

impl Process for Forest {
    fn layers(&self) -> Vec<LayerUse> {
        vec![
            HEIGHT.read(0.0),
            LAKE.read(0.0),
            WATER.read(0.0),
            DRAINED_AREA.read(0.0),
            RIVER.read(0.0),
            GROVE.changed(0.0),
            FOREST.written(0.0),
            TREE_SIZE.written(0.0),
        ]
    }

    fn start(&self, name: &str, moment: &Moment, plan: &mut Plan) {
        if name == GROVE.name {
            // Without a belt groves begin above the tree line, too, and are cut by (3), as in the source.
            let upper = if self.belt > 0.0 { self.lines(moment)[1] } else { f32::MAX };
            plan.push_given::<Sow>(SowParams {
                share: given!(plan, self.share),
                upper: upper.into(),
                per_belt: (1.0 / self.belt.max(1e-3)).into(),
            });
        }
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("forest", self)?;
        if self.lower >= self.upper {
            return Err(Error::BadParameter {
                owner: "forest".into(),
                field: "lower".into(),
                reason: format!(
                    "the lower tree line, at {} m, is not below the upper one, `upper`, at {} m: no tree could stand",
                    self.lower, self.upper
                ),
            });
        }
        Ok(())
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let angle = self.slope.to_radians();
        let steepest = eyot_core::math::sin(angle) / eyot_core::math::cos(angle);
        let [lower, upper] = self.lines(moment);
        plan.push::<Live>(LiveParams { four: 4.0 });
        plan.push_given::<Stand>(StandParams {
            per_2dx: (0.5 / moment.grid.cell_x_m as f32).into(),
            per_2dy: (0.5 / moment.grid.cell_y_m as f32).into(),
            steepest: (steepest * steepest).into(),
            lower: lower.into(),
            upper: upper.into(),
            per_fade: 1.0 / given!(plan, self.fade),
            size: given!(plan, self.size),
            wet: given!(plan, self.wet),
            river_area: given!(plan, self.river_area),
            sea: (moment.sea_level_m as f32).into(),
        });
    }
}

rule_params! {
    /// Parameters of [`Sow`].
    pub struct SowParams {
        /// Share of the cells that are alive, 1.
        share,
        /// Height of the upper tree line, m.
        upper,
        /// `1 / belt`, 1/m.
        per_belt,
    }
}

/// Equation (1).
pub struct Sow;

impl Rule for Sow {
    const NAME: &'static str = "forest_sow";
    const READS: &'static [Read] = &[read("height", 0)];
    const WRITES: &'static [&'static str] = &["grove"];
    type Params = SowParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &SowParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let thinned = ((p.upper - c.here(0)) * p.per_belt).clamp(R::of(0.0), R::of(1.0));
        ([c.uniform(START).lt(p.share * thinned).one()], [])
    }
}

rule_params! {
    /// Parameters of [`Live`].
    pub struct LiveParams {
        /// Neighbours with which a cell changes, 1.
        four,
    }
}

/// Equation (2).
pub struct Live;

impl Rule for Live {
    const NAME: &'static str = "forest_live";
    const READS: &'static [Read] = &[read("grove", 1)];
    const WRITES: &'static [&'static str] = &["grove"];
    type Params = LiveParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &LiveParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let edges = (c.at(0, 1, 0) + c.at(0, -1, 0)) + (c.at(0, 0, 1) + c.at(0, 0, -1));
        let corners = (c.at(0, 1, 1) + c.at(0, -1, -1)) + (c.at(0, -1, 1) + c.at(0, 1, -1));
        let neighbours = (edges + corners).named("(2) neighbours");
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let changed = neighbours.gt(p.four).pick(one, one - c.here(0));
        ([neighbours.lt(p.four).pick(zero, changed)], [])
    }
}

rule_params! {
    /// Parameters of [`Stand`].
    pub struct StandParams {
        /// Half of one over the cell's east-west size, 1/m.
        per_2dx,
        /// Half of one over its north-south size, 1/m.
        per_2dy,
        /// Square of the tangent of the steepest slope, 1.
        steepest,
        /// Height of the lower tree line, m.
        lower,
        /// Height of the upper tree line, m.
        upper,
        /// `1 / fade`, 1/m.
        per_fade,
        /// Size of the smallest trees, 1.
        size,
        /// Fresh water that keeps trees away, m.
        wet,
        /// Drained area of rivers, m2.
        river_area,
        /// Level of the sea, m.
        sea,
    }
}

/// Equations (3) and (4).
pub struct Stand;

impl Rule for Stand {
    const NAME: &'static str = "forest_stand";
    const READS: &'static [Read] = &[
        read("grove", 1),
        read("height", 1),
        read("lake", 0),
        read("water", 0),
        read("drained_area", 0),
        read("river", 0),
    ];
    const WRITES: &'static [&'static str] = &["forest", "tree_size"];
    type Params = StandParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &StandParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 0]) {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let height = c.here(1);
        let x = (c.at(1, 1, 0) - c.at(1, -1, 0)) * p.per_2dx;
        let y = (c.at(1, 0, 1) - c.at(1, 0, -1)) * p.per_2dy;
        let gentle = p.steepest.lt(x * x + y * y).pick(zero, one);
        let between = height.lt(p.lower).pick(zero, p.upper.lt(height).pick(zero, one));
        let fresh = c.here(2).max(c.here(3));
        let still = fresh.lt(p.wet).pick(height.lt(p.sea).pick(zero, one), zero);
        let dry = c.here(4).lt(p.river_area).pick(still, zero);
        let dry = c.here(5).lt(R::of(0.1)).pick(dry, zero);
        let edges = (c.at(0, 1, 0) + c.at(0, -1, 0)) + (c.at(0, 0, 1) + c.at(0, 0, -1));
        let corners = (c.at(0, 1, 1) + c.at(0, -1, -1)) + (c.at(0, -1, 1) + c.at(0, 1, -1));
        let weight = R::of(4.0) * c.here(0) + (R::of(2.0) * edges + corners);
        let forest = (weight.gt(R::of(8.0)).one() * gentle * between * dry).named("(3) forest");
        let size = ((p.upper - height) * p.per_fade + p.size).min(one);
        ([forest, (between * size).named("(4) size")], [])
    }
}
