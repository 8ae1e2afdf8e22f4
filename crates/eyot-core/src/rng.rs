//! Random numbers without state: a hash of (seed, stream, step, cell).
//!
//! The same key gives the same number on any thread, tile, engine and lane width, and in any order.

use crate::real::{Bits, Real};

/// Mixes 64 bits well (the finaliser of SplitMix64; Steele, Lea and Flood 2014).
pub const fn mix64(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The part of a key that all cells of a step share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// Mixed in before the cell.
    pub low: u32,
    /// Mixed in after it.
    pub high: u32,
}

impl Key {
    /// The key of `stream` in `step` of a world with this `seed`.
    pub const fn new(seed: u64, stream: u32, step: u64) -> Self {
        let k = mix64(mix64(seed) ^ step);
        // The stream is mixed in with 32 bits, so that shaders can do it too.
        let (low, high) = (stream.wrapping_mul(0x9e37_79b9), stream.wrapping_mul(0x85eb_ca6b));
        Self { low: k as u32 ^ low, high: ((k >> 32) as u32).wrapping_add(high) }
    }
}

/// 32 mixed bits for the cell numbered `cell` under `key`.
///
/// Two rounds of the integer hash `lowbias32` (Wellons 2018), keyed before each.
#[inline(always)]
pub fn hash<B: Bits>(key: Key, cell: B) -> B {
    let h = round(cell.xor(B::of(key.low)));
    round(h.add(B::of(key.high)))
}

#[inline(always)]
fn round<B: Bits>(h: B) -> B {
    let h = h.xor(h.shr(16)).mul(B::of(0x21f0_aaad));
    let h = h.xor(h.shr(15)).mul(B::of(0x735a_2d97));
    h.xor(h.shr(15))
}

/// A number in [0, 1) with 24 random bits.
#[inline(always)]
pub fn unit<R: Real>(bits: R::Bits) -> R {
    bits.shr(8).to_real() * R::of(1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_numbers_are_uniform_and_keyed() {
        let n = 1u32 << 20;
        let mut bins = [0u32; 64];
        let (mut sum, mut lag) = (0.0, 0.0);
        let key = Key::new(1, 2, 3);
        let mut last = 0.0;
        for c in 0..n {
            let u: f32 = unit::<f32>(hash(key, c));
            assert!((0.0..1.0).contains(&u));
            bins[(u * 64.0) as usize] += 1;
            sum += f64::from(u);
            lag += (f64::from(u) - 0.5) * (last - 0.5);
            last = f64::from(u);
        }
        let expected = f64::from(n) / 64.0;
        let chi2: f64 = bins.iter().map(|&b| (f64::from(b) - expected).powi(2) / expected).sum();
        // 63 degrees of freedom: 99.99 % lie below 113.
        assert!(chi2 < 113.0, "chi2 {chi2}");
        assert!((sum / f64::from(n) - 0.5).abs() < 1e-3);
        assert!((lag / f64::from(n)).abs() < 5e-4, "neighbouring cells are independent");
        for other in [Key::new(2, 2, 3), Key::new(1, 3, 3), Key::new(1, 2, 4)] {
            let same = (0..4096u32).filter(|&c| hash(other, c) == hash(key, c)).count();
            assert_eq!(same, 0);
        }
    }
}
