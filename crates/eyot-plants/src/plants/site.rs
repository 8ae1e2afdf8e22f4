//! What the climate of a cell is to plants: equations (1) to (3) of the parent module.

use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::rule_params;

rule_params! {
    /// Parameters of [`Site`].
    pub struct SiteParams {
        /// Mean temperature of the year at level of the sea, °C.
        temperature,
        /// Half of what the warmest month is warmer than the coldest, K.
        swing,
        /// How much colder it is higher up, K/m.
        lapse,
        /// Rain of the year, mm.
        rain,
        /// By how much the driest month lies below the mean one, over that.
        dry_season,
        /// Thickness of the soil, m.
        soil,
        /// How much moister valleys are, 1.
        hollows,
        /// Half of one over the cell's east-west size, 1/m.
        per_2dx,
        /// Half of one over its north-south size, 1/m.
        per_2dy,
        /// `1 / slope^2` of the steepest soil, 1.
        per_steepest,
        /// Water that drowns, m.
        wet,
        /// Level of the sea, m.
        sea,
        /// Level of the sea, or 0 on land without one, m.
        datum,
    }
}

/// Equations (1) to (3), with the climate as layers have it or as it was given.
pub struct Site<const LAYERS: bool>;

const HEIGHT: usize = 0;
const GIVEN: [Read; 4] = [read("height", 1), read("drained_area", 0), read("water", 0), read("lake", 0)];
const FROM_LAYERS: [Read; 10] = [
    GIVEN[0],
    GIVEN[1],
    GIVEN[2],
    GIVEN[3],
    read("temperature_mean", 0),
    read("temperature_cos", 0),
    read("temperature_sin", 0),
    read("rain_mean", 0),
    read("rain_cos", 0),
    read("rain_sin", 0),
];

/// The angle whose cosine is `x`, from 0 to pi (Abramowitz and Stegun 1964, 4.4.45: error below 7e-5).
#[inline(always)]
fn acos<R: Real>(x: R) -> R {
    let (one, x) = (R::of(1.0), x.clamp(R::of(-1.0), R::of(1.0)));
    let a = x.abs();
    let series = R::of(1.570_728_8) + a * (R::of(-0.212_114_4) + a * (R::of(0.074_261_0) - a * R::of(0.018_729_3)));
    let angle = (one - a).max(R::of(0.0)).sqrt() * series;
    x.lt(R::of(0.0)).pick(R::of(std::f32::consts::PI) - angle, angle)
}

/// Half the year's share, as an angle, for which a temperature of this mean and swing is above `limit`, and its mean excess over the year.
#[inline(always)]
fn above<R: Real>(mean: R, swing: R, limit: f32) -> (R, R) {
    let (over, pi) = (mean - R::of(limit), R::of(1.0 / std::f32::consts::PI));
    let x = (R::of(0.0) - over) / swing;
    let angle = acos(x);
    let cos = x.clamp(R::of(-1.0), R::of(1.0));
    let sin = (R::of(1.0) - cos * cos).max(R::of(0.0)).sqrt();
    (angle, ((over * angle + swing * sin) * pi).positive())
}

/// 0 at `low`, 1 at `high`, straight between.
#[inline(always)]
pub(super) fn ramp<R: Real>(x: R, low: R, high: R) -> R {
    ((x - low) / (high - low)).clamp(R::of(0.0), R::of(1.0))
}

impl<const LAYERS: bool> Rule for Site<LAYERS> {
    const NAME: &'static str = if LAYERS { "plants_site_from_layers" } else { "plants_site" };
    const READS: &'static [Read] = if LAYERS { &FROM_LAYERS } else { &GIVEN };
    const WRITES: &'static [&'static str] =
        &["site_winter", "site_summer", "site_warmth", "site_trees", "site_moisture", "site_driest", "site_leaves"];
    type Params = SiteParams<()>;
    type Out<R: Real> = [R; 7];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &SiteParams<R>, c: &impl Cell<R>) -> ([R; 7], [R; 0]) {
        let of = R::of;
        let (zero, one) = (of(0.0), of(1.0));
        let height = c.here(HEIGHT);
        // (1) The year.
        let (mean, swing, rain, dip) = if LAYERS {
            let swing = (c.here(5) * c.here(5) + c.here(6) * c.here(6)).sqrt();
            let dip = (c.here(8) * c.here(8) + c.here(9) * c.here(9)).sqrt();
            (c.here(4), swing, c.here(7), (dip / c.here(7).max(one)).min(one))
        } else {
            (p.temperature - p.lapse * (height - p.datum), p.swing, p.rain, p.dry_season)
        };
        let swing = swing.max(of(0.1));
        let (winter, summer) = (mean - swing, mean + swing);
        let (_, warmth) = above(mean, swing, 5.0);
        let warmth = (warmth * of(365.0)).named("(1) warmth");
        // (2) The season in which trees grow: TREELIM.
        let (angle, excess) = above(mean, swing, 0.9);
        let days = angle * of(365.0 / std::f32::consts::PI);
        let season = of(0.9) + excess * of(std::f32::consts::PI) / angle.max(of(1e-3));
        let long = ramp(days, of(90.0), of(98.0));
        let trees = (ramp(season, of(6.3), of(6.5)) * long * (of(0.3) + of(0.7) * ramp(season, of(6.4), of(12.0))))
            .named("(2) trees");
        // (3) Water.
        let (_, bio) = above(mean, swing, 0.0);
        let evaporation = of(58.93) * bio.clamp(of(0.5), of(30.0));
        let x = (c.at(HEIGHT, 1, 0) - c.at(HEIGHT, -1, 0)) * p.per_2dx;
        let y = (c.at(HEIGHT, 0, 1) - c.at(HEIGHT, 0, -1)) * p.per_2dy;
        let holds = (one - (x * x + y * y) * p.per_steepest).positive();
        let soil = p.soil * holds;
        let store = of(1.25) * soil / (soil + of(0.25));
        let gathers = (one + c.here(1) * of(1e-4)).ln() * of(0.1);
        let supply = rain * store * (one + p.hollows * gathers.min(one));
        let moisture = (supply / evaporation).named("(3) moisture");
        let wet = c.here(2).max(c.here(3));
        let land = wet.lt(p.wet).pick(height.lt(p.sea).pick(zero, one), zero);
        let moisture = moisture * land;
        // Rain counts for more where little evaporates, less than in proportion.
        let warm = (evaporation * of(1.0 / 1450.0)).sqrt().sqrt();
        let warm = warm * warm * warm;
        let cover = (of(2.03) * moisture * warm - of(0.142)).max(of(0.6) * moisture * warm).min(of(0.985));
        let leaves = (of(-2.0) * (one - cover).ln() + of(1e-3)).named("(3) leaves");
        ([winter, summer, warmth, trees, moisture, moisture * (one - dip), leaves], [])
    }
}
