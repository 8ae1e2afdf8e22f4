//! The rule that finds which bed lies where, equations (1) to (4) of the parent module.

use super::beds::{MOST_BEDS, SURFACES};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, ParamSet, Read, Rule, Tally, TallyUnit, read};

/// Parameters of [`Expose`].
#[derive(Clone, Copy, Debug)]
pub struct ExposeParams<T, const BEDS: usize> {
    /// The beds from the top: bottom below the datum (m), number of the material, erodibility, tangent of the steepest slope, and
    /// 1 / erodibility, at most 1e12. Those that are missing are the last bed, which begins above them.
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

/// Beds as thick everywhere, [`Expose`]'s `LIE`.
pub const FLAT: u8 = 0;
/// Beds of which the first have surfaces of their own.
pub const BENT: u8 = 1;
/// Beds that begin again below the last one.
pub const REPEATING: u8 = 2;

/// Equations (1) to (4) for up to `BEDS` beds above the last one, which lie as `LIE` says: [`FLAT`], [`BENT`] or [`REPEATING`]. `UNDER` new
/// rock, which [`Take`](super::new_rock::Take) has cut before, and of which [`Overlay`](super::new_rock::Overlay) says afterwards
/// where it lies. `SUMS` is 2 and one for each bed, the last one among them where it has no place among the `BEDS`.
pub struct Expose<const BEDS: usize, const SUMS: usize, const UNDER: bool, const LIE: u8>;

const fn worn(account: &'static str, meaning: &'static str) -> Tally {
    Tally { account, unit: TallyUnit::Thickness, sign: 0, meaning }
}

const ACCOUNTS: &[Tally] = &[
    worn("rock.worn", "Bedrock that others took from the height"),
    worn("rock.weathered", "Rock that became soil"),
    worn("rock.worn_bed_1", "Of the first bed, with what became soil"),
    worn("rock.worn_bed_2", "Of the second bed, with what became soil"),
    worn("rock.worn_bed_3", "Of the third bed, with what became soil"),
    worn("rock.worn_bed_4", "Of the fourth bed, with what became soil"),
    worn("rock.worn_bed_5", "Of the fifth bed, with what became soil"),
    worn("rock.worn_bed_6", "Of the sixth bed, with what became soil"),
    worn("rock.worn_bed_7", "Of the seventh bed, with what became soil"),
    worn("rock.worn_bed_8", "Of the eighth bed, with what became soil"),
    worn("rock.worn_bed_9", "Of the ninth bed, with what became soil"),
    worn("rock.worn_bed_10", "Of the tenth bed, with what became soil"),
    worn("rock.worn_bed_11", "Of the eleventh bed, with what became soil"),
    worn("rock.worn_bed_12", "Of the twelfth bed, with what became soil"),
    worn("rock.worn_bed_13", "Of the thirteenth bed, with what became soil"),
];
/// Sums that are not of a bed.
const OF_ALL: usize = 2;
/// Deeper than every bed that has a bottom, m.
const BOTTOMLESS: f32 = 1e19;

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

/// Bottom of a bed below the datum, m, given that of the one above it; the surfaces are read from slot `first` on.
#[inline(always)]
pub(super) fn bottom<R: Real, const BEDS: usize, const LIE: u8>(
    p: &ExposeParams<R, BEDS>,
    c: &impl Cell<R>,
    first: usize,
    i: usize,
    above: R,
) -> R {
    if LIE == BENT && i < SURFACES {
        (p.beds[i][0] + p.surfaces[i] * c.here(first + i)).max(above)
    } else if LIE == BENT {
        p.beds[i][0].max(above)
    } else {
        p.beds[i][0]
    }
}

/// A depth below the datum in the first turn of the beds.
#[inline(always)]
pub(super) fn fold<R: Real, const BEDS: usize, const LIE: u8>(p: &ExposeParams<R, BEDS>, depth: R) -> R {
    if LIE == REPEATING { depth - p.sequence * (depth * p.per_sequence).floor() } else { depth }
}

/// How much of what lies between two depths each bed is, m, into the sums from `FIRST` on. Above the first turn lies the last bed, which has a
/// sum behind those of the `BEDS` where it is none of them.
#[inline(always)]
pub(super) fn shares<R: Real, const BEDS: usize, const SUMS: usize, const FIRST: usize, const LIE: u8>(
    bottoms: &[R; BEDS],
    from: R,
    to: R,
    sums: &mut [R; SUMS],
) {
    let zero = R::of(0.0);
    let begin = if LIE == REPEATING { from.positive() } else { from };
    let before = begin - from;
    let mut deepest = R::of(-1e30);
    let mut i = 0;
    while i < BEDS {
        // What no bed has above it begins at the top.
        let top = if i == 0 { begin } else { begin.max(bottoms[i - 1]) };
        let share = (to.min(bottoms[i]) - top).positive();
        let is_last = R::of(BOTTOMLESS).lt(bottoms[i]);
        sums[FIRST + i] = if LIE == REPEATING { share + is_last.pick(before, zero) } else { share };
        deepest = deepest.max(bottoms[i]);
        i += 1;
    }
    if FIRST + BEDS < SUMS {
        let share = (to - begin.max(deepest)).positive();
        let is_last = R::of(BOTTOMLESS).lt(deepest);
        let before = is_last.pick(zero, before);
        sums[FIRST + BEDS] = if LIE == REPEATING { share + before } else { share };
    }
}

impl<const BEDS: usize, const SUMS: usize, const UNDER: bool, const LIE: u8> Expose<BEDS, SUMS, UNDER, LIE> {
    const FIRST_SURFACE: usize = if UNDER { TOP + 1 } else { TIME + 1 };
}

impl<const BEDS: usize, const SUMS: usize, const UNDER: bool, const LIE: u8> Rule for Expose<BEDS, SUMS, UNDER, LIE> {
    const NAME: &'static str = match (BEDS, UNDER, LIE) {
        (4, false, _) => "strata_expose_4",
        (4, true, _) => "strata_expose_4_under",
        (8, false, FLAT) => "strata_expose_8",
        (8, true, FLAT) => "strata_expose_8_under",
        (8, false, BENT) => "strata_expose_8_bent",
        (8, true, BENT) => "strata_expose_8_bent_under",
        (8, false, _) => "strata_expose_8_repeating",
        (8, true, _) => "strata_expose_8_repeating_under",
        (_, false, FLAT) => "strata_expose_12",
        (_, true, FLAT) => "strata_expose_12_under",
        (_, false, BENT) => "strata_expose_12_bent",
        (_, true, BENT) => "strata_expose_12_bent_under",
        (_, false, _) => "strata_expose_12_repeating",
        (_, true, _) => "strata_expose_12_repeating_under",
    };
    const READS: &'static [Read] = match (UNDER, LIE) {
        (false, BENT) => {
            reads![read("erodibility", 0), read("bed_1", 0), read("bed_2", 0), read("bed_3", 0), read("bed_4", 0)]
        }
        (true, BENT) => reads![
            read("cut_time", 0),
            read("cut_top", 0),
            read("bed_1", 0),
            read("bed_2", 0),
            read("bed_3", 0),
            read("bed_4", 0)
        ],
        (false, _) => reads![read("erodibility", 0)],
        (true, _) => reads![read("cut_time", 0), read("cut_top", 0)],
    };
    const WRITES: &'static [&'static str] =
        &["height", "sediment", "bedrock", "material", "erodibility", "rock_slope", "bed_left", "erodibility_below"];
    const TALLIES: &'static [Tally] = ACCOUNTS.split_at(SUMS).0;
    type Params = ExposeParams<(), BEDS>;
    type Out<R: Real> = [R; 8];
    type Sums<R: Real> = [R; SUMS];

    #[inline(always)]
    fn cell<R: Real>(p: &ExposeParams<R, BEDS>, c: &impl Cell<R>) -> ([R; 8], [R; SUMS]) {
        let zero = R::of(0.0);
        let (height, before, datum) = (c.here(HEIGHT), c.here(BEDROCK), c.here(DATUM));
        // (1) What was cut of the rock below `top`, and the time that it took.
        let (top, told) = if UNDER {
            (c.here(TOP), c.here(TIME))
        } else {
            let cut = (before - height).positive();
            (before, (cut / c.here(TIME).max(R::of(1e-6))).named("(1) time"))
        };
        let most = (top - height).positive();
        // Each bed wears for as long as there is some of it, then the next one. How long those above it take follows from what there is of them, so
        // that no bed waits for what came of the one before.
        let depth = fold::<R, BEDS, LIE>(p, datum - top);
        let time = told.positive();
        let (mut cut, mut spent, mut begin) = (zero, zero, depth);
        let mut bottoms = [zero; BEDS];
        let mut above = R::of(-1e30);
        let mut i = 0;
        while i < BEDS {
            let bed = p.beds[i];
            above = bottom::<R, BEDS, LIE>(p, c, Self::FIRST_SURFACE, i, above);
            bottoms[i] = above;
            let there = (above - begin).positive();
            cut = cut + there.min(bed[2] * (time - spent).positive());
            spent = spent + there * bed[4];
            begin = depth.max(above);
            i += 1;
        }
        let cut = (cut + p.last[2] * (time - spent).positive()).min(most).named("(1) cut");
        let spared = (most - cut).min(c.here(SEDIMENT)).named("(1) spared");
        let ground = (height + spared).named("height");
        let load = (c.here(SEDIMENT) - (ground - height)).positive().named("sediment");
        let bare = top.min(ground);
        // (2) Rock becomes soil; new rock has seen to that itself.
        let buried = ground - bare;
        let soil = p.soil * (-(buried * p.per_soil_depth)).exp();
        let soil = if UNDER { told.lt(zero).pick(zero, soil) } else { soil };
        let rock = (bare - soil).named("(2) bedrock");
        // (3) From below, so that the uppermost bed that reaches down to here is the last to be chosen.
        let depth = fold::<R, BEDS, LIE>(p, datum - rock);
        let mut here = p.last;
        let (mut bottom, mut below) = (R::of(1e6) + depth, p.last[2]);
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
        }
        let mut sums = [zero; SUMS];
        sums[0] = top - bare;
        sums[1] = bare - rock;
        shares::<R, BEDS, SUMS, OF_ALL, LIE>(&bottoms, depth - (top - rock), depth, &mut sums);
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
