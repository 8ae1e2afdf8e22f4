//! Perspective views: one ray a pixel, and more where neighbours differ.

use crate::block::Block;
use crate::camera::Camera;
use crate::math::{V3, add, scale};
use crate::picture::{Picture, encode, quantise, tone_map};
use crate::scene::Scene;
use crate::sea::sea;
use crate::view::ViewOptions;
use eyot_core::{Control, Result, World};
use rayon::prelude::*;

/// Difference of encoded colours from which a pixel counts as an edge.
const EDGE: f32 = 0.055;

/// A view of the world from a camera over it. See [`ViewOptions`].
///
/// # Errors
/// If the world has no layer `height`.
pub fn perspective(world: &World, o: &ViewOptions) -> Result<Picture> {
    perspective_controlled(world, o, &Control::none())
}

/// As [`perspective`]; can be stopped.
///
/// # Errors
/// As [`perspective`], and on a request to stop.
pub fn perspective_controlled(world: &World, o: &ViewOptions, control: &Control<'_>) -> Result<Picture> {
    let scene = Scene::new(world, o, control)?;
    scene.picture(&scene.stage.camera(o), [o.width, o.height], control)
}

impl Scene {
    /// The scene from `camera`, in `size` pixels (columns, rows).
    ///
    /// # Errors
    /// On a request to stop.
    pub fn picture(&self, camera: &Camera, size: [usize; 2], control: &Control<'_>) -> Result<Picture> {
        let shot = Shot::new(self, camera, size);
        let [w, h] = size;
        let mut once = vec![[0.0f32; 3]; w * h];
        once.par_chunks_mut(w.max(1)).enumerate().try_for_each(|(y, row)| {
            row.iter_mut().enumerate().for_each(|(x, c)| *c = shot.encoded(x as f32 + 0.5, y as f32 + 0.5));
            control.check()
        })?;
        let mut pixels = vec![[0u8; 3]; w * h];
        pixels.par_chunks_mut(w.max(1)).enumerate().try_for_each(|(y, row)| {
            control.check()?;
            for (x, out) in row.iter_mut().enumerate() {
                let mut c = once[y * w + x];
                if self.samples > 1 && is_edge(&once, w, h, x, y) {
                    for k in 1..self.samples {
                        let [dx, dy] = r2(k);
                        c = add(c, shot.encoded(x as f32 + dx, y as f32 + dy));
                    }
                    c = scale(c, 1.0 / self.samples as f32);
                }
                *out = quantise(c, x, y);
            }
            Ok(())
        })?;
        Ok(Picture { width: w, height: h, pixels })
    }
}

/// Points that fill the pixel evenly for any count (Roberts' R2 sequence); the first is the centre.
fn r2(k: usize) -> [f32; 2] {
    let k = k as f32;
    [(0.5 + 0.754_877_7 * k).fract(), (0.5 + 0.569_840_3 * k).fract()]
}

fn is_edge(colours: &[V3], w: usize, h: usize, x: usize, y: usize) -> bool {
    let here = colours[y * w + x];
    let differs = |x: usize, y: usize| {
        let c = colours[y * w + x];
        (0..3).any(|k| (c[k] - here[k]).abs() > EDGE)
    };
    (x > 0 && differs(x - 1, y))
        || (x + 1 < w && differs(x + 1, y))
        || (y > 0 && differs(x, y - 1))
        || (y + 1 < h && differs(x, y + 1))
}

/// Scene and camera together.
struct Shot<'a> {
    scene: &'a Scene,
    camera: Camera,
    /// Length of a pixel at distance 1.
    pixel: f32,
    size: [usize; 2],
    block: Option<Block>,
}

impl<'a> Shot<'a> {
    fn new(scene: &'a Scene, camera: &Camera, size: [usize; 2]) -> Self {
        let block = scene.stage.block.then(|| Block::new(scene));
        Self { scene, camera: *camera, pixel: camera.pixel(size[1]), size, block }
    }

    fn encoded(&self, x: f32, y: f32) -> V3 {
        let d = self.camera.ray(x, y, self.size);
        match &self.block {
            Some(block) => self.model(block, self.camera.eye, d),
            None => self.film(self.open(self.camera.eye, d)),
        }
    }

    /// Light to encoded colours.
    fn film(&self, light: V3) -> V3 {
        tone_map(scale(light, self.scene.stage.exposure))
    }

    /// A ray into the relief model, as an encoded colour.
    fn model(&self, block: &Block, eye: V3, d: V3) -> V3 {
        let s = self.scene;
        let Some(entry) = block.enter(eye, d) else {
            return self.film(block.studio(s, eye, d));
        };
        let p = add(eye, scale(d, entry.from));
        if let Some(c) = block.wall(s, p, d, &entry) {
            return self.film(c);
        }
        let to_sea = if s.stage.sea && d[2] < 0.0 { -eye[2] / d[2] } else { f32::INFINITY };
        let to = entry.to.min(to_sea);
        let ground = self.ground_hit(eye, d, entry.from, to);
        if let Some(c) = self.tree_hit(eye, d, [entry.from, ground.unwrap_or(to)]) {
            return self.film(c.0);
        }
        if let Some(t) = ground {
            let c = s.land(add(eye, scale(d, t)), d, self.pixel * t);
            // Colours of layers keep their legend's values.
            return if s.draped { c.map(|v| encode(v.min(1.0))) } else { self.film(c) };
        }
        if to_sea < entry.to {
            return self.film(sea(s, add(eye, scale(d, to_sea)), d, self.pixel * to_sea));
        }
        self.film(block.studio(s, eye, d))
    }

    /// A ray into the open world.
    fn open(&self, eye: V3, d: V3) -> V3 {
        let s = self.scene;
        let to_sea = if d[2] < -1e-6 { -eye[2] / d[2] } else { f32::INFINITY };
        if let Some((from, to)) = self.over_grid(eye, d)
            && let to = to.min(to_sea)
            && let ground = self.ground_hit(eye, d, from, to)
            && let Some((c, t)) = self
                .tree_hit(eye, d, [from, ground.unwrap_or(to)])
                .or_else(|| ground.map(|t| (s.land(add(eye, scale(d, t)), d, self.pixel * t), t)))
        {
            return s.stage.sky.through_air(c, d, s.stage.haze * t);
        }
        if to_sea < 3e3 * s.stage.extent {
            let c = sea(s, add(eye, scale(d, to_sea)), d, self.pixel * to_sea);
            return s.stage.sky.through_air(c, d, s.stage.haze * to_sea);
        }
        s.stage.sky.seen(d)
    }

    /// Colour and distance of the first tree.
    fn tree_hit(&self, eye: V3, d: V3, span: [f32; 2]) -> Option<(V3, f32)> {
        let grove = self.scene.grove.as_ref()?;
        let met = grove.meet(eye, d, span, self.pixel)?;
        Some((self.scene.tree(grove, &met, eye, d, self.pixel * met.t), met.t))
    }

    fn ground_hit(&self, eye: V3, d: V3, from: f32, to: f32) -> Option<f32> {
        let step = self.scene.surface.step.map(f64::from);
        let [e, d] = [eye, d].map(|v| v.map(f64::from));
        let origin = [e[0] / step[0], e[1] / step[1], e[2]];
        let dir = [d[0] / step[0], d[1] / step[1], d[2]];
        self.scene.surface.trace(origin, dir, f64::from(from), f64::from(to)).map(|t| t as f32)
    }

    /// The part of a ray over the grid and below its highest point.
    fn over_grid(&self, eye: V3, d: V3) -> Option<(f32, f32)> {
        let s = &self.scene.surface;
        let e = s.extent();
        let (mut from, mut to) = (0.0f32, f32::INFINITY);
        for (p, d, lo, hi) in
            [(eye[0], d[0], 0.0, e[0]), (eye[1], d[1], 0.0, e[1]), (eye[2], d[2], f32::NEG_INFINITY, s.top.max(1e-3))]
        {
            if d.abs() < 1e-9 {
                if p < lo || p > hi {
                    return None;
                }
                continue;
            }
            let (a, b) = ((lo - p) / d, (hi - p) / d);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        (from < to).then_some((from, to))
    }
}
