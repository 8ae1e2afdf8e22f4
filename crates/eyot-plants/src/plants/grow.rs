//! A year of a cohort of trees or bushes: equations (6) to (9) of the parent module.

use super::canopy::{EXTINCTION, cohort, height, least, leaves_above, mass};
use super::site::ramp;
use crate::types::{BIOMASS, GROW, STEM, TYPES};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, TallyUnit, read};
use eyot_core::rule_params;

rule_params! {
    /// Parameters of [`Grow`].
    pub struct GrowParams {
        /// Share of the seeds that reach the next cell to the east or west.
        east,
        /// Share that reach the next cell to the north or south.
        south,
        /// Share that reach a cell across a corner.
        corner,
        /// Chance that seeds from far away come in a year.
        far,
        /// Share of a cell that falls when its old plants die.
        gap,
    }
}

/// Stream of the random numbers of falling trees and far seeds; the type is added.
const CHANCE: u32 = 0x706c_6100;

const fn account(account: &'static str, sign: i8, meaning: &'static str) -> Tally {
    Tally { account, unit: TallyUnit::Thickness, sign, meaning }
}

/// What grows, dies and burns. A kg/m2 of dry matter is a mm, as water would be: 1 m3 in the ledger is 1 t.
pub(super) const MATTER: [Tally; 3] = [
    account("plants.grown", 1, "Dry matter that grew, less what plants that stay need; 1 m3 is 1 t"),
    account("plants.died", -1, "Dry matter of plants that died of age, shade, thirst, floods and slides; 1 m3 is 1 t"),
    account("plants.burnt", -1, "Dry matter of plants that fires killed; 1 m3 is 1 t"),
];
/// Thickness of a kg/m2 of dry matter in the ledger, m.
pub(super) const LEDGER_M: f32 = 1e-3;

/// A year of type `T`.
pub struct Grow<const T: usize>;

impl<const T: usize> Rule for Grow<T> {
    const NAME: &'static str = GROW[T];
    const READS: &'static [Read] = &[
        read(BIOMASS[T], 1),
        read(STEM[T], 0),
        read("suits", 0),
        read("leaves_above_0", 0),
        read("leaves_above_5", 0),
        read("leaves_above_16", 0),
        read("site_leaves", 0),
        read("turf", 0),
        read("burnt_area", 0),
        read("overturned", 0),
    ];
    const WRITES: &'static [&'static str] = &[BIOMASS[T], STEM[T]];
    const TALLIES: &'static [Tally] = &MATTER;
    type Params = GrowParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 3];

    #[inline(always)]
    fn cell<R: Real>(p: &GrowParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 3]) {
        let of = R::of;
        let (zero, one) = (of(0.0), of(1.0));
        let t = const { &TYPES[T] };
        let (biomass, suits, turf) = (c.here(0), c.here(2), c.here(7));
        let stem = c.here(1).max(of(least(t)));
        let k = cohort(t, biomass, stem);
        // (6) Light, and with it how well it grows.
        let levels = [c.here(3), c.here(4), c.here(5)];
        let extinction = of(-EXTINCTION);
        let light = (extinction * leaves_above(levels, of(0.7) * k.height)).exp();
        let vigour = (lit::<R, T>(light) * suits).named("(6) vigour");
        // (7) Who stands too close dies, who starves, who is old.
        let bears = of(1.0 / leaves_borne(t.shade));
        let full = levels[0] / c.here(6);
        let crowd = (leaves_above(levels, of(0.4) * k.height) * bears).max(full).named("(7) crowd");
        let thins = (of(0.4) * (crowd - one)).clamp(zero, of(0.97));
        let starves = (one - vigour * of(1.0 / 0.06)).positive() * of(0.25);
        let chance = c.uniform(CHANCE + T as u32);
        let old = of(2.3 / t.age);
        let falls = chance.lt(old).pick(p.gap, zero);
        let fades = of(4.6 / t.age) - old * p.gap;
        let stays = (one - (fades + thins + starves).min(of(0.97))) * (one - falls) * (one - c.here(9));
        let tall = ramp(k.height, of(5.0), of(14.0));
        let survives = of(t.fire) * (of(0.6) + of(0.4) * ramp(k.height, of(2.0), of(5.0))) + of(0.9 - t.fire) * tall;
        let passes = one - c.here(8) * (one - survives);
        let alive = (k.number * stays * passes).named("(7) alive");
        // (8) JABOWA, in m.
        let (foot, rise) = (t.foot(), t.height - t.foot());
        let (b2, b3) = (2.0 * rise / t.stem, rise / (t.stem * t.stem));
        let left = one - stem * k.height * of(1.0 / (t.stem * t.height));
        let slows = of(2.0 * foot) + stem * (of(3.0 * b2) - of(4.0 * b3) * stem);
        let competes = if t.is_tree() { one - of(0.5) * turf * ramp(of(5.0) - k.height, zero, of(3.0)) } else { one };
        let thirst = (of(1.3) - of(0.5) * full).clamp(zero, one);
        let rate = of(0.01 * t.growth) * stem * left.positive() / slows;
        let thicker = (stem + rate * vigour * thirst * competes).min(of(t.stem)).named("(8) stem");
        // (9) Seeds of the cells around, and from far away.
        let edges = p.east * (c.at(0, 1, 0) + c.at(0, -1, 0)) + p.south * (c.at(0, 0, 1) + c.at(0, 0, -1));
        let corners = p.corner * ((c.at(0, 1, 1) + c.at(0, -1, -1)) + (c.at(0, -1, 1) + c.at(0, 1, -1)));
        let near = biomass + (edges + corners);
        let near = near / (near + of(0.5));
        let seeds = near.max((one - p.far).lt(chance).pick(of(0.5), zero));
        let room = (one - (levels[0] * bears).max(full)).positive();
        let ground = (extinction * (levels[0] + of(0.9) * turf)).exp();
        let grass = if t.is_tree() { one - of(0.6) * turf } else { one };
        let roots = room * lit::<R, T>(ground) * (of(3.0) * suits).min(one) * seeds * grass * of(0.08);
        let new = of(least(t));
        let number = alive + roots;
        let blend = (alive * thicker * thicker + roots * new * new) / number.max(of(1e-12));
        let none = number.lt(of(1e-7));
        let stem_now = none.pick(new, blend.sqrt().clamp(new, of(t.stem))).named("(9) stem");
        let now = none.pick(zero, number * mass(t, stem_now, height(t, stem_now))).named("(9) biomass");
        let died = biomass * (one - stays);
        let burnt = biomass * stays * (one - passes);
        let grown = now - biomass + (died + burnt);
        ([now, stem_now], [grown, died, burnt].map(|v| v * of(LEDGER_M)))
    }
}

/// Leaf area in whose shade a type that tolerates as much can still live.
pub(super) fn leaves_borne(shade: f32) -> f32 {
    -eyot_core::math::ln(least_light(shade)) / EXTINCTION
}

/// Light at which growth ends.
const fn least_light(shade: f32) -> f32 {
    0.10 - 0.07 * 0.25 * (shade - 1.0)
}

/// Growth in this light over that in full light, between JABOWA's curves for trees that need light and those that bear shade.
#[inline(always)]
fn lit<R: Real, const T: usize>(light: R) -> R {
    let of = R::of;
    let s = const { 0.25 * (TYPES[T].shade - 1.0) };
    let (high, bends) = (2.24 - 1.24 * s, 1.136 + 3.504 * s);
    let curve = of(1.0) - (of(-bends) * (light - of(const { least_light(TYPES[T].shade) }))).exp();
    (of(high) * curve).clamp(of(0.0), of(1.0))
}
