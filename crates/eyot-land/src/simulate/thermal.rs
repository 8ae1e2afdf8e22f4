//! Thermal erosion.
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::rule_params;

rule_params! {
    /// Parameters of [`Slump`].
    pub struct SlumpParams {
        /// Height difference to an eastern neighbour that stays, m.
        stay_x,
        /// To a southern one.
        stay_y,
        /// To a diagonal one.
        stay_d,
        /// Share of the excess that moves between neighbours that share an edge, 1.
        rate,
        /// Share of the excess that moves between diagonal neighbours, 1.
        rate_d,
    }
}

/// Equation (1).
pub struct Slump;

impl Rule for Slump {
    const NAME: &'static str = "thermal_slump";
    const READS: &'static [Read] = &[read("height", 1)];
    const WRITES: &'static [&'static str] = &["height"];
    type Params = SlumpParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &SlumpParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let h = c.here(0);
        let x = excess(c, 1, 0, p.stay_x) + excess(c, -1, 0, p.stay_x);
        let y = excess(c, 0, 1, p.stay_y) + excess(c, 0, -1, p.stay_y);
        let d = (excess(c, 1, 1, p.stay_d) + excess(c, -1, -1, p.stay_d))
            + (excess(c, -1, 1, p.stay_d) + excess(c, 1, -1, p.stay_d));
        ([h + (p.rate * (x + y) + p.rate_d * d)], [])
    }
}

/// What the neighbour sends here, negative if it is sent there: the part of the difference beyond what stays.
#[inline(always)]
fn excess<R: Real>(c: &impl Cell<R>, dx: isize, dy: isize, stay: R) -> R {
    let d = c.at(0, dx, dy) - c.here(0);
    d - d.clamp(-stay, stay)
}
