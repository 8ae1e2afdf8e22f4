//! Courses: smooth lines through the cells of reaches.
//!
//! # Rule
//! 1. Ways from cell to cell know eight directions, rivers know all. Each cell's point is moved by lot within half a cell each way, the same for
//!    every reach that touches it, so that junctions stay joined; then the points between the ends are smoothed three times by
//!    (1, 2, 1)/4. No point ends further than half a cell from the middle of its cell.
//! 2. Between points the line is a centripetal Catmull-Rom spline, which has neither loops nor cusps (Yuksel, Schaefer & Keyser 2011).
//! 3. Heights are those of the cells, between them linear: where the water's surface never rises from cell to cell, the line never
//!    does.

use crate::lines::{distance, smooth};
use eyot_core::Grid;
use eyot_core::rng::{Key, hash, unit};
use eyot_drainage::{Routing, STEPS};

/// How a reach runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pattern {
    /// As the land leads it.
    #[default]
    Led,
    /// In bends that it made itself.
    Meandering,
    /// In several threads.
    Braided,
}

/// A bend that was cut off from its river.
#[derive(Clone, Debug, PartialEq)]
pub struct Oxbow {
    /// The middle of its water: m east, m south.
    pub line: Vec<[f64; 2]>,
    /// Height of its water, m.
    pub level: f32,
}

/// The line of a reach.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    /// m east, m south, height of the water, m.
    pub line: Vec<[f32; 3]>,
    /// For each vertex the place in the reach's cells, 0 at the first.
    pub place: Vec<f32>,
    /// Its further threads, vertex by vertex beside `line`, if it braids.
    pub threads: Vec<Vec<[f32; 3]>>,
    /// Lakes that its bends left behind.
    pub oxbows: Vec<Oxbow>,
    /// How it runs.
    pub pattern: Pattern,
}

impl Course {
    /// All its threads.
    pub fn lines(&self) -> impl Iterator<Item = &[[f32; 3]]> {
        std::iter::once(&self.line).chain(&self.threads).map(Vec::as_slice)
    }

    /// How many threads share its water.
    pub fn thread_count(&self) -> usize {
        1 + self.threads.len()
    }
}

/// How far the middle of a cell is moved at most, cells.
const LOT: f64 = 0.5;
/// How far a point of a line may lie from the middle of its cell, cells.
const AWAY: f64 = 0.5;
/// Stream of random numbers.
const STREAM: u32 = 0x5249_5645;
/// Parts that the line between two cells is cut in.
const PARTS: usize = 2;

/// The course of the reach through `cells`, each the receiver of the one before it.
pub fn course(cells: &[u32], grid: &Grid, routing: &Routing, surface: &[f32], seed: u64) -> Course {
    let (key_x, key_y) = (Key::new(seed, STREAM, 0), Key::new(seed, STREAM, 1));
    let lot = |key: Key, i: u32| LOT * (2.0 * f64::from(unit::<f32>(hash(key, i))) - 1.0);
    let (mut x, mut y) = (cells[0] as usize % grid.width, cells[0] as usize / grid.width);
    let (mut x_m, mut y_m) = (x as f64 + 0.5, y as f64 + 0.5);
    let mut middle = Vec::with_capacity(cells.len());
    let mut points = Vec::with_capacity(cells.len());
    for (k, &i) in cells.iter().enumerate() {
        if k > 0 {
            let d = usize::from(routing.directions()[cells[k - 1] as usize]);
            // Across a wrapping rim the line goes on beyond it.
            (x_m, y_m) = (x_m + STEPS[d].0 as f64, y_m + STEPS[d].1 as f64);
            (x, y) = (i as usize % grid.width, i as usize / grid.width);
        }
        let edge = x == 0 || y == 0 || x + 1 == grid.width || y + 1 == grid.height;
        let moved = if edge { [x_m, y_m] } else { [x_m + lot(key_x, i), y_m + lot(key_y, i)] };
        middle.push([x_m, y_m]);
        points.push(moved);
    }
    for _ in 0..3 {
        smooth(&mut points);
    }
    for (p, m) in points.iter_mut().zip(&middle) {
        let (dx, dy) = (p[0] - m[0], p[1] - m[1]);
        let away = distance(*p, *m);
        if away > AWAY {
            *p = [m[0] + dx * AWAY / away, m[1] + dy * AWAY / away];
        }
    }
    let mut found = Course::default();
    let last = points.len() - 1;
    let mut height = f32::INFINITY;
    let mut push = |p: [f64; 2], place: f64| {
        let (k, t) = ((place as usize).min(last), place.fract() as f32);
        let (a, b) = (surface[cells[k] as usize], surface[cells[(k + 1).min(last)] as usize]);
        height = height.min(a + (b - a) * t);
        found.line.push([(p[0] * grid.cell_x_m) as f32, (p[1] * grid.cell_y_m) as f32, height]);
        found.place.push(place as f32);
    };
    for k in 0..last {
        let before = if k > 0 { points[k - 1] } else { beyond(points[0], points[1]) };
        let after = if k + 2 <= last { points[k + 2] } else { beyond(points[k + 1], points[k]) };
        for part in 0..PARTS {
            let t = part as f64 / PARTS as f64;
            push(spline([before, points[k], points[k + 1], after], t), k as f64 + t);
        }
    }
    push(points[last], last as f64);
    found
}

/// The mirror of `b` at `a`.
fn beyond(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [2.0 * a[0] - b[0], 2.0 * a[1] - b[1]]
}

/// The centripetal Catmull-Rom spline between the two middle ones of four points, at 0 <= t <= 1.
fn spline(p: [[f64; 2]; 4], t: f64) -> [f64; 2] {
    if t == 0.0 {
        return p[1];
    }
    let gap = |a: [f64; 2], b: [f64; 2]| distance(a, b).sqrt().max(1e-3);
    let t1 = gap(p[0], p[1]);
    let t2 = t1 + gap(p[1], p[2]);
    let t3 = t2 + gap(p[2], p[3]);
    let t = t1 + t * (t2 - t1);
    let mix = |a: [f64; 2], b: [f64; 2], from: f64, to: f64| {
        [0, 1].map(|c| ((to - t) * a[c] + (t - from) * b[c]) / (to - from))
    };
    let (a1, a2, a3) = (mix(p[0], p[1], 0.0, t1), mix(p[1], p[2], t1, t2), mix(p[2], p[3], t2, t3));
    let (b1, b2) = (mix(a1, a2, 0.0, t2), mix(a2, a3, t1, t3));
    mix(b1, b2, t1, t2)
}
