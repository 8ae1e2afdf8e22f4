//! Shores: the outlines of lakes as polygons with islands as holes.
//!
//! Marching squares between the middles of cells (Lorensen & Cline 1987, in the plane): the shore crosses the way from a cell under
//! water to one above it where the ground, linear between them, has the level of the lake. Cells that touch by a corner are joined,
//! as water joins them. At the rim, and where an axis is a ring at its seam, the outline follows the cells' outer sides.

use crate::lakes::Lakes;
use eyot_core::Grid;
use eyot_core::component::signed_double_area;
use std::collections::BTreeMap;

/// Of each lake, from 1 on, its rings: outer ones, each followed by its holes. Row 0 is empty. `z`: the ground, m.
pub fn shores(lakes: &Lakes, z: &[f32], grid: &Grid) -> Vec<Vec<Vec<[f32; 3]>>> {
    let (w, h) = (grid.width as isize, grid.height as isize);
    let id = |x: isize, y: isize| {
        if (0..w).contains(&x) && (0..h).contains(&y) { lakes.lake[(y * w + x) as usize] } else { 0 }
    };
    // Of each lake the crossings that follow each other, by the number of the edge between two middles.
    let mut next: Vec<BTreeMap<u64, u64>> = vec![BTreeMap::new(); lakes.lakes.len()];
    for y in -1..h {
        for x in -1..w {
            let corners = [id(x, y), id(x + 1, y), id(x + 1, y + 1), id(x, y + 1)];
            if corners.iter().all(|c| *c == corners[0]) {
                continue;
            }
            let edges = [edge(x, y, w, 0), edge(x + 1, y, w, 1), edge(x, y + 1, w, 0), edge(x, y, w, 1)];
            let mut done = [0; 4];
            for (k, &lake) in corners.iter().enumerate().filter(|(_, l)| **l > 0) {
                if done[..k].contains(&lake) {
                    continue;
                }
                done[k] = lake;
                // Round the block clockwise as seen on the map: where the water ends a line begins that ends where it begins again.
                // Two that face each other are joined, so that each line goes from the end of one to the begin of the other.
                for side in 0..4 {
                    let (here, after) = (corners[side] == lake, corners[(side + 1) % 4] == lake);
                    if here && !after {
                        let begin = (1..=4)
                            .map(|n| (side + n) % 4)
                            .find(|s| corners[*s] != lake && corners[(*s + 1) % 4] == lake);
                        if let Some(begin) = begin {
                            next[lake as usize].insert(edges[begin], edges[side]);
                        }
                    }
                }
            }
        }
    }
    next.into_iter().enumerate().map(|(lake, next)| rings(lake as u32, next, lakes, z, grid)).collect()
}

/// The number of the edge from the middle of cell (x, y) to the east (0) or to the south (1).
fn edge(x: isize, y: isize, w: isize, axis: u64) -> u64 {
    (((y + 1) * (w + 2) + x + 1) as u64) << 1 | axis
}

fn rings(lake: u32, mut next: BTreeMap<u64, u64>, lakes: &Lakes, z: &[f32], grid: &Grid) -> Vec<Vec<[f32; 3]>> {
    let level = lakes.lakes[lake as usize].level;
    let mut rings: Vec<Vec<[f32; 3]>> = Vec::new();
    while let Some((start, _)) = next.first_key_value() {
        let (start, mut at, mut ring) = (*start, *start, Vec::new());
        while let Some(to) = next.remove(&at) {
            ring.push(crossing(at, lake, lakes, z, grid, level));
            at = to;
        }
        ring.push(crossing(start, lake, lakes, z, grid, level));
        if ring.len() >= 4 {
            rings.push(ring);
        }
    }
    arranged(rings)
}

/// Where the shore crosses an edge.
fn crossing(edge: u64, lake: u32, lakes: &Lakes, z: &[f32], grid: &Grid, level: f32) -> [f32; 3] {
    let (w, h) = (grid.width as isize, grid.height as isize);
    let (number, south) = ((edge >> 1) as isize, edge & 1 == 1);
    let a = [number % (w + 2) - 1, number / (w + 2) - 1];
    let b = if south { [a[0], a[1] + 1] } else { [a[0] + 1, a[1]] };
    let cell = |p: [isize; 2]| ((0..w).contains(&p[0]) && (0..h).contains(&p[1])).then(|| (p[1] * w + p[0]) as usize);
    let wet = |c: Option<usize>| c.is_some_and(|i| lakes.lake[i] == lake);
    let (from, to, inner) = if wet(cell(a)) { (a, b, cell(a)) } else { (b, a, cell(b)) };
    let t = match (inner, cell(to)) {
        (Some(i), Some(o)) if z[o] > z[i] => f64::from(level - z[i]) / f64::from(z[o] - z[i]),
        _ => 0.5,
    };
    // Not onto the middle of a cell, where two shores could meet.
    let t = t.clamp(0.02, 0.98);
    let at = |c: usize, size: f64| ((from[c] as f64 + t * (to[c] - from[c]) as f64 + 0.5) * size) as f32;
    [at(0, grid.cell_x_m), at(1, grid.cell_y_m), level]
}

/// Outer rings, each followed by the holes within it; rings without an area are left out.
fn arranged(rings: Vec<Vec<[f32; 3]>>) -> Vec<Vec<[f32; 3]>> {
    let (mut outer, mut holes) = (Vec::new(), Vec::new());
    for ring in rings {
        match signed_double_area(&ring) {
            area if area > 0.0 => outer.push(vec![ring]),
            area if area < 0.0 => holes.push(ring),
            _ => {}
        }
    }
    for hole in holes {
        let around = outer.iter().position(|o| contains(&o[0], hole[0])).unwrap_or(0);
        if let Some(o) = outer.get_mut(around) {
            o.push(hole);
        }
    }
    outer.into_iter().flatten().collect()
}

/// True if a ring goes round a point, by the crossings of a ray to the east.
fn contains(ring: &[[f32; 3]], p: [f32; 3]) -> bool {
    let crossings = ring.windows(2).filter(|pair| {
        let (a, b) = (pair[0], pair[1]);
        (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    });
    crossings.count() % 2 == 1
}
