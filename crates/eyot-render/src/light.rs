//! Light that reaches each place of the ground: soft shadows of the sun and the open share of the sky.
//!
//! Both come from horizons. The height of the horizon towards the sun is continuous along the ground, so the
//! shadow's edge that is read from it is smooth between cells, and nothing can shade itself by rounding.

use crate::math::smoothstep;
use crate::surface::Surface;
use rayon::prelude::*;

/// Half width of the penumbra, as an angle. The sun's disc has 0.27 degrees; a little more hides the grid.
pub const PENUMBRA_DEG: f32 = 0.9;

/// The direction to the sun in node coordinates.
#[derive(Clone, Copy)]
pub(crate) struct Sun {
    /// Node coordinates per metre of horizontal way.
    along: [f32; 2],
    tan_low: f32,
    tan_high: f32,
}

impl Sun {
    pub(crate) fn new(s: &Surface, azimuth_deg: f32, elevation_deg: f32) -> Self {
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        let tan = |e: f32| e.clamp(-89.0, 89.0).to_radians().tan();
        Self {
            along: [sin / s.step[0], -cos / s.step[1]],
            tan_low: tan(elevation_deg - PENUMBRA_DEG),
            tan_high: tan(elevation_deg + PENUMBRA_DEG),
        }
    }

    /// How far the sun's disc stands above the horizon of a point at height `z`, 0..1 from its low to its high edge.
    fn above_horizon(&self, s: &Surface, u: f32, v: f32, z: f32) -> f32 {
        let quick = self.along[0].abs().max(self.along[1].abs());
        let step = 1.0 / quick;
        let (w, h) = (s.nx as f32 - 1.0, s.ny as f32 - 1.0);
        let mut horizon = self.tan_low;
        let mut way = 1.5 * step;
        let mut level = 3;
        loop {
            let (pu, pv) = (u + self.along[0] * way, v + self.along[1] * way);
            let line = z + horizon * way;
            if line > s.top || !(pu >= 0.0 && pv >= 0.0 && pu < w && pv < h) {
                break;
            }
            let (x, y) = (pu as usize, pv as usize);
            if line > s.block_max(level, x, y) {
                // Leave the block: nothing in it reaches the line, which only rises. Then try a larger one.
                let exit = |i: usize, p: f32, a: f32| {
                    let edge = if a > 0.0 { ((i >> level) + 1) << level } else { (i >> level) << level };
                    if a == 0.0 { f32::INFINITY } else { (edge as f32 - p) / a }
                };
                way += exit(x, pu, self.along[0]).min(exit(y, pv, self.along[1])).max(0.0) + 0.05 * step;
                level = (level + 1).min(9);
                continue;
            }
            if level > 1 {
                level -= 1;
                continue;
            }
            let tan = (s.height(pu, pv) - z) / way;
            if tan > horizon {
                horizon = tan;
                if horizon >= self.tan_high {
                    return 0.0;
                }
            }
            // Far away a node covers less of the penumbra.
            way += step * (1.0 + 0.01 * way / step);
        }
        (self.tan_high - horizon) / (self.tan_high - self.tan_low)
    }
}

/// Values on every `stride`-th node, read between them.
pub(crate) struct Coarse {
    nx: usize,
    ny: usize,
    stride: usize,
    values: Vec<f32>,
}

impl Coarse {
    /// Computes the values from their node coordinates, about `side` of them along the longer side.
    fn new(s: &Surface, side: usize, value: impl Fn(usize, usize) -> f32 + Sync) -> Self {
        let stride = ((s.nx.max(s.ny) + side / 2) / side).max(1);
        let [nx, ny] = [s.nx, s.ny].map(|n| (n - 1).div_ceil(stride) + 1);
        let mut values = vec![0.0; nx * ny];
        values.par_chunks_mut(nx).enumerate().for_each(|(y, row)| {
            row.iter_mut().enumerate().for_each(|(x, v)| *v = value(x * stride, y * stride));
        });
        Self { nx, ny, stride, values }
    }

    /// The value at node coordinates; those outside are clamped to the rim.
    pub(crate) fn at(&self, u: f32, v: f32) -> f32 {
        let k = 1.0 / self.stride as f32;
        let u = (u * k).clamp(0.0, (self.nx - 1) as f32);
        let v = (v * k).clamp(0.0, (self.ny - 1) as f32);
        let (x, y) = (u as usize, v as usize);
        let (x1, y1) = ((x + 1).min(self.nx - 1), (y + 1).min(self.ny - 1));
        let (fx, fy) = (u - x as f32, v - y as f32);
        let at = |x: usize, y: usize| self.values[y * self.nx + x];
        let top = at(x, y) + (at(x1, y) - at(x, y)) * fx;
        let low = at(x, y1) + (at(x1, y1) - at(x, y1)) * fx;
        top + (low - top) * fy
    }
}

/// Share of the sun's disc in view at every node, 0..1; `floor` lifts what lies lower (the sea's surface).
///
/// What is interpolated is the horizon, which has no edges; the shadow's edge is cut from it afterwards.
pub(crate) fn sunlight(s: &Surface, sun: &Sun, floor: f32) -> Vec<f32> {
    let above = Coarse::new(s, 512, |x, y| {
        let (u, v) = (x as f32, y as f32);
        sun.above_horizon(s, u, v, s.height(u, v).max(floor))
    });
    let mut out = vec![1.0; s.nx * s.ny];
    out.par_chunks_mut(s.nx).enumerate().for_each(|(y, row)| {
        row.iter_mut().enumerate().for_each(|(x, o)| *o = smoothstep(0.0, 1.0, above.at(x as f32, y as f32)));
    });
    out
}

/// Directions in which the sky's horizon is looked for.
const DIRECTIONS: usize = 12;
/// Distances of the look, in steps of the coarse grid.
const REACH: [f32; 9] = [1.0, 2.0, 3.2, 5.0, 8.0, 13.0, 21.0, 34.0, 55.0];

/// Open share of the sky, 0..1.
pub(crate) fn sky_share(s: &Surface, floor: f32) -> Coarse {
    let ground = Coarse::new(s, 400, |x, y| s.height(x as f32, y as f32).max(floor));
    let (nx, ny, stride) = (ground.nx, ground.ny, ground.stride);
    let least = 0.25 * (s.step[0] + s.step[1]) * stride as f32;
    let mut looks = [[(0isize, 0isize, 0.0f32); REACH.len()]; DIRECTIONS];
    for (k, row) in looks.iter_mut().enumerate() {
        let (sin, cos) = ((k as f32 + 0.3) * std::f32::consts::TAU / DIRECTIONS as f32).sin_cos();
        for (l, r) in row.iter_mut().zip(REACH) {
            let (dx, dy) = ((sin * r).round(), (cos * r).round());
            let way = (dx * s.step[0]).hypot(dy * s.step[1]) * stride as f32;
            *l = (dx as isize, dy as isize, 1.0 / way.max(least));
        }
    }
    let z = &ground.values;
    let values = (0..ny)
        .into_par_iter()
        .flat_map_iter(|y| (0..nx).map(move |x| (x, y)))
        .map(|(x, y)| {
            let here = z[y * nx + x];
            let mut sum = 0.0;
            for direction in &looks {
                let mut tan = 0.0f32;
                for &(dx, dy, inverse) in direction {
                    let (px, py) = (x as isize + dx, y as isize + dy);
                    if px < 0 || py < 0 || px >= nx as isize || py >= ny as isize {
                        break;
                    }
                    tan = tan.max((z[py as usize * nx + px as usize] - here) * inverse);
                }
                // Cosine weighted sky above the horizon: 1 - sin^2.
                sum += 1.0 / (1.0 + tan * tan);
            }
            sum / DIRECTIONS as f32
        })
        .collect();
    Coarse { nx, ny, stride, values }
}
