//! Priority flood: raises the floor of every closed depression to its lowest spill.
//!
//! # Source
//! Barnes, Lehman & Mulla (2014), Priority-Flood: an optimal depression-filling and watershed-labeling algorithm for
//! digital elevation models, Computers & Geosciences 62, 117-127, Algorithm 2 (with a plain queue for pits).
//!
//! # Result
//! `filled(c) = min over paths c -> outlet of max height on the path`, which is unique: it does not depend on the order
//! in which equal heights are visited, and every filled value is one of the input values, so nothing is rounded.

use crate::drainage::Neighbours;
use eyot_core::{Field, Grid};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// The height with all depressions filled that cannot drain to one of `outlets` (one flag a cell, row by row; see
/// [`outlets`](super::outlets())). Neighbours are the eight around a cell.
///
/// Cells from which no outlet can be reached keep their height; that happens only if `outlets` has none.
///
/// # Panics
/// If `height` or `outlets` has another size than `grid`.
pub fn priority_flood(height: &Field, grid: &Grid, outlets: &[bool]) -> Field {
    let mut z = height.to_vec();
    assert_eq!((z.len(), outlets.len()), (grid.cells(), grid.cells()), "height, outlets and grid differ in size");
    let around = Neighbours::new(grid);
    let mut closed = outlets.to_vec();
    let mut open = BinaryHeap::new();
    let mut pits = VecDeque::new();
    for i in (0..z.len()).filter(|&i| outlets[i]) {
        // Open water far from the shore needs no visit.
        let mut shore = false;
        around.each(i, |_, j| shore |= !outlets[j]);
        if shore {
            open.push(Reverse(key(z[i], i)));
        }
    }
    loop {
        let i = match pits.pop_front() {
            Some(i) => i,
            None => match open.pop() {
                Some(Reverse(k)) => (k & u64::from(u32::MAX)) as usize,
                None => break,
            },
        };
        let level = z[i];
        around.each(i, |_, j| {
            if !closed[j] {
                closed[j] = true;
                if z[j] <= level {
                    z[j] = level;
                    pits.push_back(j);
                } else {
                    open.push(Reverse(key(z[j], j)));
                }
            }
        });
    }
    Field::from_slice(grid.width, grid.height, &z).expect("the size was checked above")
}

/// Height and cell in one integer that sorts by height, then by cell.
fn key(z: f32, i: usize) -> u64 {
    // Adding zero turns -0 into 0. The bits of positive floats sort like integers, those of negative ones backwards.
    let bits = (z + 0.0).to_bits();
    let sortable = if bits >> 31 == 0 { bits | 1 << 31 } else { !bits };
    u64::from(sortable) << 32 | i as u64
}

#[cfg(test)]
mod tests {
    use super::super::outlets::outlets;
    use super::*;
    use eyot_core::{Edge, Limits, Rim};
    use proptest::prelude::*;

    fn fill(z: &Field, rim: Rim, sea: Option<f64>) -> Field {
        let grid = Grid::new(z.width(), z.height(), 1.0, rim, &Limits::default()).unwrap();
        priority_flood(z, &grid, &outlets(z, &grid, sea))
    }

    #[test]
    fn keys_sort_like_heights() {
        let z = [-1e30, -7.5, -1e-30, 0.0, 1e-30, 2.0, 3e30];
        assert!(z.windows(2).all(|p| key(p[0], 9) < key(p[1], 0)));
        assert_eq!(key(-0.0, 3), key(0.0, 3));
    }

    #[test]
    fn a_bowl_fills_to_its_rim() {
        // z = r^2 within r < 20 and a plain at 400 with a notch at 256 leading out: everything below 256 fills to 256.
        let z = Field::from_fn(61, 61, |x, y| {
            let (dx, dy) = (x as f32 - 30.0, y as f32 - 30.0);
            let bowl = (dx * dx + dy * dy).min(400.0);
            if y == 30 && x >= 46 { bowl.min(256.0) } else { bowl }
        });
        let filled = fill(&z, Rim::CLOSED, None);
        for (a, b) in z.iter().zip(filled.iter()) {
            assert_eq!(b, a.max(256.0));
        }
    }

    #[test]
    fn the_sea_is_an_outlet_and_a_ring_has_no_border() {
        // A ramp with a hole. On the torus the hole is the only outlet, and the way to it leads over 13.
        let z = Field::from_fn(8, 8, |x, y| if (x, y) == (4, 4) { -5.0 } else { 10.0 + x as f32 });
        let walled_in = Field::from_fn(8, 8, |x, y| if (x, y) == (4, 4) { -5.0 } else { z.get(x, y).max(13.0) });
        assert_eq!(fill(&z, Rim::WRAP, None), walled_in);
        assert_eq!(fill(&z, Rim::CLOSED, Some(0.0)), z);
        // The hole at (4, 4) lies among 13, 14 and 15; it spills west.
        assert_eq!(fill(&z, Rim::CLOSED, None).get(4, 4), 13.0);
        assert_eq!(fill(&z, Rim { x: Edge::Wrap, y: Edge::Open }, None).get(4, 4), 13.0);
    }

    proptest! {
        /// The two properties that define the result: no cell falls, and none but outlets is lower than all around it.
        #[test]
        fn fills_are_pitless_and_minimal(w in 1_usize..9, h in 1_usize..9, seed in any::<u64>(), rim in 0_usize..4) {
            let mut s = seed | 1;
            let z = Field::from_fn(w, h, |_, _| {
                s ^= s << 13; s ^= s >> 7; s ^= s << 17;
                (s % 7) as f32 - 3.0
            });
            let rim = [Rim::CLOSED, Rim::WRAP, Rim { x: Edge::Wrap, y: Edge::Open }, Rim { x: Edge::Open, y: Edge::Wrap }][rim];
            let grid = Grid::new(w, h, 1.0, rim, &Limits::default()).unwrap();
            let out = outlets(&z, &grid, None);
            let filled = priority_flood(&z, &grid, &out).to_vec();
            // The same minimax by relaxation until nothing changes (Planchon & Darboux 2001).
            let around = Neighbours::new(&grid);
            let z = z.to_vec();
            let mut slow: Vec<f32> = (0..z.len()).map(|i| if out[i] { z[i] } else { f32::INFINITY }).collect();
            loop {
                let before = slow.clone();
                for i in 0..slow.len() {
                    around.each(i, |_, j| slow[i] = slow[i].min(slow[j].max(z[i])));
                }
                if slow == before { break; }
            }
            prop_assert_eq!(filled, slow);
        }
    }
}
