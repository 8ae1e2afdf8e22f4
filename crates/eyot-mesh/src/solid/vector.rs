//! Vectors of three floats.

use crate::primitive::Point;
pub(crate) use eyot_core::vec3::{add, cross, dot, scale, sub};

/// `a` with length 1, or `None` if it has no length.
#[inline]
pub(crate) fn unit(a: Point) -> Option<Point> {
    let length = dot(a, a).sqrt();
    (length > 0.0 && length.is_finite()).then(|| scale(a, 1.0 / length))
}
