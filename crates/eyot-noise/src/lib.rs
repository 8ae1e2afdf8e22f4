//! Lattice noise: the one home of what generators, processes and pictures are strewn with.
//!
//! - [`plane`]: noise over the land in metres, for layers. Squares, triangles and strewn points; sums over octaves; repeats with the
//!   extent on wrapping rims; in vectors, the same bits with every instruction set.
//! - [`ring`]: noise that repeats after whole numbers of lattice cells, one place at a time, for processes.
//! - [`picture`]: gradient noise with its slopes, for colours, waves and clouds, and the same for shaders.
//!
//! They differ in their hashes and gradients, since what is made with them shall not change. What they share stands here.

pub mod picture;
pub mod plane;
pub mod ring;

use eyot_core::real::Real;

/// The quintic fade of Perlin 2002, `6 t^5 - 15 t^4 + 10 t^3`: 0 and 1 at the ends, first and second derivative 0 there.
#[inline(always)]
pub fn fade<R: Real>(t: R) -> R {
    t * t * t * (t * (t * R::of(6.0) - R::of(15.0)) + R::of(10.0))
}

/// The derivative of [`fade`].
#[inline(always)]
pub fn fade_slope<R: Real>(t: R) -> R {
    R::of(30.0) * t * t * (t - R::of(1.0)) * (t - R::of(1.0))
}

/// Between the corners (0, 0), (1, 0), (0, 1) and (1, 1) of a square, at the faded place (s, t).
#[inline(always)]
pub fn blend<R: Real>(corners: [R; 4], s: R, t: R) -> R {
    let north = corners[0] + s * (corners[1] - corners[0]);
    let south = corners[2] + s * (corners[3] - corners[2]);
    north + t * (south - north)
}

/// The integer below `x`; the library's `floor` is a call where the processor's own is not assumed.
#[inline(always)]
fn floor(x: f32) -> i32 {
    let i = x as i32;
    i.wrapping_sub(i32::from((i as f32) > x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fade_is_flat_at_its_ends_and_its_slope_is_its_derivative() {
        assert_eq!((fade(0.0f64), fade(1.0f64), fade_slope(0.0f64), fade_slope(1.0f64)), (0.0, 1.0, 0.0, 0.0));
        for t in (1..100).map(|i| f64::from(i) / 100.0) {
            let slope = (fade(t + 1e-6) - fade(t - 1e-6)) / 2e-6;
            assert!((slope - fade_slope(t)).abs() < 1e-8, "{t}");
        }
    }

    #[test]
    fn whole_numbers_below() {
        for (x, below) in [(0.0, 0), (-0.0, 0), (0.99, 0), (-0.01, -1), (-1.0, -1), (7.5, 7), (-7.5, -8)] {
            assert_eq!(floor(x), below, "{x}");
        }
    }

    #[test]
    fn blends_are_the_corners_at_the_corners() {
        let corners = [1.0f32, 2.0, 4.0, 8.0];
        let at = |s, t| blend(corners, s, t);
        assert_eq!([at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)], corners);
        assert_eq!(at(0.5, 0.5), 3.75);
    }
}
