//! Boulders: balls along 24 arcs from the ends of the rays to the crown over the middle.
//!
//! # Equations
//! In the plane of a ray, with lengths in mean radii: from the crown `B = (0, 0.6)` to `A = (0.8, 0)` runs `a = A - B`; `x` is the
//! unit vector across it, outwards. Node `i` stands at
//! 1. `B + t_i a + f(t_i) q_i x`, with `t_i` growing by random steps of 0.10 to 0.14,
//! 2. `f(t) = -h/m^2 t^2 + 2 h/m t` for `t <= m`, and `-z t^2 + 2 m z t + z (1 - 2 m)`, `z = h / (m - 1)^2`, beyond: two
//!    parabolas that meet in their common top at `m = 0.6`. `h` is 0.21 to 0.27, `q_i` `1 - roughness` to 1.
//!
//! Its ball has 0.25 to 0.40 mean radii. Then each arc is stretched outwards until its outermost ball ends where the ray does.
//! Random numbers belong to colony, ray and node, so the colony of the next month has the same ones.
//!
//! # Source
//! The reef thesis, eqs 5.1 to 5.3 and algorithm 5.1.
//!
//! # Differences
//! - The crown stands at 0.6 radii instead of 0.5, or there would be a hollow on top.
//! - Short rays have smaller balls: those of the source reach beyond the outline where a neighbour stopped the colony.
//! - The source draws `h` from 0.50 to 0.65 and multiplies it by `x` before that has unit length, about half. With a unit vector and
//!   0.5 boulders are as steep as cheeses.
//! - Equation 5.1 makes `x` stand on the plane of M, A and B; it must lie in it.
//! - The inside is filled by a thick spoke under each arc. The source's boulders are hollow, which nobody sees but which counts as
//!   volume.
//! - Rough boulders have knobs on top of it all, of 0.13 to 0.20 radii.

use super::chance::Chance;
use super::outline::Outline;
use crate::community::{DIRECTIONS, RAYS};
use eyot_mesh::Primitive;

/// Nodes of an arc.
const NODES: u32 = 10;
/// Height of the crown, and how far the arc's other end lies from the middle.
const CROWN: f32 = 0.6;
const FOOT: f32 = 0.8;
/// Where the bulge is highest.
const TOP: f32 = 0.6;
/// Parts of the random numbers.
const BEND: u32 = 1;
const STEP: u32 = 2;
const OFFSET: u32 = 3;
const SIZE: u32 = 4;
const KNOB: u32 = 5;

/// A node in the plane of its ray: distance from the middle, height, radius; in mean radii.
#[derive(Clone, Copy)]
struct Node {
    out: f32,
    up: f32,
    radius: f32,
}

pub(super) fn massive(outline: &Outline, roughness: f32, chance: Chance) -> Vec<Primitive> {
    let mut primitives = Vec::new();
    for ray in 0..RAYS {
        let length = outline.rays[ray] / outline.radius;
        let narrow = (outline.narrowest(ray) / outline.radius).min(1.0);
        let mut nodes: Vec<Node> = arc(ray as u32, roughness, chance).collect();
        nodes.iter_mut().for_each(|n| n.radius *= narrow);
        nodes.iter_mut().for_each(|n| n.out *= length);
        let room = |n: &Node| (length - n.radius) / n.out;
        let outer = nodes.iter().filter(|n| n.up > 0.0 && n.out > 0.3 * length);
        let stretch = outer.map(room).fold(f32::INFINITY, f32::min).clamp(0.5, 1.5);
        primitives.push(spoke(outline, ray, 0.55 * length, narrow));
        for (i, n) in nodes.iter().enumerate() {
            primitives.push(ball(outline, ray, n.out * stretch, n.up, n.radius));
            // Knobs sit where the ball's own surface is.
            let at = ray as u32 * NODES + i as u32;
            if n.up > 0.1 && chance.between(KNOB, 2 * at, 0.0, 1.0) < roughness {
                let size = chance.between(KNOB, 2 * at + 1, 0.13, 0.2) * narrow;
                let lift = (n.radius - 0.72 * size) / (n.out * stretch).hypot(n.up);
                let (out, up) = (n.out * stretch * (1.0 + lift), n.up * (1.0 + lift));
                primitives.push(ball(outline, ray, out.min(length - size), up, size));
            }
        }
    }
    primitives
}

/// What fills the body below an arc, from the middle to so many mean radii out.
fn spoke(outline: &Outline, ray: usize, out: f32, narrow: f32) -> Primitive {
    let r = outline.radius;
    let [x, z] = DIRECTIONS[ray].map(|d| d * out * r);
    Primitive::cone([0.0, 0.28 * r, 0.0], [x, 0.15 * r, z], [0.34 * r, 0.3 * narrow * r])
}

fn ball(outline: &Outline, ray: usize, out: f32, up: f32, radius: f32) -> Primitive {
    let [x, z] = DIRECTIONS[ray].map(|d| d * out * outline.radius);
    Primitive::ball([x, up * outline.radius, z], radius * outline.radius)
}

fn arc(ray: u32, roughness: f32, chance: Chance) -> impl Iterator<Item = Node> {
    let bend = chance.between(BEND, ray, 0.21, 0.27);
    let a = [FOOT, -CROWN];
    let length = a[0].hypot(a[1]);
    let across = [-a[1] / length, a[0] / length];
    let mut t = 0.0;
    (0..NODES).map(move |i| {
        let at = ray * NODES + i;
        let bulge = f(t, bend) * chance.between(OFFSET, at, 1.0 - roughness, 1.0);
        let node = Node {
            out: t * a[0] + bulge * across[0],
            up: CROWN + t * a[1] + bulge * across[1],
            radius: chance.between(SIZE, at, 0.25, 0.4),
        };
        t += chance.between(STEP, at, 0.1, 0.14);
        node
    })
}

/// Height of the bulge over the line from the crown to the foot.
fn f(t: f32, h: f32) -> f32 {
    if t <= TOP {
        return -h / (TOP * TOP) * t * t + 2.0 * h / TOP * t;
    }
    let z = h / ((TOP - 1.0) * (TOP - 1.0));
    -z * t * t + 2.0 * TOP * z * t + z * (1.0 - 2.0 * TOP)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bulge_has_its_top_where_its_halves_meet() {
        for h in [0.5, 0.65] {
            assert!(f(0.0, h) == 0.0 && (f(TOP, h) - h).abs() < 1e-6);
            assert!(f(1.0, h).abs() < 1e-6 && f(1.1, h) < 0.0);
            let slope = |t: f32| (f(t + 1e-3, h) - f(t - 1e-3, h)) / 2e-3;
            assert!(slope(TOP).abs() < 1e-2 && slope(0.3) > 0.0 && slope(0.8) < 0.0);
            assert!((f(TOP + 1e-4, h) - h).abs() < 1e-5);
        }
    }
}
