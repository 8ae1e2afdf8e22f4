//! Lanes in the registers of AVX2 (two of eight) and AVX-512 (one of sixteen).
//!
//! With plain arrays everything depends on LLVM finding the vectors again, and for long rules it does not: the erosion
//! rule came out four times slower with AVX2 than without it. Naming the registers costs a table of instructions and
//! makes the speed of a rule predictable. Each instruction computes what [`Lanes`](super::Lanes) computes, bit by bit;
//! the conformance tests compare them.

// Reason for the exception: processor intrinsics. Values of these types only exist inside functions compiled for the
// instruction set (`isa::run_lanes`), which run only after the processor was asked.
#![allow(unsafe_code)]

use super::{LaneBlock, WIDTH};
use crate::real::{Bits, Real, WHOLE};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Sixteen `f32` in two AVX2 registers.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(__m256, __m256);
/// Sixteen `u32` in two AVX2 registers.
#[derive(Clone, Copy)]
pub(crate) struct Avx2Bits(__m256i, __m256i);
/// Sixteen `f32` in one AVX-512 register.
#[derive(Clone, Copy)]
pub(crate) struct Avx512(__m512);
/// Sixteen `u32` in one AVX-512 register.
#[derive(Clone, Copy)]
pub(crate) struct Avx512Bits(__m512i);

macro_rules! binary {
    ($($trait:ident $method:ident $i256:ident $i512:ident),*) => {$(
        impl $trait for Avx2 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                // SAFETY: see the head of this file; likewise everywhere below.
                unsafe { Self($i256(self.0, o.0), $i256(self.1, o.1)) }
            }
        }
        impl $trait for Avx512 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                // SAFETY: see above.
                unsafe { Self($i512(self.0, o.0)) }
            }
        }
    )*};
}
binary!(Add add _mm256_add_ps _mm512_add_ps, Sub sub _mm256_sub_ps _mm512_sub_ps);
binary!(Mul mul _mm256_mul_ps _mm512_mul_ps, Div div _mm256_div_ps _mm512_div_ps);

impl Neg for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: see above.
        unsafe {
            let sign = _mm256_set1_ps(-0.0);
            Self(_mm256_xor_ps(self.0, sign), _mm256_xor_ps(self.1, sign))
        }
    }
}

impl Neg for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm512_xor_ps(self.0, _mm512_set1_ps(-0.0))) }
    }
}

impl Real for Avx2 {
    type Bits = Avx2Bits;
    #[inline(always)]
    fn of(v: f32) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm256_set1_ps(v), _mm256_set1_ps(v)) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm256_sqrt_ps(self.0), _mm256_sqrt_ps(self.1)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see above.
        unsafe {
            let sign = _mm256_set1_ps(-0.0);
            Self(_mm256_andnot_ps(sign, self.0), _mm256_andnot_ps(sign, self.1))
        }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm256_floor_ps(self.0), _mm256_floor_ps(self.1)) }
    }
    #[inline(always)]
    fn select_lt(a: Self, b: Self, x: Self, y: Self) -> Self {
        // SAFETY: see above.
        unsafe {
            Self(
                _mm256_blendv_ps(y.0, x.0, _mm256_cmp_ps::<_CMP_LT_OQ>(a.0, b.0)),
                _mm256_blendv_ps(y.1, x.1, _mm256_cmp_ps::<_CMP_LT_OQ>(a.1, b.1)),
            )
        }
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        // SAFETY: see above. The instruction gives its second operand unless the first is smaller, as `Real` asks.
        unsafe { Self(_mm256_min_ps(self.0, o.0), _mm256_min_ps(self.1, o.1)) }
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm256_max_ps(self.0, o.0), _mm256_max_ps(self.1, o.1)) }
    }
    #[inline(always)]
    fn to_bits(self) -> Avx2Bits {
        // SAFETY: see above.
        unsafe { Avx2Bits(_mm256_castps_si256(self.0), _mm256_castps_si256(self.1)) }
    }
    #[inline(always)]
    fn from_bits(b: Avx2Bits) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm256_castsi256_ps(b.0), _mm256_castsi256_ps(b.1)) }
    }
    #[inline(always)]
    fn to_int_bits(self) -> Avx2Bits {
        (self + Self::of(WHOLE)).to_bits().add(Avx2Bits::of(WHOLE.to_bits().wrapping_neg()))
    }
}

impl Real for Avx512 {
    type Bits = Avx512Bits;
    #[inline(always)]
    fn of(v: f32) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm512_set1_ps(v)) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm512_sqrt_ps(self.0)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm512_abs_ps(self.0)) }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: see above. 0x09: towards minus infinity, without exceptions.
        unsafe { Self(_mm512_roundscale_ps::<0x09>(self.0)) }
    }
    #[inline(always)]
    fn select_lt(a: Self, b: Self, x: Self, y: Self) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm512_mask_blend_ps(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(a.0, b.0), y.0, x.0)) }
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm512_min_ps(self.0, o.0)) }
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm512_max_ps(self.0, o.0)) }
    }
    #[inline(always)]
    fn to_bits(self) -> Avx512Bits {
        // SAFETY: see above.
        unsafe { Avx512Bits(_mm512_castps_si512(self.0)) }
    }
    #[inline(always)]
    fn from_bits(b: Avx512Bits) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm512_castsi512_ps(b.0)) }
    }
    #[inline(always)]
    fn to_int_bits(self) -> Avx512Bits {
        (self + Self::of(WHOLE)).to_bits().add(Avx512Bits::of(WHOLE.to_bits().wrapping_neg()))
    }
}

macro_rules! binary_bits {
    ($($method:ident $i256:ident $i512:ident),*) => {
        impl Bits for Avx2Bits {
            type Real = Avx2;
            #[inline(always)]
            fn of(v: u32) -> Self {
                // SAFETY: see above.
                unsafe { Self(_mm256_set1_epi32(v as i32), _mm256_set1_epi32(v as i32)) }
            }
            $(#[inline(always)]
            fn $method(self, o: Self) -> Self {
                // SAFETY: see above.
                unsafe { Self($i256(self.0, o.0), $i256(self.1, o.1)) }
            })*
            #[inline(always)]
            fn shl(self, n: u32) -> Self {
                // SAFETY: see above.
                unsafe {
                    let n = _mm_cvtsi32_si128(n as i32);
                    Self(_mm256_sll_epi32(self.0, n), _mm256_sll_epi32(self.1, n))
                }
            }
            #[inline(always)]
            fn shr(self, n: u32) -> Self {
                // SAFETY: see above.
                unsafe {
                    let n = _mm_cvtsi32_si128(n as i32);
                    Self(_mm256_srl_epi32(self.0, n), _mm256_srl_epi32(self.1, n))
                }
            }
            #[inline(always)]
            fn to_real(self) -> Avx2 {
                // SAFETY: see above.
                unsafe { Avx2(_mm256_cvtepi32_ps(self.0), _mm256_cvtepi32_ps(self.1)) }
            }
        }
        impl Bits for Avx512Bits {
            type Real = Avx512;
            #[inline(always)]
            fn of(v: u32) -> Self {
                // SAFETY: see above.
                unsafe { Self(_mm512_set1_epi32(v as i32)) }
            }
            $(#[inline(always)]
            fn $method(self, o: Self) -> Self {
                // SAFETY: see above.
                unsafe { Self($i512(self.0, o.0)) }
            })*
            #[inline(always)]
            fn shl(self, n: u32) -> Self {
                // SAFETY: see above.
                unsafe { Self(_mm512_sll_epi32(self.0, _mm_cvtsi32_si128(n as i32))) }
            }
            #[inline(always)]
            fn shr(self, n: u32) -> Self {
                // SAFETY: see above.
                unsafe { Self(_mm512_srl_epi32(self.0, _mm_cvtsi32_si128(n as i32))) }
            }
            #[inline(always)]
            fn to_real(self) -> Avx512 {
                // SAFETY: see above.
                unsafe { Avx512(_mm512_cvtepi32_ps(self.0)) }
            }
        }
    };
}
binary_bits!(
    add _mm256_add_epi32 _mm512_add_epi32,
    mul _mm256_mullo_epi32 _mm512_mullo_epi32,
    xor _mm256_xor_si256 _mm512_xor_si512,
    and _mm256_and_si256 _mm512_and_si512,
    or _mm256_or_si256 _mm512_or_si512
);

impl LaneBlock for Avx2 {
    #[inline(always)]
    fn from_array(v: [f32; WIDTH]) -> Self {
        // SAFETY: see above; both halves lie inside the array.
        unsafe { Self(_mm256_loadu_ps(v.as_ptr()), _mm256_loadu_ps(v.as_ptr().add(8))) }
    }
    #[inline(always)]
    fn to_array(self) -> [f32; WIDTH] {
        let mut v = [0.0; WIDTH];
        // SAFETY: as above.
        unsafe {
            _mm256_storeu_ps(v.as_mut_ptr(), self.0);
            _mm256_storeu_ps(v.as_mut_ptr().add(8), self.1);
        }
        v
    }
    #[inline(always)]
    fn bits_from_array(v: [u32; WIDTH]) -> Avx2Bits {
        // SAFETY: as above.
        unsafe { Avx2Bits(_mm256_loadu_si256(v.as_ptr().cast()), _mm256_loadu_si256(v.as_ptr().add(8).cast())) }
    }
}

impl LaneBlock for Avx512 {
    #[inline(always)]
    fn from_array(v: [f32; WIDTH]) -> Self {
        // SAFETY: see above.
        unsafe { Self(_mm512_loadu_ps(v.as_ptr())) }
    }
    #[inline(always)]
    fn to_array(self) -> [f32; WIDTH] {
        let mut v = [0.0; WIDTH];
        // SAFETY: see above.
        unsafe { _mm512_storeu_ps(v.as_mut_ptr(), self.0) };
        v
    }
    #[inline(always)]
    fn bits_from_array(v: [u32; WIDTH]) -> Avx512Bits {
        // SAFETY: see above.
        unsafe { Avx512Bits(_mm512_loadu_si512(v.as_ptr().cast())) }
    }
}
