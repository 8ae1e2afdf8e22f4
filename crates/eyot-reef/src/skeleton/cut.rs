//! A body within its outline and above its foot.

use super::outline::Outline;
use eyot_core::rng::mix64;
use eyot_mesh::{Point, ScalarField, Within};

/// The part of a field that lies over its foot and, if there is an outline, within it.
pub(crate) struct Cut<'a> {
    pub(crate) field: Box<dyn ScalarField + 'a>,
    pub(crate) outline: Option<&'a Outline>,
    /// How deep below the ground it ends, m: the edge there is ragged.
    pub(crate) foot: f32,
    /// What distances are multiplied by, 1/m: about the gradient of the field.
    pub(crate) steepness: f32,
}

impl Cut<'_> {
    /// The lesser one of what ground and outline leave, and its gradient.
    fn limit(&self, p: Point) -> (f32, Point) {
        let ground = ((p[1] + self.foot) * self.steepness, [0.0, self.steepness, 0.0]);
        let Some(outline) = self.outline else { return ground };
        let (gauge, [gx, gz]) = outline.gauge(p[0], p[2]);
        let scale = self.steepness * outline.radius;
        let side = ((1.0 - gauge) * scale, [-gx * scale, 0.0, -gz * scale]);
        if side.0 < ground.0 { side } else { ground }
    }
}

impl ScalarField for Cut<'_> {
    fn value(&self, p: Point) -> f32 {
        let (limit, value) = (self.limit(p).0, self.field.value(p));
        if limit < value { limit } else { value }
    }

    fn slope(&self, p: Point, voxel: f32) -> (f32, Point) {
        let (limit, inner) = (self.limit(p), self.field.slope(p, voxel));
        if limit.0 < inner.0 { limit } else { inner }
    }

    fn row(&self, xs: &[f32], y: f32, z: f32, values: &mut [f32]) {
        self.field.row(xs, y, z, values);
        for (v, &x) in values.iter_mut().zip(xs) {
            let limit = self.limit([x, y, z]).0;
            if limit < *v {
                *v = limit;
            }
        }
    }

    fn within(&self, low: Point, high: Point) -> Within<'_> {
        if high[1] < -self.foot {
            return Within::Nothing;
        }
        match self.field.within(low, high) {
            Within::Part(field) => Within::Part(Box::new(Cut { field, ..*self })),
            other => other,
        }
    }

    fn stamp(&self) -> Option<u64> {
        let rays = self.outline.map_or(&[][..], |o| &o.rays);
        let numbers = rays.iter().chain([&self.steepness, &self.foot]);
        let stamp = self.field.stamp()?;
        Some(numbers.fold(stamp, |stamp, v| mix64(stamp ^ u64::from(v.to_bits()))))
    }
}
