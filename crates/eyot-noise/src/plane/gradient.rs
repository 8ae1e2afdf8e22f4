//! Gradients: unit vectors at any angle, chosen by a hash of the lattice point.
//!
//! Two bits choose a quarter of the circle, thirty more the place within it; cosine and sine within the quarter are
//! polynomials, and the length lies within 0.9997..=1. A few fixed directions would be cheaper (by a fifth), but where the
//! gradients of two neighbours are both perpendicular to the edge between them the noise is zero all along it, and with eight
//! directions that happened often enough for straight ridges to be seen.

use eyot_core::real::{Bits, Real};

const SIGN: u32 = 0x8000_0000;

/// Multiplier of columns; it and [`ROW`] are odd, and far from small multiples of each other modulo 2^32.
pub const COLUMN: u32 = 0x9e37_79b1;
/// Multiplier of rows.
pub const ROW: u32 = 0x85eb_ca77;

/// The top bits of the hash of a lattice point choose its gradient.
///
/// `column` is the column number times [`COLUMN`] and `row` is the row number times [`ROW`], each with a key added. The test
/// below compares the top bits of all pairs of lattice points up to twelve apart.
#[inline(always)]
pub fn hash<B: Bits>(column: B, row: B) -> B {
    let h = column.xor(row);
    let h = h.xor(h.shr(15)).mul(B::of(0x2c1b_3c6d));
    h.xor(h.shl(13)).mul(B::of(0x297a_2d39))
}

/// Scalar product of the gradient chosen by `hash` with the offset (x, y).
#[inline(always)]
pub(super) fn dot<R: Real>(hash: R::Bits, x: R, y: R) -> R {
    // The gradient is (c, s) with an angle of 45 t degrees, -1 <= t < 1, or its mirror image (s, c), or the opposite of either:
    // all angles alike.
    let t = hash.shl(2).to_real() * R::of(1.0 / 2_147_483_648.0);
    let t2 = t * t;
    let c = R::of(C[0]) - t2 * (R::of(C[1]) - t2 * R::of(C[2]));
    let s = t * (R::of(S[0]) - t2 * R::of(S[1]));
    let turn = hash.to_real().lt(R::of(0.0));
    let product = turn.pick(y, x) * c + turn.pick(x, y) * s;
    R::from_bits(product.to_bits().xor(hash.shl(1).and(R::Bits::of(SIGN))))
}

/// cos (pi/4 t) as C0 - C1 t^2 + C2 t^4, and sin (pi/4 t) as S0 t - S1 t^3; fitted to -1..=1, then times 0.99988, so that no
/// gradient is longer than 1.
const C: [f32; 3] = [0.999_88, 0.3082479, 0.0154017];
const S: [f32; 2] = [0.7845416, 0.0776708];

#[cfg(test)]
mod tests {
    use super::*;

    fn top(seed: u32, i: i32, j: i32) -> u32 {
        let column = (i as u32).wrapping_mul(COLUMN).wrapping_add(seed);
        let row = (j as u32).wrapping_mul(ROW).wrapping_add(seed.rotate_left(16) ^ 0x1234_5678);
        hash(column, row) >> 28
    }

    #[test]
    fn gradients_have_unit_length_and_all_angles_alike() {
        let n = 1u32 << 20;
        let mut bins = [0f64; 360];
        for k in 0..n {
            let h = k << 12;
            let (gx, gy) = (dot(h, 1.0f32, 0.0), dot(h, 0.0f32, 1.0));
            let length = gx.hypot(gy);
            assert!((0.9997..=1.0).contains(&length), "{length}");
            let angle = gy.atan2(gx).to_degrees().rem_euclid(360.0);
            bins[(angle as usize).min(359)] += 1.0;
        }
        let mean = f64::from(n) / 360.0;
        let worst = bins.iter().map(|b| (b / mean - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 0.01, "{worst}");
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
            let mut bins = [0f64; 16];
            table.iter().for_each(|&t| bins[t as usize] += 1.0);
            let mean = table.len() as f64 / 16.0;
            let chi2: f64 = bins.iter().map(|b| (b - mean).powi(2) / mean).sum();
            assert!(chi2 < 50.0, "seed {seed}: chi2 {chi2} of 15 degrees of freedom");
            for dj in 0..=reach {
                for di in -reach..=reach {
                    if dj == 0 && di <= 0 {
                        continue;
                    }
                    for mask in 1..16u32 {
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
        // 23,400 comparisons: chance makes the largest of them about 4.2, and more than 5.5 once in 1,000 trials.
        assert!(worst < 5.5, "{worst} standard deviations");
    }
}
