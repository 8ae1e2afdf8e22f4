//! Perlin's gradient noise on a square lattice, with the quintic fade of 2002.
//!
//! The noise in a cell of the lattice is the blend of four planes through zero, one a corner: the scalar product of the
//! corner's gradient with the offset from it. With unit gradients the largest magnitude is sqrt(1/2), reached in the middle of
//! a cell; [`SCALE`] makes it 1.

use super::gradient::dot;
use super::lattice::{Kernel, Octave};
use crate::{blend, fade};
use eyot_core::real::Real;

/// One over the largest magnitude that unit gradients can give.
pub(super) const SCALE: f32 = std::f32::consts::SQRT_2;

/// Square lattice.
pub(super) struct Perlin;

impl Kernel for Perlin {
    #[inline(always)]
    fn at<R: Real, const TORUS: bool>(o: &Octave, origin: [u32; 2], u: R, v: R) -> R {
        let (iu, iv) = (u.floor(), v.floor());
        let (x, y) = (u - iu, v - iv);

        let h = o.corner_hashes::<R, TORUS>(origin, iu, iv);

        let (x1, y1) = (x - R::of(1.0), y - R::of(1.0));
        let (s, t) = (fade(x), fade(y));
        let n00 = dot(h[0], x, y);
        let n10 = dot(h[1], x1, y);
        let n01 = dot(h[2], x, y1);
        let n11 = dot(h[3], x1, y1);
        blend([n00, n10, n01, n11], s, t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_is_the_largest_value_that_unit_gradients_can_give() {
        let (n, mut largest) = (400, 0.0f64);
        for j in 0..=n {
            for i in 0..=n {
                let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let (s, t) = (fade(x), fade(y));
                let reach = (1.0 - s) * (1.0 - t) * x.hypot(y)
                    + s * (1.0 - t) * (1.0 - x).hypot(y)
                    + (1.0 - s) * t * x.hypot(1.0 - y)
                    + s * t * (1.0 - x).hypot(1.0 - y);
                largest = largest.max(reach);
            }
        }
        assert!((largest * f64::from(SCALE) - 1.0).abs() < 1e-6, "{largest}");
    }
}
