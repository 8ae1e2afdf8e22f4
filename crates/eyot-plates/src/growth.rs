//! How the world is divided into plates: seeds that grow until they meet.
//!
//! Every plate grows from a seed at a speed of its own, faster through some ground than through other (fractal noise), and all at
//! once, so that each cell goes to the plate that reaches it first (Dijkstra 1959). Plates are connected by construction, of
//! different sizes, and their borders follow no axis. A seed is the one of several random cells that is farthest from those
//! before it, so no two fall together. At last fractal noise bends the borders.

use crate::geometry::Geometry;
use crate::noise::Fractal;
use crate::parts;
use crate::runs;
use eyot_core::BoundaryCondition;
use eyot_core::rng::mix64;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Cells tried for each seed.
const CANDIDATES: u64 = 4;
/// How far borders bend, as a share of the shorter side of the grid.
const FRAY: f32 = 0.08;
/// Times that torn-off parts are looked for.
const ROUNDS: usize = 4;
/// No owner.
pub(crate) const NOBODY: u8 = u8::MAX;

/// A number in [0, 1) for a key.
pub(crate) fn unit(seed: u64, key: u64) -> f64 {
    (mix64(seed ^ mix64(key)) >> 11) as f64 / (1u64 << 53) as f64
}

/// The owner of each cell; plates are numbered in the order of their seeds.
pub(crate) fn grow(g: &Geometry, count: usize, seed: u64) -> Vec<u8> {
    let owner = fronts(g, count, seed);
    fray(g, owner, seed)
}

fn fronts(g: &Geometry, count: usize, seed: u64) -> Vec<u8> {
    let seeds = seeds(g, count, seed);
    let ground = Fractal { scale: 0.3, octaves: 5, gain: 0.7, warp: 0.0 }.field(g, mix64(seed ^ 0x9707));
    let pace: Vec<f32> = (0..seeds.len()).map(|p| 0.6 + 1.1 * unit(seed, 0xace0 + p as u64) as f32).collect();
    let (sx, sy) = g.cell_m;
    let (sx, sy) = ((sx / g.cell_side_m()) as f32, (sy / g.cell_side_m()) as f32);
    let steps = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (1, -1), (-1, 1)]
        .map(|(dx, dy): (isize, isize)| (dx, dy, (dx as f32 * sx).hypot(dy as f32 * sy)));
    let mut owner = vec![NOBODY; g.cells()];
    let mut soonest = vec![f32::INFINITY; g.cells()];
    // Times are positive, so their bits sort as they do.
    let mut front: BinaryHeap<Reverse<(u32, u32, u8)>> =
        seeds.iter().zip(0..).map(|(&cell, p)| Reverse((0, cell as u32, p))).collect();
    while let Some(Reverse((time, cell, p))) = front.pop() {
        let cell = cell as usize;
        if owner[cell] != NOBODY {
            continue;
        }
        owner[cell] = p;
        for &(dx, dy, length) in &steps {
            let Some(next) = g.beside(cell, dx, dy).filter(|&n| owner[n] == NOBODY) else { continue };
            // Hard ground takes fifty times as long as soft ground.
            let hard = (0.5 + 0.5 * ground[next]).clamp(0.0, 1.0);
            let cost = length * (0.12 + 6.0 * hard * hard * hard) / pace[usize::from(p)];
            let there = f32::from_bits(time) + cost;
            if there < soonest[next] {
                soonest[next] = there;
                front.push(Reverse((there.to_bits(), next as u32, p)));
            }
        }
    }
    owner
}

/// Bends borders by fractal noise: rifts are as uneven as the coasts that they leave, and no front of growth is.
fn fray(g: &Geometry, owner: Vec<u8>, seed: u64) -> Vec<u8> {
    let inside = |i: isize, n: usize, edge: BoundaryCondition| {
        if edge == BoundaryCondition::Wrap { i } else { i.clamp(0, n as isize - 1) }
    };
    // Noise this smooth needs no value for each cell.
    let apart = (g.width.min(g.height) / 128).max(1);
    let coarse = Geometry { width: g.width.div_ceil(apart), height: g.height.div_ceil(apart), ..*g };
    let bend = |key: u64| Fractal { scale: 0.3, octaves: 6, gain: 0.5, warp: 0.0 }.field(&coarse, mix64(seed ^ key));
    let (east, south) = (bend(0xf4a1), bend(0xf4a2));
    let most = FRAY * g.width.min(g.height) as f32;
    let scale = (coarse.width as f32 / g.width as f32, coarse.height as f32 / g.height as f32);
    let between = |field: &[f32], x: isize, y: isize| {
        let (x, y) = ((x as f32 + 0.5) * scale.0 - 0.5, (y as f32 + 0.5) * scale.1 - 0.5);
        let (west, north) = (x.floor(), y.floor());
        let at = |dx: isize, dy: isize| {
            let x = inside(west as isize + dx, coarse.width, g.rim.0);
            let y = inside(north as isize + dy, coarse.height, g.rim.1);
            coarse.cell(x, y).map_or(0.0, |c| field[c])
        };
        let (u, v) = (x - west, y - north);
        let along = |dy: isize| at(0, dy) + u * (at(1, dy) - at(0, dy));
        along(0) + v * (along(1) - along(0))
    };
    let from = |cell: usize| {
        let (x, y) = g.place(cell);
        let (dx, dy) =
            ((most * between(&east, x, y)).round() as isize, (most * between(&south, x, y)).round() as isize);
        let to = (inside(x + dx, g.width, g.rim.0), inside(y + dy, g.height, g.rim.1));
        owner[g.cell(to.0, to.1).unwrap_or(cell)]
    };
    let mut frayed: Vec<u8> = (0..owner.len()).map(from).collect();
    // What was torn off goes to those around it, also where they change hands themselves.
    for _ in 0..ROUNDS {
        let rows = runs::of_rows(&frayed, g.width);
        let parts = parts::find(g, &rows);
        let mut largest: [Option<usize>; 256] = [None; 256];
        for (i, part) in parts.iter().enumerate() {
            let l = &mut largest[usize::from(part.owner)];
            *l = l.filter(|&l| parts[l].cells >= part.cells).or(Some(i));
        }
        // On few cells a plate may be gone.
        if owner.iter().any(|&o| largest[usize::from(o)].is_none()) {
            return owner;
        }
        for (_, part) in parts.iter().enumerate().filter(|(i, p)| largest[usize::from(p.owner)] != Some(*i)) {
            if let Some(new) = part.neighbour(g, &rows, &frayed) {
                part.iter(g.width, &rows).for_each(|c| frayed[c] = new);
            }
        }
    }
    frayed
}

/// Distinct cells, spread out; fewer than `count` if the grid has fewer cells.
fn seeds(g: &Geometry, count: usize, seed: u64) -> Vec<usize> {
    let mut seeds: Vec<usize> = Vec::with_capacity(count);
    let place = |cell: usize| ((cell % g.width) as f64, (cell / g.width) as f64);
    for i in 0..count.min(g.cells()) as u64 {
        let candidates = (0..CANDIDATES).map(|c| (unit(seed, i * CANDIDATES + c) * g.cells() as f64) as usize);
        let room = |cell: usize| {
            let distances = seeds.iter().map(|&s| g.way(place(s), place(cell))).map(|(x, y)| x * x + y * y);
            distances.fold(f64::INFINITY, f64::min)
        };
        let best = candidates
            .map(|c| (room(c), c))
            .fold((0.0, None), |(far, best), (room, c)| if room > far { (room, Some(c)) } else { (far, best) });
        // All candidates may be taken on a tiny grid.
        let free = || (0..g.cells()).find(|c| !seeds.contains(c));
        seeds.extend(best.1.or_else(free));
    }
    seeds
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Grid, Limits};

    #[test]
    fn plates_cover_the_grid_and_are_of_different_sizes() {
        for (w, h, n) in [(64, 32, 10), (3, 2, 30), (1, 1, 2), (1, 40, 5)] {
            let g = Geometry::new(&Grid::new(w, h, 1.0, Boundary::WRAP, &Limits::default()).unwrap());
            let owner = grow(&g, n, 7);
            let mut sizes = vec![0; n.min(w * h)];
            owner.iter().for_each(|&o| sizes[usize::from(o)] += 1);
            assert!(sizes.iter().all(|&s| s > 0), "{sizes:?}");
            if w > 3 {
                assert!(sizes.iter().max().unwrap() > &(2 * sizes.iter().min().unwrap()), "{sizes:?}");
            }
        }
    }
}
