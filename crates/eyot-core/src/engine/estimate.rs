//! How much memory a simulation takes, before it begins.

use crate::field::Field;
use crate::grid::Grid;
use crate::plan::Plan;
use crate::process::{Moment, Scheduled, changed_by_failure, plan_step};

/// Memory of a simulation at its peak.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryEstimate {
    /// Fields of the grid's size: layers, scratch layers, second copies, and copies to go back to where something acts that
    /// can fail.
    pub fields: usize,
    /// What actions hold beside them, some of it between their turns, too; bytes per cell.
    pub action_bytes_per_cell: usize,
}

impl MemoryEstimate {
    /// What simulating these processes needs on a world that has `layers` layers, those of the processes included. The grid is the
    /// whole one, as plans depend on it.
    pub fn of(grid: &Grid, layers: usize, processes: &[Scheduled]) -> Self {
        let mut plan = Plan::default();
        let mut moment = Moment::whole(*grid, 0, 0.0);
        plan_step(processes, 0, &mut moment, &mut plan);
        let actions: Vec<_> = processes.iter().filter_map(|s| s.process.action()).collect();
        // Steps in which not all processes are due keep no more than one in which they are.
        let copies = changed_by_failure(processes.iter()).len();
        let fields = layers + plan.scratch_layers().len() + plan.doubled_layers().len() + copies;
        Self { fields, action_bytes_per_cell: actions.iter().map(|a| a.bytes_per_cell()).sum() }
    }

    /// All of it on a grid, bytes.
    pub fn bytes(&self, grid: &Grid) -> u128 {
        let action = self.action_bytes_per_cell as u128 * grid.cells() as u128;
        Field::bytes_of(grid.width, grid.height) * self.fields as u128 + action
    }
}
