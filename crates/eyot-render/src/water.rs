//! Water: how its colour follows from depth, and the small waves on it.

use crate::math::{V3, add, attenuate, mul, scale, smoothstep};
use eyot_noise::picture::noise_with_slope;

/// Index of refraction of water against air.
const INDEX: f32 = 1.333;

/// Optical constants of one water body.
#[derive(Clone, Copy, Debug)]
pub struct Water {
    /// Absorption of red, green and blue, 1/m.
    pub absorb: V3,
    /// Light scattered back by a deep column, as an albedo.
    pub deep: V3,
    /// How fast the column's own colour builds up, 1/m.
    pub build: V3,
}

impl Water {
    /// Clear sea. `clarity_m` is the depth at which the bottom is all but lost.
    pub(crate) fn sea(clarity_m: f32) -> Self {
        let k = 1.0 / clarity_m.max(1e-6);
        Self { absorb: scale([5.6, 1.05, 0.62], k), deep: [0.0030, 0.024, 0.064], build: scale([2.6, 1.5, 1.3], k) }
    }

    /// River or lake; a little green and brown.
    pub(crate) fn fresh(clarity_m: f32) -> Self {
        let k = 1.0 / clarity_m.max(1e-6);
        Self { absorb: scale([4.6, 2.3, 1.9], k), deep: [0.012, 0.045, 0.075], build: scale([3.0, 2.6, 2.4], k) }
    }

    /// The share of light from a grey ground that `depth` m of water take away: `1 - exp(-depth k)` over the colours.
    pub(crate) fn opacity(&self, depth: f32) -> f32 {
        let left = attenuate(self.absorb, 2.0 * depth.max(0.0));
        1.0 - (0.2 * left[0] + 0.5 * left[1] + 0.3 * left[2])
    }

    /// Light that comes up through the surface, as an albedo: `floor` below `depth` m of water, light and view going
    /// `path` times the depth.
    pub(crate) fn upwelling(&self, floor: V3, depth: f32, path: f32) -> V3 {
        let depth = depth.max(0.0);
        let floor_left = attenuate(self.absorb, depth * path);
        let column = attenuate(self.build, depth * path * 0.5).map(|x| 1.0 - x);
        add(mul(floor, floor_left), mul(self.deep, column))
    }
}

/// Share of light that a water surface reflects, for the cosine between its normal and the view (Schlick).
pub(crate) fn fresnel(cos: f32) -> f32 {
    let c = (1.0 - cos).clamp(0.0, 1.0);
    let c2 = c * c;
    0.02 + 0.98 * c2 * c2 * c
}

/// Cosine of the refracted direction under water.
pub(crate) fn refracted_cos(cos: f32) -> f32 {
    let sin2 = (1.0 - cos * cos).max(0.0) / (INDEX * INDEX);
    (1.0 - sin2).sqrt()
}

/// Slopes of small waves at a place, in m per m. `unit_m` is the length of the longest; waves shorter than about two
/// pixels (`footprint_m`) are left out and counted as roughness, which is the second result.
pub(crate) fn waves(x: f32, y: f32, unit_m: f32, footprint_m: f32) -> ([f32; 2], f32) {
    // Length relative to the unit, slope, and the turn of the lattice as (cos, sin); crests lie across the wind.
    const TRAINS: [(f32, f32, f32, f32); 5] = [
        (1.0, 0.030, 0.921, 0.391),
        (0.41, 0.042, 0.731, 0.682),
        (0.173, 0.052, 0.990, -0.139),
        (0.071, 0.058, 0.559, 0.829),
        (0.029, 0.060, 0.857, 0.515),
    ];
    let (mut sx, mut sy, mut rough) = (0.0, 0.0, 0.0);
    for (i, (length, slope, c, s)) in TRAINS.into_iter().enumerate() {
        let length = length * unit_m;
        let keep = smoothstep(3.2, 1.1, footprint_m * 2.0 / length);
        rough += slope * (1.0 - keep);
        if keep <= 0.0 {
            continue;
        }
        // Crests are longer than wide.
        let (a, b) = ((c * x + s * y) / length, (c * y - s * x) / (1.8 * length));
        let (_, da, db) = noise_with_slope(a, b, 900 + i as u32);
        let k = slope * keep * 0.55;
        sx += k * (c * da - s * db / 1.8);
        sy += k * (s * da + c * db / 1.8);
    }
    ([sx, sy], rough)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opacity_grows_with_depth_from_nothing_to_all() {
        for water in [Water::sea(20.0), Water::fresh(2.0)] {
            let mut last = -1.0;
            for i in 0..400 {
                let o = water.opacity(0.25 * i as f32);
                assert!(o > last || o > 0.9999, "depth {}: {o} after {last}", 0.25 * i as f32);
                last = o;
            }
            assert_eq!(water.opacity(0.0), 0.0);
            assert!(last > 0.99);
        }
    }

    #[test]
    fn red_goes_first_and_deep_water_hides_its_floor() {
        let w = Water::sea(25.0);
        let c = w.upwelling([0.5; 3], 6.0, 2.2);
        assert!(c[0] < 0.5 * c[1] && c[1] > 0.1, "{c:?}");
        let (bright, dark) = (w.upwelling([0.8; 3], 400.0, 2.2), w.upwelling([0.0; 3], 400.0, 2.2));
        assert!((0..3).all(|k| (bright[k] - dark[k]).abs() < 1e-5));
    }

    #[test]
    fn a_mirror_at_grazing_angles_and_clear_from_above() {
        assert!(fresnel(1.0) < 0.03 && fresnel(0.0) > 0.99);
        assert!((refracted_cos(1.0) - 1.0).abs() < 1e-6 && refracted_cos(0.0) > 0.6);
    }
}
