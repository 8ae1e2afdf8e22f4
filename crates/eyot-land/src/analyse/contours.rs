//! Contour lines of a height map, by marching squares.
//!
//! Heights belong to the middles of cells and change linearly between neighbours; where two lines could pass through a square either way,
//! the mean of its corners decides. A height that is a level itself counts as above it. Lines end at the rim; a rim that wraps ends them,
//! too.
//!
//! # Source
//! Lorensen & Cline (1987), SIGGRAPH 21, 163-169, in two dimensions.

use super::check_fits;
use eyot_core::component::{Features, Form, Type};
use eyot_core::{Control, Error, Field, Grid, Result};
use rayon::prelude::*;
use std::collections::HashMap;

/// Most levels: more lines than anybody tells apart.
const MAX_LEVELS: f64 = 1000.0;

/// An interval (m) that makes about twenty levels between these heights: 1, 2 or 5 times a power of ten.
pub fn round_interval(low: f32, high: f32) -> f64 {
    let wanted = (f64::from(high) - f64::from(low)).max(1e-3) / 20.0;
    let power = 10_f64.powf(wanted.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|r| r * power).find(|step| *step >= 0.999 * wanted).unwrap_or(10.0 * power)
}

/// Lines of equal height at whole multiples of `interval` (m), level by level from below, with their `height` (m) and whether they are
/// `closed` (1 or 0). The higher ground is on the right of a line.
///
/// # Errors
/// If the interval is not above zero or makes more than 1000 levels, `height` has another size than `grid`, or the work is stopped.
pub fn contours(height: &Field, grid: &Grid, interval: f64, control: &Control<'_>) -> Result<Features> {
    check_fits(height, grid)?;
    let bad = |reason: String| Error::BadParameter { owner: "contours".into(), field: "interval".into(), reason };
    if !(interval.is_finite() && interval > 0.0) {
        return Err(bad(format!("{interval} m is no distance of heights; it must be above 0")));
    }
    let (low, high) = height.min_max();
    let levels = (f64::from(high) - f64::from(low)) / interval;
    if levels > MAX_LEVELS {
        let least = round_interval(0.0, 20.0 * (high - low) / MAX_LEVELS as f32);
        return Err(bad(format!(
            "{interval} m makes {levels:.0} levels, {MAX_LEVELS} are the most; choose {least} or more"
        )));
    }
    let first = (f64::from(low) / interval).floor() as i64;
    let last = (f64::from(high) / interval).floor() as i64;
    let of_levels: Vec<(f64, Vec<Vec<[f32; 3]>>)> = (first..=last)
        .into_par_iter()
        .map(|n| {
            control.check()?;
            let level = n as f64 * interval;
            Ok((level, Level { height, grid, level: level as f32 }.lines()))
        })
        .collect::<Result<_>>()?;
    let mut lines = Features::new(Form::Lines, [("height", "m", Type::F64), ("closed", "1", Type::U8)]);
    for (level, of_level) in of_levels {
        for line in of_level {
            let closed = line.first() == line.last();
            lines.push(&[&line], &[level, f64::from(u8::from(closed))])?;
        }
    }
    Ok(lines)
}

/// The corners of a square, clockwise from the north-west.
const CORNERS: [(usize, usize); 4] = [(0, 0), (1, 0), (1, 1), (0, 1)];

struct Level<'a> {
    height: &'a Field,
    grid: &'a Grid,
    level: f32,
}

impl Level<'_> {
    /// The lines of this level: those that begin at the rim, then the rings, both in the order in which rows meet them.
    fn lines(&self) -> Vec<Vec<[f32; 3]>> {
        let segments = self.segments();
        let next: HashMap<usize, usize> = segments.iter().copied().collect();
        let mut entered: Vec<usize> = segments.iter().map(|(_, to)| *to).collect();
        entered.sort_unstable();
        let from_rim = segments.iter().map(|(from, _)| *from).filter(|from| entered.binary_search(from).is_err());
        let mut taken: HashMap<usize, ()> = HashMap::with_capacity(segments.len());
        let mut lines = Vec::new();
        for start in from_rim.chain(segments.iter().map(|(from, _)| *from)) {
            let (mut line, mut at): (Vec<[f32; 3]>, _) = (Vec::new(), Some(start));
            while let Some(edge) = at.filter(|edge| taken.insert(*edge, ()).is_none()) {
                let vertex = self.vertex(edge);
                // Through a cell that is at the level itself, several edges are crossed in one place.
                if line.last() != Some(&vertex) {
                    line.push(vertex);
                }
                at = next.get(&edge).copied();
            }
            if at == Some(start) && line.len() > 2 && line.first() != line.last() {
                line.push(line[0]);
            }
            if line.len() > 1 {
                lines.push(line);
            }
        }
        lines
    }

    /// From which edge to which a line crosses a square, for all squares row by row. Edges are numbered by their first cell: twice its
    /// number to the east, and one more to the south.
    fn segments(&self) -> Vec<(usize, usize)> {
        let (w, h) = (self.grid.width, self.grid.height);
        let mut segments = Vec::new();
        for y in 0..h.saturating_sub(1) {
            let rows = [self.height.row(y), self.height.row(y + 1)];
            for x in 0..w.saturating_sub(1) {
                let z = CORNERS.map(|(dx, dy)| rows[dy][x + dx]);
                let above = z.map(|z| z >= self.level);
                if above == [above[0]; 4] {
                    continue;
                }
                let cell = y * w + x;
                let edges = [2 * cell, 2 * (cell + 1) + 1, 2 * (cell + w), 2 * cell + 1];
                let leaves = |k: usize| above[k] && !above[(k + 1) % 4];
                let enters = |k: usize| !above[k] && above[(k + 1) % 4];
                let middle = z.iter().map(|z| f64::from(*z)).sum::<f64>() / 4.0 >= f64::from(self.level);
                for from in (0..4).filter(|k| leaves(*k)) {
                    let turn = if middle { 1 } else { 3 };
                    let to = (1..4).map(|n| (from + n * turn) % 4).find(|k| enters(*k));
                    segments.extend(to.map(|to| (edges[from], edges[to])));
                }
            }
        }
        segments
    }

    /// Where the level lies on an edge.
    fn vertex(&self, edge: usize) -> [f32; 3] {
        let (w, cell) = (self.grid.width, edge / 2);
        let (x, y) = (cell % w, cell / w);
        let (dx, dy) = if edge.is_multiple_of(2) { (1, 0) } else { (0, 1) };
        let (a, b) = (f64::from(self.height.row(y)[x]), f64::from(self.height.row(y + dy)[x + dx]));
        let t = ((f64::from(self.level) - a) / (b - a)).clamp(0.0, 1.0);
        let along = |i: usize, d: usize, cell_m: f64| ((i as f64 + 0.5 + t * d as f64) * cell_m) as f32;
        [along(x, dx, self.grid.cell_x_m), along(y, dy, self.grid.cell_y_m), self.level]
    }
}
