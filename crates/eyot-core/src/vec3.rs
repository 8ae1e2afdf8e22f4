//! Vectors of three numbers: points, directions, linear colours.

use crate::real::Real;

/// Sum.
#[inline(always)]
pub fn add<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Difference.
#[inline(always)]
pub fn sub<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// All components times `s`.
#[inline(always)]
pub fn scale<R: Real>(a: [R; 3], s: R) -> [R; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// Scalar product.
#[inline(always)]
pub fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product, right-handed.
#[inline(always)]
pub fn cross<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_axes() {
        let axes = [[1.0f64, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for i in 0..3 {
            assert_eq!(cross(axes[i], axes[(i + 1) % 3]), axes[(i + 2) % 3]);
            assert_eq!((dot(axes[i], axes[i]), dot(axes[i], axes[(i + 1) % 3])), (1.0, 0.0));
        }
        assert_eq!(sub(add(axes[0], scale(axes[1], 2.0)), axes[2]), [1.0, 2.0, -1.0]);
    }
}
