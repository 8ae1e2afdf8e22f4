//! Filling: raises the floor of every closed depression to its lowest spill.
//!
//! # Result
//! `filled(c) = min over paths c -> outlet of max height on the path`, which is unique and the same as that of a priority
//! flood from the outlets. Every filled value is one of the input values, so nothing is rounded.
//!
//! # How
//! 1. Label the basins that steepest paths on the rough surface lead to (`descent.rs`), in parallel.
//! 2. Find the lowest pass between each two neighbouring basins, in parallel, and join basins in the order of the passes, so
//!    that each learns its spill level (`spill.rs`).
//! 3. `filled(c) = max(z(c), spill level of the basin of c)`: from `c` a way leads down to the bottom of its basin, so
//!    reaching that costs no more than `z(c)`, and leaving it no less than the spill level.
//!
//! # Source
//! Barnes, Lehman & Mulla (2014), Priority-Flood: an optimal depression-filling and watershed-labeling algorithm for
//! digital elevation models, Computers & Geosciences 62, 117-127: the surface. Barnes (2016), Parallel Priority-Flood
//! depression filling for trillion cell digital elevation models on desktops or clusters, Computers & Geosciences 96, 56-68:
//! a graph of spills joins pieces. Cordonnier, Bovy & Braun (2019), A versatile, linear complexity algorithm for flow routing
//! in topographies with depressions, Earth Surface Dynamics 7, 549-562: basins of the rough surface as the pieces.
//!
//! # Differences
//! No cell goes through a priority queue: only the passes between basins, some 5 in 100 cells of noise, are sorted.

use super::bands::band_cells;
use super::descent::basins;
use super::spill::spill_levels;
use super::{Height, check_sizes};
use eyot_core::{Control, Grid, Result};
use rayon::prelude::*;

/// Fills all depressions of `height` that cannot drain to one of `outlets` (one flag a cell, at least one set).
///
/// # Errors
/// If `height` or `outlets` has another size than `grid`, the grid has 2^32 cells or more, or on a request to stop;
/// `height` is then as it was.
pub fn fill<T: Height>(height: &mut [T], grid: &Grid, outlets: &[bool], control: &Control<'_>) -> Result<()> {
    check_sizes(grid, &[("height", height.len()), ("outlets", outlets.len())])?;
    let basins = basins(height, grid, outlets, control)?;
    let level = spill_levels(height, grid, &basins, control)?;
    let cells = band_cells(grid);
    height.par_chunks_mut(cells).zip(basins.label.par_chunks(cells)).for_each(|(height, label)| {
        for (z, &l) in height.iter_mut().zip(label) {
            let spill = level[l as usize];
            *z = if spill > *z { spill } else { *z };
        }
    });
    Ok(())
}
