//! Outlets: the cells where water leaves a landscape.

use eyot_core::{Edge, Field, Grid};

/// Which cells are outlets, row by row.
///
/// Outlets are the border cells of every axis that does not wrap, and every cell at or below the sea. A torus
/// without a sea would have none; then its lowest cell (the first of them) is the outlet, so that every cell of
/// every grid drains somewhere.
pub fn outlets(height: &Field, grid: &Grid, sea_level_m: Option<f64>) -> Vec<bool> {
    let (w, h) = (grid.width, grid.height);
    let mut out = vec![false; grid.cells()];
    for (y, (row, flags)) in height.rows().zip(out.chunks_exact_mut(w)).enumerate() {
        if let Some(sea) = sea_level_m {
            flags.iter_mut().zip(row).for_each(|(o, &z)| *o = f64::from(z) <= sea);
        }
        if grid.rim.y != Edge::Wrap && (y == 0 || y + 1 == h) {
            flags.fill(true);
        }
        if grid.rim.x != Edge::Wrap {
            flags[0] = true;
            flags[w - 1] = true;
        }
    }
    if !out.contains(&true) {
        let lowest = height.iter().enumerate().fold((0, f32::INFINITY), |m, (i, z)| if z < m.1 { (i, z) } else { m }).0;
        out[lowest] = true;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Limits, Rim};

    fn count(rim: Rim, sea: Option<f64>) -> usize {
        let grid = Grid::new(5, 4, 1.0, rim, &Limits::default()).unwrap();
        let z = Field::from_fn(5, 4, |x, y| (x + 5 * y) as f32);
        outlets(&z, &grid, sea).into_iter().filter(|&o| o).count()
    }

    #[test]
    fn border_sea_or_the_lowest_cell() {
        assert_eq!(count(Rim::CLOSED, None), 14);
        assert_eq!(count(Rim { x: Edge::Wrap, y: Edge::Open }, None), 10);
        assert_eq!(count(Rim::WRAP, Some(6.0)), 7);
        assert_eq!(count(Rim::WRAP, None), 1);
    }
}
