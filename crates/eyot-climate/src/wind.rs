//! Wind: belts by latitude, eddies that drift, what mountains do to it, and monsoons.
//!
//! # Equations
//! `l` latitude, turned by `follow` of the sun's; `W` = 10 m/s; `T` temperature, `z` the surface within 12 km above the sea,
//! `n` cell. On eastern faces `u` (to the east), on southern faces `v` (to the south):
//! 1. belts: `u = -0.64 W cos(3.3 l)`, `v = 0.45 W sin(6 l)`: trade winds, westerlies and polar easterlies, that meet at
//!    the equator and at 60 degrees and part at 30. `cells = "source"`: `u = -W cos(6.6 - 3.5 l)`, `v = W sin(3 l)`.
//! 2. eddies: `u = W (p_SE - p_NE)`, `v = W (p_SW - p_SE)` from a stream function `p` at the corners of cells, which
//!    drifts to the east in the north and to the west in the south. They part and gather no air.
//! 3. pressure: `u = local_pressure 30 m/s (z_e - z_w) / n`: air is drawn up slopes.
//! 4. heat low: `h' = h + D t laplace h + (1 - e^(-t / 60 h)) (T + 5.4 z / km + 13 (s^2 + s^4) - h)`, `s = sin l`, `D` = 4.1e6
//!    m2/s: how much warmer the air is than its latitude, as the air within a thousand kilometres feels it.
//! 5. monsoon: `(u, v) = monsoon 1e6 m2/s (grad h + f k x grad h) / (1 + f^2)`, `f = bend sin(latitude)`: from cold to warm,
//!    slowed by the ground and bent by the turning planet, so that summer's lows are circled and winter's highs are left.
//! 6. `w' = 0.5 w + 0.1 sum of 4 neighbours + 0.1 target`, the target being the weighted sum of (1) to (3) and (5), within
//!    -W..=W.
//!
//! # Source
//! Gerteis 2017: belts, noise and pressure with a weight for each. The eddies after Bridson, Houriham and Nordenstam 2007.
//! (5) is the balance of pressure, friction and Coriolis force of Gill 1980, with warmth in place of pressure.
//!
//! # Differences
//! - The printed belts are not symmetric (`cos(11 (v + 0.1))`) and part at 60 degrees, where they would put the
//!   deserts. They are kept as `cells = "source"`.
//! - Wind lives on faces, so that what it carries is conserved whatever it does, and no wind blows through a closed pole.
//! - Noise that gathers air would gather its water: the eddies are the curl of a noise.
//! - The weight of the eddies is 0.8 by default and not 1: at full weight they begin to hide the belts.
//! - Pressure falls evenly with height, and not as its inverse, which is the same for mountains but needs no division; and
//!   ten times less, so that mountains do not draw the water of whole continents.
//! - The belts follow the sun, and land that is warmer or colder than its latitude makes monsoons, which the source lacks:
//!   the east of continents gets its rain in summer and the dry cold of its middle in winter.
//!
//! # Layers
//! Reads `height` (m), `temperature` (degrees Celsius); reads and writes `wind_x`, `wind_y` (m/s, on faces), `heat_low`
//! (degrees) and `turbulence` (1, at south-eastern corners).
//!
//! # Limits
//! Stable for all values: (4) and (6) are means. `turbulence` is made from the world's seed if it is empty. On more than
//! 1500 columns the heat low is felt less far.

use crate::sky::{Seasons, cosine, edge_latitude, latitude, polewards, rows, sine};
use crate::temperature::TEMPERATURE;
use crate::turbulence;
use crate::units::{CELSIUS_AT_ZERO, FULL_WIND, FULL_WIND_CELLS, hours_per_step};
use eyot_core::layer::GhostFill;
use eyot_core::layer::known::HEIGHT;
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, check_ranges};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::{Centering, Grid, LayerSpec, Result, World, given, math, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Wind through eastern faces.
pub const WIND_X: LayerSpec =
    LayerSpec::new("wind_x", "m/s", "Wind to the east through the eastern edge", (-FULL_WIND, FULL_WIND))
        .on(Centering::FaceX);
/// Wind through southern faces.
pub const WIND_Y: LayerSpec =
    LayerSpec::new("wind_y", "m/s", "Wind to the south through the southern edge", (-FULL_WIND, FULL_WIND))
        .on(Centering::FaceY);
/// Stream function of the eddies.
pub const TURBULENCE: LayerSpec = {
    let meaning = "Stream function of the wind's eddies at the south-eastern corner";
    let mut spec = LayerSpec::new("turbulence", "1", meaning, (-1e3, 1e3));
    // None crosses a pole, and the northern one has no corners of its own.
    spec.beyond_closed = GhostFill::Zero;
    spec
};

/// Where warm air rises and cold air sinks.
pub const HEAT_LOW: LayerSpec = LayerSpec::new(
    "heat_low",
    "°C",
    "How much warmer the air is than others of its latitude, within a distance that winds feel",
    (-1e3, 1e3),
);

/// Belts of wind by latitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Cells {
    /// Trade winds, westerlies and polar easterlies, the same in both hemispheres.
    #[default]
    Earth,
    /// As the source prints them.
    Source,
}

/// Belts of wind, drifting eddies, mountains that draw air up, and monsoons.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub struct Wind {
    /// Weight of the belts. Negative turns them round.
    #[schemars(range(min = -2.0, max = 2.0), extend("unit" = "1"))]
    pub global_wind: f32,
    /// Weight of the eddies (1 in the source).
    #[schemars(range(min = -2.0, max = 2.0), extend("unit" = "1"))]
    pub distortion: f32,
    /// Weight of the pressure that draws air up slopes. Much of it makes all wind end on the nearest ridge.
    #[schemars(range(min = -2.0, max = 2.0), extend("unit" = "1"))]
    pub local_pressure: f32,
    /// Weight of the monsoon: air blows from cold to warm ground, land in summer and sea in winter.
    #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "1"))]
    pub monsoon: f32,
    /// How far the turning planet bends the monsoon: the Coriolis parameter at the pole over the friction of the ground.
    /// 0 on a planet that does not turn.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    pub bend: f32,
    /// Speed at which eddies drift, as a share of the strongest wind: to the east in the north and to the west in the
    /// south.
    #[schemars(range(min = -1.0, max = 1.0), extend("unit" = "1"))]
    pub wind_speed: f32,
    /// Strength of each octave of the eddies to the one before. Above 1 the small ones win.
    #[schemars(range(min = 0.0, max = 8.0), extend("unit" = "1"))]
    pub roughness: f32,
    /// Octaves of the eddies.
    #[schemars(range(min = 1, max = 20), extend("unit" = "1"))]
    pub turbulence: u32,
    /// Share of the sun's way to north and south by which the belts follow it.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub follow: f32,
    /// The belts.
    pub cells: Cells,
    /// The year.
    #[serde(flatten)]
    pub seasons: Seasons,
}

impl Default for Wind {
    fn default() -> Self {
        Self {
            global_wind: 1.0,
            distortion: 0.8,
            local_pressure: 1.0,
            monsoon: 0.5,
            bend: 4.0,
            wind_speed: 0.2,
            roughness: 0.6,
            turbulence: 4,
            follow: 0.3,
            cells: Cells::Earth,
            seasons: Seasons::default(),
        }
    }
}

/// Strength of the belts along x and along y, as shares of the strongest wind.
const BELTS: (f32, f32) = (0.64, 0.45);
/// Wind up a slope whose gradient is 1, m/s. Slopes of whole degrees of latitude are below a hundredth.
const WIND_PER_GRADIENT: f32 = 30.0;
/// Monsoon of a gradient of temperature without any bend, m2/s for each degree: 10 m/s for 10 degrees in 1000 km.
const MONSOON_PER_GRADIENT: f32 = 1e6;
/// Cooling with height that makes no monsoon, degrees/m: less than that of free air, since the ground of highlands is warmer.
const LAPSE: f32 = 5.4e-3;
/// How fast warmth at the ground is felt by the air around, m2/s; within [`RISE_HOURS`] 900 km.
const SPREAD: f64 = 4.1e6;
/// Time in which the air follows the ground, h.
const RISE_HOURS: f64 = 60.0;
/// Share that spreads between neighbours in a pass, 1; it ties the cells together that [`FAR`] would leave apart.
const NEAR: f32 = 0.05;
/// Share that spreads between next but one neighbours in a pass, 1.
const FAR: f32 = 0.15;
/// Passes in a step at most: on grids above 1500 columns warmth is felt less far.
const MAX_PASSES: f64 = 5.0;
/// Half the difference of temperature between equator and poles that drives the belts and no monsoon, degrees: less
/// than the sun makes, since winds and seas carry warmth.
const BELTS_CONTRAST: f32 = 13.0;

impl Wind {
    /// Steps in which the eddies drift by a cell; `None` if they stand.
    fn steps_per_cell(&self) -> Option<u64> {
        let cells = f64::from(FULL_WIND_CELLS * self.wind_speed.abs());
        (cells > 1e-9).then(|| (1.0 / cells).round().max(1.0) as u64)
    }
}

impl Process for Wind {
    fn layers(&self) -> Vec<LayerUse> {
        vec![
            HEIGHT.read(0.0),
            TEMPERATURE.read(CELSIUS_AT_ZERO),
            WIND_X.changed(0.0),
            WIND_Y.changed(0.0),
            TURBULENCE.changed(0.0),
            HEAT_LOW.changed(0.0),
        ]
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("wind", self)
    }

    fn prepare(&self, world: &mut World) -> Result<()> {
        turbulence::prepare(world, self.turbulence, self.roughness)
    }

    fn seconds_per_step(&self, grid: &Grid) -> Option<f64> {
        Some(3600.0 * hours_per_step(grid))
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let (rows, half_row) = rows(&moment.grid);
        let east = if self.wind_speed < 0.0 { -1.0 } else { 1.0 };
        let mut drift = 0.0;
        if let Some(n) = self.steps_per_cell() {
            // Whole cells move with the layer, the rest is looked up between two cells.
            drift = (moment.step % n) as f32 / n as f32;
            if moment.step.is_multiple_of(n) {
                plan.push::<Drift>(DriftParams { rows, east });
            }
        }
        let turn = given!(plan, self.follow) * self.seasons.declination(moment);
        let full = FULL_WIND * given!(plan, self.global_wind);
        let (x, x_turn, x_start, y, y_turn) = match self.cells {
            Cells::Earth => (BELTS.0 * full, 3.3, 0.0, BELTS.1 * full, 6.0),
            Cells::Source => (full, -11.0 / std::f32::consts::PI, 6.6, full, 3.0),
        };
        let slope = (WIND_PER_GRADIENT * given!(plan, self.local_pressure)).wide();
        let monsoon = (MONSOON_PER_GRADIENT * given!(plan, self.monsoon)).wide();
        let hours = hours_per_step(&moment.grid);
        let cell = moment.grid.cell_x_m.min(moment.grid.cell_y_m);
        plan.push_given::<Rise>(RiseParams {
            rows: rows.into(),
            half_row: half_row.into(),
            turn,
            sea: (moment.sea_level_m as f32).into(),
            rate: (1.0 - math::exp(-(hours / RISE_HOURS) as f32)).into(),
        });
        let spread = SPREAD * 3600.0 * hours / (cell * cell * f64::from(NEAR + 4.0 * FAR));
        let passes = spread.ceil().clamp(1.0, MAX_PASSES);
        let share = (spread / passes).min(1.0) as f32;
        for _ in 0..passes as usize {
            plan.push::<Spread>(SpreadParams { near: NEAR * share, far: FAR * share });
        }
        plan.push_given::<Blow>(BlowParams {
            rows: rows.into(),
            half_row: half_row.into(),
            turn,
            x,
            x_turn: x_turn.into(),
            x_start: x_start.into(),
            y,
            y_turn: y_turn.into(),
            eddies: FULL_WIND * given!(plan, self.distortion),
            drift: drift.into(),
            east: east.into(),
            slope_x: (slope / moment.grid.cell_x_m).narrow(),
            slope_y: (slope / moment.grid.cell_y_m).narrow(),
            monsoon_x: (monsoon / moment.grid.cell_x_m).narrow(),
            monsoon_y: (monsoon / moment.grid.cell_y_m).narrow(),
            bend: given!(plan, self.bend),
            sea: (moment.sea_level_m as f32).into(),
            most: FULL_WIND.into(),
        });
    }
}

rule_params! {
    /// Parameters of [`Drift`].
    pub struct DriftParams {
        /// Rows of the grid, 1.
        rows,
        /// 1 if northern eddies drift to the east, -1 if to the west.
        east,
    }
}

/// The eddies move by a cell.
pub struct Drift;

impl Rule for Drift {
    const NAME: &'static str = "wind_drift";
    const READS: &'static [Read] = &[read("turbulence", 1)];
    const WRITES: &'static [&'static str] = &["turbulence"];
    type Params = DriftParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &DriftParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        ([upstream(p.rows, p.east, c, 0, 0, 0)], [])
    }
}

/// The stream function one cell upstream of the eddies' drift.
#[inline(always)]
fn upstream<R: Real>(rows: R, east: R, c: &impl Cell<R>, slot: usize, dx: isize, dy: isize) -> R {
    // Corners north of the equator; the one on it is 0.
    let y = c.y() + R::of(dy as f32);
    let north = (y + y).lt(rows - R::of(2.0)).pick(east, -east);
    north.gt(R::of(0.0)).pick(c.at(slot, dx - 1, dy), c.at(slot, dx + 1, dy))
}

rule_params! {
    /// Parameters of [`Rise`].
    pub struct RiseParams {
        /// Rows of the grid, 1.
        rows,
        /// Latitude of half a row, rad.
        half_row,
        /// Latitude to which the belts have followed the sun, rad.
        turn,
        /// Level of the sea, m.
        sea,
        /// Share of what it lacks that it gets in a step, 1.
        rate,
    }
}

/// Equation (4).
pub struct Rise;

impl Rule for Rise {
    const NAME: &'static str = "wind_rise";
    const READS: &'static [Read] = &[read("heat_low", 0), read("temperature", 0), read("height", 0)];
    const WRITES: &'static [&'static str] = &["heat_low"];
    type Params = RiseParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &RiseParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let quarter = R::of(std::f32::consts::FRAC_PI_2);
        let s = sine((latitude(p.rows, p.half_row, c.y()) - p.turn).clamp(-quarter, quarter));
        let z = (c.here(2) - p.sea).clamp(R::of(0.0), R::of(12_000.0));
        // The monsoon is made of small differences of it: see `Real::no_contract`.
        let warmer =
            c.here(1) + (R::of(LAPSE) * z).no_contract() + (R::of(BELTS_CONTRAST) * polewards(s)).no_contract();
        let low = c.here(0);
        ([low + (p.rate * (warmer - low)).no_contract()], [])
    }
}

rule_params! {
    /// Parameters of [`Spread`].
    pub struct SpreadParams {
        /// Share that spreads between neighbours, 1.
        near,
        /// Share that spreads between next but one neighbours, 1.
        far,
    }
}

/// Equation (4).
pub struct Spread;

impl Rule for Spread {
    const NAME: &'static str = "wind_spread";
    const READS: &'static [Read] = &[read("heat_low", 2)];
    const WRITES: &'static [&'static str] = &["heat_low"];
    type Params = SpreadParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &SpreadParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let low = c.at(0, 0, 0);
        let around = |d: isize| (c.at(0, d, 0) + c.at(0, -d, 0)) + (c.at(0, 0, d) + c.at(0, 0, -d));
        let (near, far) = (around(1) - R::of(4.0) * low, around(2) - R::of(4.0) * low);
        ([low + ((p.near * near).no_contract() + (p.far * far).no_contract())], [])
    }
}

rule_params! {
    /// Parameters of [`Blow`].
    pub struct BlowParams {
        /// Rows of the grid, 1.
        rows,
        /// Latitude of half a row, rad.
        half_row,
        /// Latitude to which the belts have followed the sun, rad.
        turn,
        /// Strength of the belts along x, m/s.
        x,
        /// Their angle for each radian of latitude, 1.
        x_turn,
        /// Their angle at the equator, rad.
        x_start,
        /// Strength of the belts along y, m/s.
        y,
        /// Their angle for each radian of latitude, 1.
        y_turn,
        /// Strength of the eddies, m/s.
        eddies,
        /// Share of a cell that the eddies have drifted since they last moved, 1.
        drift,
        /// 1 if northern eddies drift to the east, -1 if to the west.
        east,
        /// Wind between columns for a difference in height, 1/s.
        slope_x,
        /// Wind between rows for a difference in height, 1/s.
        slope_y,
        /// Monsoon between columns for a difference of temperature, m/s for each degree.
        monsoon_x,
        /// The same between rows.
        monsoon_y,
        /// Coriolis parameter at the pole over friction, 1.
        bend,
        /// Level of the sea, m.
        sea,
        /// Strongest wind, m/s.
        most,
    }
}

/// Equations (1) to (3), (5) and (6).
pub struct Blow;

const HEIGHT_SLOT: usize = 0;
const X: usize = 1;
const Y: usize = 2;
const EDDIES: usize = 3;
const LOW: usize = 4;

impl Rule for Blow {
    const NAME: &'static str = "wind_blow";
    const READS: &'static [Read] =
        &[read("height", 1), read("wind_x", 1), read("wind_y", 1), read("turbulence", 2), read("heat_low", 1)];
    const WRITES: &'static [&'static str] = &["wind_x", "wind_y"];
    type Params = BlowParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &BlowParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 0]) {
        let here = latitude(p.rows, p.half_row, c.y()) - p.turn;
        let south = edge_latitude(p.rows, p.half_row, c.y()) - p.turn;
        let belts_x = (-(p.x * cosine(p.x_start + p.x_turn * here))).named("(1) belts_x");
        let belts_y = (p.y * cosine(p.y_turn * south - R::of(std::f32::consts::FRAC_PI_2))).named("(1) belts_y");

        let corner = stream(p, c, 0, 0);
        let eddies_x = (p.eddies * (corner - stream(p, c, 0, -1))).named("(2) eddies_x");
        let eddies_y = (p.eddies * (stream(p, c, -1, 0) - corner)).named("(2) eddies_y");

        let z = surface(p, c, 0, 0);
        let slope_x = (p.slope_x * (surface(p, c, 1, 0) - z)).named("(3) slope_x");
        let slope_y = (p.slope_y * (surface(p, c, 0, 1) - z)).named("(3) slope_y");

        let east = low(c, 1, 0) - low(c, 0, 0);
        let east_down = ((low(c, 0, 1) + low(c, 1, 1)) - (low(c, 0, -1) + low(c, 1, -1))) * R::of(0.25);
        let down = low(c, 0, 1) - low(c, 0, 0);
        let down_east = ((low(c, 1, 0) + low(c, 1, 1)) - (low(c, -1, 0) + low(c, -1, 1))) * R::of(0.25);
        let (f, f_edge) = (p.bend * sine(here + p.turn), p.bend * sine(south + p.turn));
        let (across_x, across_y) = ((p.monsoon_y * east_down).no_contract(), (p.monsoon_x * down_east).no_contract());
        let monsoon_x =
            ((p.monsoon_x * east).no_contract() - (f * across_x).no_contract()) / (R::of(1.0) + (f * f).no_contract());
        let monsoon_y = ((p.monsoon_y * down).no_contract() + (f_edge * across_y).no_contract())
            / (R::of(1.0) + (f_edge * f_edge).no_contract());
        let (monsoon_x, monsoon_y) = (monsoon_x.named("(5) monsoon_x"), monsoon_y.named("(5) monsoon_y"));

        let x = settled(c, X, belts_x + eddies_x + slope_x + monsoon_x, p.most);
        let y = settled(c, Y, belts_y + eddies_y + slope_y + monsoon_y, p.most);
        ([x, y], [])
    }
}

#[inline(always)]
fn low<R: Real>(c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    c.at(LOW, dx, dy)
}

#[inline(always)]
fn stream<R: Real>(p: &BlowParams<R>, c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    let here = c.at(EDDIES, dx, dy);
    here + p.drift * (upstream(p.rows, p.east, c, EDDIES, dx, dy) - here)
}

/// Height of the surface above the sea, m.
#[inline(always)]
fn surface<R: Real>(p: &BlowParams<R>, c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    (c.at(HEIGHT_SLOT, dx, dy) - p.sea).clamp(R::of(0.0), R::of(12_000.0))
}

/// Equation (6).
#[inline(always)]
fn settled<R: Real>(c: &impl Cell<R>, slot: usize, target: R, most: R) -> R {
    let around = (c.at(slot, 1, 0) + c.at(slot, -1, 0)) + (c.at(slot, 0, 1) + c.at(slot, 0, -1));
    let target = target.clamp(-most, most);
    (R::of(0.5) * c.here(slot) + R::of(0.1) * (around + target)).clamp(-most, most)
}
