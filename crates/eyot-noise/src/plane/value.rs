//! Value noise: a random number at each point of a square lattice, blended with the quintic fade.

use super::lattice::{Kernel, Octave};
use crate::{blend, fade};
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
        let h = o.corner_hashes::<R, TORUS>(origin, iu, iv);
        let (s, t) = (fade(u - iu), fade(v - iv));
        blend(h.map(number), s, t)
    }
}
