//! How large a body is: what its thickness is chosen by, and what it is compared with.

use crate::community::{DIRECTIONS, RAYS};
use eyot_mesh::{Blobs, Kernel, Point, ScalarField, Solid, Within};

/// Pixels across a shadow.
const PIXELS: usize = 192;
/// Values that are told apart when the volume is counted.
const BINS: usize = 1024;
/// Points along a side of what is sampled at once.
const BLOCK: usize = 16;

/// Area that a body covers as seen from above, m2.
pub(super) fn shadow(solid: &Solid) -> f32 {
    let Some(&first) = solid.positions.first() else { return 0.0 };
    let (mut low, mut high) = ([first[0], first[2]], [first[0], first[2]]);
    for p in &solid.positions {
        (low, high) = ([low[0].min(p[0]), low[1].min(p[2])], [high[0].max(p[0]), high[1].max(p[2])]);
    }
    let pixel = (high[0] - low[0]).max(high[1] - low[1]) / PIXELS as f32;
    let mut covered = vec![false; PIXELS * PIXELS];
    for corners in solid.corners() {
        let [a, b, c] = corners.map(|p| [(p[0] - low[0]) / pixel, (p[2] - low[1]) / pixel]);
        let cross =
            |p: [f32; 2], q: [f32; 2], r: [f32; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        // What is seen from above is enough. y up and z south make it turn that way.
        if cross(a, b, c) >= 0.0 {
            continue;
        }
        let range = |i: usize| {
            let (lowest, highest) = (a[i].min(b[i]).min(c[i]), a[i].max(b[i]).max(c[i]));
            (lowest - 0.5).ceil().max(0.0) as usize..=((highest - 0.5).floor().max(-1.0) + 1.0) as usize
        };
        for y in range(1).take_while(|&y| y < PIXELS) {
            for x in range(0).take_while(|&x| x < PIXELS) {
                let p = [x as f32 + 0.5, y as f32 + 0.5];
                covered[y * PIXELS + x] |= cross(a, b, p) <= 0.0 && cross(b, c, p) <= 0.0 && cross(c, a, p) <= 0.0;
            }
        }
    }
    covered.iter().filter(|&&c| c).count() as f32 * pixel * pixel
}

/// Area within the farthest points of the body in each of 24 directions, m2: the outline of what has gaps.
pub(super) fn hull(solid: &Solid) -> f32 {
    let mut reach = [0.0f32; RAYS];
    // Half a sector on, so that sectors lie around the rays.
    let ([c, s], half) = (DIRECTIONS[1], 0.991_444_9);
    let turn = [half, s / (2.0 * half)];
    debug_assert!((c - (2.0 * half * half - 1.0)).abs() < 1e-5);
    for p in &solid.positions {
        let (x, z) = (p[0] * turn[0] - p[2] * turn[1], p[0] * turn[1] + p[2] * turn[0]);
        let ray = &mut reach[crate::community::sector_of(x, z)];
        *ray = ray.max(p[0] * p[0] + p[2] * p[2]);
    }
    let reach = reach.map(f32::sqrt);
    (0..RAYS).map(|k| 0.5 * s * reach[k] * reach[(k + 1) % RAYS]).sum()
}

/// The isosurface of a body that holds this volume above the ground, m3, sampled every `spacing` m.
pub(super) fn iso_of_volume(blobs: &Blobs, kernel: Kernel, volume: f32, spacing: f32, thickness: f32) -> f32 {
    // As far as it may differ from 1/2: half to one and a half times the thickness.
    let (mut low, mut high) = (kernel.value(1.5 * kernel.radius_of(0.5)), kernel.value(0.55 * kernel.radius_of(0.5)));
    // How many samples there are of each value, to a thousandth: each step of the search asks for all of them.
    let mut counts = [0u32; BINS + 1];
    for v in samples(blobs, spacing) {
        counts[(v.min(1.0) * BINS as f32 + 0.5) as usize] += 1;
    }
    // Values change so much from one sample to the next; a share of those nearer to the surface counts.
    let width = 0.8 * spacing / thickness;
    let volume_within = |iso: f32| {
        let share = |(k, n): (usize, &u32)| *n as f32 * ((k as f32 / BINS as f32 - iso) / width + 0.5).clamp(0.0, 1.0);
        counts.iter().enumerate().map(share).sum::<f32>() * spacing * spacing * spacing
    };
    for _ in 0..14 {
        let middle = 0.5 * (low + high);
        if volume_within(middle) > volume { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Values above the ground, those that do not matter left out.
fn samples(blobs: &Blobs, spacing: f32) -> Vec<f32> {
    let Some([low, high]) = blobs.bounds() else { return Vec::new() };
    let count =
        |i: usize| (((high[i] - low[i].max(if i == 1 { 0.0 } else { low[i] })) / spacing).ceil() as usize).max(1);
    let start: Point = [low[0] + 0.5 * spacing, 0.5 * spacing, low[2] + 0.5 * spacing];
    let counts = [0, 1, 2].map(count);
    let mut values = Vec::new();
    let mut block = vec![0.0; BLOCK * BLOCK * BLOCK];
    let at = |i: usize, n: usize| start[i] + n as f32 * spacing;
    for z0 in (0..counts[2]).step_by(BLOCK) {
        for y0 in (0..counts[1]).step_by(BLOCK) {
            for x0 in (0..counts[0]).step_by(BLOCK) {
                let [x1, y1, z1] = [x0, y0, z0].map(|n| n + BLOCK - 1);
                let Within::Part(part) =
                    blobs.within([at(0, x0), at(1, y0), at(2, z0)], [at(0, x1), at(1, y1), at(2, z1)])
                else {
                    continue;
                };
                let line = |i: usize, first: usize| -> [f32; BLOCK] { std::array::from_fn(|n| at(i, first + n)) };
                part.fill([&line(0, x0), &line(1, y0), &line(2, z0)], &mut block);
                // The field is the value minus 1/2.
                values.extend(block.iter().map(|v| v + 0.5).filter(|&v| v > 0.02));
            }
        }
    }
    values
}
