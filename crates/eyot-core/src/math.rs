//! Elementary functions from one source, so that every lane width and every platform gives the same bits.
//!
//! Polynomials and range reductions after Cephes (Moshier 1992, single precision); coefficients are its minimax
//! fits. Measured errors against `f64` are in the tests below.

use crate::real::{Bits, Real};

/// e^x. Below -87.3 the result is 0, above 88.7 it stays at e^88.7; error at most 2 ulp.
#[inline(always)]
pub fn exp<R: Real>(x: R) -> R {
    let under = x.lt(R::of(-87.3));
    let x = x.clamp(R::of(-87.3), R::of(88.7));
    // x = n ln 2 + r with |r| <= ln 2 / 2; ln 2 in two pieces, so that n times the first is exact.
    let n = (x * R::of(std::f32::consts::LOG2_E) + R::of(0.5)).floor();
    let r = x - n * R::of(0.693_359_4) - n * R::of(-2.121_944_4e-4);
    let p = R::of(1.987_569_2e-4);
    let p = p * r + R::of(1.398_199_9e-3);
    let p = p * r + R::of(8.333_452e-3);
    let p = p * r + R::of(4.166_579_6e-2);
    let p = p * r + R::of(1.666_666_5e-1);
    let p = p * r + R::of(0.5);
    let m = p * (r * r) + r + R::of(1.0);
    // 2^n through the exponent field, in two halves: n may reach 128.
    let half = (n * R::of(0.5)).floor();
    let scaled = m * power_of_two(half) * power_of_two(n - half);
    under.pick(R::of(0.0), scaled)
}

/// 2^n for a whole n within -126..=127.
#[inline(always)]
fn power_of_two<R: Real>(n: R) -> R {
    R::from_bits(n.to_int_bits().add(R::Bits::of(127)).shl(23))
}

/// Natural logarithm of a positive normal number; error at most 2 ulp. 0 and below give about -87.3.
#[inline(always)]
pub fn ln<R: Real>(x: R) -> R {
    let x = x.max(R::of(f32::MIN_POSITIVE));
    let bits = x.to_bits();
    // x = 2^e m with m in [sqrt 1/2, sqrt 2)
    let e = bits.shr(23).add(R::Bits::of((-126i32) as u32)).to_real();
    let m = R::from_bits(bits.and(R::Bits::of(0x007f_ffff)).or(R::Bits::of(0x3f00_0000)));
    let low = m.lt(R::of(std::f32::consts::FRAC_1_SQRT_2));
    let e = low.pick(e - R::of(1.0), e);
    let f = low.pick(m + m, m) - R::of(1.0);
    let p = R::of(7.037_683_6e-2);
    let p = p * f + R::of(-1.151_461e-1);
    let p = p * f + R::of(1.167_699_9e-1);
    let p = p * f + R::of(-1.242_014_1e-1);
    let p = p * f + R::of(1.424_932_3e-1);
    let p = p * f + R::of(-1.666_805_7e-1);
    let p = p * f + R::of(2.000_071_5e-1);
    let p = p * f + R::of(-2.499_999_4e-1);
    let p = p * f + R::of(3.333_333e-1);
    let f2 = f * f;
    let tail = p * f2 * f + e * R::of(-2.121_944_4e-4) - R::of(0.5) * f2;
    f + tail + e * R::of(0.693_359_4)
}

/// Sine; error at most 1e-7 absolute for |x| < 8192 rad.
#[inline(always)]
pub fn sin<R: Real>(x: R) -> R {
    quarter(x, R::of(0.0))
}

/// Cosine; error as for [`sin`].
#[inline(always)]
pub fn cos<R: Real>(x: R) -> R {
    quarter(x, R::of(1.0))
}

/// sin(x + shift pi / 2) for a whole shift.
#[inline(always)]
fn quarter<R: Real>(x: R, shift: R) -> R {
    let q = (x * R::of(std::f32::consts::FRAC_2_PI) + R::of(0.5)).floor();
    // pi / 2 in three pieces (Cody and Waite).
    let r = x - q * R::of(1.570_312_5) - q * R::of(4.837_513e-4) - q * R::of(7.549_79e-8);
    let r2 = r * r;
    let s = ((R::of(-1.951_529_6e-4) * r2 + R::of(8.332_161e-3)) * r2 + R::of(-1.666_665_5e-1)) * r2 * r + r;
    let c = ((R::of(2.443_315_7e-5) * r2 + R::of(-1.388_731_6e-3)) * r2 + R::of(4.166_664_6e-2)) * r2 * r2
        - R::of(0.5) * r2
        + R::of(1.0);
    let q = q + shift;
    let odd = q - (q * R::of(0.5)).floor() * R::of(2.0); // 0 or 1
    let sign = R::of(1.0) - R::of(2.0) * ((q * R::of(0.5)).floor() - (q * R::of(0.25)).floor() * R::of(2.0));
    sign * odd.gt(R::of(0.5)).pick(c, s)
}

/// x^e for x >= 0, as e^(e ln x); relative error at most 2e-7 times (1 + |e ln x|). 0 to any power is 0.
#[inline(always)]
pub fn pow<R: Real>(x: R, e: R) -> R {
    x.gt(R::of(0.0)).pick(exp(e * ln(x)), R::of(0.0))
}

/// Cubic step from 0 at `low` to 1 at `high`; falls instead if `low > high`.
#[inline(always)]
pub fn smoothstep<R: Real>(low: R, high: R, x: R) -> R {
    let t = ((x - low) / (high - low)).clamp(R::of(0.0), R::of(1.0));
    t * t * (R::of(3.0) - R::of(2.0) * t)
}

/// The value with `place` values below or beside it, as if `values` were sorted; all values have a place, NaN the last ones.
///
/// # Panics
/// If there are no more than `place` values.
pub fn ordered(values: &[f32], place: usize) -> f32 {
    let mut copy = values.to_vec();
    *copy.select_nth_unstable_by(place, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    #[test]
    fn values_in_their_order() {
        let values = [3.0, -1.0, 2.0, 2.0];
        assert_eq!([0, 1, 2, 3].map(|place| super::ordered(&values, place)), [-1.0, 2.0, 2.0, 3.0]);
    }

    /// Largest error of `got` against `want` over `n` points of `low..high`, relative to the larger of |want| and `floor`.
    fn worst(low: f64, high: f64, floor: f64, got: impl Fn(f32) -> f32, want: impl Fn(f64) -> f64) -> f64 {
        let n = 200_000;
        (0..=n)
            .map(|i| (low + (high - low) * f64::from(i) / f64::from(n)) as f32)
            .map(|x| {
                let w = want(f64::from(x));
                (f64::from(got(x)) - w).abs() / w.abs().max(floor)
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn elementary_functions_are_accurate() {
        assert!(worst(-87.0, 88.0, 0.0, super::exp, f64::exp) < 2.4e-7);
        assert!(worst(1e-30, 1e3, 1e-3, super::ln, f64::ln) < 2.4e-7);
        assert!(worst(0.5, 2.0, 1e-3, super::ln, f64::ln) < 2.4e-7);
        assert!(worst(-800.0, 800.0, 1.0, super::sin, f64::sin) < 2e-7);
        assert!(worst(-800.0, 800.0, 1.0, super::cos, f64::cos) < 2e-7);
        for e in [0.3f32, 1.0, 2.0, 2.7, 5.0] {
            assert!(worst(1e-3, 50.0, 0.0, |x| super::pow(x, e), |x| x.powf(f64::from(e))) < 4e-6, "exponent {e}");
        }
        assert_eq!(super::exp(-1000.0f32), 0.0);
        assert!(super::exp(1000.0f32).is_finite());
        assert_eq!(super::pow(0.0f32, 2.0), 0.0);
    }
}
