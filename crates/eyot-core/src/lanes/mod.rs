//! Lanes: sixteen cells side by side.
//!
//! [`Lanes`] is a plain array, which LLVM turns into vectors of whatever the target has (SSE2, NEON). The types in
//! `x86` name the registers of AVX2 and AVX-512. Sixteen lanes were faster than eight also with AVX2: two registers a
//! value hide latency. All types give the same bits.

#[cfg(target_arch = "x86_64")]
pub(crate) mod x86;

use crate::real::{Bits, Real, WHOLE};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Cells in one block of lanes.
pub const WIDTH: usize = 16;

/// Sixteen `f32`, one a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes(pub [f32; WIDTH]);

/// Sixteen `u32`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct LaneBits(pub [u32; WIDTH]);

macro_rules! each {
    ($i:ident => $e:expr) => {{
        let mut out = [Default::default(); WIDTH];
        let mut $i = 0;
        while $i < WIDTH {
            out[$i] = $e;
            $i += 1;
        }
        out
    }};
}

macro_rules! arithmetic {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(each!(i => self.0[i] $op other.0[i]))
            }
        }
    )*};
}
arithmetic!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(each!(i => -self.0[i]))
    }
}

impl Real for Lanes {
    type Bits = LaneBits;
    #[inline(always)]
    fn of(v: f32) -> Self {
        Self([v; WIDTH])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(each!(i => self.0[i].sqrt()))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(each!(i => self.0[i].abs()))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(each!(i => self.0[i].floor()))
    }
    #[inline(always)]
    fn select_lt(a: Self, b: Self, x: Self, y: Self) -> Self {
        Self(each!(i => if a.0[i] < b.0[i] { x.0[i] } else { y.0[i] }))
    }
    #[inline(always)]
    fn to_bits(self) -> LaneBits {
        LaneBits(each!(i => self.0[i].to_bits()))
    }
    #[inline(always)]
    fn from_bits(bits: LaneBits) -> Self {
        Self(each!(i => f32::from_bits(bits.0[i])))
    }
    #[inline(always)]
    fn to_int_bits(self) -> LaneBits {
        LaneBits(each!(i => (self.0[i] + WHOLE).to_bits().wrapping_sub(WHOLE.to_bits())))
    }
}

impl Bits for LaneBits {
    type Real = Lanes;
    #[inline(always)]
    fn of(v: u32) -> Self {
        Self([v; WIDTH])
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(each!(i => self.0[i].wrapping_add(other.0[i])))
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(each!(i => self.0[i].wrapping_mul(other.0[i])))
    }
    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        Self(each!(i => self.0[i] ^ other.0[i]))
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(each!(i => self.0[i] & other.0[i]))
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(each!(i => self.0[i] | other.0[i]))
    }
    #[inline(always)]
    fn shl(self, n: u32) -> Self {
        Self(each!(i => self.0[i] << n))
    }
    #[inline(always)]
    fn shr(self, n: u32) -> Self {
        Self(each!(i => self.0[i] >> n))
    }
    #[inline(always)]
    fn to_real(self) -> Lanes {
        Lanes(each!(i => self.0[i] as i32 as f32))
    }
}

/// A type of sixteen lanes that can be filled and emptied.
pub trait LaneBlock: Real {
    /// Sixteen numbers.
    fn from_array(v: [f32; WIDTH]) -> Self;
    /// Sixteen numbers.
    fn to_array(self) -> [f32; WIDTH];
    /// Sixteen integers.
    fn bits_from_array(v: [u32; WIDTH]) -> Self::Bits;
    /// The numbers 0, 1, 2, ..., 15.
    #[inline(always)]
    fn index() -> Self {
        Self::from_array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0])
    }
}

impl LaneBlock for Lanes {
    #[inline(always)]
    fn from_array(v: [f32; WIDTH]) -> Self {
        Self(v)
    }
    #[inline(always)]
    fn to_array(self) -> [f32; WIDTH] {
        self.0
    }
    #[inline(always)]
    fn bits_from_array(v: [u32; WIDTH]) -> LaneBits {
        LaneBits(v)
    }
}
