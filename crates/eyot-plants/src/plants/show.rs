//! What a world shows of its plants, and how they hold the ground: equations (13) and (14) of the parent module.

use super::canopy::{EXTINCTION, NoParams, cohort};
use crate::types::{BIOMASS, C3, C4, SHOW, STEM, TYPES};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::rule_params;

rule_params! {
    /// Parameters of [`Disturb`].
    pub struct DisturbParams {
        /// `1 / slide`, 1/m.
        per_slide,
    }
}

/// Which share slides of the last year and rivers overturned; and empty canopies, which [`Shade`](super::Shade) fills.
pub struct Disturb;

impl Rule for Disturb {
    const NAME: &'static str = "plants_disturb";
    const READS: &'static [Read] = &[read("height", 0), read("plants_ground", 0), read("river", 0)];
    const WRITES: &'static [&'static str] =
        &["plants_ground", "overturned", "leaves_above_0", "leaves_above_5", "leaves_above_16"];
    type Params = DisturbParams<()>;
    type Out<R: Real> = [R; 5];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &DisturbParams<R>, c: &impl Cell<R>) -> ([R; 5], [R; 0]) {
        let (zero, height) = (R::of(0.0), c.here(0));
        let share = ((height - c.here(1)).abs() * p.per_slide).max(c.here(2)).min(R::of(1.0));
        ([height, share, zero, zero, zero], [])
    }
}

/// The ground on which plants begin.
pub struct Ground;

impl Rule for Ground {
    const NAME: &'static str = "plants_ground";
    const READS: &'static [Read] = &[read("height", 0)];
    const WRITES: &'static [&'static str] = &["plants_ground"];
    type Params = NoParams;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(_: &NoParams, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        ([c.here(0)], [])
    }
}

/// Begins with grass what [`Show`] adds trees and bushes to.
pub struct Begin;

impl Rule for Begin {
    const NAME: &'static str = "plants_begin";
    const READS: &'static [Read] = &[read("biomass_c3_grass", 0), read("biomass_c4_grass", 0)];
    const WRITES: &'static [&'static str] =
        &["plant_mass", "most_mass", "plant_type", "canopy_height", "tree_leaves", "shrub_leaves", "grass"];
    type Params = NoParams;
    type Out<R: Real> = [R; 7];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(_: &NoParams, c: &impl Cell<R>) -> ([R; 7], [R; 0]) {
        let of = R::of;
        let (cool, warm) = (c.here(0), c.here(1));
        let grass = cool + warm;
        // 10 m2 of blades a kg.
        let cover = of(1.0) - (of(-10.0 * EXTINCTION) * grass).exp();
        let kind = cool.lt(warm).pick(of(C4 as f32 + 1.0), of(C3 as f32 + 1.0));
        let grows = cover.gt(of(0.1));
        let tall = cool.lt(warm).pick(of(TYPES[C4].height), of(TYPES[C3].height));
        let zero = of(0.0);
        // What dominates has to cover a tenth of the ground, trees and bushes before grass.
        ([grass, zero, grows.pick(kind, zero), grows.pick(tall, zero), zero, zero, cover], [])
    }
}

/// Adds type `T`.
pub struct Show<const T: usize>;

impl<const T: usize> Rule for Show<T> {
    const NAME: &'static str = SHOW[T];
    const READS: &'static [Read] = &[
        read(BIOMASS[T], 0),
        read(STEM[T], 0),
        read("plant_mass", 0),
        read("most_mass", 0),
        read("plant_type", 0),
        read("canopy_height", 0),
        read("tree_leaves", 0),
        read("shrub_leaves", 0),
    ];
    const WRITES: &'static [&'static str] =
        &["plant_mass", "most_mass", "plant_type", "canopy_height", "tree_leaves", "shrub_leaves"];
    type Params = NoParams;
    type Out<R: Real> = [R; 6];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(_: &NoParams, c: &impl Cell<R>) -> ([R; 6], [R; 0]) {
        let of = R::of;
        let t = const { &TYPES[T] };
        let k = cohort(t, c.here(0), c.here(1));
        // Covers a tenth of the ground, and weighs more than the others that do.
        let seen = k.leaves.lt(of(0.21)).pick(of(0.0), c.here(0));
        let most = c.here(3).lt(seen);
        let (trees, shrubs) = if t.is_tree() { (k.leaves, of(0.0)) } else { (of(0.0), k.leaves) };
        let out = [
            c.here(2) + c.here(0),
            most.pick(seen, c.here(3)),
            most.pick(of(T as f32 + 1.0), c.here(4)),
            most.pick(k.height, c.here(5)),
            c.here(6) + trees,
            c.here(7) + shrubs,
        ];
        (out, [])
    }
}

/// Equation (13): cover.
pub struct Cover;

impl Rule for Cover {
    const NAME: &'static str = "plants_cover";
    const READS: &'static [Read] = &[read("tree_leaves", 0), read("shrub_leaves", 0), read("plant_mass", 0)];
    const WRITES: &'static [&'static str] = &["forest", "shrubs", "leaf_area"];
    type Params = NoParams;
    type Out<R: Real> = [R; 3];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(_: &NoParams, c: &impl Cell<R>) -> ([R; 3], [R; 0]) {
        let cover = |leaves: R| R::of(1.0) - (R::of(-EXTINCTION) * leaves).exp();
        ([cover(c.here(0)), cover(c.here(1)), c.here(0) + c.here(1)], [])
    }
}

rule_params! {
    /// Parameters of [`Hold`].
    pub struct HoldParams {
        /// Share of the wear that a full cover prevents.
        hold,
    }
}

/// Equation (14): roots and leaves hold the ground.
pub struct Hold;

impl Rule for Hold {
    const NAME: &'static str = "plants_hold";
    const READS: &'static [Read] = &[
        read("erodibility", 0),
        read("erodibility_bare", 0),
        read("erodibility_held", 0),
        read("forest", 0),
        read("shrubs", 0),
        read("grass", 0),
    ];
    const WRITES: &'static [&'static str] = &["erodibility", "erodibility_bare", "erodibility_held"];
    type Params = HoldParams<()>;
    type Out<R: Real> = [R; 3];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &HoldParams<R>, c: &impl Cell<R>) -> ([R; 3], [R; 0]) {
        let one = R::of(1.0);
        let (found, held) = (c.here(0), c.here(2));
        // What others wrote since is the bare ground's; what is as it was left is the bare ground's of before.
        let same = (found - held).abs().lt(R::of(1e-5) * held.abs() + R::of(1e-12));
        let bare = same.pick(c.here(1), found);
        let open = (one - c.here(3)) * (one - c.here(4)) * (one - R::of(0.7) * c.here(5));
        let now = (bare * (one - p.hold * (one - open))).named("(14) erodibility");
        ([now, bare, now], [])
    }
}
