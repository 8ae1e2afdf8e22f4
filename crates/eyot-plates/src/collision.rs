//! Continents collide: the crust of the cell that is lost folds into a belt.
//!
//! The lost crust is shared among the continental cells of both plates on the line of their relative motion, up to `fold_width` to
//! either side, more to the near ones and to those with room below `max_crust`. Nothing is lost.
//! Both plates brake each other, momentum conserved, in proportion to the length of the front.

use crate::changes::Changes;
use crate::crust::{LOWLAND_M, is_continental, metres};
use crate::geometry::Geometry;
use crate::plate::Plate;

/// Longest half belt, cells.
const LONGEST: isize = 16;

/// Shares `lost` units of crust among the cells around `cell` along `direction`, `before..=behind` cells away.
pub(crate) fn fold(
    g: &Geometry,
    crust: &[i32],
    cell: usize,
    lost: i32,
    direction: (f64, f64),
    reach: (isize, isize),
    max_crust: f32,
    changes: &mut Changes,
) {
    let (x, y) = g.place(cell);
    let mut left = lost;
    // Where the belt is full, its neighbours take the rest.
    for wider in 1..=2 {
        let (from, to) = ((wider * reach.0).max(-LONGEST), (wider * reach.1).min(LONGEST));
        let span = to.max(-from) + 1;
        let mut belt = [(0usize, 0i64); 2 * LONGEST as usize + 1];
        let (mut n, mut total) = (0, 0);
        for k in from..=to {
            let (dx, dy) = ((direction.0 * k as f64).round() as isize, (direction.1 * k as f64).round() as isize);
            let Some(to) = g.cell(x + dx, y + dy) else { continue };
            if !is_continental(crust[to]) {
                continue;
            }
            let near = (span - k.abs()) as f32 / span as f32;
            let (thick, room) = (metres(crust[to]) / LOWLAND_M, 1.0 - metres(crust[to]) / max_crust);
            let weight = (65_536.0 * near * thick * room.max(0.0)) as i64;
            belt[n] = (to, weight);
            (n, total) = (n + 1, total + weight);
        }
        // Half the belt would be filled to the brim with this much of the weight.
        if total > 4096 || wider == 2 {
            for &(to, weight) in &belt[..n] {
                let share = (i64::from(lost) * weight / total.max(1)) as i32;
                changes.add(to, share);
                left -= share;
            }
            break;
        }
    }
    changes.add(cell, left);
}

/// Cells of half a belt.
pub(crate) fn reach(g: &Geometry, fold_width: f32) -> isize {
    ((f64::from(fold_width) / g.cell_side_m()).round() as isize).clamp(0, LONGEST)
}

/// Two plates brake each other over a front of so many cells.
pub(crate) fn brake(p: &mut Plate, q: &mut Plate, cells: f64, areas: (f64, f64), friction: f64) {
    let (a, b) = areas;
    let share = (friction * cells / (a * b / (a + b)).sqrt()).min(0.5);
    for i in 0..2 {
        let relative = q.velocity[i] - p.velocity[i];
        p.velocity[i] += share * relative * b / (a + b);
        q.velocity[i] -= share * relative * a / (a + b);
    }
}

/// A plate runs into the rim of the grid with so many continental cells: it stops there and turns away.
pub(crate) fn brake_at_rim(p: &mut Plate, out: [f64; 2], cells: f64, area: f64, friction: f64) {
    let share = (friction * cells / area.sqrt()).min(0.5);
    for i in (0..2).filter(|&i| out[i] != 0.0) {
        p.velocity[i] -= share * p.velocity[i];
        if p.heading[i] * out[i] > 0.0 && share > 0.0 {
            p.heading[i] = -p.heading[i];
        }
    }
}
