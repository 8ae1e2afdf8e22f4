//! Cellular noise (Worley 1996): distances to the nearest and the second nearest of points, one in each square of a lattice.
//!
//! The sixteen squares around the nearest lattice point are searched. What they miss is at least `1.5 + (1 - jitter) / 2`
//! away, so distances are cut off there: on both sides of a line where the searched squares change, the same points
//! are nearer than that, and nothing jumps. The nearest point never is that far; the second nearest in one place of thousands.

use super::Basis;
use super::gradient::{COLUMN, ROW, hash};
use super::lattice::{Kernel, Octave};
use eyot_core::real::{Bits, Real};

/// Where points lie, and which distance is the value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    jitter: f32,
    /// Square of the distance that nothing exceeds.
    farthest2: f32,
    /// Weights of nearest and second nearest distance.
    weights: [f32; 2],
    /// Half of the largest value: what is taken off so that values lie around 0.
    pub(super) middle: f32,
}

impl Cells {
    pub(super) fn new(basis: Basis, jitter: f32) -> Self {
        let farthest = 2.0 - 0.5 * jitter;
        let (weights, largest) = match basis {
            // Points of all four squares around a lattice point, in their outer corners.
            Basis::WorleyF1 => ([1.0, 0.0], (0.5 + 0.5 * jitter) * std::f32::consts::SQRT_2),
            Basis::WorleyF2 => ([0.0, 1.0], farthest),
            _ => ([-1.0, 1.0], farthest),
        };
        Self { jitter, farthest2: farthest * farthest, weights, middle: 0.5 * largest }
    }
}

/// Square lattice with a point in each square.
pub(super) struct Worley;

impl Kernel for Worley {
    #[inline(always)]
    fn at<R: Real, const TORUS: bool>(o: &Octave, origin: [u32; 2], u: R, v: R) -> R {
        let c = &o.cells;
        let (iu, iv) = ((u - R::of(0.5)).floor(), (v - R::of(0.5)).floor());
        let (x, y) = (u - iu, v - iv);
        let (column, row) = o.hash_legs(origin, iu, iv);
        let (mut first, mut second) = (R::of(c.farthest2), R::of(c.farthest2));
        let corner = 0.5 - 0.5 * c.jitter;
        for j in -1..=2i32 {
            for i in -1..=2i32 {
                let h = if TORUS {
                    o.wrapped_hash(origin, iu + R::of(i as f32), iv + R::of(j as f32))
                } else {
                    hash(
                        column.add(R::Bits::of(COLUMN.wrapping_mul(i as u32))),
                        row.add(R::Bits::of(ROW.wrapping_mul(j as u32))),
                    )
                };
                // The low bits of a product are poor: mixed once more they are the other coordinate.
                let other = h.xor(h.shr(15)).mul(R::Bits::of(0x2c1b_3c6d));
                let share = R::of(c.jitter / 65_536.0);
                let dx = R::of(i as f32 + corner) + h.shr(16).to_real() * share - x;
                let dy = R::of(j as f32 + corner) + other.shr(16).to_real() * share - y;
                let d2 = dx * dx + dy * dy;
                second = second.min(first.max(d2));
                first = first.min(d2);
            }
        }
        first.sqrt() * R::of(c.weights[0]) + second.sqrt() * R::of(c.weights[1]) - R::of(c.middle)
    }
}
