//! The numbers that heights are made of.

use std::fmt::Debug;

/// A height in metres: `f32` or `f64`, finite.
pub trait Height: Copy + PartialOrd + Debug + Default + Send + Sync + 'static {
    /// An integer that sorts as the heights do.
    type Key: Copy + Ord + Debug + Send + Sync;

    /// The integer of this height; equal heights have equal ones, also 0 and -0.
    fn key(self) -> Self::Key;
    /// The same number in double precision.
    fn to_f64(self) -> f64;
    /// The nearest number of this type.
    fn of(v: f64) -> Self;
    /// The next higher number of this type.
    fn above(self) -> Self;
}

macro_rules! height {
    ($t:ty, $key:ty) => {
        impl Height for $t {
            type Key = $key;

            #[inline(always)]
            fn key(self) -> $key {
                const SIGN: $key = 1 << (<$key>::BITS - 1);
                // Adding zero turns -0 into 0. The bits of positive floats sort like integers, those of negative ones backwards.
                let bits = (self + 0.0).to_bits();
                if bits & SIGN == 0 { bits | SIGN } else { !bits }
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self.into()
            }
            #[inline(always)]
            fn of(v: f64) -> Self {
                v as Self
            }
            #[inline(always)]
            fn above(self) -> Self {
                self.next_up()
            }
        }
    };
}
height!(f32, u32);
height!(f64, u64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_sort_like_heights() {
        let z = [-1e30_f32, -7.5, -1e-30, 0.0, 1e-30, 2.0, 3e30];
        assert!(z.windows(2).all(|p| p[0].key() < p[1].key() && f64::from(p[0]).key() < f64::from(p[1]).key()));
        assert_eq!((-0.0_f32).key(), 0.0_f32.key());
        assert_eq!((-0.0_f64).key(), 0.0_f64.key());
    }
}
