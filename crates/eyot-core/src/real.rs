//! [`Real`]: the numbers that rules are written in.
//!
//! A rule is generic over `Real`, so the same source runs on one cell (`f32`), on sixteen ([`Lanes`](crate::lanes::Lanes)),
//! in double precision (`f64`, for tests against analytic solutions), and records itself as a graph
//! ([`Node`](crate::graph::Node)) that prints as WGSL.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, or several side by side, or the promise of one.
///
/// Comparisons are not `bool`s, because sixteen cells may disagree: `a.lt(b).pick(x, y)` is `x` where `a < b`, else `y`.
/// Nothing here fuses a multiplication with an addition: the same bits come out of every implementation of 32 bits.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self> + 'static
{
    /// 32-bit unsigned integers of the same shape, for hashes and for taking numbers apart.
    type Bits: Bits<Real = Self>;

    /// The number `v` in every lane.
    fn of(v: f32) -> Self;
    /// Square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// Largest whole number not above.
    fn floor(self) -> Self;
    /// `x` where `a < b`, else `y` (also where a or b is NaN).
    fn select_lt(a: Self, b: Self, x: Self, y: Self) -> Self;
    /// The IEEE 754 binary32 pattern.
    fn to_bits(self) -> Self::Bits;
    /// The number with this IEEE 754 binary32 pattern.
    fn from_bits(bits: Self::Bits) -> Self;
    /// A whole number of magnitude below 2^22 as a two's complement integer; anything else gives something useless.
    fn to_int_bits(self) -> Self::Bits;

    /// The same number; where the rule is printed as a shader it is called `name`. Shown with its equation: `"(3) depth"`.
    #[inline(always)]
    fn named(self, _name: &'static str) -> Self {
        self
    }
    /// The same number; a compiler of shaders must round it before it goes on, and not fuse it with what comes next. For products
    /// in rules that amplify rounding.
    #[inline(always)]
    fn no_contract(self) -> Self {
        self
    }
    /// Starts a choice: `a.lt(b).pick(x, y)`.
    #[inline(always)]
    fn lt(self, other: Self) -> Less<Self> {
        Less(self, other)
    }
    /// Starts a choice: `a.gt(b).pick(x, y)`.
    #[inline(always)]
    fn gt(self, other: Self) -> Less<Self> {
        Less(other, self)
    }
    /// The smaller one; `other` if either is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select_lt(self, other, self, other)
    }
    /// The larger one; `other` if either is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select_lt(other, self, self, other)
    }
    /// At least `low`, at most `high`.
    #[inline(always)]
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }
    /// Zero where the number is negative.
    #[inline(always)]
    fn positive(self) -> Self {
        self.max(Self::of(0.0))
    }
    /// Zero where the magnitude is below 1e-30, so that no subnormal number ever slows a processor down.
    #[inline(always)]
    fn flushed(self) -> Self {
        Self::select_lt(self.abs(), Self::of(1e-30), Self::of(0.0), self)
    }
    /// e to this power; see [`crate::math`] for ranges and errors.
    #[inline(always)]
    fn exp(self) -> Self {
        crate::math::exp(self)
    }
    /// Natural logarithm.
    #[inline(always)]
    fn ln(self) -> Self {
        crate::math::ln(self)
    }
    /// Sine of an angle in radians.
    #[inline(always)]
    fn sin(self) -> Self {
        crate::math::sin(self)
    }
    /// Cosine of an angle in radians.
    #[inline(always)]
    fn cos(self) -> Self {
        crate::math::cos(self)
    }
    /// This number, which must be positive, to the power `e`; 0 to any power is 0.
    #[inline(always)]
    fn pow(self, e: Self) -> Self {
        crate::math::pow(self, e)
    }
}

/// A comparison that has not been decided yet.
#[derive(Clone, Copy)]
pub struct Less<R>(R, R);

impl<R: Real> Less<R> {
    /// `x` where the comparison holds, else `y`.
    #[inline(always)]
    pub fn pick(self, x: R, y: R) -> R {
        R::select_lt(self.0, self.1, x, y)
    }
    /// 1 where the comparison holds, else 0.
    #[inline(always)]
    pub fn one(self) -> R {
        self.pick(R::of(1.0), R::of(0.0))
    }
}

/// 32-bit unsigned integers; arithmetic wraps.
pub trait Bits: Copy + 'static {
    /// The real numbers of the same shape.
    type Real;
    /// The integer `v` in every lane.
    fn of(v: u32) -> Self;
    /// Sum modulo 2^32.
    fn add(self, other: Self) -> Self;
    /// Product modulo 2^32.
    fn mul(self, other: Self) -> Self;
    /// Bitwise exclusive or.
    fn xor(self, other: Self) -> Self;
    /// Bitwise and.
    fn and(self, other: Self) -> Self;
    /// Bitwise or.
    fn or(self, other: Self) -> Self;
    /// Shift towards the high bits by 0..=31.
    fn shl(self, n: u32) -> Self;
    /// Logical shift towards the low bits by 0..=31.
    fn shr(self, n: u32) -> Self;
    /// As a real number, read as two's complement.
    fn to_real(self) -> Self::Real;
}

impl Bits for u32 {
    type Real = f32;
    #[inline(always)]
    fn of(v: u32) -> Self {
        v
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.wrapping_add(other)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.wrapping_mul(other)
    }
    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        self ^ other
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self & other
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self | other
    }
    #[inline(always)]
    fn shl(self, n: u32) -> Self {
        self << n
    }
    #[inline(always)]
    fn shr(self, n: u32) -> Self {
        self >> n
    }
    #[inline(always)]
    fn to_real(self) -> f32 {
        self as i32 as f32
    }
}

/// Adding this makes the bit pattern of a small whole number its two's complement plus a constant.
pub(crate) const WHOLE: f32 = 12_582_912.0; // 1.5 * 2^23

impl Real for f32 {
    type Bits = u32;
    #[inline(always)]
    fn of(v: f32) -> Self {
        v
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        f32::floor(self)
    }
    #[inline(always)]
    fn select_lt(a: Self, b: Self, x: Self, y: Self) -> Self {
        if a < b { x } else { y }
    }
    #[inline(always)]
    fn to_bits(self) -> u32 {
        f32::to_bits(self)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        f32::from_bits(bits)
    }
    #[inline(always)]
    fn to_int_bits(self) -> u32 {
        (self + WHOLE).to_bits().wrapping_sub(WHOLE.to_bits())
    }
}

/// Integers beside `f64`; only what the reference needs.
#[derive(Clone, Copy)]
pub struct Bits64(u32);

impl Bits for Bits64 {
    type Real = f64;
    fn of(v: u32) -> Self {
        Self(v)
    }
    fn add(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }
    fn mul(self, other: Self) -> Self {
        Self(self.0.wrapping_mul(other.0))
    }
    fn xor(self, other: Self) -> Self {
        Self(self.0 ^ other.0)
    }
    fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
    fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
    fn shl(self, n: u32) -> Self {
        Self(self.0 << n)
    }
    fn shr(self, n: u32) -> Self {
        Self(self.0 >> n)
    }
    fn to_real(self) -> f64 {
        f64::from(self.0 as i32)
    }
}

/// Double precision for tests against analytic solutions; elementary functions are the platform's.
impl Real for f64 {
    type Bits = Bits64;
    fn of(v: f32) -> Self {
        f64::from(v)
    }
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    fn abs(self) -> Self {
        f64::abs(self)
    }
    fn floor(self) -> Self {
        f64::floor(self)
    }
    fn select_lt(a: Self, b: Self, x: Self, y: Self) -> Self {
        if a < b { x } else { y }
    }
    fn to_bits(self) -> Bits64 {
        Bits64((self as f32).to_bits())
    }
    fn from_bits(bits: Bits64) -> Self {
        f64::from(f32::from_bits(bits.0))
    }
    fn to_int_bits(self) -> Bits64 {
        Bits64(self as i32 as u32)
    }
    fn exp(self) -> Self {
        f64::exp(self)
    }
    fn ln(self) -> Self {
        f64::ln(self)
    }
    fn sin(self) -> Self {
        f64::sin(self)
    }
    fn cos(self) -> Self {
        f64::cos(self)
    }
    fn pow(self, e: Self) -> Self {
        f64::powf(self, e)
    }
}
