//! What standing water softened: taken from new rock first, then told of the beds.
//!
//! The process `soak` lowers the bedrock's surface and keeps by how much in the layer `soaked`; what that was, only the beds know.

use super::expose::{BENT, ExposeParams, bottom, fold, shares};
use super::{MOST_BEDS, NewRockParams};
use crate::sequence::SLOTS;
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, TallyUnit, read};

const fn soaked(account: &'static str, meaning: &'static str) -> Tally {
    Tally { account, unit: TallyUnit::Thickness, sign: 0, meaning }
}

/// New rock loses what was softened of it; the rest is left for [`Soaked`].
pub struct Drain;

impl Rule for Drain {
    const NAME: &'static str = "strata_drain";
    const READS: &'static [Read] = &[
        read("soaked", 0),
        read("new_rock_1", 0),
        read("new_rock_2", 0),
        read("new_rock_3", 0),
        read("new_rock_4", 0),
        read("new_rock_5", 0),
        read("new_rock_6", 0),
    ];
    const WRITES: &'static [&'static str] =
        &["soaked", "new_rock_1", "new_rock_2", "new_rock_3", "new_rock_4", "new_rock_5", "new_rock_6"];
    const TALLIES: &'static [Tally] = &[
        soaked("rock.soaked_new_1", "Of the first stage of new rock"),
        soaked("rock.soaked_new_2", "Of the second stage of new rock"),
        soaked("rock.soaked_new_3", "Of the third stage of new rock"),
        soaked("rock.soaked_new_4", "Of the fourth stage of new rock"),
        soaked("rock.soaked_new_5", "Of the fifth stage of new rock"),
        soaked("rock.soaked_new_6", "Of the sixth stage of new rock"),
    ];
    type Params = NewRockParams<()>;
    type Out<R: Real> = [R; 1 + SLOTS];
    type Sums<R: Real> = [R; SLOTS];

    #[inline(always)]
    fn cell<R: Real>(_: &NewRockParams<R>, c: &impl Cell<R>) -> ([R; 1 + SLOTS], [R; SLOTS]) {
        let mut out = [R::of(0.0); 1 + SLOTS];
        let mut sums = [R::of(0.0); SLOTS];
        out[0] = c.here(0);
        let mut i = 0;
        while i < SLOTS {
            let there = c.here(1 + i);
            let lost = there.min(out[0]);
            out[1 + i] = there - lost;
            out[0] = out[0] - lost;
            sums[i] = lost;
            i += 1;
        }
        (out, sums)
    }
}

/// Which beds were softened, as [`Expose`](super::Expose) tells which were worn.
pub struct Soaked<const LIE: u8>;

impl<const LIE: u8> Rule for Soaked<LIE> {
    const NAME: &'static str = match LIE {
        super::FLAT => "strata_soaked",
        BENT => "strata_soaked_bent",
        _ => "strata_soaked_repeating",
    };
    const READS: &'static [Read] = match LIE {
        BENT => &[
            read("soaked", 0),
            read("bedrock", 0),
            read("bed_datum", 0),
            read("bed_1", 0),
            read("bed_2", 0),
            read("bed_3", 0),
            read("bed_4", 0),
        ],
        _ => &[read("soaked", 0), read("bedrock", 0), read("bed_datum", 0)],
    };
    const WRITES: &'static [&'static str] = &["soaked"];
    const TALLIES: &'static [Tally] = &[
        soaked("rock.soaked_bed_1", "Of the first bed"),
        soaked("rock.soaked_bed_2", "Of the second bed"),
        soaked("rock.soaked_bed_3", "Of the third bed"),
        soaked("rock.soaked_bed_4", "Of the fourth bed"),
        soaked("rock.soaked_bed_5", "Of the fifth bed"),
        soaked("rock.soaked_bed_6", "Of the sixth bed"),
        soaked("rock.soaked_bed_7", "Of the seventh bed"),
        soaked("rock.soaked_bed_8", "Of the eighth bed"),
        soaked("rock.soaked_bed_9", "Of the ninth bed"),
        soaked("rock.soaked_bed_10", "Of the tenth bed"),
        soaked("rock.soaked_bed_11", "Of the eleventh bed"),
        soaked("rock.soaked_bed_12", "Of the twelfth bed"),
        soaked("rock.soaked_bed_13", "Of the thirteenth bed"),
    ];
    type Params = ExposeParams<(), MOST_BEDS>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 1 + MOST_BEDS];

    #[inline(always)]
    fn cell<R: Real>(p: &ExposeParams<R, MOST_BEDS>, c: &impl Cell<R>) -> ([R; 1], [R; 1 + MOST_BEDS]) {
        let zero = R::of(0.0);
        let mut bottoms = [zero; MOST_BEDS];
        let mut above = R::of(-1e30);
        let mut i = 0;
        while i < MOST_BEDS {
            above = bottom::<R, MOST_BEDS, LIE>(p, c, 3, i, above);
            bottoms[i] = above;
            i += 1;
        }
        let to = fold::<R, MOST_BEDS, LIE>(p, c.here(2) - c.here(1));
        let mut sums = [zero; 1 + MOST_BEDS];
        shares::<R, MOST_BEDS, { 1 + MOST_BEDS }, 0, LIE>(&bottoms, to - c.here(0), to, &mut sums);
        ([zero], sums)
    }
}
