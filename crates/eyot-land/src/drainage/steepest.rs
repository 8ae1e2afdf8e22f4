//! The steepest way down from each cell.

use super::Height;
use super::neighbours::Neighbours;
use eyot_core::{Control, Grid, Result};

/// The direction of outlets.
pub(super) const NOWHERE: u8 = 8;
/// The direction of cells without a lower neighbour, until flats are resolved.
pub(super) const FLAT: u8 = 9;

/// The direction of the steepest descent, [`NOWHERE`] at outlets, [`FLAT`] where nothing is lower.
pub(super) fn steepest<T: Height>(
    z: &[T],
    _grid: &Grid,
    around: &Neighbours,
    outlets: &[bool],
    control: &Control<'_>,
) -> Result<Vec<u8>> {
    control.check()?;
    let per_m = around.distance_m.map(|d| 1.0 / d);
    Ok((0..z.len())
        .map(|i| {
            if outlets[i] {
                return NOWHERE;
            }
            let (mut best, mut direction) = (0.0, FLAT);
            around.each(i, |d, j| {
                let slope = (z[i].to_f64() - z[j].to_f64()) * per_m[d];
                if slope > best {
                    (best, direction) = (slope, d as u8);
                }
            });
            direction
        })
        .collect())
}
