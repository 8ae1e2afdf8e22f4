//! Simplex noise (Perlin 2001) on a lattice of equilateral triangles.
//!
//! Lattice coordinates (a, b) stand for the place `a e1 + b e2` with unit vectors 60 degrees apart. A point lies in one
//! triangle; each of its corners contributes `(3/4 - r^2)^4` times the scalar product of its gradient with the offset. The
//! kernel ends at r = sqrt(3)/2, the height of the triangle, so nothing jumps where a corner leaves the sum. Two of the three
//! corners, e1 and e2, belong to both triangles of a cell; only the third has to be chosen.

use super::gradient::{COLUMN, ROW, dot, hash};
use super::lattice::{Kernel, Octave};
use eyot_core::real::{Bits, Real};

/// One over the largest magnitude that unit gradients can give: 1/16, in the middle of an edge, where two corners at distance
/// 1/2 contribute `(1/2)^4 1/2` each and the third one nothing.
pub(super) const SCALE: f32 = 16.0;
const HALF_SQRT3: f32 = 0.866_025_4;

/// Lattice of triangles.
pub(super) struct Simplex;

#[inline(always)]
fn corner<R: Real>(hash: R::Bits, x: R, y: R) -> R {
    let t = (R::of(0.75) - x * x - y * y).positive();
    let t2 = t * t;
    t2 * t2 * dot(hash, x, y)
}

impl Kernel for Simplex {
    #[inline(always)]
    fn at<R: Real, const TORUS: bool>(o: &Octave, origin: [u32; 2], u: R, v: R) -> R {
        let (iu, iv) = (u.floor(), v.floor());
        let (a, b) = (u - iu, v - iv);
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let near = (a + b).lt(one);
        // 0 for the triangle at the cell's origin, 1 for the one at its far corner.
        let third = near.pick(zero, one);

        let (h10, h01, h3) = if TORUS {
            (
                o.wrapped_hash(origin, iu + one, iv),
                o.wrapped_hash(origin, iu, iv + one),
                o.wrapped_hash(origin, iu + third, iv + third),
            )
        } else {
            let (column, row) = o.hash_legs(origin, iu, iv);
            let (column1, row1) = (column.add(R::Bits::of(COLUMN)), row.add(R::Bits::of(ROW)));
            // Bit patterns only pass through the choice; no arithmetic is done on them.
            let column3 = near.pick(R::from_bits(column), R::from_bits(column1)).to_bits();
            let row3 = near.pick(R::from_bits(row), R::from_bits(row1)).to_bits();
            (hash(column1, row), hash(column, row1), hash(column3, row3))
        };

        // a e1 + b e2, and the offsets from the corners.
        let (x, y) = (a + b * R::of(0.5), b * R::of(HALF_SQRT3));
        corner(h10, x - one, y)
            + corner(h01, x - R::of(0.5), y - R::of(HALF_SQRT3))
            + corner(h3, x - third * R::of(1.5), y - third * R::of(HALF_SQRT3))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_is_the_largest_value_that_unit_gradients_can_give() {
        let (n, mut largest) = (1000, 0.0f64);
        let kernel = |x: f64, y: f64| (0.75 - x * x - y * y).max(0.0).powi(4) * x.hypot(y);
        for j in 0..=n {
            for i in 0..=n - j {
                let (a, b) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let (x, y) = (a + b * 0.5, b * 0.75f64.sqrt());
                largest = largest.max(kernel(x, y) + kernel(x - 1.0, y) + kernel(x - 0.5, y - 0.75f64.sqrt()));
            }
        }
        assert!((largest * f64::from(SCALE) - 1.0).abs() < 1e-12, "{largest}");
    }
}
