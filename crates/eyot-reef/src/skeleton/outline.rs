//! The outline of a colony on the sea floor: the polygon through the ends of its 24 rays.

use crate::community::{DIRECTIONS, RAYS, Rays};

/// Rays are not shorter than this share of their mean, so that a body has no seams down to its middle.
const SHORTEST: f32 = 0.08;

/// The polygon through the ends of rays. Places are m from the colony's centre, to the east (x) and the south (z).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Outline {
    pub(crate) rays: Rays,
    /// Mean length of the rays.
    pub(crate) radius: f32,
    /// For each sector between two rays, the gradient of [`Outline::gauge`].
    gradients: [[f32; 2]; RAYS],
}

impl Outline {
    pub(crate) fn new(rays: &Rays) -> Self {
        let radius = rays.iter().sum::<f32>() / RAYS as f32;
        let rays = rays.map(|r| r.max(SHORTEST * radius));
        let gradients = std::array::from_fn(|k| {
            let tip = |k: usize| DIRECTIONS[k % RAYS].map(|d| d * rays[k % RAYS]);
            let ([ax, az], [bx, bz]) = (tip(k), tip(k + 1));
            // The linear function that is 1 at both tips and 0 in the middle.
            let area = ax * bz - az * bx;
            [(bz - az) / area, (ax - bx) / area]
        });
        Self { rays, radius, gradients }
    }

    /// 0 in the middle, 1 on the outline, in proportion between and beyond; and its gradient.
    pub(crate) fn gauge(&self, x: f32, z: f32) -> (f32, [f32; 2]) {
        let g = self.gradients[sector(x, z)];
        (g[0] * x + g[1] * z, g)
    }

    /// Distance from the middle to the outline along ray `k`, and the shorter one of its neighbours and itself.
    pub(crate) fn narrowest(&self, k: usize) -> f32 {
        self.rays[(k + RAYS - 1) % RAYS].min(self.rays[k]).min(self.rays[(k + 1) % RAYS])
    }

    /// Area, m2.
    pub(crate) fn area(&self) -> f32 {
        // Sine of 15 degrees.
        let s = DIRECTIONS[1][1];
        (0..RAYS).map(|k| 0.5 * s * self.rays[k] * self.rays[(k + 1) % RAYS]).sum()
    }
}

/// Number of the ray before a place, counted from the east over the south.
fn sector(x: f32, z: f32) -> usize {
    crate::community::sector_of(x, z)
}
