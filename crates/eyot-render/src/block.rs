//! The relief model: cut sides of the block, the ground that it stands on and the backdrop.

use crate::cut::{Cut, Side};
use crate::math::{V3, add, dot, mix, mul, scale, smoothstep};
use crate::scene::Scene;
use eyot_noise::picture::{fbm, noise};

/// Colours of the relief model, as linear albedos.
#[derive(Clone, Copy, Debug)]
pub struct BlockColours {
    /// Soil on top of the cut sides.
    pub soil: V3,
    /// Beds of the cut sides; they follow each other at random.
    pub beds: [V3; 5],
    /// Ground and backdrop of the studio.
    pub studio: V3,
    /// The cut through the sea at its surface.
    pub pane: V3,
    /// The cut through the sea in the deep.
    pub deep_pane: V3,
}

/// Colours of the relief model.
pub const BLOCK_COLOURS: BlockColours = BlockColours {
    soil: [0.085, 0.055, 0.034],
    beds: [[0.34, 0.225, 0.125], [0.43, 0.315, 0.195], [0.27, 0.185, 0.12], [0.38, 0.29, 0.20], [0.215, 0.165, 0.125]],
    studio: [0.78, 0.775, 0.76],
    pane: [0.075, 0.30, 0.36],
    deep_pane: [0.012, 0.075, 0.15],
};

const SOIL: V3 = BLOCK_COLOURS.soil;
const LAYERS: [V3; 5] = BLOCK_COLOURS.beds;
const STUDIO: V3 = BLOCK_COLOURS.studio;

/// The block's box in metres.
pub(crate) struct Block {
    size: [f32; 2],
    pub(crate) base: f32,
    top: f32,
}

/// Where a ray meets the box.
pub(crate) struct Entry {
    pub(crate) from: f32,
    pub(crate) to: f32,
    /// Outward normal of the side that it comes in by, if it is a side.
    side: Option<V3>,
}

impl Block {
    pub(crate) fn new(s: &Scene) -> Self {
        let low = s.surface.z.iter().copied().fold(f32::INFINITY, f32::min);
        let (base, top) = s.stage.block_span(low, s.surface.top);
        Self { size: s.surface.extent(), base, top }
    }

    /// The part of a ray within the box.
    pub(crate) fn enter(&self, eye: V3, d: V3) -> Option<Entry> {
        let (mut from, mut to, mut side) = (0.0f32, f32::INFINITY, None);
        for (axis, (lo, hi)) in
            [(0.0, self.size[0]), (0.0, self.size[1]), (self.base, self.top)].into_iter().enumerate()
        {
            if d[axis].abs() < 1e-9 {
                if eye[axis] < lo || eye[axis] > hi {
                    return None;
                }
                continue;
            }
            let (a, b) = ((lo - eye[axis]) / d[axis], (hi - eye[axis]) / d[axis]);
            if a.min(b) > from {
                from = a.min(b);
                side = (axis < 2).then(|| {
                    let mut n = [0.0; 3];
                    n[axis] = -d[axis].signum();
                    n
                });
            }
            to = to.min(a.max(b));
        }
        (from < to).then_some(Entry { from, to, side })
    }

    /// Colour of the cut side where the ray comes in, if it comes in below the surface.
    pub(crate) fn wall(&self, s: &Scene, p: V3, d: V3, e: &Entry) -> Option<V3> {
        let normal = e.side?;
        let (u, v) = s.place(p);
        let ground = s.surface.height(u, v);
        if p[2] > if s.stage.sea { ground.max(0.0) } else { ground } {
            return None;
        }
        let facing = dot(normal, s.stage.sky.sun).max(0.0);
        // The ground below sends light up; the foot of the wall sees less of everything.
        let up = (p[2] - self.base) / (ground - self.base).max(1e-6);
        let ambient = add(scale(s.stage.sky.skylight, 0.55), scale(s.stage.sky.sunlight, 0.07));
        let light =
            add(scale(s.stage.sky.sunlight, 0.92 * facing), scale(ambient, 0.62 + 0.38 * smoothstep(0.0, 0.4, up)));
        if p[2] > ground {
            return Some(self.water_wall(s, p, d, ground, normal, light));
        }
        let beds = s.stage.cut.as_ref().and_then(|cut| self.beds(s, cut, p, normal));
        Some(mul(beds.unwrap_or_else(|| self.strata(s, p, ground)), light))
    }

    /// The beds that the world has, with a grain that lies as they do and a dark line where they meet.
    fn beds(&self, s: &Scene, cut: &Cut, p: V3, normal: V3) -> Option<V3> {
        let cell = s.stage.cell_m();
        let (side, along) = match normal {
            [x, _, _] if x < 0.0 => (Side::West, p[1] / cell[1]),
            [x, _, _] if x > 0.0 => (Side::East, p[1] / cell[1]),
            [_, y, _] if y < 0.0 => (Side::North, p[0] / cell[0]),
            _ => (Side::South, p[0] / cell[0]),
        };
        let rock = cut.at(side, along, p[2] / s.stage.exaggeration)?;
        let far = (p[0] + 1.37 * p[1]) / s.stage.extent;
        let thick = (self.top - self.base) / s.stage.exaggeration;
        let bedding = rock.bedding / thick;
        let grain = 0.10 * fbm(160.0 * far, 40.0 * bedding, 3, 9) + 0.10 * noise(3.0 * far, 60.0 * bedding, 12);
        let line = 0.35 * smoothstep(0.006, 0.001, rock.contact / thick);
        Some(scale(rock.colour, (1.0 + grain) * (1.0 - line)))
    }

    /// Of a world that knows no beds: some that lie nearly level, so that valleys cut through them, with soil on top.
    fn strata(&self, s: &Scene, p: V3, ground: f32) -> V3 {
        let along = (p[0] + 1.37 * p[1]) / s.stage.extent;
        let thick = self.top - self.base;
        let below = ground - p[2];
        let bent = p[2] + 0.05 * thick * fbm(5.0 * along, 0.2, 3, 5);
        let t = 11.0 * bent / thick + 0.4 * noise(9.0 * along, 3.1, 8);
        let (i, f) = (t.floor(), t - t.floor());
        let pick = |i: f32| LAYERS[eyot_noise::picture::hash(i as i32, 7, 19) as usize % LAYERS.len()];
        let mut c = mix(pick(i), pick(i + 1.0), smoothstep(0.80, 1.0, f));
        let grain = fbm(160.0 * along, 40.0 * bent / thick, 3, 9);
        c = scale(c, 1.0 + 0.16 * grain + 0.10 * noise(3.0 * along, 60.0 * bent / thick, 12));
        let soil = (0.011 + 0.005 * fbm(20.0 * along, 1.0, 2, 14)) * s.stage.extent;
        mix(c, SOIL, 0.85 * smoothstep(soil, 0.45 * soil, below) * if ground > 0.0 || !s.stage.sea { 1.0 } else { 0.0 })
    }

    /// A cut through the sea: a pane of water, paler above and dark below.
    fn water_wall(&self, s: &Scene, p: V3, d: V3, ground: f32, normal: V3, light: V3) -> V3 {
        let depth = -p[2] / s.stage.exaggeration;
        let deep = smoothstep(0.0, 1.0, (depth / (3.0 * s.stage.clarity)).min(1.0))
            .max(0.35 * smoothstep(0.0, 1.0, p[2] / ground.min(-1e-6)));
        let pane = mul(mix(BLOCK_COLOURS.pane, BLOCK_COLOURS.deep_pane, deep), scale(light, 0.8));
        let f = crate::water::fresnel((-dot(d, normal)).max(0.1));
        add(scale(pane, 1.0 - f), scale(STUDIO, 0.6 * f))
    }

    /// Ground and backdrop of the studio for a ray that meets nothing else.
    pub(crate) fn studio(&self, s: &Scene, eye: V3, d: V3) -> V3 {
        let backdrop = scale(STUDIO, 0.94);
        if d[2] > -1e-4 {
            return backdrop;
        }
        let way = (self.base - eye[2]) / d[2];
        let p = [eye[0] + d[0] * way, eye[1] + d[1] * way, self.base];
        let beyond = |p: f32, size: f32| (-p).max(p - size).max(0.0);
        let off = beyond(p[0], self.size[0]).hypot(beyond(p[1], self.size[1]));
        // The block hides part of the sky close to it.
        let tall = 0.55 * (self.top - self.base);
        let contact = 0.50 * (-off / (0.25 * tall)).exp() + 0.22 * (-off / tall).exp();
        let lit = mix(scale(STUDIO, 1.02), scale(STUDIO, 0.40), 0.85 * self.shadow(s, p));
        let c = scale(lit, 1.0 - 0.75 * contact);
        let far = smoothstep(1.2, 3.2, off / s.stage.extent);
        mix(c, backdrop, far)
    }

    /// Shadow of the block at a point of the ground, 0..1.
    fn shadow(&self, s: &Scene, p: V3) -> f32 {
        let sun = s.stage.sky.sun;
        let flat = sun[0].hypot(sun[1]).max(1e-6);
        let (dx, dy, tan) = (sun[0] / flat, sun[1] / flat, sun[2] / flat);
        let (mut from, mut to) = (0.0f32, (self.top - self.base) / tan.max(0.02) * 1.3);
        for (p, d, size) in [(p[0], dx, self.size[0]), (p[1], dy, self.size[1])] {
            let (a, b) = ((0.0 - p) / d, (size - p) / d);
            if d.abs() < 1e-6 {
                if !(0.0..=size).contains(&p) {
                    return 0.0;
                }
                continue;
            }
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        if from >= to {
            return 0.0;
        }
        const STEPS: usize = 40;
        let mut horizon = 0.0f32;
        for i in 0..STEPS {
            // Denser at the near end, where the walls stand.
            let f = i as f32 / (STEPS - 1) as f32;
            let way = from + (to - from) * f * f;
            let (u, v) = s.place([p[0] + dx * way, p[1] + dy * way, 0.0]);
            horizon = horizon.max((s.surface.height(u, v) - self.base) / way.max(1e-3 * s.stage.extent));
        }
        smoothstep(0.80 * tan, 1.20 * tan, horizon)
    }
}
