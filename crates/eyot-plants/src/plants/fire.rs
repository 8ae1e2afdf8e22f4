//! Grass, and the fires that it carries: equations (10) to (12) of the parent module.

use super::canopy::{EXTINCTION, NoParams, climate};
use super::grow::{LEDGER_M, MATTER};
use super::site::ramp;
use crate::types::{C3, C4, TYPES};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, read};
use eyot_core::rule_params;

/// Streams of random numbers.
const BURNS: u32 = 0x706c_6201;
const LIT: u32 = 0x706c_6202;

rule_params! {
    /// Parameters of [`Kindle`].
    pub struct KindleParams {
        /// Chance that a cell is lit in a year.
        lit,
        /// Cover of trees up to which grass carries fire.
        open,
        /// Cover of trees from which it does not.
        closed,
        /// Chance that fire goes through a closed forest in a dry season.
        crowns,
    }
}

/// Equation (10): grass, and where fire can go and begins.
pub struct Kindle;

impl Rule for Kindle {
    const NAME: &'static str = "plants_kindle";
    const READS: &'static [Read] = &[
        read("biomass_c3_grass", 0),
        read("biomass_c4_grass", 0),
        read("site_driest", 0),
        read("leaves_above_0", 0),
        read("site_moisture", 0),
    ];
    const WRITES: &'static [&'static str] = &["turf", "burns", "burnt_area"];
    type Params = KindleParams<()>;
    type Out<R: Real> = [R; 3];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &KindleParams<R>, c: &impl Cell<R>) -> ([R; 3], [R; 0]) {
        let of = R::of;
        let (zero, one) = (of(0.0), of(1.0));
        let grass = c.here(0) + c.here(1);
        let turf = (grass * of(1.0 / 0.3)).min(one);
        let dry = (one - c.here(2) * of(1.0 / 0.6)).positive();
        let cover = one - (of(-EXTINCTION) * c.here(3)).exp();
        let fuel = ramp(grass, of(0.08), of(0.35));
        let opens = ramp(p.closed - cover, zero, p.closed - p.open);
        let carries = dry * (opens * fuel).max(p.crowns * cover);
        // Water and bare rock do not burn.
        let carries = c.here(4).gt(of(0.01)).pick(carries, zero);
        let burns = c.uniform(BURNS).lt(carries).one();
        ([turf, burns, burns * c.uniform(LIT).lt(p.lit).one()], [])
    }
}

/// Equation (11): fire goes to the cells around that can burn.
pub struct Spread;

impl Rule for Spread {
    const NAME: &'static str = "plants_spread";
    const READS: &'static [Read] = &[read("burnt_area", 1), read("burns", 0)];
    const WRITES: &'static [&'static str] = &["burnt_area"];
    type Params = NoParams;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(_: &NoParams, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let edges = c.at(0, 1, 0).max(c.at(0, -1, 0)).max(c.at(0, 0, 1).max(c.at(0, 0, -1)));
        let corners = c.at(0, 1, 1).max(c.at(0, -1, -1)).max(c.at(0, -1, 1).max(c.at(0, 1, -1)));
        ([c.here(0).max(edges.max(corners) * c.here(1))], [])
    }
}

rule_params! {
    /// Parameters of [`Grass`].
    pub struct GrassParams {
        /// 1 if there is grass of cool countries, else 0.
        cool,
        /// 1 if there is grass of warm countries, else 0.
        warm,
    }
}

/// Equation (12): a year of grass.
pub struct Grass;

impl Rule for Grass {
    const NAME: &'static str = "plants_grass";
    const READS: &'static [Read] = &[
        read("biomass_c3_grass", 0),
        read("biomass_c4_grass", 0),
        read("site_winter", 0),
        read("site_summer", 0),
        read("site_warmth", 0),
        read("site_moisture", 0),
        read("leaves_above_0", 0),
        read("burnt_area", 0),
        read("overturned", 0),
    ];
    const WRITES: &'static [&'static str] = &["biomass_c3_grass", "biomass_c4_grass"];
    const TALLIES: &'static [Tally] = &MATTER;
    type Params = GrassParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 3];

    #[inline(always)]
    fn cell<R: Real>(p: &GrassParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 3]) {
        let of = R::of;
        let (zero, one) = (of(0.0), of(1.0));
        let suits = |n: usize| {
            let t = &TYPES[n];
            climate(t, c.here(2), c.here(3), c.here(4)) * ramp(c.here(5), of(t.moisture[0]), of(t.moisture[1]))
        };
        let season = ramp(c.here(4), zero, of(400.0));
        let light = (of(-1.2 * EXTINCTION) * c.here(6)).exp();
        let (cool, warm) = (p.cool * suits(C3) * season, p.warm * suits(C4) * season);
        // Where both would grow they share.
        let share = one / (cool + warm).max(one);
        let most = [
            of(0.35) * cool * share * (of(1.2) * light - of(0.1)).clamp(zero, one),
            of(0.60) * warm * share * (of(1.4) * light - of(0.4)).clamp(zero, one),
        ];
        let mut sums = [zero; 3];
        let mut year = |before: R, most: R| {
            let burnt = of(0.9) * c.here(7) * before;
            let torn = (before - burnt) * c.here(8);
            let left = before - burnt - torn;
            let change = of(0.6) * (most - left);
            let now = (left + change).flushed();
            let now = now.lt(of(1e-6)).pick(zero, now);
            let died = torn + (left - now).positive();
            sums = [sums[0] + (now - left).positive(), sums[1] + died, sums[2] + burnt];
            now
        };
        let now = [year(c.here(0), most[0]), year(c.here(1), most[1])];
        (now, sums.map(|v| v * of(LEDGER_M)))
    }
}
