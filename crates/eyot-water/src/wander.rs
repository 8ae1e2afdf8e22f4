//! Patterns: which reaches meander or braid, and on what ground.
//!
//! A reach that is 20 widths long and at least a quarter of a cell wide, and that has a flood plain of five widths along half of its way,
//! braids where it is steep for its water (`braid.rs`) and else meanders where it falls less than 0.005 (`meander.rs`). It stays on
//! the ground that is nearer to it than to any other reach, so that no two cross. Bends that were cut off stay as oxbow lakes where the
//! river did not come back.

use crate::braid::{braids, threads};
use crate::course::{Course, Oxbow, Pattern};
use crate::lakes::Lakes;
use crate::lines::{distance, length_m, plane, resampled};
use crate::meander::meander;
use crate::network::{Network, Reach};
use eyot_core::{BoundaryCondition, Grid};

/// Steeper rivers do not meander, 1.
const MEANDER_SLOPE: f64 = 0.005;
/// Ground that lies at most so far above or below a reach is its flood plain, m.
const PLAIN_M: f32 = 2.0;
/// Shortest reach that has a pattern, widths.
const SHORTEST: f64 = 20.0;
/// Narrowest reach that has one, cells.
const NARROWEST: f64 = 0.25;
/// How far from its cells a reach's own ground goes at most, widths.
const FARTHEST: f64 = 16.0;
/// Belongs to no reach.
const NONE: u32 = u32::MAX;

/// What reaches wander over.
pub struct Ground<'a> {
    /// Lakes and surfaces.
    pub found: &'a Lakes,
    /// Cells.
    pub grid: &'a Grid,
    /// Of each cell the reach that it is nearest to; empty if none wanders.
    nearest: Vec<u32>,
}

/// How a reach may wander.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Freedom {
    /// Length over the straight way that meandering reaches come to.
    pub sinuosity: f64,
    /// Whether steep ones braid.
    pub braids: bool,
}

impl<'a> Ground<'a> {
    /// The ground of all reaches of `network`, `width(reach)` wide, m.
    pub fn new(
        found: &'a Lakes,
        grid: &'a Grid,
        network: &Network,
        freedom: Freedom,
        width: impl Fn(&Reach) -> f64,
    ) -> Self {
        let cell_m = grid.cell_x_m.min(grid.cell_y_m);
        let widest = network.reaches.iter().filter(|r| r.lake == 0).map(width).fold(0.0, f64::max);
        let mut nearest = Vec::new();
        if (freedom.sinuosity > 1.0 || freedom.braids) && widest >= NARROWEST * cell_m {
            nearest = near(network, grid, (FARTHEST * widest / cell_m).ceil() as usize);
        }
        Self { found, grid, nearest }
    }

    /// The course of reach `number` when it has taken its pattern.
    pub fn wandered(
        &self,
        number: u32,
        reach: &Reach,
        course: Course,
        width: f64,
        freedom: Freedom,
        seed: u64,
    ) -> Course {
        let (grid, found) = (self.grid, self.found);
        let (first, last) = (course.line[0], course.line[course.line.len() - 1]);
        let (length, fall) = (length_m(&course.line), f64::from(first[2]) - f64::from(last[2]));
        let cell_m = grid.cell_x_m.min(grid.cell_y_m);
        let room = length >= SHORTEST * width && width >= NARROWEST * cell_m;
        if reach.lake > 0 || self.nearest.is_empty() || !room {
            return course;
        }
        let braided = freedom.braids && braids(fall / length, reach.discharge);
        let meanders = !braided && freedom.sinuosity > 1.0 && fall <= MEANDER_SLOPE * length;
        if !(braided || meanders) {
            return course;
        }
        let at = |p: [f64; 2]| {
            let (x, y) = ((p[0] / grid.cell_x_m).floor(), (p[1] / grid.cell_y_m).floor());
            let inside = x >= 0.0 && y >= 0.0 && x < grid.width as f64 && y < grid.height as f64;
            inside.then(|| y as usize * grid.width + x as usize)
        };
        let flat =
            |i: usize| found.lake[i] == 0 && (last[2] - PLAIN_M..=first[2] + PLAIN_M).contains(&found.surface[i]);
        // Vertices are a width apart: what is free for half of one around each is free between them.
        let clear = 0.6 * width;
        let around = [[0.0, 0.0], [clear, 0.0], [-clear, 0.0], [0.0, clear], [0.0, -clear]];
        let own = |p: [f64; 2]| {
            around.iter().all(|d| at([p[0] + d[0], p[1] + d[1]]).is_some_and(|i| self.nearest[i] == number))
        };
        let plain = |p: [f64; 2]| own(p) && at(p).is_some_and(flat);
        let line: Vec<[f64; 2]> = course.line.iter().map(plane).collect();
        // Half of five widths to each side, by the axes.
        let wide = |p: &&[f64; 2]| {
            let off = 2.5 * width;
            let sides = [[off, 0.0], [-off, 0.0], [0.0, off], [0.0, -off]];
            sides.iter().all(|d| at([p[0] + d[0], p[1] + d[1]]).is_some_and(flat))
        };
        if 2 * line.iter().filter(wide).count() < line.len() {
            return course;
        }
        let (lines, bends, pattern) = if braided {
            (threads(&resampled(&line, width), width, seed, number, plain), Vec::new(), Pattern::Braided)
        } else {
            let wound = meander(&line, width, freedom.sinuosity, plain);
            (vec![wound.line], wound.oxbows, Pattern::Meandering)
        };
        // Heights fall evenly along the longer way.
        let parts = (lines[0].len() - 1) as f64;
        let place = |k: usize| (k as f64 / parts * (reach.cells.len() - 1) as f64) as f32;
        let height = |k: usize| {
            let at = course.place.partition_point(|p| *p < place(k)).min(course.line.len() - 1);
            course.line[at][2]
        };
        let raised = |line: &Vec<[f64; 2]>| -> Vec<[f32; 3]> {
            let vertex = |(k, p): (usize, &[f64; 2])| match k {
                0 => first,
                k if k + 1 == line.len() => last,
                k => [p[0] as f32, p[1] as f32, height(k)],
            };
            line.iter().enumerate().map(vertex).collect()
        };
        let mut threads: Vec<Vec<[f32; 3]>> = lines.iter().map(raised).collect();
        let line = threads.remove(0);
        let place = (0..line.len()).map(place).collect();
        let oxbows = bends.iter().filter_map(|bend| oxbow(bend, &line, width)).collect();
        Course { line, place, threads, oxbows, pattern }
    }
}

/// What is left of a bend that was cut off from the river `line`: the longest part that lies apart from it.
fn oxbow(bend: &[[f64; 2]], line: &[[f32; 3]], width: f64) -> Option<Oxbow> {
    let near = |p: &[f64; 2]| {
        let far = |v: &&[f32; 3]| distance(plane(v), *p);
        line.iter().min_by(|a, b| far(a).total_cmp(&far(b))).map(|v| (far(&v), v[2]))
    };
    let apart = |p: &[f64; 2]| near(p).is_some_and(|(far, _)| far > 1.5 * width);
    let part = bend.split(|p| !apart(p)).max_by_key(|part| part.len()).filter(|part| part.len() >= 5)?;
    let (_, level) = near(&part[part.len() / 2])?;
    Some(Oxbow { line: part.to_vec(), level })
}

/// Of each cell the reach whose cells are nearest, by steps along the axes, at most `steps` of them.
fn near(network: &Network, grid: &Grid, steps: usize) -> Vec<u32> {
    let (w, h) = (grid.width, grid.height);
    let mut nearest = vec![NONE; w * h];
    let mut front: Vec<u32> = Vec::new();
    for (k, reach) in network.reaches.iter().enumerate() {
        for &i in &reach.cells[..reach.cells.len() - 1] {
            if nearest[i as usize] == NONE {
                nearest[i as usize] = k as u32;
                front.push(i);
            }
        }
    }
    let beside = |v: usize, n: usize, rim: BoundaryCondition| {
        let wraps = rim == BoundaryCondition::Wrap;
        let before = if v > 0 { Some(v - 1) } else { wraps.then_some(n - 1) };
        let after = if v + 1 < n { Some(v + 1) } else { wraps.then_some(0) };
        [before, after]
    };
    for _ in 0..steps {
        let mut next = Vec::new();
        for &i in &front {
            let (x, y, own) = (i as usize % w, i as usize / w, nearest[i as usize]);
            let across = beside(x, w, grid.rim.x).into_iter().flatten().map(|x| y * w + x);
            let along = beside(y, h, grid.rim.y).into_iter().flatten().map(|y| y * w + x);
            for j in across.chain(along) {
                if nearest[j] == NONE {
                    nearest[j] = own;
                    next.push(j as u32);
                }
            }
        }
        front = next;
    }
    nearest
}
