//! What flows together: cells, areas and other amounts upstream of each cell, and an order to visit cells in.
//!
//! # Source
//! The walk down from each source until a confluence still waits for another donor is Kahn's topological sort (1962).

use super::Routing;
use eyot_core::{Grid, Result};

impl Routing {
    /// All cells, each after its receiver: outlets first. Read backwards, each cell comes before its receiver.
    pub fn order(&self) -> Vec<u32> {
        let mut order = vec![0; self.cells()];
        let mut last = order.len();
        self.walk(|i, _| {
            last -= 1;
            order[last] = i as u32;
        });
        order
    }

    /// For each cell the number of cells that drain through it, itself included. Over all outlets they add up to the
    /// number of cells exactly.
    pub fn upstream_cells(&self) -> Vec<u32> {
        let mut cells = vec![1; self.cells()];
        self.walk(|i, r| {
            if i != r {
                cells[r] += cells[i];
            }
        });
        cells
    }

    /// For each cell the area that drains through it, itself included, m2: an exact count times the area of a cell.
    pub fn upstream_area_m2(&self, grid: &Grid) -> Vec<f64> {
        let area = grid.cell_area_m2();
        self.upstream_cells().into_iter().map(|n| f64::from(n) * area).collect()
    }

    /// Adds to each cell's amount those of all cells upstream: with rain (m/s) times area (m2) they become discharge (m3/s).
    ///
    /// # Errors
    /// If there is not one amount for each cell.
    pub fn accumulate(&self, amounts: &mut [f64]) -> Result<()> {
        super::check_length("amounts to accumulate", self.cells(), amounts.len())?;
        self.walk(|i, r| {
            if i != r {
                amounts[r] += amounts[i];
            }
        });
        Ok(())
    }

    /// For each cell the length of the longest way that water takes to it, m.
    pub fn longest_upstream_m(&self) -> Vec<f64> {
        let mut length = vec![0.0_f64; self.cells()];
        self.walk(|i, r| {
            if i != r {
                length[r] = length[r].max(length[i] + self.distance_m(i));
            }
        });
        length
    }

    /// For each cell the outlet that its water leaves by.
    pub fn basins(&self) -> Vec<u32> {
        let mut basin = self.receiver.clone();
        for i in self.order() {
            basin[i as usize] = basin[self.receiver[i as usize] as usize];
        }
        basin
    }

    /// Calls `f(cell, receiver)` for all cells, for each after all its donors.
    fn walk(&self, mut f: impl FnMut(usize, usize)) {
        let mut waiting = vec![0_u8; self.cells()];
        for (i, &r) in self.receiver.iter().enumerate() {
            waiting[r as usize] += u8::from(r as usize != i);
        }
        for start in 0..self.cells() {
            if waiting[start] > 0 {
                continue;
            }
            let mut i = start;
            loop {
                let r = self.receiver[i] as usize;
                f(i, r);
                if r == i {
                    break;
                }
                waiting[r] -= 1;
                if waiting[r] > 0 {
                    break;
                }
                // A later start is a source from the beginning: cells that reach 0 here get a count that no cell has.
                waiting[r] = u8::MAX;
                i = r;
            }
        }
    }
}
