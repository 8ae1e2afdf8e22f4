//! Branches: a grammar draws the full-grown colony once and for all; what lies within the colony's growth volume is there.
//!
//! The growth volume is a dome over the outline. Branches that leave it end where they do, and nothing grows from there on, so that
//! branches get longer month by month and fork when there is room. The drawing itself grows with the root of the radius. Equation 1 below gives each its thickness.
//!
//! # Equations
//! 1. `r_i = r w_i`, `w_i` being the width that the grammar gives, and `r` such that all branches together have the volume that
//!    the community gives the colony: `volume = 0.8 pi r^2 sum of l_i w_i^2` to begin with; `bodies` measures and corrects it.
//!
//! 2. Where the meshing cannot draw branches of that thickness, the last generations of branches are left out until the others
//!    have it: all up to generation `D`, and of the next one the part `D - floor(D)` of each branch, so that nothing jumps when
//!    the colony grows.
//!
//! # Source
//! The reef thesis, section 5.1.2; its grammar is `grammars/thicket.txt`.
//!
//! # Differences
//! - The parent branch stays (equation 5.5 replaces it), as the thesis' own count of 250 segments needs.
//! - Young colonies have shorter branches. With lengths of the full-grown one, nothing would fork before half of its radius.
//! - Branches end on the growth volume itself; equation 5.10 is exact for radial branches alone.
//! - Branches wholly outside are left out; the text says "drawn".

use super::chance::Chance;
use super::outline::Outline;
use crate::lsystem::{Grammar, Segment, Vector};
use eyot_core::{Limits, Result};
use eyot_mesh::Primitive;

/// Radius of a growing tip over that of its branch.
const TIP: f32 = 0.8;

/// What a colony's branches grow by.
pub(super) struct Branches<'a> {
    /// What the grammar draws.
    pub(super) drawing: &'a [Segment],
    /// Radius of the full-grown colony, m.
    pub(super) full_radius: f32,
    /// Height of the growth volume over its radius.
    pub(super) height: f32,
    /// Volume that they are to have, m3.
    pub(super) volume: f32,
    /// Radius of the thinnest branches that can be drawn, m.
    pub(super) thinnest: f32,
}

/// A branch within the growth volume; m, y up.
struct Branch {
    ends: [[f32; 3]; 2],
    widths: [f32; 2],
    is_tip: bool,
}

/// Everything that a colony's grammar ever draws, as long as it lives.
///
/// # Errors
/// If the grammar makes more than fits into 256 MiB, or leaves the range of numbers.
pub(crate) fn drawing(grammar: &Grammar, chance: Chance) -> Result<Vec<Segment>> {
    let limits = Limits { max_bytes: 256 << 20, ..Limits::default() };
    let word = grammar.derive(grammar.steps, chance.seed(), &limits)?;
    Ok(grammar.draw(&word, chance.seed(), &limits)?.segments)
}

pub(super) fn branching(outline: &Outline, b: &Branches<'_>) -> Vec<Primitive> {
    let (clipped, r) = grown(b.drawing, outline, b);
    let cone = |branch: &Branch| {
        let mut radii = branch.widths.map(|w| w * r);
        if branch.is_tip {
            radii[1] *= TIP;
        }
        Primitive::cone(branch.ends[0], branch.ends[1], radii.map(|r| r.max(b.thinnest)))
    };
    let mut primitives: Vec<Primitive> = clipped.iter().map(cone).collect();
    // What all of them grow from.
    let foot = (0.16 * outline.radius).min(2.5 * r).max(1.2 * r);
    primitives.push(Primitive::ball([0.0, 0.3 * foot, 0.0], foot));
    primitives
}

/// The branches that there are, and their thickness, m.
fn grown(segments: &[Segment], outline: &Outline, b: &Branches<'_>) -> (Vec<Branch>, f32) {
    // The turtle's z is up.
    let scale = (outline.radius * b.full_radius).sqrt();
    let place = |v: Vector| [v[0] as f32, v[2] as f32, v[1] as f32].map(|c| c * scale);
    let ends: Vec<[[f32; 3]; 2]> = segments.iter().map(|s| [place(s.from), place(s.to)]).collect();
    let free: Vec<Option<f32>> = ends.iter().map(|&e| inside(e, outline, b, 0.0)).collect();
    let with = |generations: f32| {
        let all = clip(segments, &ends, generations, |i| free[i]);
        // Once more with the room that the branches' own thickness takes.
        let margin = thickness(&all, b.volume, outline.radius);
        let all = clip(segments, &ends, generations, |i| inside(ends[i], outline, b, margin));
        let r = thickness(&all, b.volume, outline.radius);
        (all, r)
    };
    let deepest = segments.iter().map(|s| s.depth).max().unwrap_or(0) as f32;
    let whole = with(deepest);
    if whole.1 >= b.thinnest {
        return whole;
    }
    let (mut low, mut high) = (0.0, deepest);
    for _ in 0..10 {
        let middle = 0.5 * (low + high);
        if with(middle).1 >= b.thinnest { low = middle } else { high = middle }
    }
    with(low)
}

fn thickness(branches: &[Branch], volume: f32, radius: f32) -> f32 {
    let square = |b: &Branch| {
        let [from, to] = b.ends;
        let length = (0..3).map(|i| (to[i] - from[i]) * (to[i] - from[i])).sum::<f32>().sqrt();
        length * 0.5 * (b.widths[0] * b.widths[0] + b.widths[1] * b.widths[1])
    };
    let sum: f32 = branches.iter().map(square).sum();
    if sum > 0.0 { (volume / (0.8 * std::f32::consts::PI * sum)).sqrt().min(0.4 * radius) } else { 0.3 * radius }
}

/// The part of a segment before it leaves the growth volume, which ends `margin` before the colony does; `None` if it begins
/// outside.
fn inside(ends: [[f32; 3]; 2], outline: &Outline, b: &Branches<'_>, margin: f32) -> Option<f32> {
    let room = ((outline.radius - margin) / outline.radius).max(0.3);
    let height = (b.height * outline.radius - margin).max(0.3 * b.height * outline.radius);
    let depth = |p: [f32; 3]| {
        let (q, y) = (outline.gauge(p[0], p[2]).0 / room, p[1] / height);
        q * q + y * y
    };
    // Branches neither leave the dome nor run into the floor.
    let is_inside = |t: f32| {
        let p = between(ends, t);
        depth(p) < 1.0 && p[1] >= 0.0
    };
    let begins = depth(ends[0]) < 1.0 && ends[0][1] >= -1e-6;
    begins.then(|| if is_inside(1.0) { 1.0 } else { last_inside(is_inside) })
}

fn between([from, to]: [[f32; 3]; 2], t: f32) -> [f32; 3] {
    std::array::from_fn(|i| from[i] + t * (to[i] - from[i]))
}

/// The parts of segments of so many generations beyond the first within the growth volume, in which each has a part `inside`.
fn clip(
    segments: &[Segment],
    ends: &[[[f32; 3]; 2]],
    generations: f32,
    inside: impl Fn(usize) -> Option<f32>,
) -> Vec<Branch> {
    let first = segments.iter().map(|s| s.depth).min().unwrap_or(0);
    let mut whole = vec![false; segments.len()];
    let mut branches = Vec::new();
    let mut has_children = vec![false; segments.len()];
    for (i, (s, &ends)) in segments.iter().zip(ends).enumerate() {
        if s.parent.is_some_and(|p| !whole[p as usize]) {
            continue;
        }
        let part = (generations + 1.0 - (s.depth - first) as f32).clamp(0.0, 1.0);
        if part < 0.02 {
            continue;
        }
        let Some(inside) = inside(i) else { continue };
        if let Some(p) = s.parent {
            has_children[p as usize] = true;
        }
        let t = inside.min(part);
        whole[i] = t >= 1.0;
        let [w0, w1] = s.widths.map(|w| w as f32);
        branches
            .push((i, Branch { ends: [ends[0], between(ends, t)], widths: [w0, w0 + t * (w1 - w0)], is_tip: true }));
    }
    branches.into_iter().map(|(i, b)| Branch { is_tip: !has_children[i], ..b }).collect()
}

/// The end of the inside between 0, which is inside, and 1, which is not.
fn last_inside(is_inside: impl Fn(f32) -> bool) -> f32 {
    let (mut inside, mut outside) = (0.0, 1.0);
    for _ in 0..16 {
        let middle = 0.5 * (inside + outside);
        if is_inside(middle) { inside = middle } else { outside = middle }
    }
    inside
}
