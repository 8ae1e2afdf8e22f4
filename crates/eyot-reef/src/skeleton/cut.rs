//! A body within its outline and above its foot.

use super::outline::Outline;
use eyot_core::rng::mix64;
use eyot_mesh::{Point, ScalarField, Within};

/// The part of a field that lies over its foot and, if there is an outline, within it.
pub(crate) struct Cut<'a> {
    pub(crate) field: Box<dyn ScalarField + Send + 'a>,
    pub(crate) outline: Option<&'a Outline>,
    /// How deep below the ground it ends, m: the edge there is ragged.
    pub(crate) foot: f32,
    /// What distances are multiplied by, 1/m: about the gradient of the field.
    pub(crate) steepness: f32,
}

impl Cut<'_> {
    /// What the ground leaves.
    fn ground(&self, y: f32) -> f32 {
        (y + self.foot) * self.steepness
    }

    /// What the outline leaves, and the gradient of that.
    fn side(outline: &Outline, steepness: f32, x: f32, z: f32) -> (f32, Point) {
        let (gauge, [gx, gz]) = outline.gauge(x, z);
        let scale = steepness * outline.radius;
        ((1.0 - gauge) * scale, [-gx * scale, 0.0, -gz * scale])
    }

    /// The lesser one of what ground and outline leave, and its gradient.
    fn limit(&self, p: Point) -> (f32, Point) {
        let ground = (self.ground(p[1]), [0.0, self.steepness, 0.0]);
        let Some(outline) = self.outline else { return ground };
        let side = Self::side(outline, self.steepness, p[0], p[2]);
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

    fn slopes(&self, points: &[Point], voxel: f32, slopes: &mut [(f32, Point)]) {
        self.field.slopes(points, voxel, slopes);
        for (slope, &p) in slopes.iter_mut().zip(points) {
            let limit = self.limit(p);
            if limit.0 < slope.0 {
                *slope = limit;
            }
        }
    }

    fn fill(&self, [xs, ys, zs]: [&[f32]; 3], values: &mut [f32]) {
        self.field.fill([xs, ys, zs], values);
        let mut sides = vec![f32::INFINITY; xs.len()];
        for (plane, &z) in values.chunks_exact_mut(xs.len() * ys.len()).zip(zs) {
            // The outline is the same at all heights.
            if let Some(outline) = self.outline {
                sides.iter_mut().zip(xs).for_each(|(s, &x)| *s = Self::side(outline, self.steepness, x, z).0);
            }
            for (row, &y) in plane.chunks_exact_mut(xs.len()).zip(ys) {
                let ground = self.ground(y);
                for (v, &side) in row.iter_mut().zip(&sides) {
                    let limit = if side < ground { side } else { ground };
                    *v = if limit < *v { limit } else { *v };
                }
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
