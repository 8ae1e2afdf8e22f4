//! Beds: what rivers dig, and what they cover.
//!
//! # Equations
//! With `r` the distance from the line, `w` the width, `d` the depth of the water and `z_w` its surface on the line:
//! 1. In the bed (`r <= w/2`): `z' = min(z, z_w - d)`.
//! 2. Beside it, over a bank of width `b`: `z' = z - max(0, z - (z_w - d) - s (r - w/2)) (1 - smooth((r - w/2) / b))`: the ground falls to
//!    the bed without a step where the bank ends, whatever the slope beside it is.
//!
//! Rivers narrower than 0.7 cells dig nothing: a cell cannot show them.

use eyot_core::Grid;

/// Slope of a bank, 1.
const BANK_SLOPE: f64 = 1.0 / 3.0;
/// Share of a cell that a river must have to dig it.
pub const LEAST_SHARE: f64 = 0.7;

/// A piece of a river between two vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Where it begins and ends: m east, m south, height of the water's surface, m.
    pub ends: [[f32; 3]; 2],
    /// Width of the water, m.
    pub width_m: f64,
    /// Its depth, m.
    pub depth_m: f64,
}

/// What rivers do to the cells.
#[derive(Clone, Debug)]
pub struct Beds {
    /// The ground when their beds are dug, m.
    pub ground: Vec<f32>,
    /// Depth of their water, m, where they are as wide as cells.
    pub water: Vec<f32>,
    /// Share of the cell that they cover, 0..=1.
    pub cover: Vec<f32>,
}

/// Digs the beds of `pieces` into `ground` if `dig`, and says what they cover. `keep(cell)`: cells that are left as they are.
pub fn dig(ground: &[f32], grid: &Grid, pieces: &[Piece], dig: bool, keep: impl Fn(usize) -> bool) -> Beds {
    let mut beds = Beds { ground: ground.to_vec(), water: vec![0.0; ground.len()], cover: vec![0.0; ground.len()] };
    let cell = grid.cell_x_m.max(grid.cell_y_m);
    for piece in pieces {
        let half = 0.5 * piece.width_m;
        let digs = dig && piece.width_m >= LEAST_SHARE * cell;
        let bank = piece.width_m.max(1.5 * cell);
        let reach = half + if digs { bank } else { 0.5 * cell };
        for_cells(grid, piece, reach, |i, r, t| {
            let cover = ((half + 0.5 * cell - r) / cell).clamp(0.0, 1.0).min(piece.width_m / cell) as f32;
            beds.cover[i] = beds.cover[i].max(cover);
            if !digs || keep(i) {
                return;
            }
            let surface = f64::from(piece.ends[0][2]) * (1.0 - t) + f64::from(piece.ends[1][2]) * t;
            let bed = surface - piece.depth_m;
            let z = f64::from(ground[i]);
            let outside = (r - half).max(0.0);
            let over = (z - bed - BANK_SLOPE * outside).max(0.0);
            let u = (outside / bank).min(1.0);
            let dug = (z - over * (1.0 - u * u * (3.0 - 2.0 * u))) as f32;
            beds.ground[i] = beds.ground[i].min(dug);
            if r <= half.max(0.5 * cell) {
                let depth = (surface - f64::from(beds.ground[i])) as f32;
                beds.water[i] = beds.water[i].max(depth);
            }
        });
    }
    beds
}

/// Calls `f(cell, r, t)` for the cells whose middle is at most `reach_m` from a piece: `r` m from it, nearest to it at `t` of its length.
pub fn for_cells(grid: &Grid, piece: &Piece, reach_m: f64, mut f: impl FnMut(usize, f64, f64)) {
    let [a, b] = piece.ends.map(|v| [f64::from(v[0]), f64::from(v[1])]);
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let cells = [grid.cell_x_m, grid.cell_y_m];
    let low = [0, 1].map(|c| ((a[c].min(b[c]) - reach_m) / cells[c] - 0.5).ceil() as isize);
    let high = [0, 1].map(|c| ((a[c].max(b[c]) + reach_m) / cells[c] - 0.5).floor() as isize);
    let inside = |v: isize, n: usize, wraps: bool| wraps || (0..n as isize).contains(&v);
    let wraps = |edge| edge == eyot_core::BoundaryCondition::Wrap;
    let (wrap_x, wrap_y) = (wraps(grid.rim.x), wraps(grid.rim.y));
    for y in (low[1]..=high[1]).filter(|&y| inside(y, grid.height, wrap_y)) {
        for x in (low[0]..=high[0]).filter(|&x| inside(x, grid.width, wrap_x)) {
            let p = [(x as f64 + 0.5) * cells[0] - a[0], (y as f64 + 0.5) * cells[1] - a[1]];
            let t = if square > 0.0 { ((p[0] * along[0] + p[1] * along[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
            let off = [p[0] - t * along[0], p[1] - t * along[1]];
            let r = (off[0] * off[0] + off[1] * off[1]).sqrt();
            if r <= reach_m {
                let (column, row) = (x.rem_euclid(grid.width as isize), y.rem_euclid(grid.height as isize));
                f(row as usize * grid.width + column as usize, r, t);
            }
        }
    }
}
