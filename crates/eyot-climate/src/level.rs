//! Levelling: what flows from the higher surface to the lower one, pair by pair.

use eyot_core::real::Real;
use eyot_core::rule::Side;

/// What flows from one cell to the next one: a share of the difference of their heads, never more than a part of what
/// the giver has. Both cells of a pair compute the same number from the same operands, so that what one loses the other
/// gains to the bit.
#[inline(always)]
pub(crate) fn flow<R: Real>(share: R, part: R, head: R, next_head: R, has: R, next_has: R) -> R {
    (share * (head - next_head)).clamp(-(part * next_has), part * has)
}

/// What leaves through a side, from the flows through eastern and southern faces.
#[inline(always)]
pub(crate) fn out<R: Real>(side: Side, east: impl Fn(isize) -> R, south: impl Fn(isize) -> R) -> R {
    match side {
        Side::West => -east(-1),
        Side::East => east(0),
        Side::North => -south(-1),
        Side::South => south(0),
    }
}
