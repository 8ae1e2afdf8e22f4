//! Filling: raises the floor of every closed depression to its lowest spill.
//!
//! # Source
//! Barnes, Lehman & Mulla (2014), Priority-Flood: an optimal depression-filling and watershed-labeling algorithm for
//! digital elevation models, Computers & Geosciences 62, 117-127, Algorithm 2 (with a plain queue for pits).
//!
//! # Result
//! `filled(c) = min over paths c -> outlet of max height on the path`, which is unique: it does not depend on the order
//! in which equal heights are visited, and every filled value is one of the input values, so nothing is rounded.

use super::{Height, Neighbours, check_sizes};
use eyot_core::{Control, Grid, Result};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// Fills all depressions of `height` that cannot drain to one of `outlets` (one flag a cell, at least one set).
///
/// # Errors
/// If `height` or `outlets` has another size than `grid`, the grid has 2^32 cells or more, or on a request to stop;
/// `height` is then as it was.
pub fn fill<T: Height>(height: &mut [T], grid: &Grid, outlets: &[bool], control: &Control<'_>) -> Result<()> {
    check_sizes(grid, &[("height", height.len()), ("outlets", outlets.len())])?;
    control.check()?;
    let around = Neighbours::new(grid);
    let mut closed = outlets.to_vec();
    let mut open = BinaryHeap::new();
    let mut pits = VecDeque::new();
    for i in (0..height.len()).filter(|&i| outlets[i]) {
        // Open water far from the shore needs no visit.
        let mut shore = false;
        around.each(i, |_, j| shore |= !outlets[j]);
        if shore {
            open.push(Reverse((height[i].key(), i as u32)));
        }
    }
    while let Some(i) = pits.pop_front().or_else(|| open.pop().map(|Reverse((_, i))| i as usize)) {
        let level = height[i];
        around.each(i, |_, j| {
            if !closed[j] {
                closed[j] = true;
                if height[j] <= level {
                    height[j] = level;
                    pits.push_back(j);
                } else {
                    open.push(Reverse((height[j].key(), j as u32)));
                }
            }
        });
    }
    Ok(())
}
