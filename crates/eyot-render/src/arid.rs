//! Colours of dry land: bare rock in beds, sand and scree on the flats, sparse scrub.

use crate::albedo::Site;
use crate::math::{V3, mix, scale, smoothstep};
use eyot_noise::picture::{hash, noise};

// Linear albedos of sedimentary rock: red and orange sandstone, buff limestone, brown and grey shale.
const BEDS: [V3; 7] = [
    [0.200, 0.062, 0.027],
    [0.270, 0.098, 0.040],
    [0.335, 0.205, 0.108],
    [0.150, 0.047, 0.024],
    [0.140, 0.075, 0.042],
    [0.290, 0.132, 0.058],
    [0.165, 0.112, 0.080],
];
const SAND: V3 = [0.275, 0.142, 0.068];
const SCRUB: V3 = [0.082, 0.088, 0.040];
/// Thickness of a bed as a share of the relief.
const BED: f32 = 1.0 / 15.0;

/// Colour of one cell. `up` is its height and `relief` the height of the land, `steep` its slope in units of the slope where
/// rock begins to show.
pub(crate) fn arid(s: &Site, up: f32, relief: f32, steep: f32) -> V3 {
    // Beds lie nearly level, so that all walls show them at the same height; the deep ones are at a fixed depth below zero.
    let beds = (s.z - s.zero + 0.010 * relief * (s.broad + 0.4 * s.fine)) / (BED * relief);
    let rock = mix(bed(beds), bed(4.3 * beds + 0.37), 0.38);
    // What lies on a bench has fallen from the beds above it.
    let soil = mix(SAND, rock, 0.32);
    let bare = smoothstep(0.38, 0.80, steep + 0.35 * s.fine + 0.15 * s.bump.max(0.0));
    let mut c = mix(soil, scale(rock, 1.0 - 0.22 * smoothstep(0.0, 0.5, s.fine)), bare);
    // More rain falls on high plateaus; on every flat scrub stands in patches.
    let scrub = 0.75 * s.fine + 0.55 * s.broad + 0.25 * up - 0.14;
    c = mix(c, SCRUB, 0.72 * smoothstep(-0.05, 0.35, scrub) * smoothstep(0.60, 0.25, steep));
    scale(c, 1.0 + 0.10 * s.fine + 0.08 * s.broad)
}

/// The colour at a height in beds, with a short passage from one bed to the next.
fn bed(height: f32) -> V3 {
    let i = height.floor();
    let pick = |i: f32| {
        let c = BEDS[hash(i as i32, 11, 23) as usize % BEDS.len()];
        scale(c, 1.0 + 0.16 * noise(0.37 * i, 5.2, 31))
    };
    mix(pick(i), pick(i + 1.0), smoothstep(0.82, 1.0, height - i))
}
