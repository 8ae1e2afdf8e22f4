//! Individuals: colonies of corals, and macroalgae.

use super::geometry::{Rays, inner, longest};
use super::index::{Entry, Kind};
use super::species::{Form, Species};
use std::f32::consts::PI;

/// A colony of corals. Its rays stand apart, see [`Plot::rays`](super::Plot::rays).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colony {
    /// Never given again on the same plot.
    pub id: u64,
    /// Number of its species.
    pub species: u8,
    /// Months since it settled.
    pub age: u32,
    /// Centre, m from the west side.
    pub x: f32,
    /// Centre, m from the north side.
    pub y: f32,
    /// Mean length of the rays, m.
    pub radius: f32,
    /// 1 fully bleached, 0 healthy.
    pub bleaching: f32,
    /// Factor on growth by the light at its place.
    pub light: f32,
    /// Factor on this month's growth by bleaching.
    pub(super) vigour: f32,
    /// Skeleton made in the last month, kg.
    pub calcified_kg: f32,
}

impl Colony {
    /// Area of the disc of its mean radius, m2.
    pub fn area_m2(&self) -> f32 {
        PI * self.radius * self.radius
    }

    /// True until it has recovered.
    pub fn is_bleached(&self) -> bool {
        self.bleaching > 0.0
    }

    pub(super) fn entry(&self, who: usize, rays: &Rays, species: &Species, compat: bool) -> Entry {
        let (kind, reach, inner) = match species.form {
            Form::Massive => (Kind::Massive, longest(rays), inner(rays)),
            Form::Branching => (Kind::Branching, self.radius, self.radius),
        };
        let rank = if compat { self.radius } else { self.radius * species.competition };
        let (x, y, radius) = (self.x, self.y, self.radius);
        Entry { x, y, radius, reach, inner, rank, who: who as u32, kind, bleached: self.is_bleached() }
    }
}

/// A macroalga.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alga {
    /// Never given again on the same plot; colonies and algae share the numbers.
    pub id: u64,
    /// Months since it settled.
    pub age: u32,
    /// Centre, m from the west side.
    pub x: f32,
    /// Centre, m from the north side.
    pub y: f32,
    /// Radius, m.
    pub radius: f32,
    /// Height, m.
    pub height: f32,
}

impl Alga {
    /// Area that it covers, m2.
    pub fn area_m2(&self) -> f32 {
        PI * self.radius * self.radius
    }

    pub(super) fn entry(&self, who: usize) -> Entry {
        let (x, y, radius) = (self.x, self.y, self.radius);
        Entry {
            x,
            y,
            radius,
            reach: radius,
            inner: radius,
            rank: self.height,
            who: who as u32,
            kind: Kind::Alga,
            bleached: false,
        }
    }
}
