//! Value noise: a random number at each point of a square lattice, blended with the quintic fade.

use super::gradient::{COLUMN, ROW, hash};
use super::lattice::{Kernel, Octave};
use super::perlin::fade;
use eyot_core::real::{Bits, Real};

/// Square lattice of numbers.
pub(super) struct Value;

/// A number within -1..=1.
#[inline(always)]
fn number<R: Real>(hash: R::Bits) -> R {
    hash.to_real() * R::of(1.0 / 2_147_483_648.0)
}

impl Kernel for Value {
    #[inline(always)]
    fn at<R: Real, const TORUS: bool>(o: &Octave, origin: [u32; 2], u: R, v: R) -> R {
        let (iu, iv) = (u.floor(), v.floor());
        let h = if TORUS {
            [
                o.wrapped_hash(origin, iu, iv),
                o.wrapped_hash(origin, iu + R::of(1.0), iv),
                o.wrapped_hash(origin, iu, iv + R::of(1.0)),
                o.wrapped_hash(origin, iu + R::of(1.0), iv + R::of(1.0)),
            ]
        } else {
            let (column, row) = o.hash_legs(origin, iu, iv);
            let (column1, row1) = (column.add(R::Bits::of(COLUMN)), row.add(R::Bits::of(ROW)));
            [hash(column, row), hash(column1, row), hash(column, row1), hash(column1, row1)]
        };
        let (s, t) = (fade(u - iu), fade(v - iv));
        let n00: R = number(h[0]);
        let n01: R = number(h[2]);
        let n0 = n00 + s * (number::<R>(h[1]) - n00);
        let n1 = n01 + s * (number::<R>(h[3]) - n01);
        n0 + t * (n1 - n0)
    }
}
