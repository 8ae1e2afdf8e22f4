//! The steepest way down from each cell.

use super::Height;
use super::bands::{around, band_cells, three_rows};
use super::neighbours::Neighbours;
use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::LaneBlock;
use eyot_core::{Control, Grid, Result};
use rayon::prelude::*;

/// The direction of outlets.
pub(super) const NOWHERE: u8 = 8;
/// The direction of cells without a lower neighbour, until flats are resolved.
pub(super) const FLAT: u8 = 9;

/// The direction of the steepest descent, [`NOWHERE`] at outlets, [`FLAT`] where nothing is lower.
pub(super) fn steepest<T: Height>(z: &[T], grid: &Grid, outlets: &[bool], control: &Control<'_>) -> Result<Vec<u8>> {
    let (near, isa, w) = (Neighbours::new(grid), Isa::best(), grid.width);
    let per_m = near.distance_m.map(|d| 1.0 / d);
    let slowly = |i: usize| {
        let (mut best, mut direction) = (0.0, FLAT);
        near.each(i, |d, j| {
            let slope = (z[i].to_f64() - z[j].to_f64()) * per_m[d];
            if slope > best {
                (best, direction) = (slope, d as u8);
            }
        });
        direction
    };
    let mut direction = vec![0; z.len()];
    let cells = band_cells(grid);
    direction.par_chunks_mut(cells).enumerate().try_for_each(|(band, out)| {
        control.check()?;
        for (k, out) in out.chunks_exact_mut(w).enumerate() {
            let y = band * cells / w + k;
            if let Some(rows) = three_rows(z, grid, y) {
                run_lanes(isa, Steepest { rows, per_m, out: &mut out[1..w - 1] });
                (out[0], out[w - 1]) = (slowly(y * w), slowly(y * w + w - 1));
            } else {
                out.iter_mut().enumerate().for_each(|(x, o)| *o = slowly(y * w + x));
            }
            out.iter_mut().zip(&outlets[y * w..]).for_each(|(d, &o)| *d = if o { NOWHERE } else { *d });
        }
        Ok(())
    })?;
    Ok(direction)
}

/// The steepest descent from the inner cells of a row.
struct Steepest<'a, T> {
    rows: [&'a [T]; 3],
    per_m: [f64; 8],
    out: &'a mut [u8],
}

impl<T: Height> LaneTask for Steepest<'_, T> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let n = self.out.len();
        let rows = self.rows.map(|r| &r[..n + 2]);
        for x in 0..n {
            let (z, others) = (rows[1][x + 1].to_f64(), around(rows, x));
            let (mut best, mut direction) = (0.0, u64::from(FLAT));
            for k in 0..8 {
                let slope = (z - others[k].to_f64()) * self.per_m[k];
                let steeper = slope > best;
                best = if steeper { slope } else { best };
                direction = if steeper { k as u64 } else { direction };
            }
            self.out[x] = direction as u8;
        }
    }
}
