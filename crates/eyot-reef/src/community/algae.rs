//! A month in the life of macroalgae.

use super::colony::{Alga, Colony};
use super::geometry::{Rays, contains};
use super::index::{Entry, Index, Kind};
use super::parameters::Community;
use super::random::{Draws, Stream};

/// Everybody, as they are at the beginning of the month.
pub(super) struct Shore<'a> {
    pub(super) corals: &'a Index,
    pub(super) algae: &'a Index,
    pub(super) colonies: &'a [Colony],
    pub(super) rays: &'a [Rays],
    pub(super) draws: Draws,
}

impl Shore<'_> {
    pub(super) fn stream(seed: u64, month: u64) -> Draws {
        Draws::new(seed, Stream::AlgaShade, month)
    }

    /// True if a coral takes the alga's place this month.
    pub(super) fn is_displaced(&self, me: &Alga) -> bool {
        let mut displaced = false;
        self.corals.visit(me.x, me.y, me.radius, |other| {
            if displaced || !self.covers(other, me) {
                return;
            }
            // Bleached corals defend themselves as far as they have recovered.
            let health = 1.0 - self.colonies[other.who as usize].bleaching;
            displaced = health >= 1.0 || self.draws.chance(me.id, health);
        });
        displaced
    }

    /// A larger massive coral covers an alga that stands on it, a branching one that stands wholly among its branches.
    fn covers(&self, coral: &Entry, me: &Alga) -> bool {
        let (dx, dy) = (me.x - coral.x, me.y - coral.y);
        let d2 = dx * dx + dy * dy;
        if coral.kind == Kind::Branching {
            let within = coral.radius - me.radius;
            return within >= 0.0 && d2 <= within * within;
        }
        coral.radius > me.radius
            && (d2 < coral.inner * coral.inner
                || d2 < coral.reach * coral.reach && contains(&self.rays[coral.who as usize], dx, dy))
    }

    /// True if a taller alga overlaps it, of those for which `alive` holds.
    pub(super) fn is_shaded(&self, me: &Alga, alive: impl Fn(usize) -> bool) -> bool {
        let mut shaded = false;
        self.algae.visit(me.x, me.y, me.radius, |other| {
            let (dx, dy, apart) = (me.x - other.x, me.y - other.y, me.radius + other.radius);
            shaded |= other.rank > me.height && dx * dx + dy * dy < apart * apart && alive(other.who as usize);
        });
        shaded
    }
}

impl Alga {
    /// Grows for a month: in width, then in height.
    pub(super) fn grow(&mut self, community: &Community) {
        let rules = &community.algae;
        if self.radius < rules.max_radius {
            self.radius = (self.radius + rules.growth).min(rules.max_radius);
            self.height = self.height.max(self.radius);
        } else {
            self.height += rules.growth;
            if !community.compat {
                self.height = self.height.min(rules.max_height.max(self.radius));
            }
        }
        self.age += 1;
    }

    /// How many fragments leave it this month.
    pub(super) fn fragments(&self, community: &Community, draws: Draws) -> u32 {
        let rules = &community.algae;
        if self.height <= rules.fragmentation_height {
            return 0;
        }
        let u = draws.unit(self.id);
        if community.compat {
            // It draws one number less than it should, and makes one fragment more than it drew, or none.
            if u < 0.5 { 0 } else { rules.max_fragments }
        } else {
            (u * (rules.max_fragments + 1) as f32) as u32
        }
    }
}
