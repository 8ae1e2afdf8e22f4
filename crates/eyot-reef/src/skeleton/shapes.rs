//! Skeletons of columnar, foliaceous and laminar colonies.
//!
//! - Columnar: upright fingers on a sunflower's spiral, the tallest in the middle, each with a bud or two, on a common crust.
//! - Foliaceous: whorls of thin leaves, each a fan of ribs that lean outwards and upwards.
//! - Laminar, or tables: a stalk that flares into a plate of forking ribs, with short twigs on top.
//!
//! All fill the outline: what points to a ray ends where the ray does. Forms after the figure of Randall and Myers 1983 that the
//! reef thesis shows; the geometry is our own.

use super::chance::Chance;
use super::outline::Outline;
use crate::community::{DIRECTIONS, RAYS};
use eyot_core::math64::{cos_degrees, sin_degrees};
use eyot_mesh::{Point, Primitive};

/// Parts of the random numbers.
const PLACE: u32 = 11;
const LENGTH: u32 = 12;
const BUD: u32 = 13;
const LEAF: u32 = 14;
const RIB: u32 = 15;
const TWIG: u32 = 16;

/// Degrees from one seed of a sunflower to the next.
const GOLDEN: f32 = 137.507_76;

fn direction(degrees: f32) -> [f32; 2] {
    [cos_degrees(f64::from(degrees)) as f32, sin_degrees(f64::from(degrees)) as f32]
}

/// The place in a direction at a share of the way to the outline.
fn towards(outline: &Outline, [x, z]: [f32; 2], share: f32) -> [f32; 2] {
    let reach = 1.0 / outline.gauge(x, z).0;
    [x * reach * share, z * reach * share]
}

pub(super) fn columnar(outline: &Outline, height: f32, chance: Chance) -> Vec<Primitive> {
    const COLUMNS: u32 = 19;
    let r = outline.radius;
    let mut primitives = crust(outline, 0.1 * r);
    for i in 0..COLUMNS {
        let share = 0.8 * ((i as f32 + 0.5) / COLUMNS as f32).sqrt();
        let turn = GOLDEN * i as f32 + chance.between(PLACE, i, -12.0, 12.0);
        let [x, z] = towards(outline, direction(turn), share);
        let [ox, oz] = direction(turn);
        let top = height * r * (1.0 - 0.6 * share * share) * chance.between(LENGTH, i, 0.75, 1.0);
        let lean = 0.14 * r * share;
        let thick = r * chance.between(LENGTH, 64 + i, 0.085, 0.115);
        let tip = [x + lean * ox, (top - thick).max(0.1 * r), z + lean * oz];
        primitives.push(Primitive::cone([x, 0.0, z], tip, [1.35 * thick, 0.85 * thick]));
        for bud in 0..2 {
            let n = 2 * i + bud;
            if chance.between(BUD, n, 0.0, 1.0) < 0.6 {
                let up = chance.between(BUD, 64 + n, 0.35, 0.65);
                let [bx, bz] = direction(chance.between(BUD, 128 + n, 0.0, 360.0));
                let from: Point = std::array::from_fn(|k| [x, 0.0, z][k] * (1.0 - up) + tip[k] * up);
                let to = [from[0] + 0.14 * r * bx, from[1] + 0.22 * top, from[2] + 0.14 * r * bz];
                let inside = outline.gauge(to[0], to[2]).0 < 1.0 - thick / r;
                primitives.extend(inside.then(|| Primitive::cone(from, to, [0.8 * thick, 0.6 * thick])));
            }
        }
    }
    primitives
}

/// A layer on the ground that reaches to the ends of the rays.
fn crust(outline: &Outline, thick: f32) -> Vec<Primitive> {
    let rib = |k: usize| {
        let [x, z] = DIRECTIONS[k].map(|d| d * (outline.rays[k] - thick).max(0.0));
        Primitive::cone([0.0; 3], [x, 0.0, z], [1.6 * thick, thick])
    };
    (0..RAYS).map(rib).collect()
}

pub(super) fn foliaceous(outline: &Outline, height: f32, chance: Chance) -> Vec<Primitive> {
    const WHORLS: [(u32, f32, f32); 3] = [(7, 1.0, 28.0), (6, 0.72, 48.0), (4, 0.42, 66.0)];
    const RIBS: u32 = 15;
    let r = outline.radius;
    let thick = 0.04 * r;
    let mut primitives = vec![Primitive::cone([0.0; 3], [0.0, 0.12 * r, 0.0], [0.22 * r, 0.12 * r])];
    for (whorl, (leaves, length, rise)) in WHORLS.into_iter().enumerate() {
        for leaf in 0..leaves {
            let n = 8 * whorl as u32 + leaf;
            let turn = 360.0 * leaf as f32 / leaves as f32 + 40.0 * whorl as f32 + chance.between(LEAF, n, -10.0, 10.0);
            let width = 1.25 * 360.0 / leaves as f32;
            let rise = rise + chance.between(LEAF, 64 + n, -5.0, 5.0);
            for rib in 0..RIBS {
                let across = rib as f32 / (RIBS - 1) as f32 - 0.5;
                let d = direction(turn + across * width);
                // Leaves are rounded, wavy, and curl up at the rim.
                let share = length * (1.0 - 1.1 * across * across) * chance.between(RIB, 16 * n + rib, 0.96, 1.0);
                let [x, z] = towards(outline, d, share * (1.0 - thick / r));
                let out = x.hypot(z);
                let wave = 0.05 * r * cos_degrees(f64::from(across) * 540.0) as f32;
                let top = (out * sin_degrees(f64::from(rise)) as f32 * height + wave).max(thick);
                let bend = [0.55 * x, 0.05 * r + 0.35 * top, 0.55 * z];
                primitives.push(Primitive::cone([0.0, 0.06 * r, 0.0], bend, [1.5 * thick, 1.3 * thick]));
                primitives.push(Primitive::cone(bend, [x, top, z], [1.3 * thick, thick]));
            }
        }
    }
    primitives
}

pub(super) fn laminar(outline: &Outline, height: f32, chance: Chance) -> Vec<Primitive> {
    const RIBS: usize = 2 * RAYS;
    let r = outline.radius;
    let (plate, thick) = (height * r, 0.045 * r);
    let mut primitives = vec![
        Primitive::cone([0.0; 3], [0.0, 0.45 * plate, 0.0], [0.26 * r, 0.17 * r]),
        Primitive::cone([0.0, 0.45 * plate, 0.0], [0.0, plate - 0.2 * r, 0.0], [0.17 * r, 0.19 * r]),
    ];
    for rib in 0..RIBS as u32 {
        let turn = 360.0 * rib as f32 / RIBS as f32 + chance.between(RIB, rib, -2.0, 2.0);
        let place = |turn: f32, share: f32, up: f32| {
            let [x, z] = towards(outline, direction(turn), share);
            [x, plate + up * r - thick, z]
        };
        let share = (1.0 - thick / r) * chance.between(RIB, 64 + rib, 0.93, 1.0);
        let sag = chance.between(RIB, 128 + rib, -0.01, 0.03);
        let (root, fork) = (place(turn, 0.06, -0.1), place(turn, 0.55, 0.0));
        primitives.push(Primitive::cone(root, fork, [1.7 * thick, 1.2 * thick]));
        for side in [-1.0, 1.0] {
            let spread = side * 360.0 / RIBS as f32 * 0.27;
            primitives.push(Primitive::cone(fork, place(turn + spread, share, sag), [1.2 * thick, 0.8 * thick]));
        }
        for twig in 0..4 {
            let n = 4 * rib + twig;
            let share = share * (0.25 + 0.22 * twig as f32 + chance.between(TWIG, n, 0.0, 0.12));
            let foot = place(turn + chance.between(TWIG, 256 + n, -3.0, 3.0), share, 0.0);
            let up = thick + r * chance.between(TWIG, 512 + n, 0.0, 0.045);
            primitives.push(Primitive::cone(foot, [foot[0], foot[1] + up, foot[2]], [0.8 * thick, 0.55 * thick]));
        }
    }
    primitives
}
