//! Gradients: eight unit vectors, chosen by a hash of the lattice point.
//!
//! The vectors point to 22.5, 67.5, 112.5, ... degrees: `(±C, ±S)` and `(±S, ±C)` with `C = cos 22.5`, `S = sin 22.5`. None
//! lies along an axis or a diagonal of the lattice, all have the same length, and a scalar product with one of them takes a
//! choice and two changes of sign instead of a table.

use eyot_core::real::{Bits, Real};

/// cos 22.5 degrees.
const C: f32 = 0.923_879_5;
/// sin 22.5 degrees.
const S: f32 = 0.382_683_43;
const SIGN: u32 = 0x8000_0000;

/// Multipliers of column and row; odd, and far from small multiples of each other modulo 2^32.
pub(super) const COLUMN: u32 = 0x9e37_79b1;
pub(super) const ROW: u32 = 0x85eb_ca77;

/// The three top bits of the hash of a lattice point choose its gradient.
///
/// `column` is the column number times [`COLUMN`] and `row` is the row number times [`ROW`], each with a key added. One
/// multiplication does for three good bits: the test below compares all pairs of lattice points up to twelve apart.
#[inline(always)]
pub(super) fn hash<B: Bits>(column: B, row: B) -> B {
    let h = column.xor(row);
    let h = h.xor(h.shr(15)).mul(B::of(0x2c1b_3c6d));
    h.xor(h.shl(13)).mul(B::of(0x297a_2d39))
}

/// One coordinate of an offset, scaled by both lengths that a gradient's component can have.
#[derive(Clone, Copy)]
pub(super) struct Leg<R> {
    c: R,
    s: R,
}

impl<R: Real> Leg<R> {
    #[inline(always)]
    pub(super) fn of(x: R) -> Self {
        Self { c: x * R::of(C), s: x * R::of(S) }
    }
    /// The leg of `x - 1`.
    #[inline(always)]
    pub(super) fn less_one(self) -> Self {
        Self { c: self.c - R::of(C), s: self.s - R::of(S) }
    }
}

/// Scalar product of the gradient chosen by `hash` with the offset (x, y).
#[inline(always)]
pub(super) fn dot<R: Real>(hash: R::Bits, x: Leg<R>, y: Leg<R>) -> R {
    let steep = hash.to_real().lt(R::of(0.0));
    let p = steep.pick(x.s, x.c);
    let q = steep.pick(y.c, y.s);
    let sign = R::Bits::of(SIGN);
    R::from_bits(p.to_bits().xor(hash.shl(1).and(sign))) + R::from_bits(q.to_bits().xor(hash.shl(2).and(sign)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn top(seed: u32, i: i32, j: i32) -> u32 {
        let column = (i as u32).wrapping_mul(COLUMN).wrapping_add(seed);
        let row = (j as u32).wrapping_mul(ROW).wrapping_add(seed.rotate_left(16) ^ 0x1234_5678);
        hash(column, row) >> 29
    }

    #[test]
    fn the_vectors_have_unit_length_and_eight_directions() {
        let mut angles: Vec<i32> = (0..8u32)
            .map(|k| {
                let g = |x: f32, y: f32| dot(k << 29, Leg::of(x), Leg::of(y));
                let (gx, gy) = (g(1.0, 0.0), g(0.0, 1.0));
                assert!((gx * gx + gy * gy - 1.0).abs() < 1e-6);
                (gy.atan2(gx).to_degrees() * 10.0).round() as i32
            })
            .collect();
        angles.sort_unstable();
        assert_eq!(angles, [-1575, -1125, -675, -225, 225, 675, 1125, 1575]);
    }

    /// For each seed and each shift, how often a gradient equals, mirrors or turns another one must be what chance gives.
    #[test]
    fn gradients_of_near_lattice_points_are_independent() {
        let n = 256i32;
        let reach = 12i32;
        let mut worst = 0.0f64;
        for seed in [0u32, 1, 77, 0x8000_0000, 0xdead_beef] {
            let side = n + 2 * reach;
            let table: Vec<u32> =
                (0..side * side).map(|k| top(seed, k % side - side / 2, k / side - side / 2)).collect();
            let at = |i: i32, j: i32| table[((j + reach) * side + i + reach) as usize];
            let mut bins = [0f64; 8];
            table.iter().for_each(|&t| bins[t as usize] += 1.0);
            let mean = table.len() as f64 / 8.0;
            let chi2: f64 = bins.iter().map(|b| (b - mean).powi(2) / mean).sum();
            assert!(chi2 < 40.0, "seed {seed}: chi2 {chi2} of 7 degrees of freedom");
            for dj in 0..=reach {
                for di in -reach..=reach {
                    if dj == 0 && di <= 0 {
                        continue;
                    }
                    for mask in 1..8u32 {
                        let mut odd = 0i32;
                        for j in 0..n {
                            for i in 0..n {
                                odd += ((at(i, j) ^ at(i + di, j + dj)) & mask).count_ones() as i32 & 1;
                            }
                        }
                        let cells = f64::from(n * n);
                        let z = (2.0 * f64::from(odd) - cells) / cells.sqrt();
                        worst = worst.max(z.abs());
                    }
                }
            }
        }
        // 10,500 comparisons of chance: the largest of them is expected near 4, beyond 5.5 once in 2,500 runs.
        assert!(worst < 5.5, "{worst} standard deviations");
    }
}
