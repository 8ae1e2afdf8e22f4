//! Do channels follow the grid? The share of diagonal steps among those of small channels.
//!
//! # Definition
//! Depressions are filled and each cell's water goes down the steepest of eight ways (D8). Among the cells through which
//! an area within given bounds drains, which are neither sea nor raised by filling, `share = diagonal steps / all steps`.
//!
//! A straight line at an angle of `a` <= 45 degrees to an axis takes `cos a` steps per length, `sin a` of them diagonal. Over
//! all directions that makes a share of `(1 - sqrt 1/2) / sqrt 1/2 = 0.414`. The Jacksboro tile has 0.43. Less means channels along the rows and columns of
//! the grid, more means diagonal ones.

use super::check_fits;
use eyot_core::{Control, Field, Grid, Result};
use eyot_drainage::{Base, Routing, fill, outlets};
use std::ops::RangeInclusive;

/// Share of diagonal steps, 0..=1, among those of channels through which an area of `cells` cells drains; `None` if there are no
/// such channels. Water leaves over all rims that do not wrap and, with `sea_level_m`, into the sea.
///
/// # Errors
/// If `height` has another size than `grid`, or the grid has 2^32 cells or more.
pub fn diagonal_share(
    height: &Field,
    grid: &Grid,
    sea_level_m: Option<f64>,
    cells: RangeInclusive<u32>,
) -> Result<Option<f64>> {
    check_fits(height, grid)?;
    let ground = height.to_vec();
    let outlets = outlets(&ground, grid, &Base { closed_rims: true, sea_level_m, mask: None })?;
    let mut surface = ground.clone();
    fill(&mut surface, grid, &outlets, &Control::none())?;
    let routing = Routing::new(&surface, grid, &outlets, &Control::none())?;
    let upstream = routing.upstream_cells();
    let (mut diagonal, mut all) = (0_u64, 0_u64);
    for i in 0..ground.len() {
        if !routing.is_outlet(i) && surface[i] == ground[i] && cells.contains(&upstream[i]) {
            // Odd directions are diagonal.
            diagonal += u64::from(routing.directions()[i] % 2);
            all += 1;
        }
    }
    Ok((all > 0).then(|| diagonal as f64 / all as f64))
}
