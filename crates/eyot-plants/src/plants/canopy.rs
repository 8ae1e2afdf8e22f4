//! Light: leaves of each type, and how many lie above a height. Equations (4) and (5) of the parent module.

use super::site::ramp;
use crate::types::{BIOMASS, PlantType, SHADE, STEM, STEM_FORM, SUIT, TYPES};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, ParamSet, Read, Rule, read};

/// Heights above which leaves are counted, m.
pub(super) const LEVELS: [f32; 3] = [0.0, 5.0, 16.0];
/// Above the last level leaves thin out to nothing at this height, m.
const TOP: f32 = 40.0;
/// Light that passes a unit of leaf area, as the exponent of Beer's law.
pub(super) const EXTINCTION: f32 = 0.5;
/// Leaves of a stem: `LEAVES D^(7/4)`, m2 for D in m.
const LEAVES: f32 = 1350.0;

/// A cohort: what follows from its dry matter and its stems' diameter.
pub(super) struct Cohort<R> {
    /// Plants, 1/m2.
    pub number: R,
    /// Height, m.
    pub height: R,
    /// Leaf area over ground, 1.
    pub leaves: R,
}

/// Height of plants of a type whose stems are this thick, m.
#[inline(always)]
pub(super) fn height<R: Real>(t: &PlantType, stem: R) -> R {
    let share = (stem * R::of(1.0 / t.stem)).clamp(R::of(0.0), R::of(1.0));
    R::of(t.foot()) + R::of(t.height - t.foot()) * share * (R::of(2.0) - share)
}

/// Dry matter of a plant, kg.
#[inline(always)]
pub(super) fn mass<R: Real>(t: &PlantType, stem: R, height: R) -> R {
    R::of(STEM_FORM * t.wood) * stem * stem * height
}

/// Equation (4): a cohort of `biomass` kg/m2 with stems of `stem` m.
#[inline(always)]
pub(super) fn cohort<R: Real>(t: &PlantType, biomass: R, stem: R) -> Cohort<R> {
    let stem = stem.max(R::of(least(t)));
    let height = height(t, stem);
    let number = biomass / mass(t, stem, height);
    let leaves = number * R::of(LEAVES) * stem * (stem * stem.sqrt()).sqrt();
    Cohort { number, height, leaves }
}

/// Diameter of stems that take root, m.
pub(super) const fn least(t: &PlantType) -> f32 {
    if t.stem < 0.05 { 0.2 * t.stem } else { 0.01 }
}

/// Leaf area above `z`, from that above the levels.
#[inline(always)]
pub(super) fn leaves_above<R: Real>(levels: [R; 3], z: R) -> R {
    let of = R::of;
    let low = levels[0] + (levels[1] - levels[0]) * ramp(z, of(LEVELS[0]), of(LEVELS[1]));
    let middle = levels[1] + (levels[2] - levels[1]) * ramp(z, of(LEVELS[1]), of(LEVELS[2]));
    let high = levels[2] * (of(1.0) - ramp(z, of(LEVELS[2]), of(TOP)));
    z.lt(of(LEVELS[1])).pick(low, z.lt(of(LEVELS[2])).pick(middle, high))
}

/// Equation (4): adds the leaves of type `T` above each level.
pub struct Shade<const T: usize>;

/// Of rules that have no parameters.
#[derive(Clone, Copy, Debug)]
pub struct NoParams;

impl ParamSet for NoParams {
    type Of<T: Copy + 'static> = Self;
    const NAMES: &'static [&'static str] = &[];

    fn build<U: Copy + 'static>(_: impl FnMut(&'static str) -> U) -> Self {
        Self
    }

    #[inline(always)]
    fn map<T: Copy + 'static, U: Copy + 'static>(_: &Self, _: impl FnMut(&'static str, T) -> U) -> Self {
        Self
    }
}

impl<const T: usize> Rule for Shade<T> {
    const NAME: &'static str = SHADE[T];
    const READS: &'static [Read] = &[
        read(BIOMASS[T], 0),
        read(STEM[T], 0),
        read("leaves_above_0", 0),
        read("leaves_above_5", 0),
        read("leaves_above_16", 0),
    ];
    const WRITES: &'static [&'static str] = &["leaves_above_0", "leaves_above_5", "leaves_above_16"];
    type Params = NoParams;
    type Out<R: Real> = [R; 3];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(_: &NoParams, c: &impl Cell<R>) -> ([R; 3], [R; 0]) {
        let of = R::of;
        let k = cohort(&TYPES[T], c.here(0), c.here(1));
        // Crowns hang down to two fifths of the height.
        let per_depth = of(1.0) / (of(0.6) * k.height + of(0.1));
        let share = |z: f32| ((k.height - of(z)) * per_depth).clamp(of(0.0), of(1.0));
        let [a, b, d] = [share(LEVELS[0]), share(LEVELS[1]), share(LEVELS[2])];
        ([c.here(2) + k.leaves * a, c.here(3) + k.leaves * b, c.here(4) + k.leaves * d], [])
    }
}

/// Equation (5): how well the climate suits type `T`.
pub struct Suit<const T: usize>;

impl<const T: usize> Rule for Suit<T> {
    const NAME: &'static str = SUIT[T];
    const READS: &'static [Read] = &[
        read("site_winter", 0),
        read("site_summer", 0),
        read("site_warmth", 0),
        read("site_trees", 0),
        read("site_moisture", 0),
        read("site_driest", 0),
    ];
    const WRITES: &'static [&'static str] = &["suits"];
    type Params = NoParams;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(_: &NoParams, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let t = const { &TYPES[T] };
        let warm = climate(t, c.here(0), c.here(1), c.here(2));
        let water = ramp(c.here(4), R::of(t.moisture[0]), R::of(t.moisture[1]));
        let season = ramp(c.here(5), R::of(t.driest[0]), R::of(t.driest[1]));
        let grows = if t.is_tree() { warm * c.here(3) } else { warm };
        ([grows * water * season], [])
    }
}

/// How well the temperatures of a year suit a type.
#[inline(always)]
pub(super) fn climate<R: Real>(t: &PlantType, winter: R, summer: R, warmth: R) -> R {
    let of = R::of;
    let mild = ramp(winter, of(t.winter[0] - 1.0), of(t.winter[0] + 1.0));
    let cold = ramp(of(0.0) - winter, of(-t.winter[1] - 1.0), of(1.0 - t.winter[1]));
    let cool = ramp(of(0.0) - summer, of(-t.summer - 1.0), of(1.0 - t.summer));
    mild * cold * cool * ramp(warmth, of(0.75 * t.warmth - 1.0), of(t.warmth))
}
