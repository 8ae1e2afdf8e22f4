//! Crust that is added to cells and taken from them, collected before anything is changed.
//!
//! Everything that happens at the borders in a step looks at the crust as it was after the plates moved, and additions of whole
//! units do not depend on their order.

use crate::crust::{HIGHEST_M, is_continental, units};
use crate::geometry::Geometry;

/// Rounds in which thick crust flows after each shift.
const ROUNDS: usize = 12;
/// Of these, how many it flows over continents only.
const ON_LAND: usize = 8;
/// What is still so much thicker than it may be sinks.
const SINKS: f32 = 1.1;

/// Additions to the thickness of cells, units.
#[derive(Default)]
pub(crate) struct Changes(Vec<(u32, i32)>);

impl Changes {
    pub(crate) fn add(&mut self, cell: usize, units: i32) {
        if units != 0 {
            self.0.push((cell as u32, units));
        }
    }

    /// Applies them, lets what is thicker than `max_crust` m flow to the sides, and returns what sank because a column was still too
    /// high, units.
    pub(crate) fn apply(self, g: &Geometry, crust: &mut [i32], max_crust: f32) -> i64 {
        let (full, highest) = (units(max_crust), units((SINKS * max_crust).min(HIGHEST_M)));
        for &(cell, units) in &self.0 {
            crust[cell as usize] += units;
        }
        let mut over: Vec<u32> = self.0.iter().map(|c| c.0).filter(|&c| crust[c as usize] > full).collect();
        for round in 0..ROUNDS {
            over.sort_unstable();
            over.dedup();
            over.retain(|&c| crust[c as usize] > full);
            over = flow(g, crust, full, &over, round >= ON_LAND);
        }
        let mut sunk = 0;
        for cell in self.0.iter().map(|c| c.0).chain(over) {
            let c = &mut crust[cell as usize];
            sunk += i64::from((*c - highest).max(0));
            *c = (*c).min(highest);
        }
        sunk
    }
}

/// Every cell in `over` gives a part of what it has above `full` to its neighbours, all at once; returns who may be too thick then.
fn flow(g: &Geometry, crust: &mut [i32], full: i32, over: &[u32], into_sea: bool) -> Vec<u32> {
    let mut moves: Vec<(u32, i32)> = Vec::with_capacity(9 * over.len());
    for &cell in over {
        // An eighth to each neighbour would only swap a full cell with those around it.
        let share = (crust[cell as usize] - full) / 10;
        let to = g.ring(cell as usize).filter(|&n| into_sea || is_continental(crust[n]));
        let before = moves.len();
        moves.extend(to.map(|n| (n as u32, share)));
        let given = share * (moves.len() - before) as i32;
        moves.push((cell, -given));
    }
    for &(cell, units) in &moves {
        crust[cell as usize] += units;
    }
    moves.into_iter().map(|m| m.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Grid, Limits};

    #[test]
    fn thick_crust_flows_and_none_is_lost() {
        let g = Geometry::new(&Grid::new(16, 16, 1.0, Boundary::WRAP, &Limits::default()).unwrap());
        let mut crust = vec![units(36_000.0); 256];
        let mut changes = Changes::default();
        (0..20).for_each(|_| changes.add(100, units(9_000.0)));
        let before: i64 = crust.iter().map(|&c| i64::from(c)).sum();
        let sunk = changes.apply(&g, &mut crust, 70_000.0);
        assert_eq!(sunk, 0);
        assert_eq!(crust.iter().map(|&c| i64::from(c)).sum::<i64>(), before + i64::from(units(180_000.0)));
        assert!(*crust.iter().max().unwrap() < units(80_000.0), "{}", crust.iter().max().unwrap() / 128);
    }
}
