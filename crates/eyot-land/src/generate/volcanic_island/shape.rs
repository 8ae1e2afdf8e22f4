//! Height at a place: equations (1) to (6).

use super::draw::{Cone, Island, Trough, Volcano};
use eyot_core::math::smoothstep;
use eyot_core::math64::exp;

/// Metres over which a volcano's own forms are joined without an edge.
const JOIN_M: f64 = 12.0;
/// Slope of the rubble below the shelf.
const SLOPE: f64 = 0.5;

/// Least slope of the flanks under the sea.
const FOOT: f64 = 0.35;

/// What the noises say of a place, within -1..=1.
#[derive(Clone, Copy)]
pub(super) struct Chance {
    /// Of the ground's height.
    pub ground: f64,
    /// Of what differs along the coast.
    pub coast: f64,
}

/// The smaller number, rounded off where they differ by less than `k`.
fn lower(a: f64, b: f64, k: f64) -> f64 {
    let t = (1.0 - (a - b).abs() / k).max(0.0);
    a.min(b) - 0.25 * k * t * t
}

/// The larger number, rounded off where they differ by less than `k`.
fn higher(a: f64, b: f64, k: f64) -> f64 {
    -lower(-a, -b, k)
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn length(a: [f64; 2]) -> f64 {
    dot(a, a).sqrt()
}

impl Trough {
    /// Equation (3): nothing rises above this.
    fn cap_m(&self, p: [f64; 2]) -> f64 {
        let from_head = minus(p, self.head);
        let along = dot(from_head, self.down).max(0.0);
        let t = along / self.length_m;
        let d = length(minus(from_head, self.down.map(|d| d * along.min(self.open_m))));
        // A flat floor up to half the width, and a round foot of the walls.
        let width = 0.5 * self.width_m * (1.0 + self.widening * t.min(1.0));
        let aside = (d - width).max(0.0);
        let floor = if t < 1.0 { self.head_m * (1.0 - t) * (1.0 - t) } else { 0.0 };
        floor - self.drowned_m * t + self.wall * ((aside * aside + width * width).sqrt() - width)
    }
}

impl Cone {
    /// Height that the cone adds: a straight flank and a crater.
    fn height_m(&self, p: [f64; 2]) -> f64 {
        let r = length(minus(p, self.centre)) / self.radius_m;
        if r < 1.0 { self.height_m * lower(1.0 - r, 0.38 + 1.1 * r, 0.15).max(0.0) } else { 0.0 }
    }
}

impl Volcano {
    /// Distance from the centre in radii, equation (1).
    fn radii(&self, p: [f64; 2]) -> f64 {
        let from_centre = minus(p, self.centre);
        let far = length(from_centre);
        let u = if far > 0.0 { from_centre.map(|v| v / far) } else { [0.0; 2] };
        let arms = self.rifts.iter().map(|(d, a)| a * (dot(u, *d).max(0.0).powi(6) - 0.125));
        far / (self.radius_m * (1.0 + arms.sum::<f64>()).max(0.3))
    }

    /// Equations (2) to (4) at the distance `r` in radii, m over the sea.
    fn height_m(&self, p: [f64; 2], r: f64, chance: Chance) -> f64 {
        let k = self.concavity;
        let at = |s: f64| exp(-k * s) - exp(-k);
        let mut z = self.height_m * at((r * r + self.round * self.round).sqrt()) / at(self.round);
        // Below the sea flanks are steep even where the island is flat.
        z = z.min(FOOT * (1.0 - r).min(0.0) * self.radius_m + z.max(0.0));
        if r > 1.7 {
            return z;
        }
        // Old ground is rough, and roughest high up.
        z += chance.ground * (0.05 + 0.15 * self.age) * (z.max(0.0) + 0.15 * self.height_m);
        z += self.cones.iter().map(|c| c.height_m(p)).sum::<f64>();
        // The floors of troughs keep a third of the roughness.
        let floor = 0.04 * chance.ground * self.height_m;
        self.troughs.iter().fold(z, |z, t| lower(z, t.cap_m(p) + floor, JOIN_M))
    }
}

impl Island {
    /// Height over the sea at a place in m from the middle of the grid, east and south.
    pub(super) fn height_m(&self, p: [f64; 2], chance: Chance) -> f64 {
        let (mut z, mut shelf) = (-self.depth_m, -self.depth_m);
        for v in &self.volcanoes {
            let r = v.radii(p);
            z = higher(z, v.height_m(p, r, chance), 3.0 * JOIN_M);
            // Equation (6).
            let width = self.shelf * (0.5 + 0.5 * v.age) * (0.75 + 0.5 * chance.coast);
            let beyond_m = ((r - 1.0 - width) * v.radius_m).max(0.0);
            shelf = higher(shelf, -self.shelf_depth_m - SLOPE * beyond_m, 4.0 * JOIN_M);
        }
        let far = length(p).max(1.0);
        let beyond_m = SLOPE * (far - self.room_m);
        z = lower(z, -beyond_m, 4.0 * JOIN_M);
        shelf = lower(shelf, -self.shelf_depth_m - beyond_m, 4.0 * JOIN_M);
        // Equation (5).
        let exposed = 0.25 + 0.75 * smoothstep(-0.4, 0.8, dot(p, self.windward) / far);
        let cut = self.cliffs_m * exposed * (0.6 + 0.8 * chance.coast).clamp(0.0, 1.0);
        let platform = -2.0 - 0.1 * (cut - z);
        let standing = smoothstep(0.5 * cut - 2.0, cut + 2.0, z);
        let z = if z > -self.shelf_depth_m { platform + (z - platform) * standing } else { z.min(platform.max(z)) };
        higher(z, shelf.min(-self.shelf_depth_m), 2.0).max(-self.depth_m)
    }
}
