//! What ice does to its bed: how fast it slides where the valley is narrow, and how much it wears and plucks.

use crate::padded::Padded;
use eyot_core::{BoundaryCondition, Grid};
use rayon::prelude::*;

/// Nothing slides faster than this, m/a.
const FASTEST: f32 = 500.0;
/// What a round erodes at most, m: less than this is hardly held back.
const MOST_M: f32 = 30.0;
/// Ice of this thickness wears half as much as thick ice does: thinner ice is mostly frozen to its bed, m.
const THAWED_M: f32 = 80.0;

/// Differences around a cell.
struct Around {
    x: f32,
    y: f32,
    xx: f32,
    yy: f32,
    xy: f32,
}

impl Around {
    #[inline(always)]
    fn of(v: &Padded, x: usize, y: usize, step: (f32, f32)) -> Self {
        let (a, b, c) = (v.framed(y), v.framed(y + 1), v.framed(y + 2));
        let (west, here, east) = (b[x], b[x + 1], b[x + 2]);
        let (north, south) = (a[x + 1], c[x + 1]);
        Self {
            x: (east - west) / (2.0 * step.0),
            y: (south - north) / (2.0 * step.1),
            xx: ((east - here) - (here - west)) / (step.0 * step.0),
            yy: ((south - here) - (here - north)) / (step.1 * step.1),
            xy: ((c[x + 2] - c[x]) - (a[x + 2] - a[x])) / (4.0 * step.0 * step.1),
        }
    }
}

fn spacing(grid: &Grid) -> (f32, f32) {
    (grid.cell_x_m as f32, grid.cell_y_m as f32)
}

/// Sliding of every cell ([`Sheet::slip`](crate::sheet::Sheet)): less in narrow valleys, whose walls hold the ice. `surface`: of the
/// ice, smoothed, m; `constriction`: length, m.
pub fn slip(grid: &Grid, bed: &Padded, surface: &Padded, slip: f32, constriction: f32) -> Padded {
    let step = spacing(grid);
    let mut smooth = bed.clone();
    smooth.smooth(grid, 1);
    Padded::from_fn(grid, |x, y| {
        let (b, s) = (Around::of(&smooth, x, y, step), Around::of(surface, x, y, step));
        let square = s.x * s.x + s.y * s.y;
        // Curvature of the bed across the flow.
        let across = (b.xx * s.y * s.y - 2.0 * b.xy * s.x * s.y) + b.yy * s.x * s.x;
        let bend = (across / (square + 1e-9)).max(0.0);
        slip / (1.0 + constriction * bend)
    })
}

/// Speed of sliding, smoothed `times` over, m/a.
pub fn speed(grid: &Grid, ice: &Padded, surface: &Padded, slip: &Padded, times: usize) -> Padded {
    let step = spacing(grid);
    let mut speed = Padded::from_fn(grid, |x, y| {
        let s = Around::of(surface, x, y, step);
        let slope = (s.x * s.x + s.y * s.y).sqrt();
        let pull = ice.at(x, y) * slope;
        (slip.at(x, y) * (pull * pull * pull)).min(FASTEST)
    });
    speed.smooth(grid, times);
    speed
}

/// How fast ice erodes.
#[derive(Clone, Copy)]
pub struct Wear {
    /// Abrasion of the speed squared, a/m.
    pub abrasion: f32,
    /// Plucking of the speed, where the bed falls in the direction of flow, 1.
    pub plucking: f32,
    /// Years.
    pub years: f32,
}

/// What a round takes from the bed, m, row by row.
pub fn erosion(
    grid: &Grid,
    bed: &Padded,
    ice: &Padded,
    surface: &Padded,
    speed: &Padded,
    wear: Wear,
    factor: impl Fn(usize, usize) -> f32 + Sync,
) -> Vec<f32> {
    let step = spacing(grid);
    let mut eroded = vec![0.0; grid.cells()];
    eroded.par_chunks_exact_mut(grid.width).enumerate().for_each(|(y, row)| {
        for (x, out) in row.iter_mut().enumerate() {
            if ice.at(x, y) < 1.0 {
                continue;
            }
            let (b, s) = (Around::of(bed, x, y, step), Around::of(surface, x, y, step));
            let flow = (s.x * s.x + s.y * s.y).sqrt();
            // How steeply the bed falls along the flow.
            let fall = ((b.x * s.x + b.y * s.y) / (flow + 1e-6)).max(0.0);
            let u = speed.at(x, y);
            // Wear is across the bed: walls give way to the side.
            let aslant = (1.0 + (b.x * b.x + b.y * b.y)).sqrt();
            let rate = aslant * (wear.abrasion * u * u) + wear.plucking * u * fall;
            let thick = ice.at(x, y) * ice.at(x, y);
            let thawed = thick / (thick + THAWED_M * THAWED_M);
            let depth = rate * thawed * wear.years * factor(x, y).max(0.0);
            *out = depth * MOST_M / (depth + MOST_M);
        }
    });
    // Ice that leaves over an open rim wears that as much as the cells before it: else it would dam the valleys.
    let (w, h) = (grid.width, grid.height);
    if grid.rim.x == BoundaryCondition::Open && w > 2 {
        for row in eroded.chunks_exact_mut(w) {
            (row[0], row[w - 1]) = (row[1], row[w - 2]);
        }
    }
    if grid.rim.y == BoundaryCondition::Open && h > 2 {
        eroded.copy_within(w..2 * w, 0);
        eroded.copy_within((h - 2) * w..(h - 1) * w, (h - 1) * w);
    }
    eroded
}
