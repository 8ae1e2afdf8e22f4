//! Single trees in views: bodies that rays meet, each with its own shade of green.
//!
//! Trees lie in the squares of a grid. A ray first finds the top of the canopy, as it finds the ground, and then goes from square to square
//! until it meets a tree or leaves the canopy. Far away, where a crown is smaller than a pixel, trees fade into the colour of the forest's ground.

use crate::math::{V3, add, dot, mix, scale, smoothstep, unit};
use crate::scene::Scene;
use crate::stage::Stage;
use crate::surface::{Refinement, Surface};
use eyot_core::World;
use eyot_noise::picture::{hash, noise, noise_with_slope};
use eyot_plants::trees::{Kind, Tree, Trees};
use eyot_plants::types::TYPES;
use rayon::prelude::*;

/// Side of the squares, m.
const SQUARE: f32 = 16.0;
/// More trees than that are drawn as colour alone.
const MOST: u64 = 2_000_000;
/// Largest area of land whose trees are looked for, m2.
const WIDEST: f64 = 1.5e8;
/// Pixels of these sizes, m, show the first and the last single trees.
const FADE: [f32; 2] = [8.0, 18.0];

/// Linear colour of bark.
const TRUNK: V3 = [0.070, 0.052, 0.038];

/// A tree as it is drawn. Lengths in m, places in the scene's coordinates.
#[derive(Clone, Copy)]
struct Body {
    foot: V3,
    height: f32,
    crown: f32,
    kind: Kind,
    species: Option<u8>,
    /// Its own number, for its shade of green.
    salt: u32,
}

/// What a ray meets.
pub(crate) struct Met {
    pub(crate) t: f32,
    body: Body,
    normal: V3,
}

/// The trees of a world.
pub(crate) struct Grove {
    /// Squares from west to east and from north to south.
    squares: [usize; 2],
    /// Where the trees of each square begin in the list.
    starts: Vec<u32>,
    bodies: Vec<Body>,
    /// Top of the canopy, on the nodes of the ground.
    canopy: Surface,
}

impl Grove {
    /// The trees of a world that has some, and not too many.
    pub(crate) fn new(world: &World, stage: &Stage, ground: &Surface) -> Option<Self> {
        let trees = Trees::of(world)?;
        let g = &world.grid;
        if trees.most() == 0 || trees.most() > MOST || g.cell_area_m2() * g.cells() as f64 > WIDEST {
            return None;
        }
        // The scene's first node is the middle of the first cell.
        let half = [0.5 * g.cell_x_m as f32, 0.5 * g.cell_y_m as f32];
        let extent = ground.extent();
        let body = |t: &Tree| {
            let at = [t.place[0] - half[0], t.place[1] - half[1]];
            let inside = (0..2).all(|i| at[i] >= 0.0 && at[i] < extent[i]);
            inside.then(|| Body {
                foot: [at[0], at[1], ground.height(at[0] / ground.step[0], at[1] / ground.step[1])],
                height: t.height * stage.exaggeration,
                crown: t.crown,
                kind: t.kind,
                species: t.species,
                salt: hash(t.id as i32, (t.id >> 32) as i32, 0x7472),
            })
        };
        let all: Vec<Body> = trees.all().par_iter().filter_map(body).collect();
        let squares = extent.map(|e| ((e / SQUARE).ceil() as usize).max(1));
        // A tree is listed in every square that its crown reaches.
        let reached = |b: &Body| {
            let span = |i: usize| {
                let at = |v: f32| ((v / SQUARE).max(0.0) as usize).min(squares[i] - 1);
                at(b.foot[i] - b.crown)..at(b.foot[i] + b.crown) + 1
            };
            let (xs, ys) = (span(0), span(1));
            ys.flat_map(move |y| xs.clone().map(move |x| y * squares[0] + x))
        };
        let mut starts = vec![0u32; squares[0] * squares[1] + 1];
        all.iter().flat_map(reached).for_each(|i| starts[i + 1] += 1);
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut order = vec![0u32; starts[starts.len() - 1] as usize];
        for (k, b) in all.iter().enumerate() {
            for i in reached(b) {
                order[next[i] as usize] = k as u32;
                next[i] += 1;
            }
        }
        let bodies = order.into_iter().map(|k| all[k as usize]).collect();
        let mut grove = Self { squares, starts, bodies, canopy: Surface::flat() };
        grove.canopy = grove.top(ground, &Refinement { cells: [2, 2], factor: 1, nodes: [ground.nx, ground.ny] });
        Some(grove)
    }

    /// Top of the canopy: what stands in the squares around a node.
    fn top(&self, ground: &Surface, nodes: &Refinement) -> Surface {
        let [w, h] = self.squares;
        let tallest = |x: usize, y: usize| {
            let top = |b: &Body| b.height;
            self.of(x, y).iter().map(top).fold(0.0, f32::max)
        };
        let of: Vec<f32> = (0..w * h).into_par_iter().map(|i| tallest(i % w, i / w)).collect();
        // As far as the nodes of an interval can be from what stands in it.
        let reach = [0, 1].map(|i| (ground.step[i] / SQUARE).ceil() as usize + 1);
        let around = |values: &[f32], axis: usize| -> Vec<f32> {
            let most = |i: usize| {
                let (x, y) = (i % w, i / w);
                let (at, n) = if axis == 0 { (x, w) } else { (y, h) };
                let span = at.saturating_sub(reach[axis])..(at + reach[axis] + 1).min(n);
                let value = |k: usize| if axis == 0 { values[y * w + k] } else { values[k * w + x] };
                span.map(value).fold(0.0, f32::max)
            };
            (0..w * h).into_par_iter().map(most).collect()
        };
        let of = around(&around(&of, 0), 1);
        let z = (0..ground.nx * ground.ny).into_par_iter().map(|i| {
            let (x, y) = (i % ground.nx, i / ground.nx);
            let square =
                |v: usize, axis: usize| ((v as f32 * ground.step[axis] / SQUARE) as usize).min(self.squares[axis] - 1);
            let tall = of[square(y, 1) * w + square(x, 0)];
            // On a slope a foot lies higher than the nodes around it: trees reach over the canopy by that.
            ground.z[i] + if tall > 0.0 { 1.15 * tall } else { -1.0 }
        });
        Surface::with_step(ground.step, nodes, z.collect())
    }

    fn of(&self, x: usize, y: usize) -> &[Body] {
        let i = y * self.squares[0] + x;
        &self.bodies[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// The first tree that the ray `eye + t d` meets for t in `from..to`; a pixel is `pixel` m wide at distance 1, and trees that are small in it
    /// are left out, ever more of them.
    pub(crate) fn meet(&self, eye: V3, d: V3, [from, to]: [f32; 2], pixel: f32) -> Option<Met> {
        let to = to.min(if pixel > 0.0 { FADE[1] / pixel } else { f32::MAX });
        let step = self.canopy.step.map(f64::from);
        let [e, dir] = [eye, d].map(|v| v.map(f64::from));
        let (origin, way) = ([e[0] / step[0], e[1] / step[1], e[2]], [dir[0] / step[0], dir[1] / step[1], dir[2]]);
        let mut t = from;
        // Each turn leaves the canopy once.
        for _ in 0..256 {
            if t >= to {
                return None;
            }
            t = self.canopy.trace(origin, way, f64::from(t), f64::from(to))? as f32;
            let p = add(eye, scale(d, t + 1e-3));
            let at = [0, 1].map(|i| (p[i] / SQUARE).floor());
            if (0..2).any(|i| at[i] < 0.0 || at[i] >= self.squares[i] as f32) {
                return None;
            }
            let exit = (0..2)
                .map(|i| {
                    let edge = if d[i] > 0.0 { at[i] + 1.0 } else { at[i] };
                    if d[i].abs() < 1e-9 { f32::MAX } else { (edge * SQUARE - eye[i]) / d[i] }
                })
                .fold(f32::MAX, f32::min)
                .max(t + 0.02);
            let seen = |b: &&Body| {
                let gone = smoothstep(FADE[0], FADE[1], pixel * t);
                gone <= 0.0 || (b.salt >> 8) as f32 / 16_777_216.0 > gone
            };
            let first = self
                .of(at[0] as usize, at[1] as usize)
                .iter()
                .filter(seen)
                .filter_map(|b| b.meet(eye, d, from, to).map(|(t, normal)| Met { t, body: *b, normal }))
                .min_by(|a, b| a.t.total_cmp(&b.t));
            if let Some(met) = first {
                return Some(met);
            }
            t = exit + 1e-3;
        }
        None
    }

    /// Share of the sun that trees let through to a point.
    pub(crate) fn lets_through(&self, p: V3, sun: V3, footprint: f32) -> f32 {
        if footprint > FADE[0] || sun[2] <= 0.02 {
            return 1.0;
        }
        // No tree's shadow is longer than this.
        let far = 45.0 / sun[2];
        // Crowns let some light through.
        if self.meet(add(p, scale(sun, 0.4)), sun, [0.0, far], 0.0).is_some() { 0.16 } else { 1.0 }
    }
}

impl Body {
    /// Where a ray meets the tree first, and the surface's normal there.
    fn meet(&self, eye: V3, d: V3, from: f32, to: f32) -> Option<(f32, V3)> {
        let o = [eye[0] - self.foot[0], eye[1] - self.foot[1], eye[2] - self.foot[2]];
        // Out of the way by more than the crown: most of them.
        let level = d[0] * d[0] + d[1] * d[1];
        let aside = o[0] * d[1] - o[1] * d[0];
        if aside * aside > self.crown * self.crown * level {
            return None;
        }
        let crown = self.meet_crown(o, d).filter(|(t, normal)| {
            *t > from && *t < to && {
                // The rim is ragged: twigs stand out, and between them one sees through.
                let p = add(o, scale(d, *t));
                let grain = 0.5 + 0.7 * noise(2.6 * (p[0] + p[1]), 2.6 * (p[2] + 0.6 * p[0] - 0.8 * p[1]), self.salt);
                -dot(*normal, d) > 0.55 * grain
            }
        });
        crown.or_else(|| self.meet_trunk(o, d).filter(|(t, _)| *t > from && *t < to))
    }

    /// A bare trunk up into the crown.
    fn meet_trunk(&self, o: V3, d: V3) -> Option<(f32, V3)> {
        let radius = (0.018 * self.height).min(0.2 * self.crown);
        let a = d[0] * d[0] + d[1] * d[1];
        let b = o[0] * d[0] + o[1] * d[1];
        let c = o[0] * o[0] + o[1] * o[1] - radius * radius;
        let root = b * b - a * c;
        if root <= 0.0 || a <= 0.0 {
            return None;
        }
        let t = (-b - root.sqrt()) / a;
        let p = add(o, scale(d, t));
        let high = if self.kind == Kind::Palm { 0.9 } else { 0.5 };
        (p[2] >= 0.0 && p[2] <= high * self.height).then(|| (t, unit([p[0], p[1], 0.0])))
    }

    fn meet_crown(&self, o: V3, d: V3) -> Option<(f32, V3)> {
        if self.kind == Kind::Conifer {
            // A cone with its tip at the top: x^2 + y^2 = k^2 (h - z)^2.
            let (low, k) = (0.1 * self.height, self.crown / (0.9 * self.height));
            let up = self.height - o[2];
            let a = d[0] * d[0] + d[1] * d[1] - k * k * d[2] * d[2];
            let b = o[0] * d[0] + o[1] * d[1] + k * k * up * d[2];
            let c = o[0] * o[0] + o[1] * o[1] - k * k * up * up;
            let root = b * b - a * c;
            if root < 0.0 {
                return None;
            }
            let root = root.sqrt();
            let inside = |t: &f32| {
                let z = o[2] + t * d[2];
                *t > 0.0 && z >= low && z <= self.height
            };
            let near = [(-b - root) / a, (-b + root) / a].into_iter().filter(inside).fold(f32::MAX, f32::min);
            let at = [0, 1].map(|i| o[i] + near * d[i]);
            return (near < f32::MAX).then(|| (near, unit([at[0], at[1], k * at[0].hypot(at[1]).max(1e-3)])));
        }
        let (middle, half) = match self.kind {
            Kind::Palm => (0.88, 0.13),
            Kind::Shrub => (0.45, 0.52),
            _ => (0.60, 0.40),
        };
        let radii = [self.crown, self.crown, half * self.height];
        let o = [o[0], o[1], o[2] - middle * self.height];
        let over = |v: V3| -> V3 { std::array::from_fn(|i| v[i] / radii[i]) };
        let (p, q) = (over(o), over(d));
        let (a, b, c) = (dot(q, q), dot(p, q), dot(p, p) - 1.0);
        let root = b * b - a * c;
        let t = (-b - root.max(0.0).sqrt()) / a;
        (root > 0.0).then(|| (t, unit(over(add(p, scale(q, t))))))
    }

    /// Linear colour of leaves: each tree its own.
    fn leaves(&self) -> V3 {
        let [dark, light] = match self.kind {
            Kind::Conifer => [[0.016, 0.031, 0.020], [0.031, 0.048, 0.028]],
            Kind::Palm => [[0.050, 0.082, 0.024], [0.084, 0.118, 0.034]],
            Kind::Shrub => [[0.040, 0.060, 0.022], [0.064, 0.078, 0.030]],
            _ => [[0.031, 0.053, 0.018], [0.062, 0.079, 0.023]],
        };
        let share = |shift: u32| ((self.salt >> shift) & 255) as f32 / 255.0;
        let colour = mix(dark, light, share(0));
        // Some are a little yellower or bluer.
        let warm = 0.16 * (share(8) - 0.5);
        let tint = tint(self.species);
        [colour[0] * (1.0 + warm) * tint[0], colour[1] * tint[1], colour[2] * (1.0 - warm) * tint[2]]
    }
}

/// How the leaves of a type differ from those of their kind.
fn tint(species: Option<u8>) -> V3 {
    match species.map(|n| TYPES[usize::from(n)].name) {
        Some("larch") => [1.9, 1.8, 1.1],
        Some("boreal_summergreen") => [1.5, 1.5, 1.2],
        Some("tropical_raingreen") => [1.5, 1.2, 0.8],
        Some("desert_shrub") => [2.0, 1.4, 1.2],
        Some("mediterranean_pine") => [1.4, 1.3, 0.9],
        _ => [1.0; 3],
    }
}

impl Scene {
    /// Colour of a tree seen along `d`, a pixel being `footprint` m wide.
    pub(crate) fn tree(&self, grove: &Grove, met: &Met, eye: V3, d: V3, footprint: f32) -> V3 {
        let (b, p) = (&met.body, add(eye, scale(d, met.t)));
        let (u, v) = self.place(b.foot);
        let node = self.node(u, v);
        // Twigs: bumps as large as a pixel shows.
        let length = 0.34 * b.crown;
        let keep = smoothstep(0.9, 0.3, footprint / length.max(0.05));
        let (n1, nx, z1) = noise_with_slope(p[0] / length, p[2] / length, b.salt);
        let (n2, ny, z2) = noise_with_slope(p[1] / length, p[2] / length + 17.0, b.salt);
        let n = n1 + n2;
        let normal = unit(add(met.normal, scale([nx, ny, 0.7 * (z1 + z2)], 0.34 * keep)));
        // Leaves within a crown and low in it see less of the sky.
        let high = ((p[2] - b.foot[2]) / b.height).clamp(0.0, 1.0);
        let open = self.open_sky(u, v) * (0.30 + 0.70 * high);
        // Whorls of branches, dark between them.
        let whorl = if b.kind == Kind::Conifer { (high * 0.55 * b.height).fract() } else { 0.5 };
        let sun = node.sun * grove.lets_through(p, self.stage.sky.sun, footprint);
        // Light goes through leaves: the side away from the sun is not black.
        let lit = unit(add(scale(normal, 0.75), scale(self.stage.sky.sun, 0.25)));
        let light = self.irradiance(lit, sun, open);
        let out = (p[0] - b.foot[0]).hypot(p[1] - b.foot[1]);
        let trunk = out < 0.022 * b.height && high < 0.5;
        let leaves = scale(b.leaves(), (1.0 + 0.22 * keep * n) * (1.0 + 0.7 * keep * (0.5 - whorl)));
        let colour = if trunk { TRUNK } else { leaves };
        std::array::from_fn(|i| colour[i] * light[i])
    }
}
