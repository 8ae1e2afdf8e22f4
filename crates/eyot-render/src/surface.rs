//! The smooth surface that rays meet: cells refined by a cubic kernel, with a pyramid of maxima over it.

use crate::ground::Ground;
use rayon::prelude::*;

/// Refine until the longer side has about this many nodes: a node is then a pixel or two wide on screen.
const NODES: usize = 1000;
/// Finest refinement of a tiny grid.
const MAX_FACTOR: usize = 24;

/// Weights of four neighbouring values at the fraction `t` between the middle two.
pub(crate) type Kernel = fn(f32) -> [f32; 4];

/// Mitchell and Netravali's cubic (1/3, 1/3): C1, nearly interpolating, no ringing that the eye would find.
pub(crate) fn mitchell(t: f32) -> [f32; 4] {
    let near = |x: f32| (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0;
    let far = |x: f32| (-7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0;
    [far(1.0 + t), near(t), near(1.0 - t), far(2.0 - t)]
}

/// The cubic B-spline: C2, never outside the range of its values.
pub(crate) fn b_spline(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [
        s * s * s / 6.0,
        (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
        (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0,
        t * t * t / 6.0,
    ]
}

/// How a grid of cells maps to the finer grid of nodes.
#[derive(Clone, Copy)]
pub(crate) struct Refinement {
    pub(crate) cells: [usize; 2],
    pub(crate) factor: usize,
    pub(crate) nodes: [usize; 2],
}

impl Refinement {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let longer = width.max(height);
        let factor = if longer >= NODES { 1 } else { NODES.div_ceil(longer).min(MAX_FACTOR) };
        // A single row or column becomes a strip of its own width.
        let nodes = [width, height].map(|n| if n == 1 { factor + 1 } else { (n - 1) * factor + 1 });
        Self { cells: [width, height], factor, nodes }
    }

    /// Values at the nodes.
    pub(crate) fn refine(&self, values: &[f32], kernel: Kernel) -> Vec<f32> {
        let ([w, h], f) = (self.cells, self.factor);
        let [nx, ny] = self.nodes;
        let weights: Vec<[f32; 4]> = (0..f).map(|i| kernel(i as f32 / f as f32)).collect();
        let at = |i: isize, n: usize| i.clamp(0, n as isize - 1) as usize;
        let mut across = vec![0.0; nx * h];
        across.par_chunks_mut(nx).zip(values.par_chunks(w)).for_each(|(out, row)| {
            for (i, o) in out.iter_mut().enumerate() {
                let (c, k) = ((i / f) as isize, &weights[i % f]);
                *o = (0..4).map(|j| k[j] * row[at(c + j as isize - 1, w)]).sum();
            }
        });
        let mut out = vec![0.0; nx * ny];
        out.par_chunks_mut(nx).enumerate().for_each(|(j, line)| {
            let (c, k) = ((j / f) as isize, &weights[j % f]);
            let rows: [&[f32]; 4] = std::array::from_fn(|i| &across[at(c + i as isize - 1, h) * nx..][..nx]);
            for (i, o) in line.iter_mut().enumerate() {
                *o = k[0] * rows[0][i] + k[1] * rows[1][i] + k[2] * rows[2][i] + k[3] * rows[3][i];
            }
        });
        out
    }
}

/// One level of the pyramid: maxima over squares of `2^level` node intervals.
struct Level {
    width: usize,
    max: Vec<f32>,
}

/// A height field in node coordinates (column, row) with heights in metres as drawn.
pub(crate) struct Surface {
    pub(crate) nx: usize,
    pub(crate) ny: usize,
    /// Distance of nodes, m.
    pub(crate) step: [f32; 2],
    pub(crate) z: Vec<f32>,
    pub(crate) top: f32,
    levels: Vec<Level>,
}

impl Surface {
    /// The surface of `z` (already refined), exaggerated by the caller.
    pub(crate) fn new(g: &Ground, r: &Refinement, z: Vec<f32>) -> Self {
        Self::with_step([g.cell[0] / r.factor as f32, g.cell[1] / r.factor as f32], r, z)
    }

    /// The surface of `z` on nodes that are `step` m apart.
    pub(crate) fn with_step(step: [f32; 2], r: &Refinement, z: Vec<f32>) -> Self {
        let [nx, ny] = r.nodes;
        let (w0, h0) = (nx - 1, ny - 1);
        let mut max = vec![0.0; w0 * h0];
        max.par_chunks_mut(w0).enumerate().for_each(|(y, row)| {
            let (a, b) = (&z[y * nx..][..nx], &z[(y + 1) * nx..][..nx]);
            row.iter_mut().enumerate().for_each(|(x, m)| *m = a[x].max(a[x + 1]).max(b[x]).max(b[x + 1]));
        });
        let mut levels = vec![Level { width: w0, max }];
        let (mut w, mut h) = (w0, h0);
        while w > 1 || h > 1 {
            let below = &levels[levels.len() - 1];
            let (nw, nh) = (w.div_ceil(2), h.div_ceil(2));
            let max = (0..nw * nh)
                .map(|i| {
                    let (x, y) = (2 * (i % nw), 2 * (i / nw));
                    let (x1, y1) = ((x + 1).min(w - 1), (y + 1).min(h - 1));
                    let at = |x: usize, y: usize| below.max[y * w + x];
                    at(x, y).max(at(x1, y)).max(at(x, y1)).max(at(x1, y1))
                })
                .collect();
            levels.push(Level { width: nw, max });
            (w, h) = (nw, nh);
        }
        let top = levels[levels.len() - 1].max[0];
        Self { nx, ny, step, z, top, levels }
    }

    /// Level ground of a single interval.
    pub(crate) fn flat() -> Self {
        Self::with_step([1.0; 2], &Refinement { cells: [2; 2], factor: 1, nodes: [2; 2] }, vec![0.0; 4])
    }

    /// East-west and north-south extent, m.
    pub(crate) fn extent(&self) -> [f32; 2] {
        [(self.nx - 1) as f32 * self.step[0], (self.ny - 1) as f32 * self.step[1]]
    }

    /// Column, row and fractions of the interval that holds the node coordinates, clamped to the grid.
    pub(crate) fn interval(&self, u: f32, v: f32) -> (usize, usize, f32, f32) {
        let u = u.clamp(0.0, (self.nx - 1) as f32);
        let v = v.clamp(0.0, (self.ny - 1) as f32);
        let (x, y) = ((u as usize).min(self.nx - 2), (v as usize).min(self.ny - 2));
        (x, y, u - x as f32, v - y as f32)
    }

    /// Height at node coordinates, those outside clamped to the rim.
    pub(crate) fn height(&self, u: f32, v: f32) -> f32 {
        let (x, y, fx, fy) = self.interval(u, v);
        let i = y * self.nx + x;
        let (a, b, c, d) = (self.z[i], self.z[i + 1], self.z[i + self.nx], self.z[i + self.nx + 1]);
        let top = a + (b - a) * fx;
        top + (c + (d - c) * fx - top) * fy
    }

    /// Largest height in the square of `2^level` intervals that holds the interval (x, y).
    pub(crate) fn block_max(&self, level: usize, x: usize, y: usize) -> f32 {
        let level = level.min(self.levels.len() - 1);
        let l = &self.levels[level];
        l.max[(y >> level) * l.width + (x >> level)]
    }

    /// Where the ray `origin + t direction` (node coordinates and m) first goes below the surface, for t in `from..to`.
    ///
    /// The ray walks through the squares of the pyramid: above a square's maximum it leaves the square in one step and
    /// tries a larger one, else it looks into the smaller ones; in a single interval the bilinear patch gives a
    /// quadratic in t.
    pub(crate) fn trace(&self, origin: [f64; 3], dir: [f64; 3], from: f64, to: f64) -> Option<f64> {
        let (w, h) = ((self.nx - 1) as i64, (self.ny - 1) as i64);
        let inverse = [1.0 / dir[0], 1.0 / dir[1]];
        let start_level = 4.min(self.levels.len() - 1);
        let mut level = start_level;
        let mut t = from;
        let nudge = 1e-5 / (dir[0].abs() + dir[1].abs() + 1e-9);
        // Every step leaves a square, so the count is bounded by the path; the bound only guards against NaN.
        for _ in 0..8 * (w + h) + 64 {
            if t > to {
                return None;
            }
            let inside = t + nudge;
            let at = |axis: usize, n: i64| {
                let p = origin[axis] + dir[axis] * inside;
                let i = p as i64 - i64::from(p < 0.0);
                // A ray that comes in through the rim may start a rounding error outside.
                if i == n && dir[axis] < 0.0 {
                    n - 1
                } else if i == -1 && dir[axis] > 0.0 {
                    0
                } else {
                    i
                }
            };
            let (x, y) = (at(0, w), at(1, h));
            if x < 0 || y < 0 || x >= w || y >= h {
                return None;
            }
            loop {
                let (cx, cy) = (x >> level, y >> level);
                let exit = |c: i64, axis: usize| {
                    if dir[axis] == 0.0 {
                        return f64::INFINITY;
                    }
                    let edge = if dir[axis] > 0.0 { (c + 1) << level } else { c << level };
                    (edge as f64 - origin[axis]) * inverse[axis]
                };
                let out = exit(cx, 0).min(exit(cy, 1)).max(t).min(to);
                let z = origin[2] + dir[2] * if dir[2] < 0.0 { out } else { t };
                let l = &self.levels[level];
                if z > f64::from(l.max[cy as usize * l.width + cx as usize]) {
                    if out >= to {
                        return None;
                    }
                    t = out;
                    level = (level + 1).min(self.levels.len() - 1);
                    break;
                }
                if level == 0 {
                    if let Some(hit) = self.patch(x as usize, y as usize, origin, dir, t, out) {
                        return Some(hit);
                    }
                    if out >= to {
                        return None;
                    }
                    t = out;
                    level = 1.min(self.levels.len() - 1);
                    break;
                }
                level -= 1;
            }
            t += nudge;
        }
        None
    }

    /// The ray against one bilinear patch, for t in `from..to`.
    fn patch(&self, x: usize, y: usize, o: [f64; 3], d: [f64; 3], from: f64, to: f64) -> Option<f64> {
        let i = y * self.nx + x;
        let z = |k: usize| f64::from(self.z[k]);
        let a = z(i);
        let (b, c) = (z(i + 1) - a, z(i + self.nx) - a);
        let e = z(i + self.nx + 1) - z(i + 1) - c;
        let (u, v) = (o[0] + d[0] * from - x as f64, o[1] + d[1] * from - y as f64);
        // f(s) = ray height - patch height at t = from + s: q2 s^2 + q1 s + q0.
        let q0 = o[2] + d[2] * from - (a + b * u + c * v + e * u * v);
        if q0 <= 0.0 {
            return Some(from);
        }
        let q1 = d[2] - b * d[0] - c * d[1] - e * (u * d[1] + v * d[0]);
        let q2 = -e * d[0] * d[1];
        let s = to - from;
        if q0 + s * (q1 + s * q2) > 0.0 && (q2 <= 0.0 || q1 >= 0.0 || -q1 >= 2.0 * q2 * s) {
            return None;
        }
        let disc = q1 * q1 - 4.0 * q2 * q0;
        if disc < 0.0 {
            return None;
        }
        // The first root, in the form that does not cancel.
        let root = 2.0 * q0 / (-q1 + disc.sqrt());
        (root >= 0.0 && root <= s).then_some(from + root)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_noise::picture::fbm;

    fn hills(n: usize) -> Surface {
        let z = (0..n * n).map(|i| 20.0 * fbm((i % n) as f32 * 0.11, (i / n) as f32 * 0.13, 4, 3)).collect();
        Surface::with_step([1.0, 1.0], &Refinement { cells: [n, n], factor: 1, nodes: [n, n] }, z)
    }

    #[test]
    fn kernels_sum_to_one() {
        for k in [mitchell, b_spline] {
            for i in 0..=10 {
                let sum: f32 = k(i as f32 / 10.0).iter().sum();
                assert!((sum - 1.0).abs() < 1e-5, "{sum}");
            }
        }
    }

    #[test]
    fn rays_hit_where_small_steps_find_the_surface() {
        let s = hills(65);
        let mut hits = 0;
        for k in 0..200 {
            let (sin, cos) = (k as f64 * 0.37).sin_cos();
            let o = [32.0 - 31.0 * cos, 32.0 - 31.0 * sin, 22.0 + (k % 7) as f64];
            let d = [cos, sin, -0.2 - 0.004 * k as f64];
            let found = s.trace(o, d, 0.0, 1e3);
            let z = |t: f64| o[2] + d[2] * t - f64::from(s.height((o[0] + d[0] * t) as f32, (o[1] + d[1] * t) as f32));
            let inside = |t: f64| (0..2).all(|a| (0.0..=64.0).contains(&(o[a] + d[a] * t)));
            let walked = (0..80_000).map(|i| i as f64 * 1e-3).take_while(|t| inside(*t)).find(|t| z(*t) <= 0.0);
            match (found, walked) {
                (Some(a), Some(b)) => {
                    assert!((a - b).abs() < 2e-2, "ray {k}: {a} but {b}");
                    hits += 1;
                }
                (None, None) => {}
                other => panic!("ray {k}: {other:?}"),
            }
        }
        assert!(hits > 100, "{hits}");
    }

    #[test]
    fn refinement_keeps_a_plane() {
        let r = Refinement::new(40, 30);
        let plane: Vec<f32> = (0..1200).map(|i| 2.0 * (i % 40) as f32 - (i / 40) as f32).collect();
        let fine = r.refine(&plane, b_spline);
        let [nx, ny] = r.nodes;
        for (x, y) in [(nx / 2, ny / 2), (nx / 3, ny / 4)] {
            let exact = (2.0 * x as f32 - y as f32) / r.factor as f32;
            assert!((fine[y * nx + x] - exact).abs() < 1e-3);
        }
    }
}
