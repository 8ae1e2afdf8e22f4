//! Which patches of the ground a picture needs, and how fine each.
//!
//! A quadtree after Strugar (2009), "Continuous distance-dependent level of detail for rendering heightmaps": level `l` serves
//! distances up to `range 2^l`, and its vertices morph into level `l + 1` over the last part of that range. Two conditions keep it
//! free of cracks: neighbours differ by one level at most, and where they meet the finer one has morphed wholly and the coarser one
//! not yet. Both hold if a range is at least four patches long and morphing begins after `1/2 + sqrt 2 patch / range` of it.

use crate::levels::{Levels, PATCH};
use eyot_render::Camera;

/// Least range of the finest level, in its own patches.
const LEAST_RANGE: f32 = 4.0;
/// Longest edge of a triangle, pixels.
const EDGE_PIXELS: f32 = 2.0;

/// Lowest and highest heights over squares of patches, level by level.
pub(crate) struct Bounds {
    levels: Vec<Row>,
}

struct Row {
    columns: usize,
    spans: Vec<[f32; 2]>,
}

impl Bounds {
    /// Bounds of the surface that the B-spline makes of `tops` (cells), `factor` nodes a cell.
    pub(crate) fn new(levels: &Levels, tops: &[f32], cells: [usize; 2], factor: usize) -> Self {
        let [columns, rows] = Self::patches(levels);
        // A node depends on the cells around it, two to each side; a vertex of the next level on one node more.
        let range = |i: usize, n: usize| {
            let (a, b) = (i * PATCH as usize / factor, (i + 1) * PATCH as usize / factor);
            a.saturating_sub(3).min(n - 1)..(b + 4).min(n)
        };
        let span = |x: usize, y: usize| {
            let mut s = [f32::INFINITY, f32::NEG_INFINITY];
            for row in range(y, cells[1]) {
                for z in &tops[row * cells[0]..][range(x, cells[0])] {
                    s = [s[0].min(*z), s[1].max(*z)];
                }
            }
            s
        };
        Self::over(levels, (0..columns * rows).map(|i| span(i % columns, i / columns)).collect())
    }

    /// Columns and rows of patches of the finest level.
    pub(crate) fn patches(levels: &Levels) -> [usize; 2] {
        [0, 1].map(|k| patches(levels, 0, k))
    }

    /// Bounds over those of the patches of the finest level.
    pub(crate) fn over(levels: &Levels, spans: Vec<[f32; 2]>) -> Self {
        let mut all = vec![Row { columns: patches(levels, 0, 0), spans }];
        for l in 1..=levels.top() {
            let below = &all[l - 1];
            let (columns, rows) = (patches(levels, l, 0), patches(levels, l, 1));
            let below_rows = below.spans.len() / below.columns;
            let span = |x: usize, y: usize| {
                let mut s = [f32::INFINITY, f32::NEG_INFINITY];
                for y in 2 * y..(2 * y + 2).min(below_rows) {
                    for x in 2 * x..(2 * x + 2).min(below.columns) {
                        let b = below.spans[y * below.columns + x];
                        s = [s[0].min(b[0]), s[1].max(b[1])];
                    }
                }
                s
            };
            let spans = (0..columns * rows).map(|i| span(i % columns, i / columns)).collect();
            all.push(Row { columns, spans });
        }
        Self { levels: all }
    }

    /// Lowest and highest height of all.
    pub(crate) fn whole(&self) -> [f32; 2] {
        let top = &self.levels[self.levels.len() - 1];
        top.spans.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |s, b| [s[0].min(b[0]), s[1].max(b[1])])
    }

    fn of(&self, level: usize, x: usize, y: usize) -> [f32; 2] {
        let row = &self.levels[level];
        row.spans[y * row.columns + x]
    }

    fn size(&self, level: usize) -> [usize; 2] {
        let row = &self.levels[level];
        [row.columns, row.spans.len() / row.columns]
    }
}

/// Patches along an axis of a level.
fn patches(levels: &Levels, level: usize, axis: usize) -> usize {
    levels.places[level][2 + axis].max(1).div_ceil(PATCH) as usize
}

/// What a picture draws of the ground.
#[derive(Default)]
pub(crate) struct Detail {
    /// First vertex (column, row in its level), level, 0: one for each patch.
    pub(crate) patches: Vec<[u32; 4]>,
    /// The same with the side of the grid (0 west, 1 east, 2 north, 3 south): one for each strip of a relief model's walls.
    pub(crate) walls: Vec<[u32; 4]>,
    /// Range of the finest level, m.
    pub(crate) range: f32,
    /// Share of a range where morphing begins.
    pub(crate) morph: f32,
    /// Square of the camera's height over the surface, m2.
    pub(crate) over: f32,
}

/// What a selection looks at.
pub(crate) struct Look<'a> {
    pub(crate) levels: &'a Levels,
    pub(crate) bounds: &'a Bounds,
    /// Distance of nodes, m.
    pub(crate) step: [f32; 2],
    pub(crate) camera: &'a Camera,
    /// Columns and rows of the picture.
    pub(crate) size: [u32; 2],
    /// What lies below this height is hidden.
    pub(crate) hidden_below: f32,
    /// Base of the walls, if there are any.
    pub(crate) base: Option<f32>,
}

impl Look<'_> {
    /// The patches that the camera sees.
    pub(crate) fn select(&self) -> Detail {
        let step = self.step[0].max(self.step[1]);
        let patch = PATCH as f32 * step;
        let pixel = self.camera.pixel(self.size[1] as usize);
        // At the near end of its range an edge of level l, step 2^l long, is range 2^(l-1) away.
        let range = (2.0 * step / (EDGE_PIXELS * pixel)).max(LEAST_RANGE * patch);
        let over = (self.camera.eye[2] - self.bounds.whole()[1]).max(0.0);
        let morph = 0.5 + 1.5 * patch / range;
        let mut out = Detail { range, morph, over: over * over, ..Detail::default() };
        let planes = self.planes();
        let [columns, rows] = self.bounds.size(self.levels.top());
        for y in 0..rows {
            for x in 0..columns {
                self.descend(self.levels.top(), x, y, &planes, &mut out);
            }
        }
        out
    }

    fn descend(&self, level: usize, x: usize, y: usize, planes: &[[f32; 3]; 5], out: &mut Detail) {
        let span = self.bounds.of(level, x, y);
        let side = (PATCH as usize) << level;
        let place = |k: usize, i: usize| (i * side).min(self.levels.nodes[k] as usize - 1) as f32 * self.step[k];
        let low = [place(0, x), place(1, y), self.base.unwrap_or(span[0])];
        let high = [place(0, x + 1), place(1, y + 1), span[1].max(if self.base.is_some() { 0.0 } else { span[0] })];
        if planes.iter().any(|p| self.beyond(p, &low, &high)) {
            return;
        }
        let off = |k: usize| (low[k] - self.camera.eye[k]).max(self.camera.eye[k] - high[k]).max(0.0);
        let distance = (off(0) * off(0) + off(1) * off(1) + out.over).sqrt();
        if level > 0 && distance <= out.range * (1u64 << (level - 1)) as f32 {
            let [columns, rows] = self.bounds.size(level - 1);
            for y in 2 * y..(2 * y + 2).min(rows) {
                for x in 2 * x..(2 * x + 2).min(columns) {
                    self.descend(level - 1, x, y, planes, out);
                }
            }
            return;
        }
        let [fx, fy] = [x as u32 * PATCH, y as u32 * PATCH];
        if span[1] > self.hidden_below {
            out.patches.push([fx, fy, level as u32, 0]);
        }
        if self.base.is_some() {
            let last = self.levels.places[level];
            let sides = [x == 0, fx + PATCH >= last[2], y == 0, fy + PATCH >= last[3]];
            out.walls.extend((0..4u32).filter(|s| sides[*s as usize]).map(|s| [fx, fy, level as u32, s]));
        }
    }

    /// Inward normals of the planes through the eye, and the one that looks forward.
    fn planes(&self) -> [[f32; 3]; 5] {
        let c = self.camera;
        let (up, right) = (c.tan, c.tan * self.size[0] as f32 / self.size[1] as f32);
        let lean = |a: [f32; 3], sign: f32, tan: f32| std::array::from_fn(|k| sign * a[k] + tan * c.forward[k]);
        [lean(c.right, 1.0, right), lean(c.right, -1.0, right), lean(c.up, 1.0, up), lean(c.up, -1.0, up), c.forward]
    }

    /// True if the box lies wholly on the outer side of a plane through the eye.
    fn beyond(&self, plane: &[f32; 3], low: &[f32; 3], high: &[f32; 3]) -> bool {
        let farthest: f32 =
            (0..3).map(|k| plane[k] * (if plane[k] > 0.0 { high[k] } else { low[k] } - self.camera.eye[k])).sum();
        farthest < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn detail(n: u32, eye: [f32; 3], target: [f32; 3]) -> (Levels, Detail) {
        let levels = Levels::new([n, n]);
        let tops = vec![1.0; (n * n) as usize];
        let bounds = Bounds::new(&levels, &tops, [n as usize; 2], 1);
        let camera = Camera::looking(eye, target, 60.0);
        let look = Look {
            levels: &levels,
            bounds: &bounds,
            step: [1.0; 2],
            camera: &camera,
            size: [512, 512],
            hidden_below: f32::NEG_INFINITY,
            base: None,
        };
        let detail = look.select();
        (levels, detail)
    }

    #[test]
    fn patches_cover_the_view_once_and_neighbours_differ_by_one_level() {
        let n = 1025;
        let (levels, d) = detail(n, [512.0, 1100.0, 60.0], [512.0, 500.0, 0.0]);
        let mut level_of = vec![u32::MAX; 32 * 32];
        for [x, y, level, _] in &d.patches {
            let side = 1usize << level;
            let (x, y) = ((*x / PATCH) as usize * side, (*y / PATCH) as usize * side);
            for y in y..(y + side).min(32) {
                for x in x..(x + side).min(32) {
                    assert_eq!(level_of[y * 32 + x], u32::MAX, "patch ({x}, {y}) is drawn twice");
                    level_of[y * 32 + x] = *level;
                }
            }
        }
        let distinct: std::collections::BTreeSet<_> = d.patches.iter().map(|p| p[2]).collect();
        assert!(distinct.len() >= 3 && levels.top() == 5, "{distinct:?}");
        for y in 0..32 {
            for x in 0..31 {
                let (a, b) = (level_of[y * 32 + x], level_of[y * 32 + x + 1]);
                assert!(a == u32::MAX || b == u32::MAX || a.abs_diff(b) <= 1, "({x}, {y}): {a} beside {b}");
            }
        }
    }

    #[test]
    fn what_lies_behind_is_left_out() {
        let (_, towards) = detail(513, [256.0, 700.0, 50.0], [256.0, 0.0, 0.0]);
        let (_, away) = detail(513, [256.0, 700.0, 50.0], [256.0, 1400.0, 0.0]);
        assert!(!towards.patches.is_empty() && away.patches.is_empty());
    }

    #[test]
    fn finer_where_it_is_near() {
        let (_, d) = detail(2049, [0.0, 0.0, 3.0], [1000.0, 1000.0, 0.0]);
        assert!(d.patches.iter().any(|p| p[..3] == [0, 0, 0]), "the patch at the camera is the finest");
        assert!(d.patches.len() < 800, "{}", d.patches.len());
        assert!(d.morph < 0.9 && d.range >= 4.0 * PATCH as f32);
    }

    #[test]
    fn the_picture_bounds_the_work_and_not_the_world() {
        for n in [257, 1025, 4097] {
            let side = n as f32;
            for (eye, target) in [
                // The usual view, one from low over the rim, and one straight down.
                ([0.5 * side, 1.5 * side, 0.35 * side], [0.5 * side, 0.5 * side, 0.0]),
                ([0.5 * side, side, 5.0], [0.5 * side, 0.0, 0.0]),
                ([0.5 * side, 0.501 * side, side], [0.5 * side, 0.5 * side, 0.0]),
            ] {
                let (_, d) = detail(n, eye, target);
                let vertices = d.patches.len() as u32 * (PATCH + 1) * (PATCH + 1);
                println!("{n} nodes a side: {} patches, {vertices} vertices", d.patches.len());
                assert!((1..600_000).contains(&vertices), "{vertices} vertices for {n} nodes a side");
            }
        }
    }
}
