//! Colours and texture coordinates of bodies.
//!
//! # Equations
//! 1. `c = c1 (1 - r) + c2 r`, `r` being the colony's own number (thesis, eq 5.14), in linear light.
//! 2. Bleached corals go to the white of their skeleton, by their grade. Growing ends are paler, the shaded foot is darker.
//! 3. `u = 1/2 + atan2(d_z, d_x) / (2 pi)`, `v = 1/2 + asin(d_y) / pi`, `d` being the direction from the middle (eqs 5.15, 5.16).

use crate::skeleton::Chance;
use eyot_core::math64::{acos, pow};
use eyot_mesh::{Point, Solid};

/// Linear light of a bare skeleton.
const SKELETON: [f32; 3] = [0.86, 0.84, 0.78];
const COLOUR: u32 = 31;

/// What the colours of a colony depend on.
pub(super) struct Paint {
    /// sRGB.
    pub(super) colours: [[u8; 3]; 2],
    pub(super) bleaching: f32,
    /// How much paler growing ends are, 0..=1.
    pub(super) pale_ends: f32,
    pub(super) chance: Chance,
}

/// Linear colours of the vertices of a body of this radius and height, m.
pub(super) fn colours(solid: &Solid, radius: f32, height: f32, paint: &Paint) -> Vec<[u8; 4]> {
    let r = paint.chance.between(COLOUR, 0, 0.0, 1.0);
    let [first, second] = paint.colours.map(|c| c.map(linear));
    let own: [f32; 3] = std::array::from_fn(|i| first[i] * (1.0 - r) + second[i] * r);
    let of_vertex = |p: &Point| {
        let up = (p[1] / height).clamp(0.0, 1.0);
        // 1 on the dome over the outline, where the colony grows.
        let end = ((p[0] * p[0] + p[2] * p[2]) / (radius * radius) + up * up).min(1.0);
        let pale = paint.pale_ends * (end * end * end) * (end * end * end);
        let shade = 0.62 + 0.38 * up.sqrt();
        let colour: [f32; 3] = std::array::from_fn(|i| {
            let alive = own[i] + (SKELETON[i] - own[i]) * pale;
            (alive + (SKELETON[i] - alive) * paint.bleaching.clamp(0.0, 1.0)) * shade
        });
        let [r, g, b] = colour.map(|v| (255.0 * v + 0.5) as u8);
        [r, g, b, 255]
    };
    solid.positions.iter().map(of_vertex).collect()
}

/// Spherical texture coordinates. They jump from 1 to 0 to the west of the middle: one texture wraps around.
pub(super) fn texture(solid: &Solid) -> Vec<[f32; 2]> {
    let of_vertex = |p: &Point| {
        let [x, y, z] = p.map(f64::from);
        let square = x * x + z * z;
        let (out, length) = (square.sqrt(), (square + y * y).sqrt());
        let turn = if out > 0.0 { acos((x / out).clamp(-1.0, 1.0)) } else { 0.0 };
        let turn = if z < 0.0 { -turn } else { turn };
        let rise = if length > 0.0 { 0.5 - acos((y / length).clamp(-1.0, 1.0)) / std::f64::consts::PI } else { 0.0 };
        [(0.5 + turn / std::f64::consts::TAU) as f32, (0.5 + rise) as f32]
    };
    solid.positions.iter().map(of_vertex).collect()
}

fn linear(byte: u8) -> f32 {
    let c = f64::from(byte) / 255.0;
    (if c <= 0.04045 { c / 12.92 } else { pow((c + 0.055) / 1.055, 2.4) }) as f32
}
