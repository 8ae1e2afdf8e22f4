//! Climate zones: the source's table, Holdridge's life zones, and the classes of Koeppen and Geiger.
//!
//! # Equations
//! All layers hold numbers of classes, whose names and colours are in `SOURCE_ZONES`, `HOLDRIDGE_PROVINCES` and
//! `KOEPPEN_CLASSES`.
//! 1. `zone`: ice above `ice` is polar desert, the sea is ocean, water above `lake` a lake, discharge above `river` a
//!    river; else a table of `T = (mean - 12) / 24` (limits -0.8, -0.3, 0, 0.25, 0.5) and `q = rain / 2500` (0.1, 0.25,
//!    0.35, 0.5, 0.6, 0.75, 0.8).
//! 2. `holdridge`: the biotemperature `B`, the mean over the year of the temperature within 0..=30, against 1.5, 3, 6,
//!    12, 18, 24, and rain against 125, 250, ... 8000 mm.
//! 3. `humidity_province`: potential evapotranspiration over rain, `58.93 B / P`, against 16, 8, 4, 2, 1, 1/2, 1/4.
//! 4. `koeppen`: temperature `m + s cos`, rain likewise, from which come the months that the criteria ask for.
//!
//! # Source
//! (1) Gerteis 2017, in the classes of Holdridge 1947; (2) and (3) Holdridge 1967; (4) the criteria of Peel, Finlayson
//! and McMahon 2007 after Koeppen 1936.
//!
//! # Differences
//! - The source's humidity is linear and its driest class ends at 250 mm; Holdridge's is logarithmic and ends at 125 mm.
//! - Belts of life zones end at the biotemperature itself and their columns at the rain; the slanting sides of
//!   Holdridge's hexagons are not drawn.
//! - Koeppen's months are those of the first harmonic of the year (see `climate`), so that no second rainy season is seen.
//!
//! # Layers
//! Reads the layers of `climate`, `height`, `ice`, `water` (m), `flow_x`, `flow_y` (m3/s); writes `zone`, `holdridge`,
//! `humidity_province`, `koeppen`.
//!
//! # Limits
//! A limit itself belongs to the colder or drier class; `tests/it/zones.rs` checks all of them.

mod holdridge;
mod koeppen;
mod source;

pub use holdridge::{HOLDRIDGE_PROVINCES, biotemperature, life_zone, province};
pub use koeppen::{KOEPPEN_CLASSES, Months, koeppen};
pub use source::{SOURCE_ZONES, source_zone};

use crate::ice::ICE;
use crate::seasons::{RAIN_COS, RAIN_MEAN, RAIN_SIN, TEMPERATURE_COS, TEMPERATURE_MEAN, TEMPERATURE_SIN};
use crate::units::{CELSIUS_AT_ZERO, CELSIUS_PER_UNIT, MM_PER_HUMIDITY};
use crate::water::{FLOW_X, FLOW_Y};
use eyot_core::layer::Class;
use eyot_core::layer::known::{HEIGHT, WATER};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, check_ranges};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::{Grid, LayerSpec, Result, given, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Zones by the source's table.
pub const ZONE: LayerSpec = LayerSpec::new("zone", "1", "Climate zone, number of a class", (0.0, 40.0));
/// Life zones by Holdridge's limits.
pub const HOLDRIDGE: LayerSpec =
    LayerSpec::new("holdridge", "1", "Life zone after Holdridge, number of a class", (0.0, 40.0));
/// Humidity provinces by Holdridge's limits.
pub const HUMIDITY_PROVINCE: LayerSpec =
    LayerSpec::new("humidity_province", "1", "Humidity province after Holdridge, number of a class", (0.0, 8.0));
/// Classes of Koeppen and Geiger.
pub const KOEPPEN: LayerSpec =
    LayerSpec::new("koeppen", "1", "Climate after Koeppen and Geiger, number of a class", (0.0, 30.0));

/// The classes of a layer that holds numbers of classes; `None` for all other layers.
pub fn classes(layer: &str) -> Option<&'static [Class]> {
    match layer {
        "zone" | "holdridge" => Some(SOURCE_ZONES),
        "humidity_province" => Some(HOLDRIDGE_PROVINCES),
        "koeppen" => Some(KOEPPEN_CLASSES),
        _ => None,
    }
}

/// The source's table, Holdridge's life zones, and the classes of Koeppen and Geiger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Zones {
    /// Thickness from which ice makes a polar desert (100 m in the source, whose ice is much thicker).
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m"))]
    pub ice: f32,
    /// Depth from which water makes a lake.
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m"))]
    pub lake: f32,
    /// Discharge from which water makes a river: that of the Rhine is 2300.
    #[schemars(range(min = 0.0, max = 1000000.0), extend("unit" = "m3/s"))]
    pub river: f32,
}

impl Default for Zones {
    fn default() -> Self {
        Self { ice: 1.0, lake: 8.0, river: 2500.0 }
    }
}

impl Process for Zones {
    fn layers(&self) -> Vec<LayerUse> {
        let ground = [HEIGHT, ICE, WATER, FLOW_X, FLOW_Y];
        let seasons = [TEMPERATURE_COS, TEMPERATURE_SIN, RAIN_MEAN, RAIN_COS, RAIN_SIN];
        let read = ground.into_iter().chain(seasons).map(|l| l.read(0.0));
        let written = [ZONE, HOLDRIDGE, HUMIDITY_PROVINCE, KOEPPEN].into_iter().map(|l| l.written(0.0));
        read.chain(written).chain([TEMPERATURE_MEAN.read(CELSIUS_AT_ZERO)]).collect()
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("zones", self)
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let sea = moment.sea_level_m as f32;
        plan.push_given::<ByTable>(ByTableParams {
            sea: sea.into(),
            ice: given!(plan, self.ice),
            lake: given!(plan, self.lake),
            river: given!(plan, self.river),
        });
        plan.push::<ByMonths>(ByMonthsParams { sea });
    }
}

rule_params! {
    /// Parameters of [`ByTable`].
    pub struct ByTableParams {
        /// Level of the sea, m.
        sea,
        /// Thickness of ice from which it is polar desert, m.
        ice,
        /// Depth from which water is a lake, m.
        lake,
        /// Discharge from which water is a river, m3/s.
        river,
    }
}

/// Equation (1).
pub struct ByTable;

impl Rule for ByTable {
    const NAME: &'static str = "zones_by_table";
    const READS: &'static [Read] = &[
        read("temperature_mean", 0),
        read("rain_mean", 0),
        read("ice", 0),
        read("water", 0),
        read("height", 0),
        read("flow_x", 1),
        read("flow_y", 1),
    ];
    const WRITES: &'static [&'static str] = &["zone"];
    type Params = ByTableParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &ByTableParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let t = (c.here(0) - R::of(CELSIUS_AT_ZERO)) * R::of(1.0 / CELSIUS_PER_UNIT);
        let q = c.here(1) * R::of(1.0 / MM_PER_HUMIDITY);
        let discharge = c.here(5).abs().max(c.at(5, -1, 0).abs()).max(c.here(6).abs().max(c.at(6, 0, -1).abs()));
        let land = discharge.gt(p.river).pick(R::of(source::RIVER), source_zone(t, q));
        let wet = c.here(3).gt(p.lake).pick(R::of(source::LAKE), land);
        let level = c.here(4).lt(p.sea).pick(R::of(source::OCEAN), wet);
        ([c.here(2).gt(p.ice).pick(R::of(source::POLAR_DESERT), level)], [])
    }
}

rule_params! {
    /// Parameters of [`ByMonths`].
    pub struct ByMonthsParams {
        /// Level of the sea, m.
        sea,
    }
}

/// Equations (2) to (4).
pub struct ByMonths;

impl Rule for ByMonths {
    const NAME: &'static str = "zones_by_months";
    const READS: &'static [Read] = &[
        read("temperature_mean", 0),
        read("temperature_cos", 0),
        read("temperature_sin", 0),
        read("rain_mean", 0),
        read("rain_cos", 0),
        read("rain_sin", 0),
        read("height", 0),
    ];
    const WRITES: &'static [&'static str] = &["holdridge", "humidity_province", "koeppen"];
    type Params = ByMonthsParams<()>;
    type Out<R: Real> = [R; 3];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &ByMonthsParams<R>, c: &impl Cell<R>) -> ([R; 3], [R; 0]) {
        let zero = R::of(0.0);
        let (mean, cos, sin) = (c.here(0), c.here(1), c.here(2));
        let swing = (cos * cos + sin * sin).sqrt();
        let rain = c.here(3);
        let warm = biotemperature(mean, swing);
        let months = Months::of_harmonics(mean, [cos, sin, swing], rain, [c.here(4), c.here(5)]);
        let at_sea = c.here(6).lt(p.sea);
        let life = at_sea.pick(zero, life_zone(warm, rain));
        let humid = at_sea.pick(zero, province(warm, rain));
        ([life, humid, at_sea.pick(zero, koeppen(&months))], [])
    }
}

/// How many of the limits a value exceeds.
#[inline(always)]
pub(crate) fn exceeded<R: Real, const N: usize>(value: R, limits: [f32; N]) -> R {
    let mut count = R::of(0.0);
    for limit in limits {
        count = count + value.gt(R::of(limit)).one();
    }
    count
}
