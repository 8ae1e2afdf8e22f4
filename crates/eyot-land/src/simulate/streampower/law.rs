//! The stream-power law of one cell, solved implicitly for any exponents.
//!
//! With `z0` the height before erosion, `w` the level that the cell drains to, `d = z0 - w > 0` and `c = K A^m T / L^n` (`T`
//! years of the step, `L` distance to the receiver), the new height `z` satisfies `z = z0 - c (z - w)^n`. Its share of the
//! drop that is left, `t = (z - w) / d`, depends on one number:
//!
//! 1. `t + b t^n = 1` with `b = c d^(n - 1)`.
//!
//! Exponents 1, 2 and 1/2 have closed forms. For others (1) is written as `a v + e v^p = 1` with `p > 1`:
//! `v = t, p = n, a = 1, e = b` for `n > 1`, and `v = t^n, p = 1 / n, a = b, e = 1` for `n < 1`. The left side is then convex and
//! rises, so Newton's method from any point above the root goes down to it without ever passing it.

use eyot_core::math64::{exp, ln, pow};

/// Newton's method doubles the correct digits in each turn; from its start a dozen reach the last one.
const MAX_TURNS: usize = 60;

/// How to solve the law for one exponent of the slope.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    n: f64,
    form: Form,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Linear,
    Square,
    Root,
    /// `n > 1`.
    Steep,
    /// `n < 1`.
    Gentle,
}

impl Law {
    pub(super) fn new(n: f64) -> Self {
        let form = match n {
            1.0 => Form::Linear,
            2.0 => Form::Square,
            0.5 => Form::Root,
            n if n > 1.0 => Form::Steep,
            _ => Form::Gentle,
        };
        Self { n, form }
    }

    /// What [`Law::left`] needs to know about a cell of which `c = K A^m T / L^n`.
    #[inline]
    pub(super) fn prepared(&self, c: f64) -> f64 {
        match self.form {
            Form::Linear => 1.0 / (1.0 + c),
            Form::Square | Form::Root => c,
            Form::Steep | Form::Gentle => ln(c),
        }
    }

    /// As [`Law::prepared`] of a cell with `factor` times the `c` of one that is prepared.
    #[inline]
    pub(super) fn scaled(&self, prepared: f64, factor: f64) -> f64 {
        match self.form {
            Form::Linear => prepared / (prepared + factor * (1.0 - prepared)),
            Form::Square | Form::Root => prepared * factor,
            Form::Steep | Form::Gentle => prepared + ln(factor),
        }
    }

    /// Share of a drop of `d > 0` metres that is left after the step, within 0..=1.
    #[inline]
    pub(super) fn left(&self, prepared: f64, d: f64) -> f64 {
        match self.form {
            Form::Linear => prepared,
            Form::Square => 2.0 / (1.0 + (1.0 + 4.0 * prepared * d).sqrt()),
            Form::Root => {
                let b = prepared / d.sqrt();
                let v = 2.0 / (b + (b * b + 4.0).sqrt());
                v * v
            }
            Form::Steep | Form::Gentle => self.newton(prepared + (self.n - 1.0) * ln(d)),
        }
    }

    /// Solves equation (1) for `ln b`.
    fn newton(&self, ln_b: f64) -> f64 {
        let b = exp(ln_b);
        let steep = self.form == Form::Steep;
        // Both starts lie above the root: each makes one of the two terms 1.
        let (p, a, e, mut v) = if steep {
            (self.n, 1.0, b, exp(-ln_b / self.n).min(1.0))
        } else {
            (1.0 / self.n, b, 1.0, exp(-ln_b).min(1.0))
        };
        let mut power = pow(v, p - 1.0);
        for _ in 0..MAX_TURNS {
            let next = v - (v * (a + e * power) - 1.0) / (a + e * p * power);
            // Rounding ends the descent. A step that is not a number ends it too.
            if !(next < v && next >= 0.0) {
                break;
            }
            let done = v - next <= 1e-9 * v;
            v = next;
            power = pow(v, p - 1.0);
            if done {
                break;
            }
        }
        if steep { v } else { v * power }.clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residual of `t + b t^n = 1`, relative to what a rounding of t makes of it.
    fn residual(n: f64, c: f64, d: f64) -> f64 {
        let law = Law::new(n);
        let t = law.left(law.prepared(c), d);
        let b = (c.ln() + (n - 1.0) * d.ln()).exp();
        let eroded = b * t.powf(n);
        if t < f64::MIN_POSITIVE {
            // What is left of the drop, b^(-1/n), is less than the smallest number.
            return if b.ln() / n > 700.0 { 0.0 } else { 1.0 };
        }
        assert!((0.0..=1.0).contains(&t), "n {n}, c {c}, d {d}: {t}");
        (t + eroded - 1.0).abs() / (1.0 + n * eroded)
    }

    #[test]
    fn every_exponent_is_solved() {
        let mut worst = 0.0_f64;
        for n in [0.1, 0.25, 0.3, 0.5, 0.8, 0.999, 1.0, 1.001, 1.2, 1.5, 2.0, 2.5, 3.0, 5.0, 10.0] {
            for c in (-30..=30).map(|k| 10f64.powi(k)) {
                for d in (-12..=5).map(|k| 3.7 * 10f64.powi(k)) {
                    worst = worst.max(residual(n, c, d));
                }
            }
        }
        // measured: 9e-15
        assert!(worst < 5e-14, "{worst}");
    }

    #[test]
    fn scaled_is_prepared_anew() {
        for n in [0.5, 0.8, 1.0, 1.2, 2.0] {
            let law = Law::new(n);
            for (c, factor) in [(0.3, 20.0), (4.0, 0.05), (7.0, 0.0), (2.0, 1.0)] {
                let (scaled, anew) = (law.scaled(law.prepared(c), factor), law.prepared(c * factor));
                assert!((law.left(scaled, 30.0) - law.left(anew, 30.0)).abs() < 1e-12, "n {n}: {c} x {factor}");
            }
        }
    }

    #[test]
    fn an_exponent_below_one_is_not_one() {
        // n = 1 would leave 1 / (1 + c) = 0.0909 of any drop.
        let law = Law::new(0.8);
        let left = law.left(law.prepared(10.0), 100.0);
        assert!((left + 10.0 * 100f64.powf(-0.2) * left.powf(0.8) - 1.0).abs() < 1e-12);
        assert!((left - 1.0 / 11.0).abs() > 0.05, "{left}");
    }

    #[test]
    fn hard_rock_stays_and_soft_rock_goes() {
        for n in [0.5, 0.8, 1.0, 1.2, 2.0] {
            let law = Law::new(n);
            assert_eq!(law.left(law.prepared(0.0), 10.0), 1.0, "n {n}");
            assert!(law.left(law.prepared(1e200), 10.0) < 1e-30, "n {n}");
        }
    }
}
