//! New rock that hardened on the bedrock: how it is cut, and where it comes to light. Equations (1) to (4) of the parent module.
//!
//! Six slots, softest above. Since deposits only ever harden, and loose ground always lies on top, the order of the slots is that of
//! the column, and equal neighbours are one slot.

use super::expose::covered;
use crate::sequence::SLOTS;
use eyot_core::real::Real;
use eyot_core::rule::{Cell, ParamSet, Read, Rule, Tally, TallyUnit, read};

/// Parameters of [`Take`] and [`Overlay`].
#[derive(Clone, Copy, Debug)]
pub struct NewRockParams<T> {
    /// The slots from the top: number of the material, erodibility, tangent of the steepest slope, 1 / erodibility, at most 1e12.
    pub slots: [[T; 4]; SLOTS],
    /// Loose ground, as in [`ExposeParams`](super::ExposeParams).
    pub loose: [T; 5],
    /// `1 / cover`, 1/m.
    pub per_cover: T,
    /// Bare rock that becomes soil in a step, m.
    pub soil: T,
    /// `1 / soil_depth`, 1/m.
    pub per_soil_depth: T,
}

const NAMES: &[&str] = &[
    "material_1",
    "erodibility_1",
    "slope_1",
    "wear_1",
    "material_2",
    "erodibility_2",
    "slope_2",
    "wear_2",
    "material_3",
    "erodibility_3",
    "slope_3",
    "wear_3",
    "material_4",
    "erodibility_4",
    "slope_4",
    "wear_4",
    "material_5",
    "erodibility_5",
    "slope_5",
    "wear_5",
    "material_6",
    "erodibility_6",
    "slope_6",
    "wear_6",
    "loose_bottom",
    "loose_material",
    "loose_erodibility",
    "loose_slope",
    "loose_wear",
    "per_cover",
    "soil",
    "per_soil_depth",
];

impl ParamSet for NewRockParams<()> {
    type Of<T: Copy + 'static> = NewRockParams<T>;
    const NAMES: &'static [&'static str] = NAMES;

    fn build<U: Copy + 'static>(mut f: impl FnMut(&'static str) -> U) -> NewRockParams<U> {
        let mut names = NAMES.iter();
        let mut next = || f(names.next().copied().unwrap_or_default());
        let slots = std::array::from_fn(|_| std::array::from_fn(|_| next()));
        let loose = std::array::from_fn(|_| next());
        let [per_cover, soil, per_soil_depth] = std::array::from_fn(|_| next());
        NewRockParams { slots, loose, per_cover, soil, per_soil_depth }
    }

    #[inline(always)]
    fn map<T: Copy + 'static, U: Copy + 'static>(
        p: &NewRockParams<T>,
        mut f: impl FnMut(&'static str, T) -> U,
    ) -> NewRockParams<U> {
        let mut names = NAMES.iter();
        let mut next = |v: T| f(names.next().copied().unwrap_or_default(), v);
        let slots = p.slots.map(|slot| slot.map(&mut next));
        let loose = p.loose.map(&mut next);
        let [per_cover, soil, per_soil_depth] = [p.per_cover, p.soil, p.per_soil_depth].map(&mut next);
        NewRockParams { slots, loose, per_cover, soil, per_soil_depth }
    }
}

/// Equations (1) and (2) for new rock: what others took from the height is taken from the slots, each for as long as it lasts, and
/// bare new rock becomes soil. What is left of the time (below 0: there is new rock left) and the top of what is left are for
/// [`Expose`](super::Expose).
pub struct Take;

const fn lost(account: &'static str, meaning: &'static str) -> Tally {
    Tally { account, unit: TallyUnit::Thickness, sign: 0, meaning }
}

impl Rule for Take {
    const NAME: &'static str = "strata_take";
    const READS: &'static [Read] = &[
        read("height", 0),
        read("bedrock", 0),
        read("erodibility", 0),
        read("new_rock_1", 0),
        read("new_rock_2", 0),
        read("new_rock_3", 0),
        read("new_rock_4", 0),
        read("new_rock_5", 0),
        read("new_rock_6", 0),
        read("sediment", 0),
    ];
    const WRITES: &'static [&'static str] =
        &["cut_time", "cut_top", "new_rock_1", "new_rock_2", "new_rock_3", "new_rock_4", "new_rock_5", "new_rock_6"];
    const TALLIES: &'static [Tally] = &[
        Tally {
            account: "rock.worn_new",
            unit: TallyUnit::Thickness,
            sign: 0,
            meaning: "New rock that others took from the height",
        },
        Tally {
            account: "rock.weathered_new",
            unit: TallyUnit::Thickness,
            sign: 0,
            meaning: "New rock that became soil",
        },
        lost("rock.worn_new_1", "Of its first stage, with what became soil"),
        lost("rock.worn_new_2", "Of its second stage, with what became soil"),
        lost("rock.worn_new_3", "Of its third stage, with what became soil"),
        lost("rock.worn_new_4", "Of its fourth stage, with what became soil"),
        lost("rock.worn_new_5", "Of its fifth stage, with what became soil"),
        lost("rock.worn_new_6", "Of its sixth stage, with what became soil"),
    ];
    type Params = NewRockParams<()>;
    type Out<R: Real> = [R; 8];
    type Sums<R: Real> = [R; 2 + SLOTS];

    #[inline(always)]
    fn cell<R: Real>(p: &NewRockParams<R>, c: &impl Cell<R>) -> ([R; 8], [R; 2 + SLOTS]) {
        let zero = R::of(0.0);
        let (height, before) = (c.here(0), c.here(1));
        let cut = (before - height).positive();
        let time = (cut / c.here(2).max(R::of(1e-6))).named("(1) time");
        // What cannot be given back from the sediment is cut, however hard it is.
        let must = (cut - c.here(9)).positive();
        let soil = p.soil * (-((height - before).positive() * p.per_soil_depth)).exp();
        let (mut thick, mut slots) = ([zero; SLOTS], [zero; SLOTS]);
        let (mut sum, mut became) = (zero, zero);
        // Of the slots above: the time that they take, their thickness, and what is left of them for the soil.
        let (mut spent, mut above, mut bare) = (zero, zero, zero);
        let mut i = 0;
        while i < SLOTS {
            let there = c.here(3 + i);
            thick[i] = there;
            let most = (cut - above).positive();
            let wears = (p.slots[i][1] * (time - spent).positive()).max((must - above).positive());
            let worn = there.min(wears).min(most);
            spent = spent + there * p.slots[i][3];
            above = above + there;
            let left = there - worn;
            let weathered = left.min((soil - bare).positive());
            bare = bare + left;
            became = became + weathered;
            slots[i] = left - weathered;
            sum = sum + worn;
            i += 1;
        }
        let rest = (slots[0] + slots[1]) + (slots[2] + slots[3]) + (slots[4] + slots[5]);
        // What was cut too fast is given back by the rule that comes next.
        let time = zero.lt(rest).pick(R::of(-1.0), (time - spent).positive());
        let [a, b, c, d, e, f] = slots;
        let of = |k: usize| thick[k] - slots[k];
        let sums = [sum, became, of(0), of(1), of(2), of(3), of(4), of(5)];
        ([time, (before - sum) - became, a, b, c, d, e, f], sums)
    }
}

/// Material, erodibility and slope of new rock where there is some: of the lower three slots, then (`UPPER`) of the upper three and
/// of the loose ground on them, equation (4).
pub struct Overlay<const UPPER: bool>;

/// New rock thinner than this is not seen, m.
const SEEN: f32 = 0.001;

macro_rules! reads {
    ($($slot:literal),* ; $($more:literal),*) => {
        &[
            read("material", 0),
            read("erodibility", 0),
            read("rock_slope", 0),
            read("bed_left", 0),
            read("erodibility_below", 0),
            $(read($slot, 0),)*
            $(read($more, 0),)*
        ]
    };
}

impl<const UPPER: bool> Rule for Overlay<UPPER> {
    const NAME: &'static str = if UPPER { "strata_overlay_upper" } else { "strata_overlay_lower" };
    const READS: &'static [Read] = if UPPER {
        reads!["new_rock_1", "new_rock_2", "new_rock_3"; "height", "bedrock"]
    } else {
        reads!["new_rock_4", "new_rock_5", "new_rock_6"; ]
    };
    const WRITES: &'static [&'static str] = &["material", "erodibility", "rock_slope", "bed_left", "erodibility_below"];
    type Params = NewRockParams<()>;
    type Out<R: Real> = [R; 5];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &NewRockParams<R>, c: &impl Cell<R>) -> ([R; 5], [R; 0]) {
        let [mut material, mut erodibility, mut slope] = [c.here(0), c.here(1), c.here(2)];
        let [mut left, mut below] = [c.here(3), c.here(4)];
        let first = if UPPER { 0 } else { 3 };
        let mut i = 3;
        while i > 0 {
            i -= 1;
            let (slot, there) = (p.slots[first + i], c.here(5 + i));
            let seen = R::of(SEEN).lt(there);
            below = seen.pick(erodibility, below);
            left = seen.pick(there, left);
            material = seen.pick(slot[0], material);
            erodibility = seen.pick(slot[1], erodibility);
            slope = seen.pick(slot[2], slope);
        }
        if UPPER {
            let loose = c.here(8) - c.here(9);
            let [material, erodibility, left, below] =
                covered(p.loose, p.per_cover, loose, [material, erodibility, left, below]);
            return ([material, erodibility, slope, left, below], []);
        }
        ([material, erodibility, slope, left, below], [])
    }
}
