//! Seasons: moving means of temperature and rain, and how both swing with the year. Maps of climate are made of these.
//!
//! # Equations
//! `x` temperature or precipitation, `f` the time of the year (0 in the northern spring), `a = 1 - e^(-t / memory)`, or
//! 1 over the number of turns so far if that is more.
//! 1. `mean' = mean + a (x - mean)`.
//! 2. `cos' = cos + a (2 (x - mean') cos f - cos)`, and the same with the sine. The swing is `sqrt(cos^2 + sin^2)`.
//!
//! # Source
//! The first harmonic of a year, as moving means.
//!
//! # Differences
//! - Tables of climate take twelve monthly means. The first harmonic has three numbers instead, which rules of cells
//!   can keep; what it cannot hold is a second rainy season.
//!
//! # Layers
//! Reads `temperature` (degrees Celsius), `precipitation` (mm a year); reads and writes `temperature_mean`,
//! `temperature_cos`, `temperature_sin`, `rain_mean`, `rain_cos`, `rain_sin`.
//!
//! # Limits
//! The memory should be some years long, else the swing shows in the mean. Where the process acts in every n-th step
//! only, the memory is n times as long.

use crate::humidity::PRECIPITATION;
use crate::sky;
use crate::temperature::TEMPERATURE;
use crate::units::{CELSIUS_AT_ZERO, hours_per_step};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, check_ranges};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::{Grid, LayerSpec, Result, given, math, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Mean of the temperature over some years.
pub const TEMPERATURE_MEAN: LayerSpec =
    LayerSpec::new("temperature_mean", "°C", "Temperature of the air, mean of some years", (-600.0, 600.0));
/// How the temperature swings with spring and autumn.
pub const TEMPERATURE_COS: LayerSpec =
    LayerSpec::new("temperature_cos", "°C", "Swing of the temperature with the northern spring", (-600.0, 600.0));
/// How the temperature swings with summer and winter.
pub const TEMPERATURE_SIN: LayerSpec =
    LayerSpec::new("temperature_sin", "°C", "Swing of the temperature with the northern summer", (-600.0, 600.0));
/// Mean of the precipitation over some years.
pub const RAIN_MEAN: LayerSpec = LayerSpec::new("rain_mean", "mm/a", "Rain and snow, mean of some years", (0.0, 1e8));
/// How the precipitation swings with spring and autumn.
pub const RAIN_COS: LayerSpec =
    LayerSpec::new("rain_cos", "mm/a", "Swing of rain and snow with the northern spring", (-1e8, 1e8));
/// How the precipitation swings with summer and winter.
pub const RAIN_SIN: LayerSpec =
    LayerSpec::new("rain_sin", "mm/a", "Swing of rain and snow with the northern summer", (-1e8, 1e8));

/// Moving means of temperature and rain, and how both swing with the year.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub struct Climate {
    /// Time after which two thirds of the past are forgotten: some years.
    #[schemars(range(min = 1.0, max = 10000000.0), extend("unit" = "h"))]
    pub memory: f32,
    /// The year.
    #[serde(flatten)]
    pub seasons: sky::Seasons,
}

impl Default for Climate {
    fn default() -> Self {
        Self { memory: 1920.0, seasons: sky::Seasons::default() }
    }
}

impl Process for Climate {
    fn layers(&self) -> Vec<LayerUse> {
        vec![
            TEMPERATURE.read(CELSIUS_AT_ZERO),
            PRECIPITATION.read(0.0),
            TEMPERATURE_MEAN.changed(CELSIUS_AT_ZERO),
            TEMPERATURE_COS.changed(0.0),
            TEMPERATURE_SIN.changed(0.0),
            RAIN_MEAN.changed(0.0),
            RAIN_COS.changed(0.0),
            RAIN_SIN.changed(0.0),
        ]
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("climate", self)
    }

    fn seconds_per_step(&self, grid: &Grid) -> Option<f64> {
        Some(3600.0 * hours_per_step(grid))
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let (turns, turning) = (moment.turn as f32 + 1.0, self.seasons.year > 0.0);
        let hours = hours_per_step(&moment.grid) as f32;
        let phase = self.seasons.phase(moment);
        let doubled = if turning { 2.0 } else { 0.0 };
        plan.push_given::<SeasonalHarmonics>(SeasonalHarmonicsParams {
            share: (1.0 - math::exp(-hours / given!(plan, self.memory))).max((1.0 / turns).into()),
            spring: (doubled * math::cos(phase)).into(),
            summer: (doubled * math::sin(phase)).into(),
        });
    }
}

rule_params! {
    /// Parameters of [`SeasonalHarmonics`].
    pub struct SeasonalHarmonicsParams {
        /// Weight of what is now, 1.
        share,
        /// Twice the cosine of the time of the year, 1.
        spring,
        /// Twice its sine, 1.
        summer,
    }
}

/// Equations (1) and (2) for both.
pub struct SeasonalHarmonics;

impl Rule for SeasonalHarmonics {
    const NAME: &'static str = "climate_remember";
    const READS: &'static [Read] = &[
        read("temperature", 0),
        read("precipitation", 0),
        read("temperature_mean", 0),
        read("temperature_cos", 0),
        read("temperature_sin", 0),
        read("rain_mean", 0),
        read("rain_cos", 0),
        read("rain_sin", 0),
    ];
    const WRITES: &'static [&'static str] =
        &["temperature_mean", "temperature_cos", "temperature_sin", "rain_mean", "rain_cos", "rain_sin"];
    type Params = SeasonalHarmonicsParams<()>;
    type Out<R: Real> = [R; 6];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &SeasonalHarmonicsParams<R>, c: &impl Cell<R>) -> ([R; 6], [R; 0]) {
        let [t, t_cos, t_sin] = remembered(p, c, 0, 2);
        let [r, r_cos, r_sin] = remembered(p, c, 1, 5);
        ([t, t_cos, t_sin, r.positive(), r_cos, r_sin], [])
    }
}

#[inline(always)]
fn remembered<R: Real>(p: &SeasonalHarmonicsParams<R>, c: &impl Cell<R>, now: usize, first: usize) -> [R; 3] {
    let (x, mean) = (c.here(now), c.here(first));
    let mean = (mean + p.share * (x - mean)).flushed();
    let (cos, sin) = (c.here(first + 1), c.here(first + 2));
    [mean, swing(p, cos, p.spring * (x - mean)), swing(p, sin, p.summer * (x - mean))]
}

/// Equation (2).
#[inline(always)]
fn swing<R: Real>(p: &SeasonalHarmonicsParams<R>, old: R, now: R) -> R {
    (old + p.share * (now - old)).flushed()
}
