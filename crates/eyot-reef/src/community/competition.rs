//! The fight for space: what neighbours do to a colony in a month.

use super::colony::Colony;
use super::geometry::{DIRECTIONS, RAYS, Rays, contains, lens, longest};
use super::index::{Entry, Index, Kind};
use super::parameters::Community;
use super::species::Form;
use std::f32::consts::PI;

/// Everybody, as they are at the beginning of the month.
pub(super) struct Neighbours<'a> {
    pub(super) community: &'a Community,
    pub(super) corals: &'a Index,
    pub(super) algae: &'a Index,
    pub(super) rays: &'a [Rays],
}

/// What a month does to a colony.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Verdict {
    /// Its neighbours overgrow it, unless they die first.
    pub(super) overgrown: bool,
    /// A coral of at least half its radius touches it.
    pub(super) supported: bool,
    /// Mean growth of its rays before any end at the largest radius, m.
    pub(super) extension: f32,
}

/// A neighbour that covers a ray's tip: what that does to the ray.
#[derive(Clone, Copy)]
struct Shade {
    factor: f32,
    /// The body of a massive coral has edges, everything else is a disc.
    polygon: bool,
}

impl Neighbours<'_> {
    /// Grows the rays of colony number `who` into `grown`.
    pub(super) fn compete(&self, who: usize, me: &Colony, grown: &mut Rays) -> Verdict {
        let species = &self.community.species[usize::from(me.species)];
        let rays = &self.rays[who];
        let entry = me.entry(who, rays, species, self.community.compat);
        let reach = longest(rays);
        let (mut factors, mut overlap, mut supported) = ([1.0f32; RAYS], 0.0, false);
        let mut meet = |other: &Entry| {
            let (dx, dy) = (me.x - other.x, me.y - other.y);
            let apart = reach + other.reach;
            let d2 = dx * dx + dy * dy;
            if d2 >= apart * apart || (other.kind != Kind::Alga && other.who as usize == who) {
                return;
            }
            let d = d2.sqrt();
            supported |= other.kind != Kind::Alga && other.radius >= 0.5 * me.radius && d < me.radius + other.radius;
            if other.bleached {
                return;
            }
            overlap += self.overlap(&entry, other, d);
            let shade = self.shade(&entry, other);
            if d + reach <= other.inner {
                factors.iter_mut().for_each(|f| *f *= shade.factor);
            } else {
                self.shade_tips(rays, [dx, dy], other, shade, &mut factors);
            }
        };
        self.corals.visit(me.x, me.y, reach, &mut meet);
        if self.meets_algae(me) {
            self.algae.visit(me.x, me.y, reach, &mut meet);
        }
        let growth = species.growth / 12.0 * me.light * me.vigour;
        for k in 0..RAYS {
            grown[k] = (rays[k] + growth * factors[k]).min(species.max_radius);
        }
        let overgrown = overlap >= self.community.overgrowth * PI * me.radius * me.radius;
        Verdict { overgrown, supported, extension: growth * factors.iter().sum::<f32>() / RAYS as f32 }
    }

    /// True if colony number `who` is overgrown by those of its neighbours that are still alive.
    pub(super) fn is_overgrown(&self, who: usize, me: &Colony, alive: &[bool]) -> bool {
        let species = &self.community.species[usize::from(me.species)];
        let entry = me.entry(who, &self.rays[who], species, self.community.compat);
        let mut overlap = 0.0;
        let mut meet = |other: &Entry| {
            let is_coral = other.kind != Kind::Alga;
            if other.bleached || is_coral && (other.who as usize == who || !alive[other.who as usize]) {
                return;
            }
            let (dx, dy) = (me.x - other.x, me.y - other.y);
            overlap += self.overlap(&entry, other, (dx * dx + dy * dy).sqrt());
        };
        self.corals.visit(me.x, me.y, me.radius, &mut meet);
        if self.meets_algae(me) {
            self.algae.visit(me.x, me.y, me.radius, &mut meet);
        }
        overlap >= self.community.overgrowth * PI * me.radius * me.radius
    }

    /// Algae bother small corals and bleached ones.
    fn meets_algae(&self, me: &Colony) -> bool {
        me.radius <= self.community.algae.max_radius || me.is_bleached()
    }

    /// Area of `me` that `other` overlaps, m2; without end if `other` engulfs it.
    fn overlap(&self, me: &Entry, other: &Entry, d: f32) -> f32 {
        if other.radius > me.radius + d {
            return f32::INFINITY;
        }
        if me.kind == Kind::Branching && other.kind == Kind::Massive && !self.is_larger(other, me) {
            return 0.0;
        }
        lens(me.radius, other.radius, d)
    }

    fn is_larger(&self, a: &Entry, than: &Entry) -> bool {
        // An alga's rank is its height, by which corals do not measure.
        if a.kind == Kind::Alga { a.radius > than.radius } else { a.rank > than.rank }
    }

    fn shade(&self, me: &Entry, other: &Entry) -> Shade {
        let c = self.community;
        let polygon = other.kind == Kind::Massive;
        if me.kind == Kind::Branching && polygon {
            return Shade { factor: 0.0, polygon };
        }
        // The original program has it the other way round among branching corals.
        let reversed = c.compat && me.kind == Kind::Branching && other.kind == Kind::Branching;
        let larger = if reversed { self.is_larger(me, other) } else { self.is_larger(other, me) };
        Shade { factor: if larger { c.shade * c.shade_of_larger } else { c.shade }, polygon }
    }

    /// (dx, dy): from the other's centre to mine.
    fn shade_tips(&self, rays: &Rays, [dx, dy]: [f32; 2], other: &Entry, shade: Shade, factors: &mut Rays) {
        let (inner2, reach2) = (other.inner * other.inner, other.reach * other.reach);
        for k in 0..RAYS {
            let (x, y) = (dx + DIRECTIONS[k][0] * rays[k], dy + DIRECTIONS[k][1] * rays[k]);
            let r2 = x * x + y * y;
            let covered = r2 < inner2 || shade.polygon && r2 < reach2 && contains(&self.rays[other.who as usize], x, y);
            if covered {
                factors[k] *= shade.factor;
            }
        }
    }
}

/// Who may break and fragment.
pub(super) fn is_branching(community: &Community, colony: &Colony) -> bool {
    community.species[usize::from(colony.species)].form == Form::Branching
}
