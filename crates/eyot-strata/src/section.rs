//! A section: what a line across the land cuts through.

use crate::subsurface::{Kind, Run, Subsurface};
use eyot_core::{Error, Grid, Result, World};

/// A stretch of a section within one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Where it begins, m along the line.
    pub from_m: f64,
    /// Where it ends.
    pub to_m: f64,
    /// Column and row of the cell.
    pub cell: [usize; 2],
    /// Runs of the cell from the surface down to the floor.
    pub runs: Vec<Run>,
}

/// A section along a line, cell by cell. Its areas are exact: the volume over a row of cells is that of their columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Length of the line, m.
    pub length_m: f64,
    /// Height down to which it reaches, m.
    pub floor_m: f64,
    /// What it can be made of.
    pub kinds: Vec<Kind>,
    /// The line in cells.
    pub pieces: Vec<Piece>,
}

/// Most points of a line: more are no section that somebody could read.
pub const MOST_POINTS: usize = 100;

impl Section {
    /// Cuts a world along a line through points (m from the western rim, m from the northern one), down to `floor_m`.
    ///
    /// # Errors
    /// If the world has no height or the line is none on its grid.
    pub fn along(world: &World, line: &[[f64; 2]], floor_m: f64) -> Result<Self> {
        let below = Subsurface::of(world)?;
        let length_m = check(&world.grid, line)?;
        let mut pieces: Vec<Piece> = Vec::new();
        walk(&world.grid, line, |from_m, to_m, cell| {
            let mut runs = Vec::new();
            below.of_cell(cell[0], cell[1], floor_m, &mut runs);
            pieces.push(Piece { from_m, to_m, cell, runs });
        });
        Ok(Self { length_m, floor_m, kinds: below.kinds().to_vec(), pieces })
    }

    /// Area of each kind of ground, m2, in the order of [`Section::kinds`].
    pub fn areas_m2(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.kinds.len()];
        for piece in &self.pieces {
            let length = piece.to_m - piece.from_m;
            piece.runs.iter().for_each(|r| areas[r.kind] += length * r.thickness_m());
        }
        areas
    }
}

/// Area of each kind of ground below a line down to `floor_m`, m2, in the order of [`Subsurface::kinds`]: as [`Section::areas_m2`], but no piece
/// of the section is kept, and beds are told apart however thin they are ([`Subsurface::thicknesses`]).
///
/// # Errors
/// If the line is none on the grid.
pub fn areas_m2(below: &Subsurface<'_>, grid: &Grid, line: &[[f64; 2]], floor_m: f64) -> Result<Vec<f64>> {
    check(grid, line)?;
    let mut areas = vec![0.0; below.kinds().len()];
    let (mut column, mut runs) = (areas.clone(), Vec::new());
    walk(grid, line, |from_m, to_m, [x, y]| {
        below.thicknesses(x, y, floor_m, &mut runs, &mut column);
        areas.iter_mut().zip(&column).for_each(|(area, thickness)| *area += (to_m - from_m) * thickness);
    });
    Ok(areas)
}

/// The length of a line on a grid, m.
///
/// # Errors
/// If it has no length, more than [`MOST_POINTS`] points, or leaves the grid.
pub fn check(grid: &Grid, line: &[[f64; 2]]) -> Result<f64> {
    let wrong = |reason: String| Error::BadParameter { owner: "section".into(), field: "line".into(), reason };
    if line.len() > MOST_POINTS {
        return Err(wrong(format!("a line has at most {MOST_POINTS} points, this one has {}", line.len())));
    }
    let size = [grid.width as f64 * grid.cell_x_m, grid.height as f64 * grid.cell_y_m];
    for p in line {
        // A line to the rim may miss it by rounding.
        let inside = (0..2).all(|i| (-1e-6 * size[i]..=size[i] * (1.0 + 1e-6)).contains(&p[i]));
        if !inside {
            let [x, y] = p.map(|m| if m.abs() < 1e9 { m.to_string() } else { format!("{m:e}") });
            return Err(wrong(format!("({x} m, {y} m) lies outside the land of {} x {} m", size[0], size[1])));
        }
    }
    let length: f64 = line.array_windows::<2>().map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1])).sum();
    // Points that differ by less are meant to be the same.
    let least = 1e-6 * grid.cell_x_m.min(grid.cell_y_m);
    if length > least { Ok(length) } else { Err(wrong("a line needs two points that differ".into())) }
}

/// Goes along a line, cell by cell: where each stretch begins and ends, m along the line, and the column and row of its cell.
fn walk(grid: &Grid, line: &[[f64; 2]], mut each: impl FnMut(f64, f64, [usize; 2])) {
    let mut passed = 0.0;
    for [a, b] in line.array_windows::<2>() {
        let way = (b[0] - a[0]).hypot(b[1] - a[1]);
        for (from, to, cell) in cells(grid, *a, *b) {
            each(passed + from * way, passed + to * way, cell);
        }
        passed += way;
    }
}

/// The cells that a straight line passes through: shares of its way at which it enters and leaves each, and which they are.
fn cells(grid: &Grid, a: [f64; 2], b: [f64; 2]) -> Vec<(f64, f64, [usize; 2])> {
    let (from, to) = (place(grid, a), place(grid, b));
    let mut cuts = vec![0.0, 1.0];
    for i in 0..2 {
        let (low, high) = (from[i].min(to[i]), from[i].max(to[i]));
        let way = to[i] - from[i];
        if way != 0.0 {
            cuts.extend((low.ceil() as i64..=high.floor() as i64).map(|n| (n as f64 - from[i]) / way));
        }
    }
    cuts.retain(|t| (0.0..=1.0).contains(t));
    cuts.sort_unstable_by(f64::total_cmp);
    cuts.dedup();
    let size = [grid.width, grid.height];
    let cell = |t: f64| [0, 1].map(|i| ((from[i] + t * (to[i] - from[i])).max(0.0) as usize).min(size[i] - 1));
    cuts.array_windows::<2>().map(|[s, t]| (*s, *t, cell(0.5 * (s + t)))).collect()
}

/// A place in cells from the north-western corner.
fn place(grid: &Grid, p: [f64; 2]) -> [f64; 2] {
    [p[0] / grid.cell_x_m, p[1] / grid.cell_y_m]
}
