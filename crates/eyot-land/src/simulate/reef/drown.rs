//! Rivers and lakes that the sea comes over join it.

use eyot_core::ledger::known::DRAINED;
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, read};
use eyot_core::rule_params;

rule_params! {
    /// Parameters of [`Drown`].
    pub struct DrownParams {
        /// Level of the sea, m.
        sea,
    }
}

/// Equation (6).
pub struct Drown;

impl Rule for Drown {
    const NAME: &'static str = "reef_drown";
    const READS: &'static [Read] = &[read("height", 0), read("water", 0), read("wetness", 0)];
    const WRITES: &'static [&'static str] = &["water", "wetness"];
    const TALLIES: &'static [Tally] = &[DRAINED];
    type Params = DrownParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &DrownParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 1]) {
        let (zero, under) = (R::of(0.0), c.here(0).lt(p.sea));
        let (water, wetness) = (c.here(1), c.here(2));
        ([under.pick(zero, water), under.pick(zero, wetness)], [under.pick(water, zero)])
    }
}
