//! Discs, and bodies of 24 rays, as seen from above.

use eyot_core::math64::acos;
use std::f64::consts::PI;

/// Rays of a colony, 15 degrees apart; ray 0 points along +x, the others follow counter-clockwise (towards +y).
pub const RAYS: usize = 24;

/// Lengths of a colony's rays, m.
pub type Rays = [f32; RAYS];

/// sqrt 2, sqrt 3 and sqrt 6, of which the directions are made.
const R2: f32 = std::f32::consts::SQRT_2;
const R3: f32 = 1.732_050_8;
const R6: f32 = 2.449_489_8;

/// Cosines of 0, 15, 30, 45, 60, 75 and 90 degrees.
const COS: [f32; 7] = [1.0, (R6 + R2) / 4.0, R3 / 2.0, R2 / 2.0, 0.5, (R6 - R2) / 4.0, 0.0];
/// Tangents of 15, 30, 45, 60 and 75 degrees.
const TAN: [f32; 5] = [2.0 - R3, R3 / 3.0, 1.0, R3, 2.0 + R3];
/// Cosine of 7.5 degrees: what equal rays leave of their length between them.
const COS_HALF: f32 = 0.991_444_9;

/// Unit vectors along the rays.
pub const DIRECTIONS: [[f32; 2]; RAYS] = directions();

const fn directions() -> [[f32; 2]; RAYS] {
    let mut d = [[0.0; 2]; RAYS];
    let mut k = 0;
    while k < RAYS {
        let (quarter, i) = (k / 6, k % 6);
        let (c, s) = (COS[i], COS[6 - i]);
        d[k] = match quarter {
            0 => [c, s],
            1 => [-s, c],
            2 => [-c, -s],
            _ => [s, -c],
        };
        k += 1;
    }
    d
}

/// Mean length of the rays, m.
pub(super) fn mean(rays: &Rays) -> f32 {
    // Not more than the longest ray, to which rounding may add.
    (rays.iter().sum::<f32>() / RAYS as f32).min(longest(rays))
}

/// Length of the longest ray, m.
pub(super) fn longest(rays: &Rays) -> f32 {
    rays.iter().copied().fold(0.0, f32::max)
}

/// Radius of a disc that surely lies within the polygon through the rays' ends, m.
pub(super) fn inner(rays: &Rays) -> f32 {
    rays.iter().copied().fold(f32::INFINITY, f32::min) * COS_HALF
}

/// Number of the ray on the clockwise side of the direction (dx, dy).
#[inline]
pub(crate) fn sector(dx: f32, dy: f32) -> usize {
    let (x, y) = (dx.abs(), dy.abs());
    let first = TAN.iter().filter(|&&t| y >= t * x).count();
    match (dx >= 0.0, dy >= 0.0) {
        (true, true) => first,
        (false, true) => 11 - first,
        (false, false) => 12 + first,
        (true, false) => 23 - first,
    }
}

/// True if the point (dx, dy) from a colony's centre lies within the polygon through the ends of its rays.
#[inline]
pub(super) fn contains(rays: &Rays, dx: f32, dy: f32) -> bool {
    let k = sector(dx, dy);
    let next = (k + 1) % RAYS;
    let [ax, ay] = DIRECTIONS[k].map(|d| d * rays[k]);
    let [bx, by] = DIRECTIONS[next].map(|d| d * rays[next]);
    (bx - ax) * (dy - ay) - (by - ay) * (dx - ax) >= 0.0
}

/// Area that two discs at distance `d` share, m2.
pub(super) fn lens(r: f32, other: f32, d: f32) -> f32 {
    if d >= r + other {
        return 0.0;
    }
    let small = r.min(other);
    if d <= (r - other).abs() {
        return small * small * std::f32::consts::PI;
    }
    let (r, s, d) = (f64::from(r), f64::from(other), f64::from(d));
    let (a, b) = ((d * d + r * r - s * s) / (2.0 * d), (d * d + s * s - r * r) / (2.0 * d));
    let segment = |radius: f64, to_chord: f64| {
        radius * radius * acos(to_chord / radius) - to_chord * (radius * radius - to_chord * to_chord).max(0.0).sqrt()
    };
    (segment(r, a) + segment(s, b)).clamp(0.0, f64::from(small * small) * PI) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_24_equal_steps() {
        for (k, d) in DIRECTIONS.iter().enumerate() {
            let angle = (k as f32 * 15.0).to_radians();
            assert!((d[0] - angle.cos()).abs() < 3e-7 && (d[1] - angle.sin()).abs() < 3e-7, "ray {k}: {d:?}");
            let between = angle + 0.1;
            assert_eq!(sector(between.cos(), between.sin()), k);
        }
    }

    #[test]
    fn a_polygon_contains_what_lies_within_its_edges() {
        let mut rays = [1.0; RAYS];
        assert!(contains(&rays, 0.0, 0.0) && contains(&rays, 0.7, 0.7) && !contains(&rays, 0.72, 0.72));
        // Between two rays the edge is straight: cos 7.5 degrees.
        let (s, c) = 7.5f32.to_radians().sin_cos();
        assert!(contains(&rays, 0.991 * c, 0.991 * s) && !contains(&rays, 0.9919 * c, 0.9919 * s));
        rays[6] = 3.0;
        assert!(contains(&rays, 0.0, 2.9) && !contains(&rays, 0.5, 2.9) && !contains(&rays, 0.0, -1.1));
        assert_eq!((longest(&rays), mean(&rays)), (3.0, 26.0 / 24.0));
    }

    #[test]
    fn lenses_have_their_known_areas() {
        let pi = std::f32::consts::PI;
        assert_eq!((lens(1.0, 1.0, 2.0), lens(1.0, 3.0, 1.5)), (0.0, pi));
        assert!((lens(1.0, 1.0, 0.0) - pi).abs() < 1e-6);
        // Two unit discs at distance 1: 2 pi / 3 - sqrt 3 / 2.
        assert!((lens(1.0, 1.0, 1.0) - (2.0 * pi / 3.0 - 3f32.sqrt() / 2.0)).abs() < 1e-6);
        // By counting points.
        let (r, s, d) = (0.4f32, 0.9f32, 0.7f32);
        let n = 2000;
        let mut hits = 0u32;
        for i in 0..n {
            for j in 0..n {
                let (x, y) = (-0.4 + 0.8 * (i as f32 + 0.5) / n as f32, -0.4 + 0.8 * (j as f32 + 0.5) / n as f32);
                hits += u32::from(x * x + y * y < r * r && (x - d) * (x - d) + y * y < s * s);
            }
        }
        let counted = hits as f32 * 0.64 / (n * n) as f32;
        assert!((lens(r, s, d) - counted).abs() < 1e-4, "{} {counted}", lens(r, s, d));
    }
}
