//! Temperature: the sun warms by latitude, season and hour, height cools, the sea is slow, the wind carries.
//!
//! # Equations
//! `l` latitude, `d` declination of the sun, `s = sin(l - d - angle)` with the angle within -90..=90 degrees, `T` in
//! degrees Celsius, `z` the surface above the sea, `t` hours, `n` cell.
//! 1. `day = 0.5 + 4 (sin l sin d + cos l cos d cos(longitude - clock))`, within 0..=1: the height of the sun.
//! 2. `target = 12 + 24 (1 + strength - contrast (s^2 + s^4) + day_night (1 - day)) - lapse max(0, z - cooling_from)`; over
//!    the sea `currents (24 - target)` more where it is colder than 24 degrees; over land `wet_cooling soil T / 20` less,
//!    the quotient within 0..=1.
//! 3. `T1 = T + sum over 4 faces of (w_in t / n + mixing) (T_n - T)`, `w_in` the wind towards this cell.
//! 4. `T2 = T1 + (1 - e^(-t / response)) (target - T1)`; over the sea the response takes `sea_slowness` times as long.
//! 5. `T' = T2 + storms t sin(2 l)^4 laplace (T2 + lapse z)`: warm and cold air change places.
//!
//! # Source
//! Gerteis 2017.
//!
//! # Differences
//! - The source adds the sun to the temperature step by step and stops it at -1 and 1. Here temperature tends to a balance.
//! - Its sun is `cos(2 l)`, that is `1 - 2 s^2`. `1 - s^2 - s^4` has the same equator and poles and the even warmth of
//!   the Earth's tropics.
//! - Its seas are as cold as the land of their latitude. Here currents warm them, and storms of the middle latitudes what
//!   lies behind their shores.
//! - Its tilt is a number of pixels and fixed. Here `sun_angle` is in degrees and `tilt` makes a year.
//! - Its night side has one temperature at all latitudes, and its border is not symmetric. Here night takes warmth
//!   away, behind the terminator of a sphere, so that mirrored worlds stay mirrored and no polar night is warmer than
//!   its day.
//! - It cools by 1.2 units (28.8 degrees) for each 1000 m, from 2.5 units (1550 m) on, with a jump there. Here the
//!   lapse is the air's, without one.
//! - Temperature is carried as a property: carried as matter, as there, it would pile up where winds meet. In an even
//!   wind both are the same.
//! - The clock turns by 0.262 rad/h, a day of 24 h, instead of 0.02 rad a step. 0 stops it: a world that is tidally locked.
//!
//! # Layers
//! Reads `height` (m), `soil_moisture` (1), `wind_x`, `wind_y` (m/s); reads and writes `temperature` (degrees Celsius).
//!
//! # Limits
//! Stable for all values: (3) to (5) are means. On fine grids storms mix less than asked for.

use crate::advection::{Carrier, mixing, shares, storms};
use crate::humidity::SOIL;
use crate::sky::{Seasons, cosine, hours, latitude, polewards, rows, sine, storminess, turned};
use crate::units::{CELSIUS_AT_ZERO, CELSIUS_PER_UNIT, hours_per_step};
use crate::wind::{WIND_X, WIND_Y};
use eyot_core::given::Given;
use eyot_core::layer::known::HEIGHT;
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, check_ranges};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::{Grid, LayerSpec, Result, given, math, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Temperature of the air at the ground.
pub const TEMPERATURE: LayerSpec =
    LayerSpec::new("temperature", "°C", "Temperature of the air at the ground", (-600.0, 300.0));

/// The sun warms by latitude, season and hour, height cools, the sea is slow, the wind carries.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub struct Temperature {
    /// Strength of the sun beyond its curve, in units of 24 degrees: 0.08 makes the sun worth 38 degrees at the equator, of
    /// which night and wet soil take some (36 in the source).
    #[schemars(range(min = -5.0, max = 5.0), extend("unit" = "1"))]
    pub sun_strength: f32,
    /// How much colder it gets towards the poles: 1 is 48 degrees, as in the source.
    #[schemars(range(min = 0.0, max = 3.0), extend("unit" = "1"))]
    pub contrast: f32,
    /// Share of what the sea lacks to 24 degrees that its currents bring.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub currents: f32,
    /// How much cooler warm land stays while its soil is wet and dries.
    #[schemars(range(min = 0.0, max = 30.0), extend("unit" = "degree"))]
    pub wet_cooling: f32,
    /// Latitude over which the sun stands at noon, beside the seasons.
    #[schemars(range(min = -40.0, max = 40.0), extend("unit" = "degree"))]
    pub sun_angle: f32,
    /// Height above the sea from which the air gets colder (1550 m in the source).
    #[schemars(range(min = 0.0, max = 6050.0), extend("unit" = "m"))]
    pub cooling_from: f32,
    /// Cooling for each kilometre above that: 6.5 in our air, 28.8 in the source.
    #[schemars(range(min = 0.0, max = 30.0), extend("unit" = "degree"))]
    pub lapse: f32,
    /// Angle by which the sun goes round in an hour: 0.262 is a day of 24 h, 0 keeps one side dark for ever.
    #[schemars(range(min = -1.0, max = 1.0), extend("unit" = "rad/h"))]
    pub rotation_speed: f32,
    /// What night adds to the temperature that the land tends to, in units of 24 degrees: -0.2 in the source.
    #[schemars(range(min = -2.0, max = 2.0), extend("unit" = "1"))]
    pub day_night: f32,
    /// Time in which land makes good two thirds of what it lacks.
    #[schemars(range(min = 0.1, max = 10000.0), extend("unit" = "h"))]
    pub response: f32,
    /// How many times longer the sea takes: 2 in the source. More makes milder coasts.
    #[schemars(range(min = 1.0, max = 100.0), extend("unit" = "1"))]
    pub sea_slowness: f32,
    /// Mixing by weather that is smaller than the belts and eddies of the wind. A twentieth of a difference mixes in a
    /// step at most.
    #[schemars(range(min = 0.0, max = 10000000.0), extend("unit" = "m2/s"))]
    pub mixing: f32,
    /// Mixing by the storms of the middle latitudes, most at 45 degrees. Beyond what a step can mix, more changes nothing.
    #[schemars(range(min = 0.0, max = 10000000.0), extend("unit" = "m2/s"))]
    pub storms: f32,
    /// The year.
    #[serde(flatten)]
    pub seasons: Seasons,
}

impl Default for Temperature {
    fn default() -> Self {
        Self {
            sun_strength: 0.08,
            contrast: 1.2,
            currents: 0.15,
            wet_cooling: 4.0,
            sun_angle: 0.0,
            cooling_from: 0.0,
            lapse: 6.5,
            rotation_speed: 0.262,
            day_night: -0.1,
            response: 22.0,
            sea_slowness: 20.0,
            mixing: 5e5,
            storms: 5e5,
            seasons: Seasons::default(),
        }
    }
}

impl Process for Temperature {
    fn layers(&self) -> Vec<LayerUse> {
        vec![HEIGHT.read(0.0), WIND_X.read(0.0), WIND_Y.read(0.0), SOIL.read(0.0), TEMPERATURE.changed(CELSIUS_AT_ZERO)]
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("temperature", self)
    }

    fn seconds_per_step(&self, grid: &Grid) -> Option<f64> {
        Some(3600.0 * hours_per_step(grid))
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let (rows, half_row) = rows(&moment.grid);
        let (share_x, share_y) = shares(&moment.grid);
        let hours_a_step = hours_per_step(&moment.grid) as f32;
        let declination = self.seasons.declination(moment);
        let rate = |response: Given| 1.0 - math::exp(-hours_a_step / response);
        let (response, lapse) = (given!(plan, self.response), 1e-3 * given!(plan, self.lapse));
        plan.push_given::<Warm>(WarmParams {
            rows: rows.into(),
            half_row: half_row.into(),
            column: ((std::f64::consts::TAU / moment.grid.width as f64) as f32).into(),
            clock: turned(hours(moment), f64::from(self.rotation_speed)).into(),
            sun: declination + given!(plan, self.sun_angle).to_radians(),
            sin_sun: math::sin(declination).into(),
            cos_sun: math::cos(declination).into(),
            warmth: CELSIUS_AT_ZERO + CELSIUS_PER_UNIT * (1.0 + given!(plan, self.sun_strength)),
            contrast: CELSIUS_PER_UNIT * given!(plan, self.contrast),
            night: CELSIUS_PER_UNIT * given!(plan, self.day_night),
            lapse,
            cooling_from: given!(plan, self.cooling_from),
            currents: given!(plan, self.currents),
            cool: given!(plan, self.wet_cooling),
            sea: (moment.sea_level_m as f32).into(),
            land_rate: rate(response),
            sea_rate: rate(response * given!(plan, self.sea_slowness)),
            share_x: share_x.into(),
            share_y: share_y.into(),
            mixing: mixing(&moment.grid, given!(plan, self.mixing)),
        });
        let (passes, share) = storms(&moment.grid, self.storms);
        for _ in 0..passes {
            plan.push_given::<Storm>(StormParams {
                rows: rows.into(),
                half_row: half_row.into(),
                share: share.into(),
                lapse,
                sea: (moment.sea_level_m as f32).into(),
            });
        }
    }
}

rule_params! {
    /// Parameters of [`Storm`].
    pub struct StormParams {
        /// Rows of the grid, 1.
        rows,
        /// Latitude of half a row, rad.
        half_row,
        /// Share of a difference that mixes where there are most storms, 1.
        share,
        /// Cooling with height, degrees/m.
        lapse,
        /// Level of the sea, m.
        sea,
    }
}

/// Equation (5).
pub struct Storm;

impl Rule for Storm {
    const NAME: &'static str = "temperature_storm";
    const READS: &'static [Read] = &[read("temperature", 1), read("height", 1)];
    const WRITES: &'static [&'static str] = &["temperature"];
    type Params = StormParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &StormParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let storms = p.share * storminess(latitude(p.rows, p.half_row, c.y()));
        let here = at_sea_level(p, c, 0, 0);
        let x = (at_sea_level(p, c, 1, 0) - here) + (at_sea_level(p, c, -1, 0) - here);
        let y = (at_sea_level(p, c, 0, 1) - here) + (at_sea_level(p, c, 0, -1) - here);
        ([c.at(0, 0, 0) + (storms * (x + y)).no_contract()], [])
    }
}

/// Temperature that the air would have at the level of the sea, degrees Celsius.
#[inline(always)]
fn at_sea_level<R: Real>(p: &StormParams<R>, c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    c.at(0, dx, dy) + (p.lapse * (c.at(1, dx, dy) - p.sea).positive()).no_contract()
}

rule_params! {
    /// Parameters of [`Warm`].
    pub struct WarmParams {
        /// Rows of the grid, 1.
        rows,
        /// Latitude of half a row, rad.
        half_row,
        /// Longitude of a column, rad.
        column,
        /// Longitude of noon, rad.
        clock,
        /// Latitude over which the sun stands, rad.
        sun,
        /// Sine of its declination, 1.
        sin_sun,
        /// Cosine of its declination, 1.
        cos_sun,
        /// What land tends to under the sun, degrees Celsius.
        warmth,
        /// Half of what the poles lack, degrees.
        contrast,
        /// What night adds, degrees.
        night,
        /// Cooling with height, degrees/m.
        lapse,
        /// Height above the sea from which it cools, m.
        cooling_from,
        /// What wet soil takes off the warmth of land, degrees.
        cool,
        /// Share of what the sea lacks to 24 degrees that currents bring, 1.
        currents,
        /// Level of the sea, m.
        sea,
        /// Share of what land lacks that it gets in a step, 1.
        land_rate,
        /// The same of the sea, 1.
        sea_rate,
        /// Share that a wind of 1 m/s carries through an eastern face, s/m.
        share_x,
        /// The same through a southern face, s/m.
        share_y,
        /// Share that mixes, 1.
        mixing,
    }
}

/// Equations (1) to (4).
pub struct Warm;

impl Rule for Warm {
    const NAME: &'static str = "temperature_warm";
    const READS: &'static [Read] =
        &[read("temperature", 1), read("wind_x", 1), read("wind_y", 1), read("height", 0), read("soil_moisture", 0)];
    const WRITES: &'static [&'static str] = &["temperature"];
    type Params = WarmParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &WarmParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let lat = latitude(p.rows, p.half_row, c.y());
        let quarter = R::of(std::f32::consts::FRAC_PI_2);
        let noon = cosine(p.column * (c.x() + R::of(0.5)) - p.clock);
        let sun_height = p.sin_sun * sine(lat) + p.cos_sun * sine(quarter - lat.abs()) * noon;
        let night = (R::of(0.5) - R::of(4.0) * sun_height).clamp(zero, one).named("(1) night");

        let s = sine((lat - p.sun).clamp(-quarter, quarter));
        let z = c.here(3) - p.sea;
        let cooled = p.lapse * (z - p.cooling_from).positive();
        let target = p.warmth - p.contrast * polewards(s) + p.night * night - cooled;
        let target = z.lt(zero).pick(target + p.currents * (R::of(24.0) - target).positive(), target);
        let target = target - p.cool * c.here(4) * (c.here(0) * R::of(0.05)).clamp(zero, one);
        let target = target.named("(2) balance");

        let air = Carrier { what: 0, wind_x: 1, wind_y: 2, share_x: p.share_x, share_y: p.share_y, mixing: p.mixing };
        let carried = (c.here(0) + air.change(c)).named("(3) carried");
        let rate = z.lt(zero).pick(p.sea_rate, p.land_rate);
        ([carried + rate * (target - carried)], [])
    }
}
