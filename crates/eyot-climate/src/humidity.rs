//! Humidity: the air takes up water over the sea, carries it, and rains where it cools, rises and meets.
//!
//! # Equations
//! `q` humidity (1: what a column of 30 degrees holds, 32.5 mm), `S` how full the soil is, `T` in degrees Celsius, `t` hours,
//! `w` share through a face.
//! 1. `q1 = q + sum over 4 faces of (w_in q_n - w_out q)`: what leaves one cell arrives in the other.
//! 2. `W = ((T + 60) / 90)^4`: what a column of air can hold, 0 below -60 degrees.
//! 3. uptake: `(1 - e^(-water_add t / 24)) (W - q1)` where positive, over the sea; a third of it over lakes, half of it
//!    through sea ice; over land `(1 - e^(-land_add t / 24)) S (W - q1) T / 10`, the quotient within 0..=1, from the soil.
//! 4. rain: `(1 - e^(-t / 57)) q r` with `r = q / W` at most 1, and `1 - e^(-t / 6)` of what exceeds `W`.
//! 5. drying: `(1 - e^(-land_dry t / 720)) (q - rain) (0.3 + 0.4 T / 30)` over land, the last bracket within 0..=0.7,
//!    and the same with `ice_dry` and without it over ice; it is gone without rain.
//! 6. `precipitation' = precipitation + 0.1 (R - precipitation)`, `R` the rain of (4) in mm a year.
//! 7. `S' = S + (rain - uptake) / soil`, at most 1: what the soil cannot keep runs off.
//! 8. storms: `q' = q + storms t sin(2 l)^4 laplace q`, `l` latitude.
//!
//! # Source
//! Gerteis 2017. (2) follows how the water over places of that temperature falls from the Earth's tropics, 50 mm, to places of
//! -10 degrees, 7 mm: less than the pressure of saturation, since cold ground lies under warmer air. (7) is the bucket of Manabe 1969.
//!
//! # Differences
//! - In the source rain is a share of the humidity, wherever it is. Here cold air holds less and so rains more:
//!   mountains are wet on the side of the wind and dry behind, and air that sinks and parts at 30 degrees leaves
//!   deserts.
//! - The source has signs that lose water on the way and a temperature factor of drying that multiplies zero. Both are
//!   mended, and land dries by default.
//! - Soil keeps rain and gives it back when it is warm: that waters the middle of continents, and in summer.
//! - Storms carry water from the sea over the land of the middle latitudes, where the mean wind alone would leave the lee
//!   side of every continent dry.
//!
//! # Layers
//! Reads `height`, `water`, `ice` (m), `temperature` (degrees Celsius), `wind_x`, `wind_y` (m/s); reads and writes
//! `humidity`, `soil_moisture` (1) and `precipitation` (mm a year).
//!
//! # Limits
//! Stable for all values: no more leaves a cell than is there. On fine grids storms carry less than asked for.
//!
//! # Conserves
//! Water in the air with uptake, rain and drying in the ledger, as the depth it would have, and water in the soil with what
//! runs off (`tests/it/conservation.rs`).
//! The rain of the map falls as `water.rain` in its own, slower time; see `water`.

use crate::advection::{Carrier, mixing, shares, storms};
use crate::ice::ICE;
use crate::level::out;
use crate::sky::{edge_latitude, latitude, rows, storminess};
use crate::temperature::TEMPERATURE;
use crate::units::{AIR_WATER, CELSIUS_AT_ZERO, HOURS_PER_YEAR, RAIN_HOURS, hours_per_step};
use crate::wind::{WIND_X, WIND_Y};
use eyot_core::given::Given;
use eyot_core::layer::known::{HEIGHT, WATER};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, check_ranges};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Side, Tally, TallyUnit, read};
use eyot_core::{Grid, LayerSpec, Result, given, math, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Water in the air.
pub const HUMIDITY: LayerSpec =
    LayerSpec::new("humidity", "1", "Water in the air; 1 saturates it at 30 degrees", (0.0, 1000.0));
/// Rain and snow.
pub const PRECIPITATION: LayerSpec =
    LayerSpec::new("precipitation", "mm/a", "Rain and snow, as the depth that a year of it would make", (0.0, 1e8));

/// Rain that waits in the soil.
pub const SOIL: LayerSpec =
    LayerSpec::new("soil_moisture", "1", "How full the soil is of rain that it keeps until it dries", (0.0, 1.0));

const LEFT: Tally = Tally {
    account: "humidity.left",
    unit: TallyUnit::Thickness,
    sign: -1,
    meaning: "Water in the air that left over an open rim, less what came in",
};

/// The air takes up water over the sea, carries it, and rains where it cools, rises and meets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Humidity {
    /// How fast air takes up water over the sea. Little makes a dry world.
    #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "1"))]
    pub water_add: f32,
    /// How fast land dries the air without rain, more where it is warm (0 in the source, where land never dries).
    #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "1"))]
    pub land_dry: f32,
    /// How fast ice dries the air.
    #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "1"))]
    pub ice_dry: f32,
    /// How fast air takes up water over wet soil, where the sea is 1; none does in frost. Much of it makes green
    /// continents and wet summers.
    #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "1"))]
    pub land_add: f32,
    /// Rain that the soil keeps for dry months: what runs off is lost to the air. 16 mm are for a year of 40 days what
    /// 150 mm are for ours.
    #[schemars(range(min = 0.1, max = 1000.0), extend("unit" = "mm"))]
    pub soil: f32,
    /// Mixing by weather that is smaller than the belts and eddies of the wind. A twentieth of a difference mixes in a
    /// step at most.
    #[schemars(range(min = 0.0, max = 10000000.0), extend("unit" = "m2/s", "between_cells" = true))]
    pub mixing: f32,
    /// Mixing by the storms of the middle latitudes, most at 45 degrees. Beyond what a step can mix, more changes nothing.
    #[schemars(range(min = 0.0, max = 10000000.0), extend("unit" = "m2/s", "between_cells" = true))]
    pub storms: f32,
}

impl Default for Humidity {
    fn default() -> Self {
        Self { water_add: 1.0, land_dry: 0.1, ice_dry: 0.2, land_add: 0.22, soil: 16.0, mixing: 5e5, storms: 1.8e6 }
    }
}

impl Process for Humidity {
    fn layers(&self) -> Vec<LayerUse> {
        let own = [HUMIDITY.changed(0.0), PRECIPITATION.changed(0.0), SOIL.changed(0.0)];
        let others = [HEIGHT.read(0.0), WATER.read(0.0), ICE.read(0.0), TEMPERATURE.read(CELSIUS_AT_ZERO)];
        others.into_iter().chain([WIND_X.read(0.0), WIND_Y.read(0.0)]).chain(own).collect()
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("humidity", self)
    }

    fn seconds_per_step(&self, grid: &Grid) -> Option<f64> {
        Some(3600.0 * hours_per_step(grid))
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let (share_x, share_y) = shares(&moment.grid);
        let hours = hours_per_step(&moment.grid) as f32;
        let share = |strength: Given, time: f32| 1.0 - math::exp(-strength * hours / time);
        let soil = given!(plan, self.soil);
        plan.push_given::<Moisten>(MoistenParams {
            uptake: share(given!(plan, self.water_add), 24.0),
            rain: share(Given::of(1.0), RAIN_HOURS),
            excess: share(Given::of(1.0), 6.0),
            land_uptake: share(given!(plan, self.land_add), 24.0),
            soil: 1e-3 * soil / AIR_WATER,
            per_soil: 1e3 * AIR_WATER / soil,
            dry: share(given!(plan, self.land_dry), 720.0),
            ice_dry: share(given!(plan, self.ice_dry), 720.0),
            per_year: (1e3 * AIR_WATER * HOURS_PER_YEAR / hours).into(),
            depth: AIR_WATER.into(),
            sea: (moment.sea_level_m as f32).into(),
            share_x: share_x.into(),
            share_y: share_y.into(),
            mixing: mixing(&moment.grid, self.mixing.into()),
        });
        let (rows, half_row) = rows(&moment.grid);
        let (passes, share) = storms(&moment.grid, self.storms);
        for _ in 0..passes {
            plan.push::<Storm>(StormParams { rows, half_row, share, depth: AIR_WATER });
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
        /// Depth of the water in air of humidity 1, m.
        depth,
    }
}

/// Equation (8).
pub struct Storm;

impl Rule for Storm {
    const NAME: &'static str = "humidity_storm";
    const READS: &'static [Read] = &[read("humidity", 1)];
    const WRITES: &'static [&'static str] = &["humidity"];
    const TALLIES: &'static [Tally] = &[LEFT];
    type Params = StormParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &StormParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 1]) {
        let (east, south) = (storm_east(p, c, 0), storm_south(p, c, 0));
        let gain = (storm_east(p, c, -1) - east) + (storm_south(p, c, -1) - south);
        ([(c.here(0) + gain).flushed()], [R::of(0.0)])
    }

    #[inline(always)]
    fn boundary_outflow<R: Real>(p: &StormParams<R>, c: &impl Cell<R>, side: Side) -> Option<[R; 1]> {
        Some([p.depth * out(side, |at| storm_east(p, c, at), |at| storm_south(p, c, at))])
    }
}

/// What storms carry through the eastern face of the cell `at` columns east.
#[inline(always)]
fn storm_east<R: Real>(p: &StormParams<R>, c: &impl Cell<R>, at: isize) -> R {
    let storms = p.share * storminess(latitude(p.rows, p.half_row, c.y()));
    (storms * (c.at(0, at, 0) - c.at(0, at + 1, 0))).no_contract()
}

/// What storms carry through the southern face of the cell `at` rows south.
#[inline(always)]
fn storm_south<R: Real>(p: &StormParams<R>, c: &impl Cell<R>, at: isize) -> R {
    let storms = p.share * storminess(edge_latitude(p.rows, p.half_row, c.y() + R::of(at as f32)));
    (storms * (c.at(0, 0, at) - c.at(0, 0, at + 1))).no_contract()
}

rule_params! {
    /// Parameters of [`Moisten`].
    pub struct MoistenParams {
        /// Share of what the air lacks that it takes up over the sea in a step, 1.
        uptake,
        /// Share of the water of saturated air that rains in a step, 1.
        rain,
        /// Share of what exceeds saturation that rains in a step, 1.
        excess,
        /// Share of what the air lacks that it takes up over wet soil in a step, 1.
        land_uptake,
        /// Water that the soil keeps, in units of humidity.
        soil,
        /// One over it.
        per_soil,
        /// Share that warm land dries in a step, 1.
        dry,
        /// Share that ice dries in a step, 1.
        ice_dry,
        /// Rain of a step as mm a year.
        per_year,
        /// Depth of the water in air of humidity 1, m.
        depth,
        /// Level of the sea, m.
        sea,
        /// Share that a wind of 1 m/s carries through an eastern face, s/m.
        share_x,
        /// The same through a southern face, s/m.
        share_y,
        /// Share that mixes, 1.
        mixing,
    }
}

/// Equations (1) to (7).
pub struct Moisten;

#[inline(always)]
fn carrier<R: Real>(p: &MoistenParams<R>) -> Carrier<R> {
    Carrier { what: 0, wind_x: 1, wind_y: 2, share_x: p.share_x, share_y: p.share_y, mixing: p.mixing }
}

/// Equation (2).
#[inline(always)]
pub fn capacity<R: Real>(celsius: R) -> R {
    let x = (celsius + R::of(60.0)).positive() * R::of(1.0 / 90.0);
    let x2 = x * x;
    x2 * x2
}

impl Rule for Moisten {
    const NAME: &'static str = "humidity_moisten";
    const READS: &'static [Read] = &[
        read("humidity", 1),
        read("wind_x", 1),
        read("wind_y", 1),
        read("temperature", 0),
        read("height", 0),
        read("water", 0),
        read("ice", 0),
        read("precipitation", 0),
        read("soil_moisture", 0),
    ];
    const WRITES: &'static [&'static str] = &["humidity", "precipitation", "soil_moisture"];
    const TALLIES: &'static [Tally] = &[
        Tally {
            account: "humidity.taken_up",
            unit: TallyUnit::Thickness,
            sign: 1,
            meaning: "Water that the air took up over sea, lakes and wet land",
        },
        Tally {
            account: "humidity.rained",
            unit: TallyUnit::Thickness,
            sign: -1,
            meaning: "Water that rained out of the air",
        },
        Tally {
            account: "humidity.dried",
            unit: TallyUnit::Thickness,
            sign: -1,
            meaning: "Water that land and ice took from the air without rain",
        },
        LEFT,
        Tally {
            account: "soil_moisture.rained",
            unit: TallyUnit::Thickness,
            sign: 1,
            meaning: "Rain that fell on soil",
        },
        Tally {
            account: "soil_moisture.taken_up",
            unit: TallyUnit::Thickness,
            sign: -1,
            meaning: "Water that the air took up over soil",
        },
        Tally {
            account: "soil_moisture.ran_off",
            unit: TallyUnit::Thickness,
            sign: -1,
            meaning: "Rain that the soil could not keep",
        },
    ];
    type Params = MoistenParams<()>;
    type Out<R: Real> = [R; 3];
    type Sums<R: Real> = [R; 7];

    #[inline(always)]
    fn cell<R: Real>(p: &MoistenParams<R>, c: &impl Cell<R>) -> ([R; 3], [R; 7]) {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let (t, sea, frozen) = (c.here(3), c.here(4).lt(p.sea), c.here(6).gt(R::of(0.1)));
        let q = (c.here(0) + carrier(p).gain(c)).positive().named("(1) carried");
        let holds = capacity(t).named("(2) holds");

        let lake = c.here(5).gt(R::of(0.5)).pick(R::of(0.33), zero);
        let sea_share = frozen.pick(R::of(0.5), one);
        let wet = sea.pick(sea_share, frozen.pick(zero, lake));
        let lacks = (holds - q).positive();
        let uptake = (wet * p.uptake * lacks).named("(3) uptake");

        let kept = c.here(8);
        let growing = (t * R::of(0.1)).clamp(zero, one);
        let risen = (growing * kept * p.land_uptake * lacks).min(p.soil * kept);
        let risen = sea.pick(zero, risen).named("(3) risen");

        let relative = (q / holds.max(R::of(1e-6))).min(one);
        let rain = p.rain * q * relative + p.excess * (q - holds).positive();
        let rain = rain.min(q).named("(4) rain");
        let warm = (R::of(0.3) + R::of(0.4 / 30.0) * t).clamp(R::of(0.0), R::of(0.7));
        let dry = frozen.pick(p.ice_dry, sea.pick(zero, p.dry * warm)).named("(5) dry");
        let left = (q - rain).positive();
        let dried = left * dry;

        let humidity = ((left - dried) + (uptake + risen)).flushed();
        let fallen = c.here(7) + R::of(0.1) * (p.per_year * rain - c.here(7));
        let on_soil = sea.pick(zero, rain);
        let wetter = ((p.soil * kept).no_contract() - risen).positive() + on_soil;
        let soil = sea.pick(zero, (wetter * p.per_soil).min(one)).flushed().named("(7) soil");
        let ran_off = wetter - (p.soil * soil).no_contract();
        let sums = [
            p.depth * (uptake + risen),
            p.depth * rain,
            p.depth * dried,
            zero,
            p.depth * on_soil,
            p.depth * risen,
            p.depth * ran_off,
        ];
        ([humidity, fallen.flushed().named("(6) precipitation"), soil], sums)
    }

    #[inline(always)]
    fn boundary_outflow<R: Real>(p: &MoistenParams<R>, c: &impl Cell<R>, side: Side) -> Option<[R; 7]> {
        let (air, zero) = (carrier(p), R::of(0.0));
        let out = match side {
            Side::West => -air.east(c, -1),
            Side::East => air.east(c, 0),
            Side::North => -air.south(c, -1),
            Side::South => air.south(c, 0),
        };
        Some([zero, zero, zero, p.depth * out, zero, zero, zero])
    }
}
