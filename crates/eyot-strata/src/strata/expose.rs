//! The rule that finds which bed lies where, equations (1) to (4) of the parent module.

use super::beds::{MOST_BEDS, SURFACES};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, ParamSet, Read, Rule, Tally, TallyUnit, read};

/// Parameters of [`Expose`].
#[derive(Clone, Copy, Debug)]
pub struct ExposeParams<T, const BEDS: usize> {
    /// The beds from the top: bottom below the datum (m), number of the material, erodibility, tangent of the steepest slope, and
    /// 1 / erodibility or 0. Those that are missing are the last bed, which begins above them.
    pub beds: [[T; 5]; BEDS],
    /// The bed without a bottom, in the same way.
    pub last: [T; 5],
    /// Loose ground, in the same way.
    pub loose: [T; 5],
    /// Thickness of the sequence if it repeats, else 0, m.
    pub sequence: T,
    /// `1 / sequence`, or 0, 1/m.
    pub per_sequence: T,
    /// `1 / cover`, 1/m.
    pub per_cover: T,
    /// Bare rock that becomes soil in a step, m.
    pub soil: T,
    /// `1 / soil_depth`, 1/m.
    pub per_soil_depth: T,
    /// What a surface of a bed counts for: 1 if it is how much lower the bottom lies, -1 if it is the bottom's height, 0 if there is none.
    pub surfaces: [T; SURFACES],
}

/// What stands before the beds.
const SHARED: usize = 15 + SURFACES;
const NAMES: &[&str] = &[
    "last_bottom",
    "last_material",
    "last_erodibility",
    "last_slope",
    "last_wear",
    "loose_bottom",
    "loose_material",
    "loose_erodibility",
    "loose_slope",
    "loose_wear",
    "sequence",
    "per_sequence",
    "per_cover",
    "soil",
    "per_soil_depth",
    "surface_1",
    "surface_2",
    "surface_3",
    "surface_4",
    "bottom_1",
    "material_1",
    "erodibility_1",
    "slope_1",
    "wear_1",
    "bottom_2",
    "material_2",
    "erodibility_2",
    "slope_2",
    "wear_2",
    "bottom_3",
    "material_3",
    "erodibility_3",
    "slope_3",
    "wear_3",
    "bottom_4",
    "material_4",
    "erodibility_4",
    "slope_4",
    "wear_4",
    "bottom_5",
    "material_5",
    "erodibility_5",
    "slope_5",
    "wear_5",
    "bottom_6",
    "material_6",
    "erodibility_6",
    "slope_6",
    "wear_6",
    "bottom_7",
    "material_7",
    "erodibility_7",
    "slope_7",
    "wear_7",
    "bottom_8",
    "material_8",
    "erodibility_8",
    "slope_8",
    "wear_8",
    "bottom_9",
    "material_9",
    "erodibility_9",
    "slope_9",
    "wear_9",
    "bottom_10",
    "material_10",
    "erodibility_10",
    "slope_10",
    "wear_10",
    "bottom_11",
    "material_11",
    "erodibility_11",
    "slope_11",
    "wear_11",
    "bottom_12",
    "material_12",
    "erodibility_12",
    "slope_12",
    "wear_12",
];
const _: () = assert!(NAMES.len() == SHARED + 5 * MOST_BEDS);

impl<const BEDS: usize> ParamSet for ExposeParams<(), BEDS> {
    type Of<T: Copy + 'static> = ExposeParams<T, BEDS>;
    const NAMES: &'static [&'static str] = NAMES.split_at(SHARED + 5 * BEDS).0;

    fn build<U: Copy + 'static>(mut f: impl FnMut(&'static str) -> U) -> ExposeParams<U, BEDS> {
        let mut names = NAMES.iter();
        let mut next = || f(names.next().copied().unwrap_or_default());
        let [last, loose] = std::array::from_fn(|_| std::array::from_fn(|_| next()));
        let [sequence, per_sequence, per_cover, soil, per_soil_depth] = std::array::from_fn(|_| next());
        let surfaces = std::array::from_fn(|_| next());
        let beds = std::array::from_fn(|_| std::array::from_fn(|_| next()));
        ExposeParams { beds, last, loose, sequence, per_sequence, per_cover, soil, per_soil_depth, surfaces }
    }

    #[inline(always)]
    fn map<T: Copy + 'static, U: Copy + 'static>(
        p: &ExposeParams<T, BEDS>,
        mut f: impl FnMut(&'static str, T) -> U,
    ) -> ExposeParams<U, BEDS> {
        let mut names = NAMES.iter();
        let mut next = |v: T| f(names.next().copied().unwrap_or_default(), v);
        let [last, loose] = [p.last, p.loose].map(|bed| bed.map(&mut next));
        let shared = [p.sequence, p.per_sequence, p.per_cover, p.soil, p.per_soil_depth];
        let [sequence, per_sequence, per_cover, soil, per_soil_depth] = shared.map(&mut next);
        let surfaces = p.surfaces.map(&mut next);
        let beds = p.beds.map(|bed| bed.map(&mut next));
        ExposeParams { beds, last, loose, sequence, per_sequence, per_cover, soil, per_soil_depth, surfaces }
    }
}

/// Equations (1) to (4) for up to `BEDS` beds above the last one. `UNDER` new rock, which [`Take`](super::new_rock::Take) has cut
/// before, and of which [`Overlay`](super::new_rock::Overlay) says afterwards where it lies; `BENT`: with surfaces of single beds.
pub struct Expose<const BEDS: usize, const UNDER: bool, const BENT: bool>;

const fn worn(account: &'static str, meaning: &'static str) -> Tally {
    Tally { account, unit: TallyUnit::Thickness, sign: 0, meaning }
}

/// Beds whose wear has an account of its own.
const COUNTED: usize = 8;
const HEIGHT: usize = 0;
const BEDROCK: usize = 1;
const DATUM: usize = 2;
const SEDIMENT: usize = 3;
/// Erodibility; for what lies under new rock what is left of the time, see [`Take`](super::new_rock::Take).
const TIME: usize = 4;
/// Top of what is left of the new rock.
const TOP: usize = 5;

macro_rules! reads {
    ($($more:expr),*) => {
        &[read("height", 0), read("bedrock", 0), read("bed_datum", 0), read("sediment", 0), $($more),*]
    };
}

impl<const BEDS: usize, const UNDER: bool, const BENT: bool> Expose<BEDS, UNDER, BENT> {
    const FIRST_SURFACE: usize = if UNDER { TOP + 1 } else { TIME + 1 };

    /// Bottom of a bed below the datum, m, given that of the one above it.
    #[inline(always)]
    fn bottom<R: Real>(p: &ExposeParams<R, BEDS>, c: &impl Cell<R>, i: usize, above: R) -> R {
        if BENT && i < SURFACES {
            (p.beds[i][0] + p.surfaces[i] * c.here(Self::FIRST_SURFACE + i)).max(above)
        } else if BENT {
            p.beds[i][0].max(above)
        } else {
            p.beds[i][0]
        }
    }
}

impl<const BEDS: usize, const UNDER: bool, const BENT: bool> Rule for Expose<BEDS, UNDER, BENT> {
    const NAME: &'static str = match (BEDS, UNDER, BENT) {
        (4, false, false) => "strata_expose_4",
        (4, true, false) => "strata_expose_4_under",
        (_, false, false) => "strata_expose_12",
        (_, true, false) => "strata_expose_12_under",
        (_, false, true) => "strata_expose_12_bent",
        (_, true, true) => "strata_expose_12_bent_under",
    };
    const READS: &'static [Read] = match (UNDER, BENT) {
        (false, false) => reads![read("erodibility", 0)],
        (true, false) => reads![read("cut_time", 0), read("cut_top", 0)],
        (false, true) => {
            reads![read("erodibility", 0), read("bed_1", 0), read("bed_2", 0), read("bed_3", 0), read("bed_4", 0)]
        }
        (true, true) => reads![
            read("cut_time", 0),
            read("cut_top", 0),
            read("bed_1", 0),
            read("bed_2", 0),
            read("bed_3", 0),
            read("bed_4", 0)
        ],
    };
    const WRITES: &'static [&'static str] =
        &["height", "sediment", "bedrock", "material", "erodibility", "rock_slope", "bed_left", "erodibility_below"];
    const TALLIES: &'static [Tally] = &[
        worn("rock.worn", "Bedrock that others took from the height"),
        worn("rock.weathered", "Rock that became soil"),
        worn("rock.worn_bed_1", "Of the first bed"),
        worn("rock.worn_bed_2", "Of the second bed"),
        worn("rock.worn_bed_3", "Of the third bed"),
        worn("rock.worn_bed_4", "Of the fourth bed"),
        worn("rock.worn_bed_5", "Of the fifth bed"),
        worn("rock.worn_bed_6", "Of the sixth bed"),
        worn("rock.worn_bed_7", "Of the seventh bed"),
        worn("rock.worn_bed_8", "Of the eighth bed"),
    ];
    type Params = ExposeParams<(), BEDS>;
    type Out<R: Real> = [R; 8];
    type Sums<R: Real> = [R; 10];

    #[inline(always)]
    fn cell<R: Real>(p: &ExposeParams<R, BEDS>, c: &impl Cell<R>) -> ([R; 8], [R; 10]) {
        let zero = R::of(0.0);
        let (height, before, datum) = (c.here(HEIGHT), c.here(BEDROCK), c.here(DATUM));
        // (1) What was cut of the rock below `top`, and the time that it took.
        let (top, time) = if UNDER {
            (c.here(TOP), c.here(TIME))
        } else {
            let cut = (before - height).positive();
            (before, (cut / c.here(TIME).max(R::of(1e-6))).named("(1) time"))
        };
        let most = (top - height).positive();
        let fold = |rock: R| {
            let depth = datum - rock;
            depth - p.sequence * (depth * p.per_sequence).floor()
        };
        // Each bed wears for as long as there is some of it, then the next one.
        let depth = fold(top);
        let mut left = time.positive();
        let mut reached = depth;
        let mut bottoms = [zero; BEDS];
        let mut above = R::of(-1e30);
        let mut i = 0;
        while i < BEDS {
            let bed = p.beds[i];
            above = Self::bottom(p, c, i, above);
            bottoms[i] = above;
            let there = (above - reached).positive();
            let worn = there.min(bed[2] * left);
            left = worn.lt(there).pick(zero, left - worn * bed[4]).positive();
            reached = reached + worn;
            i += 1;
        }
        reached = reached + p.last[2] * left;
        let cut = (reached - depth).min(most).named("(1) cut");
        let spared = (most - cut).min(c.here(SEDIMENT)).named("(1) spared");
        let ground = (height + spared).named("height");
        let load = (c.here(SEDIMENT) - (ground - height)).positive().named("sediment");
        let bare = top.min(ground);
        // (2) Rock becomes soil; new rock has seen to that itself.
        let buried = ground - bare;
        let soil = p.soil * (-(buried * p.per_soil_depth)).exp();
        let soil = if UNDER { time.lt(zero).pick(zero, soil) } else { soil };
        let rock = (bare - soil).named("(2) bedrock");
        // (3) From below, so that the uppermost bed that reaches down to here is the last to be chosen.
        let depth = fold(rock);
        let mut here = p.last;
        let (mut bottom, mut below) = (R::of(1e6) + depth, p.last[2]);
        let mut sums = [zero; 10];
        let (from, to) = (depth - (top - rock), depth);
        while i > 0 {
            i -= 1;
            let bed = p.beds[i];
            let inside = depth.lt(bottoms[i]);
            let next = if i + 1 < BEDS { p.beds[i + 1][2] } else { p.last[2] };
            bottom = inside.pick(bottoms[i], bottom);
            below = inside.pick(next, below);
            here = [
                here[0],
                inside.pick(bed[1], here[1]),
                inside.pick(bed[2], here[2]),
                inside.pick(bed[3], here[3]),
                here[4],
            ];
            if i < COUNTED {
                let begin = if i == 0 { from } else { from.max(bottoms[i - 1]) };
                sums[2 + i] = (to.min(bottoms[i]) - begin).positive();
            }
        }
        sums[0] = top - bare;
        sums[1] = bare - rock;
        let reach = (bottom - depth).min(R::of(1e6));
        if UNDER {
            return ([ground, load, rock, here[1], here[2], here[3], reach, below], sums);
        }
        let [material, erodibility, left, below] =
            covered(p.loose, p.per_cover, ground - rock, [here[1], here[2], reach, below]);
        ([ground, load, rock, material, erodibility, here[3], left, below], sums)
    }
}

/// Equation (4): material, erodibility, thickness of the material and erodibility of what lies below, under `loose` metres of loose
/// ground.
#[inline(always)]
pub(super) fn covered<R: Real>(ground: [R; 5], per_cover: R, loose: R, rock: [R; 4]) -> [R; 4] {
    let covers = loose * per_cover;
    let bare = (-covers).exp();
    // A cover that shelters two thirds is what one sees; a tenth of it is what water has to dig through first.
    let seen = covers.lt(R::of(1.0));
    let dug = covers.lt(R::of(0.1));
    [
        seen.pick(rock[0], ground[1]),
        ground[2] + (rock[1] - ground[2]) * bare,
        dug.pick(rock[2], loose),
        dug.pick(rock[3], rock[1]),
    ]
}
