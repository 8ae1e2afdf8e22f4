//! Levelling: what flows from the higher surface to the lower one, pair by pair.

use eyot_core::real::Real;
use eyot_core::rule::{Cell, Side, Slot};

/// What flows from one cell to the next one: a share of the difference of their heads, never more than a part of what
/// the giver has. Both cells of a pair compute the same number from the same operands, so that what one loses the other
/// gains to the bit.
#[inline(always)]
pub(crate) fn flow<R: Real>(share: R, part: R, head: R, next_head: R, has: R, next_has: R) -> R {
    (share * (head - next_head)).clamp(-(part * next_has), part * has)
}

/// Matter on the ground, such as water or ice, that flows by the head of its surface, or of the sea where that is higher.
#[derive(Clone, Copy)]
pub(crate) struct Head<R> {
    /// Slot of the ground's height.
    pub(crate) ground: Slot,
    /// Slot of the matter's thickness.
    pub(crate) thickness: Slot,
    /// Level of the sea, m.
    pub(crate) sea: R,
    /// Share of a difference of heads that flows, 1.
    pub(crate) share: R,
    /// Share of the thickness that flows at most, 1.
    pub(crate) part: R,
}

impl<R: Real> Head<R> {
    /// Flow through the eastern face of the cell `at` columns east, m.
    #[inline(always)]
    pub(crate) fn east(&self, c: &impl Cell<R>, at: isize) -> R {
        self.between(c, (at, 0), (at + 1, 0))
    }

    /// Flow through the southern face of the cell `at` rows south, m.
    #[inline(always)]
    pub(crate) fn south(&self, c: &impl Cell<R>, at: isize) -> R {
        self.between(c, (0, at), (0, at + 1))
    }

    #[inline(always)]
    fn between(&self, c: &impl Cell<R>, a: (isize, isize), b: (isize, isize)) -> R {
        let (ground, next_ground) = (c.at(self.ground, a.0, a.1), c.at(self.ground, b.0, b.1));
        let (has, next_has) = (c.at(self.thickness, a.0, a.1), c.at(self.thickness, b.0, b.1));
        let (head, next_head) = (ground.max(self.sea) + has, next_ground.max(self.sea) + next_has);
        flow(self.share, self.part, head, next_head, has, next_has)
    }
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
