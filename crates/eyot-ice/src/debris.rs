//! Debris that rides on the ice to where it ends.
//!
//! Ice moves much faster than it erodes, so that in a round all debris arrives: it goes down the surface of the ice, by the fall to each
//! lower neighbour, and drops where there is no ice.

use crate::padded::Padded;
use eyot_core::{BoundaryCondition, Grid};
use rayon::prelude::*;

/// Thinner ice carries nothing, m.
const CARRIES_M: f32 = 1.0;

/// What arrives in cells without ice, m. `debris`: what the bed gave, m.
pub fn arrive(grid: &Grid, ice: &Padded, surface: &Padded, debris: Vec<f32>) -> Vec<f32> {
    let (w, h) = (grid.width, grid.height);
    let cell = |i: u32| (i as usize % w, i as usize / w);
    let height = |i: u32| {
        let (x, y) = cell(i);
        surface.at(x, y)
    };
    let mut order: Vec<u32> = (0..grid.cells() as u32)
        .into_par_iter()
        .filter(|&i| {
            let (x, y) = cell(i);
            ice.at(x, y) >= CARRIES_M
        })
        .collect();
    order.par_sort_unstable_by(|&a, &b| height(b).total_cmp(&height(a)).then(a.cmp(&b)));
    let (dx, dy) = (grid.cell_x_m, grid.cell_y_m);
    let across = (dx * dx + dy * dy).sqrt();
    let ring = |edge: BoundaryCondition| edge == BoundaryCondition::Wrap;
    let (ring_x, ring_y) = (ring(grid.rim.x), ring(grid.rim.y));
    let mut load: Vec<f64> = debris.into_iter().map(f64::from).collect();
    for i in order {
        let here = load[i as usize];
        if here <= 0.0 {
            continue;
        }
        let (x, y) = cell(i);
        let z = surface.at(x, y);
        let mut falls = [(0usize, 0.0f64); 8];
        let (mut count, mut total) = (0, 0.0);
        for (n, &(ox, oy)) in AROUND.iter().enumerate() {
            let (nx, ny) = (x as isize + ox, y as isize + oy);
            let outside = |at: isize, cells: usize| at < 0 || at >= cells as isize;
            if (outside(nx, w) && !ring_x) || (outside(ny, h) && !ring_y) {
                continue;
            }
            let (nx, ny) = (grid.wrap_x(nx), grid.wrap_y(ny));
            let far = if n >= 4 {
                across
            } else if oy == 0 {
                dx
            } else {
                dy
            };
            let fall = f64::from(z - surface.at(nx, ny)) / far;
            if fall > 0.0 {
                falls[count] = (ny * w + nx, fall);
                (count, total) = (count + 1, total + fall);
            }
        }
        // In a hollow of the ice it stays.
        if count > 0 {
            load[i as usize] = 0.0;
            falls[..count].iter().for_each(|&(to, fall)| load[to] += here * (fall / total));
        }
    }
    load.into_iter().map(|v| v as f32).collect()
}

const AROUND: [(isize, isize); 8] = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (1, -1), (-1, 1)];
