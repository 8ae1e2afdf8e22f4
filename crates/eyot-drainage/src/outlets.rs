//! Outlets: the cells where water leaves a landscape.

use super::{Height, check_sizes};
use eyot_core::{BoundaryCondition, Grid, Result};

/// What water can leave to. With the defaults only open rims count.
#[derive(Clone, Copy, Debug, Default)]
pub struct Base<'a> {
    /// Border cells of closed rims are outlets too, as on a map that was cut out of a larger one.
    pub closed_rims: bool,
    /// Cells at or below this level are outlets, m.
    pub sea_level_m: Option<f64>,
    /// More outlets, one flag a cell.
    pub mask: Option<&'a [bool]>,
}

/// Which cells are outlets, row by row: border cells of open rims, and what `base` adds.
///
/// If there is none (a basin without a sea, a torus), the lowest cells are the outlets, so that every cell of every grid
/// drains somewhere.
///
/// # Errors
/// If `height` or the mask has another size than `grid`, or the grid has 2^32 cells or more.
pub fn outlets<T: Height>(height: &[T], grid: &Grid, base: &Base<'_>) -> Result<Vec<bool>> {
    check_sizes(grid, &[("height", height.len()), ("mask of outlets", base.mask.map_or(height.len(), <[bool]>::len))])?;
    let (w, h) = (grid.width, grid.height);
    let ends = |edge: BoundaryCondition| {
        edge == BoundaryCondition::Open || (base.closed_rims && edge == BoundaryCondition::Closed)
    };
    let mut out = base.mask.map_or_else(|| vec![false; grid.cells()], <[bool]>::to_vec);
    if let Some(sea) = base.sea_level_m {
        out.iter_mut().zip(height).for_each(|(o, &z)| *o |= z.to_f64() <= sea);
    }
    if ends(grid.rim.y) {
        out[..w].fill(true);
        out[(h - 1) * w..].fill(true);
    }
    if ends(grid.rim.x) {
        for row in out.chunks_exact_mut(w) {
            row[0] = true;
            row[w - 1] = true;
        }
    }
    if !out.contains(&true)
        && let Some(lowest) = height.iter().map(|z| z.key()).min()
    {
        out.iter_mut().zip(height).for_each(|(o, z)| *o = z.key() == lowest);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Limits};

    fn count(rim: Boundary, base: &Base<'_>) -> usize {
        let grid = Grid::new(5, 4, 1.0, rim, &Limits::default()).unwrap();
        let z: Vec<f32> = (0..20).map(|i| i as f32).collect();
        outlets(&z, &grid, base).unwrap().into_iter().filter(|&o| o).count()
    }

    #[test]
    fn open_rims_the_sea_masks_or_the_lowest_cell() {
        let map = Base { closed_rims: true, ..Base::default() };
        assert_eq!(count(Boundary::OPEN, &Base::default()), 14);
        assert_eq!(count(Boundary::CLOSED, &map), 14);
        assert_eq!(count(Boundary::CLOSED, &Base::default()), 1);
        assert_eq!(count(Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Open }, &Base::default()), 10);
        assert_eq!(count(Boundary::WRAP, &Base { sea_level_m: Some(6.0), ..map }), 7);
        assert_eq!(count(Boundary::WRAP, &map), 1);
        let mask: Vec<bool> = (0..20).map(|i| i % 10 == 3).collect();
        assert_eq!(count(Boundary::WRAP, &Base { mask: Some(&mask), ..map }), 2);
    }

    #[test]
    fn all_lowest_cells_count() {
        let grid = Grid::new(2, 2, 1.0, Boundary::WRAP, &Limits::default()).unwrap();
        assert_eq!(outlets(&[1.0, 0.0, -0.0, 2.0_f64], &grid, &Base::default()).unwrap(), [false, true, true, false]);
        assert!(outlets(&[1.0_f32], &grid, &Base::default()).unwrap_err().to_string().contains("expected 4"));
    }
}
