//! D8 routing: every cell hands its water to one of its eight neighbours.
//!
//! # Rule
//! On a surface without depressions, water takes the steepest way down: the neighbour with the largest
//! `(z - z_n) / distance`; of several equally steep ones the first clockwise from north. Cells of a flat hand their
//! water to the neighbour from which a breadth-first search, started at the flat's lower edge, reached them first, so
//! every flat drains by a shortest way.
//!
//! # Source
//! O'Callaghan & Mark (1984), The extraction of drainage networks from digital elevation data, CVGIP 28, 323-344.
//! Flats: the gradient towards lower terrain of Barnes, Lehman & Mulla (2014), An efficient assignment of drainage
//! direction over flat surfaces, Computers & Geosciences 62, 128-135.
//!
//! # Differences
//! The gradient away from higher terrain of the second paper is left out: it makes rivers on wide filled flats join
//! earlier, which no measure here can tell.

use crate::drainage::Neighbours;
use eyot_core::{Field, Grid};
use std::collections::VecDeque;

/// Marks a cell that keeps its water.
const ROOT: u8 = 8;
const UNKNOWN: u8 = 9;

/// A drainage network: one receiver a cell, no loops.
#[derive(Clone, Debug)]
pub struct FlowD8 {
    /// The cell that receives a cell's water; outlets (and sinks, if the surface had any) receive their own.
    pub receiver: Vec<u32>,
    /// Distance to the receiver, m; 0 for cells that keep their water.
    pub distance_m: Vec<f32>,
    /// All cells, each before its receiver.
    pub downstream_order: Vec<u32>,
}

impl FlowD8 {
    /// Routes water over `surface`, which has no depressions (see [`priority_flood`](super::priority_flood()) and leaves
    /// at `outlets`. A cell that has neither a lower neighbour nor a flat way to one keeps its water.
    ///
    /// # Panics
    /// If `surface` or `outlets` has another size than `grid`, or the grid has 2^32 cells or more.
    pub fn new(surface: &Field, grid: &Grid, outlets: &[bool]) -> Self {
        let z = surface.to_vec();
        assert_eq!((z.len(), outlets.len()), (grid.cells(), grid.cells()), "surface, outlets and grid differ in size");
        assert!(u32::try_from(z.len()).is_ok(), "cells are numbered with 32 bits");
        let around = Neighbours::new(grid);
        let mut direction = steepest(&z, &around, outlets);
        drain_flats(&z, &around, &mut direction);

        let mut receiver: Vec<u32> = (0..z.len() as u32).collect();
        let mut distance_m = vec![0.0; z.len()];
        for (i, &d) in direction.iter().enumerate().filter(|&(_, &d)| d < ROOT) {
            if let Some(j) = around.at(i, usize::from(d)) {
                receiver[i] = j as u32;
                distance_m[i] = around.distance_m[usize::from(d)] as f32;
            }
        }
        let downstream_order = sort_downstream(&receiver);
        Self { receiver, distance_m, downstream_order }
    }

    /// True if cell `i` keeps its water.
    pub fn is_root(&self, i: usize) -> bool {
        self.receiver[i] as usize == i
    }

    /// For each cell the number of cells that drain through it, itself included. Over all roots they add up to the
    /// number of cells exactly.
    pub fn accumulation(&self) -> Vec<u32> {
        let mut cells = vec![1; self.receiver.len()];
        for &i in &self.downstream_order {
            let (i, r) = (i as usize, self.receiver[i as usize] as usize);
            if r != i {
                cells[r] += cells[i];
            }
        }
        cells
    }

    /// For each cell the length of the longest way that water takes to it, m.
    pub fn longest_upstream_m(&self) -> Vec<f64> {
        let mut length = vec![0.0_f64; self.receiver.len()];
        for &i in &self.downstream_order {
            let (i, r) = (i as usize, self.receiver[i as usize] as usize);
            if r != i {
                length[r] = length[r].max(length[i] + f64::from(self.distance_m[i]));
            }
        }
        length
    }
}

/// The steepest way down from each cell, [`ROOT`] for outlets, [`UNKNOWN`] where nothing is lower.
fn steepest(z: &[f32], around: &Neighbours, outlets: &[bool]) -> Vec<u8> {
    (0..z.len())
        .map(|i| {
            if outlets[i] {
                return ROOT;
            }
            let (mut best, mut direction) = (0.0, UNKNOWN);
            around.each(i, |d, j| {
                let slope = (f64::from(z[i]) - f64::from(z[j])) / around.distance_m[d];
                if slope > best {
                    (best, direction) = (slope, d as u8);
                }
            });
            direction
        })
        .collect()
}

/// Gives each cell of a flat the direction along which the flat's lower edge is reached in the fewest steps.
fn drain_flats(z: &[f32], around: &Neighbours, direction: &mut [u8]) {
    let mut queue = VecDeque::new();
    for i in (0..z.len()).filter(|&i| direction[i] != UNKNOWN) {
        let mut edge = false;
        around.each(i, |_, j| edge |= direction[j] == UNKNOWN && z[j] == z[i]);
        if edge {
            queue.push_back(i);
        }
    }
    while let Some(i) = queue.pop_front() {
        around.each(i, |d, j| {
            if direction[j] == UNKNOWN && z[j] == z[i] {
                direction[j] = (d as u8 + 4) % 8;
                queue.push_back(j);
            }
        });
    }
}

/// Cells such that each stands before its receiver (Kahn 1962), sources in the order of their numbers.
fn sort_downstream(receiver: &[u32]) -> Vec<u32> {
    let mut donors = vec![0_u8; receiver.len()];
    for (i, &r) in receiver.iter().enumerate() {
        donors[r as usize] += u8::from(r as usize != i);
    }
    let mut order = Vec::with_capacity(receiver.len());
    for start in 0..receiver.len() {
        if donors[start] > 0 {
            continue;
        }
        // Walk down until a confluence still waits for another donor. Visited cells get a count that no cell reaches.
        let mut i = start;
        loop {
            order.push(i as u32);
            let r = receiver[i] as usize;
            if r == i {
                break;
            }
            donors[r] -= 1;
            // A later start is a source from the beginning: cells that reach 0 here lie behind or are walked now.
            if donors[r] > 0 {
                break;
            }
            donors[r] = u8::MAX;
            i = r;
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::super::outlets::outlets;
    use super::super::priority_flood::priority_flood;
    use super::*;
    use eyot_core::{Edge, Limits, Rim};
    use proptest::prelude::*;

    fn route(z: &Field, grid: &Grid) -> FlowD8 {
        let out = outlets(z, grid, None);
        FlowD8::new(&priority_flood(z, grid, &out), grid, &out)
    }

    #[test]
    fn a_plane_drains_down_its_slope() {
        let grid = Grid::new(6, 5, 10.0, Rim::CLOSED, &Limits::default()).unwrap();
        let flow = route(&Field::from_fn(6, 5, |x, _| x as f32), &grid);
        let cells = flow.accumulation();
        // The west cell of each inner row collects its own row but the eastern border cell, which is an outlet.
        assert_eq!([cells[0], cells[6], cells[12], cells[18], cells[24]], [1, 5, 5, 5, 1]);
        assert_eq!(flow.longest_upstream_m()[6], 40.0);
    }

    #[test]
    fn narrow_cells_make_diagonals_less_steep() {
        // 3 down over hypot(1, 4) is flatter than 1 down over 1.
        let grid =
            Grid { cell_x_m: 1.0, cell_y_m: 4.0, ..Grid::new(3, 3, 1.0, Rim::CLOSED, &Limits::default()).unwrap() };
        let z = Field::from_slice(3, 3, &[9.0, 9.0, 2.0, 9.0, 5.0, 4.0, 9.0, 9.0, 9.0]).unwrap();
        assert_eq!(route(&z, &grid).receiver[4], 5);
        assert_eq!(route(&z, &Grid { cell_y_m: 1.0, ..grid }).receiver[4], 2);
    }

    #[test]
    fn a_flat_is_left_by_a_shortest_way() {
        let grid = Grid::new(9, 9, 1.0, Rim::CLOSED, &Limits::default()).unwrap();
        // A plateau within a wall that has one gap at (8, 4).
        let wall = |x, y| (x == 0 || y == 0 || x == 8 || y == 8) && (x, y) != (8, 4);
        let flow = route(&Field::from_fn(9, 9, |x, y| if wall(x, y) { 9.0 } else { 1.0 }), &grid);
        assert_eq!(flow.accumulation()[4 * 9 + 8], 7 * 7 + 1);
        let mut steps = 0;
        let mut i = 4 * 9 + 1;
        while !flow.is_root(i) {
            i = flow.receiver[i] as usize;
            steps += 1;
        }
        assert_eq!((i, steps), (4 * 9 + 8, 7));
    }

    proptest! {
        #[test]
        fn areas_sum_to_the_cells(w in 1_usize..12, h in 1_usize..12, seed in any::<u64>(), rim in 0_usize..3) {
            let mut s = seed | 1;
            let z = Field::from_fn(w, h, |_, _| {
                s ^= s << 13; s ^= s >> 7; s ^= s << 17;
                (s % 5) as f32
            });
            let rim = [Rim::CLOSED, Rim::WRAP, Rim { x: Edge::Wrap, y: Edge::Open }][rim];
            let grid = Grid::new(w, h, 2.0, rim, &Limits::default()).unwrap();
            let flow = route(&z, &grid);
            let cells = flow.accumulation();
            let out = outlets(&z, &grid, None);
            prop_assert_eq!((0..w * h).filter(|&i| flow.is_root(i)).map(|i| cells[i] as usize).sum::<usize>(), w * h);
            prop_assert!((0..w * h).all(|i| flow.is_root(i) == out[i]));
            let mut seen = vec![false; w * h];
            for &i in &flow.downstream_order {
                prop_assert!(flow.is_root(i as usize) || !seen[flow.receiver[i as usize] as usize]);
                seen[i as usize] = true;
            }
            prop_assert!(seen.iter().all(|&s| s));
        }
    }
}
