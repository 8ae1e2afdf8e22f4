//! A z-buffer: which triangle is nearest in each pixel.

use crate::math::V3;
use rayon::prelude::*;

/// Rows that one task fills.
const BAND: usize = 16;
/// No triangle.
pub(crate) const NONE: u32 = u32::MAX;

/// A pixel: the nearest triangle, one over its distance, and the shares of its corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) triangle: u32,
    /// Larger is nearer.
    pub(crate) nearness: f32,
    pub(crate) shares: V3,
}

impl Hit {
    const NOTHING: Self = Self { triangle: NONE, nearness: 0.0, shares: [0.0; 3] };
}

/// The nearest triangle of every pixel. `vertices` are column, row and nearness; vertices whose nearness is not above 0 are behind the
/// camera, and triangles with one of them are left out. Between vertices nearness is linear, as it is on a picture's plane.
pub(crate) fn rasterise(vertices: &[V3], indices: &[u32], size: [usize; 2]) -> Vec<Hit> {
    let [w, h] = size;
    let mut hits = vec![Hit::NOTHING; w * h];
    if w == 0 || h == 0 {
        return hits;
    }
    let bands = h.div_ceil(BAND);
    let mut lists: Vec<Vec<u32>> = vec![Vec::new(); bands];
    for (t, corners) in indices.chunks_exact(3).enumerate() {
        let rows = [0, 1, 2].map(|i| vertices[corners[i] as usize]);
        if rows.iter().any(|v| v[2].is_nan() || v[2] <= 0.0) {
            continue;
        }
        let (top, bottom) =
            (rows.iter().map(|v| v[1]).fold(f32::MAX, f32::min), rows.iter().map(|v| v[1]).fold(f32::MIN, f32::max));
        if bottom < 0.0 || top >= h as f32 {
            continue;
        }
        let band = |y: f32| (y.max(0.0) as usize / BAND).min(bands - 1);
        lists[band(top)..=band(bottom)].iter_mut().for_each(|list| list.push(t as u32));
    }
    hits.par_chunks_mut(BAND * w).zip(lists).enumerate().for_each(|(band, (pixels, list))| {
        for t in list {
            let corners = [0, 1, 2].map(|i| vertices[indices[3 * t as usize + i] as usize]);
            fill(pixels, w, band * BAND, corners, t);
        }
    });
    hits
}

fn fill(pixels: &mut [Hit], width: usize, first_row: usize, [a, b, c]: [V3; 3], triangle: u32) {
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if area == 0.0 {
        return;
    }
    let rows = pixels.len() / width;
    let low = |i: usize| a[i].min(b[i]).min(c[i]);
    let high = |i: usize| a[i].max(b[i]).max(c[i]);
    let y0 = (low(1) - 0.5 - first_row as f32).ceil().max(0.0) as usize;
    let y1 = (high(1) + 0.5 - first_row as f32).floor().min(rows as f32);
    let (x0, x1) = ((low(0) - 0.5).ceil().max(0.0) as usize, (high(0) + 0.5).floor().min(width as f32));
    if x1 <= 0.0 || y1 <= 0.0 {
        return;
    }
    for y in y0..y1 as usize {
        let py = (y + first_row) as f32 + 0.5;
        for x in x0..x1 as usize {
            let px = x as f32 + 0.5;
            let share = |p: V3, q: V3| ((q[0] - p[0]) * (py - p[1]) - (q[1] - p[1]) * (px - p[0])) / area;
            let shares = [share(b, c), share(c, a), share(a, b)];
            if shares.iter().any(|s| *s < 0.0) {
                continue;
            }
            let nearness = shares[0] * a[2] + shares[1] * b[2] + shares[2] * c[2];
            let pixel = &mut pixels[y * width + x];
            if nearness > pixel.nearness {
                *pixel = Hit { triangle, nearness, shares };
            }
        }
    }
}
