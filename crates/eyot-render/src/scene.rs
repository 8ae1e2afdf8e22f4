//! A world made ready for rays: surface, colours and light at nodes, water and sky.

use crate::light::{Coarse, Sun, sky_share, sunlight};
use crate::map::LayerColours;
use crate::math::{V3, add, dot, mix, mul, scale, smoothstep, unit};
use crate::stage::Stage;
use crate::streams::Frame;
use crate::surface::{Refinement, Surface, b_spline, mitchell};
use crate::view::ViewOptions;
use crate::water::{fresnel, refracted_cos};
use eyot_core::{Control, Result, World};
use eyot_noise::picture::{fbm, noise_with_slope};
use rayon::prelude::*;

/// What a ray finds at a node.
#[derive(Clone, Copy, Default)]
pub(crate) struct Node {
    pub(crate) albedo: V3,
    /// Rise per metre eastward and southward, as drawn.
    pub(crate) rise: [f32; 2],
    /// Share of the sun's disc in view.
    pub(crate) sun: f32,
    /// Depth of fresh water, m.
    pub(crate) fresh: f32,
    /// Breaking waves, 0..1.
    pub(crate) foam: f32,
}

/// A world made ready to be drawn by rays, from any number of cameras. See [`Stage`] for what it shares with other ways to draw.
pub struct Scene {
    /// What does not depend on how it is drawn.
    pub stage: Stage,
    pub(crate) surface: Surface,
    nodes: Vec<Node>,
    open_sky: Coarse,
    /// The ground wears the colours of a layer.
    pub(crate) draped: bool,
    /// Samples in pixels with edges.
    pub(crate) samples: usize,
}

/// What a scene computes from its stage: surface, colours and light at nodes.
struct Refined {
    surface: Surface,
    nodes: Vec<Node>,
    open_sky: Coarse,
}

impl Refined {
    fn new(stage: &Stage, colours: &[V3], control: &Control<'_>) -> Result<Self> {
        control.check()?;
        let refine = Refinement::new(stage.ground.width, stage.ground.height);
        let mut tops = refine.refine(stage.tops(), b_spline);
        let cell = stage.ground.cell;
        let frame = Frame {
            points: refine.nodes,
            first_m: [0.5 * cell[0], 0.5 * cell[1]],
            step_m: [cell[0] / refine.factor as f32, cell[1] / refine.factor as f32],
        };
        let fresh = match stage.streams(&frame, &refine.refine(&stage.ground.z, b_spline)) {
            Some((fresh, levels)) => {
                // Lakes are level, whatever the kernel makes of their shores.
                let drawn = levels.iter().map(|level| level * stage.exaggeration);
                tops.iter_mut().zip(drawn).filter(|(_, level)| !level.is_nan()).for_each(|(top, level)| *top = level);
                Some(fresh)
            }
            None => stage.fresh().map(|w| refine.refine(w, mitchell)),
        };
        let surface = Surface::new(&stage.ground, &refine, tops);
        let foam = stage.foam().map(|f| refine.refine(&f, b_spline));

        control.check()?;
        let sun = Sun::new(&surface, stage.sun_azimuth_deg, stage.sun_elevation_deg);
        let floor = if stage.sea { 0.0 } else { f32::NEG_INFINITY };
        let light = sunlight(&surface, &sun, floor);
        let open_sky = sky_share(&surface, floor);

        control.check()?;
        let channels: [Vec<f32>; 3] = std::array::from_fn(|k| {
            let one: Vec<f32> = colours.iter().map(|c| c[k]).collect();
            refine.refine(&one, b_spline)
        });
        let (nx, ny) = (surface.nx, surface.ny);
        let mut nodes = vec![Node::default(); nx * ny];
        nodes.par_chunks_mut(nx).enumerate().for_each(|(y, row)| {
            let (north, south) = (y.saturating_sub(1), (y + 1).min(ny - 1));
            for (x, node) in row.iter_mut().enumerate() {
                let (west, east) = (x.saturating_sub(1), (x + 1).min(nx - 1));
                let i = y * nx + x;
                let z = |x: usize, y: usize| surface.z[y * nx + x];
                *node = Node {
                    albedo: std::array::from_fn(|k| channels[k][i].max(0.0)),
                    rise: [
                        (z(east, y) - z(west, y)) / ((east - west) as f32 * surface.step[0]),
                        (z(x, south) - z(x, north)) / ((south - north) as f32 * surface.step[1]),
                    ],
                    sun: light[i],
                    fresh: fresh.as_ref().map_or(0.0, |f| f[i].max(0.0)),
                    foam: foam.as_ref().map_or(0.0, |f| f[i]),
                };
            }
        });
        Ok(Self { surface, nodes, open_sky })
    }
}

impl Scene {
    /// Refines the surface of `world` and computes the light that falls on it.
    ///
    /// # Errors
    /// If the world has no layer `height`, and on a request to stop.
    pub fn new(world: &World, o: &ViewOptions, control: &Control<'_>) -> Result<Self> {
        let stage = Stage::new(world, o)?;
        let colours = stage.colours(world);
        Self::with(stage, &colours, false, o, control)
    }

    /// A relief model that wears the colours of a layer; of the options, what [`ViewOptions::draped`] keeps.
    ///
    /// # Errors
    /// As [`Scene::new`].
    pub fn wearing(world: &World, layer: &LayerColours, o: &ViewOptions, control: &Control<'_>) -> Result<Self> {
        Self::with(Stage::new(world, &o.draped())?, &layer.colours, true, o, control)
    }

    fn with(stage: Stage, colours: &[V3], draped: bool, o: &ViewOptions, control: &Control<'_>) -> Result<Self> {
        let Refined { surface, nodes, open_sky } = Refined::new(&stage, colours, control)?;
        Ok(Self { stage, surface, nodes, open_sky, draped, samples: o.samples.clamp(1, 16) })
    }

    /// Takes over a later state of the same world, and of the layer that it wears, if it wears one. See [`Stage::follow`].
    ///
    /// # Errors
    /// If the world is of another size, and on a request to stop, after which the scene is what it was but for its stage.
    pub fn follow(&mut self, world: &World, layer: Option<&LayerColours>, control: &Control<'_>) -> Result<()> {
        self.stage.follow(world)?;
        let refined = match layer {
            Some(l) => Refined::new(&self.stage, &l.colours, control)?,
            None => Refined::new(&self.stage, &self.stage.colours(world), control)?,
        };
        (self.surface, self.nodes, self.open_sky) = (refined.surface, refined.nodes, refined.open_sky);
        Ok(())
    }

    /// Node coordinates of a place in metres.
    pub(crate) fn place(&self, p: V3) -> (f32, f32) {
        (p[0] / self.surface.step[0], p[1] / self.surface.step[1])
    }

    /// The node values between nodes.
    pub(crate) fn node(&self, u: f32, v: f32) -> Node {
        let (x, y, fx, fy) = self.surface.interval(u, v);
        let i = y * self.surface.nx + x;
        let (a, b) = (&self.nodes[i], &self.nodes[i + 1]);
        let (c, d) = (&self.nodes[i + self.surface.nx], &self.nodes[i + self.surface.nx + 1]);
        let (wa, wb, wc, wd) = ((1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy);
        let of = |f: fn(&Node) -> f32| wa * f(a) + wb * f(b) + wc * f(c) + wd * f(d);
        Node {
            albedo: std::array::from_fn(|k| wa * a.albedo[k] + wb * b.albedo[k] + wc * c.albedo[k] + wd * d.albedo[k]),
            rise: [of(|n| n.rise[0]), of(|n| n.rise[1])],
            sun: of(|n| n.sun),
            fresh: of(|n| n.fresh),
            foam: of(|n| n.foam),
        }
    }

    /// Open share of the sky at node coordinates.
    pub(crate) fn open_sky(&self, u: f32, v: f32) -> f32 {
        self.open_sky.at(u, v)
    }

    /// Light that falls on a surface.
    pub(crate) fn irradiance(&self, normal: V3, sun: f32, open: f32) -> V3 {
        let direct = scale(self.stage.sky.sunlight, sun * dot(normal, self.stage.sky.sun).max(0.0));
        let sky = scale(self.stage.sky.skylight, open * (0.62 + 0.38 * normal[2]));
        // What is not sky is sunlit ground, about as bright as this.
        let bounce = scale(self.stage.sky.sunlight, 0.050 * (1.0 - open) + 0.028 * (1.0 - normal[2]));
        add(direct, add(sky, bounce))
    }

    /// Colour of the ground seen at `p` along `d`, a pixel being `footprint` m wide.
    pub(crate) fn land(&self, p: V3, d: V3, footprint: f32) -> V3 {
        let (u, v) = self.place(p);
        let node = self.node(u, v);
        let open = self.open_sky(u, v);
        if self.draped {
            return self.painted(&node, open);
        }
        let mut rise = node.rise;
        let mut colour = node.albedo;
        // Crowns of trees and broken stone, below the size of cells: bumps as large as a pixel shows.
        let sum = colour[0] + colour[1] + colour[2] + 1e-6;
        let green = smoothstep(0.02, 0.16, (colour[1] - colour[0]) / sum);
        let pale = smoothstep(0.55, 1.2, sum);
        let rough = (0.42 + 0.50 * green) * (1.0 - 0.92 * pale);
        let (a, b) = (0.83 * p[0] + 0.56 * p[1], 0.83 * p[1] - 0.56 * p[0]);
        let mut length = 5.3 * self.stage.extent / 512.0;
        for k in 0..6 {
            let keep = smoothstep(0.85, 0.30, footprint / length) * rough;
            if keep <= 0.0 {
                break;
            }
            let (n, na, nb) = noise_with_slope(a / length, b / length, 300 + k);
            // Longer bumps would be hills that are not there.
            let s = 0.24 * keep * smoothstep(150.0, 50.0, length);
            rise[0] += s * (0.83 * na - 0.56 * nb);
            rise[1] += s * (0.56 * na + 0.83 * nb);
            colour = scale(colour, 1.0 + (0.44 - 0.20 * green) * keep * n);
            length *= 0.47;
        }
        let normal = unit([-rise[0], -rise[1], 1.0]);
        let mut c = mul(colour, self.irradiance(normal, node.sun, open));
        // Leaves and dust send light back the way it came and let it through at the rim.
        let rim = (1.0 + dot(d, normal)).clamp(0.0, 1.0);
        c = scale(c, 1.0 + 0.25 * rim * rim * green);
        let cover = self.stage.ground.river_cover(node.fresh);
        if cover > 0.0 {
            c = mix(c, self.river(&node, p, d, footprint, open), cover);
        }
        c
    }

    /// Colours of a layer under soft light: level ground in full light keeps the legend's colour.
    fn painted(&self, node: &Node, open: f32) -> V3 {
        let grey = [0.3, 0.5, 0.2];
        let normal = unit([-node.rise[0], -node.rise[1], 1.0]);
        let light = dot(self.irradiance(normal, 0.4 + 0.6 * node.sun, open), grey);
        let level = dot(self.irradiance([0.0, 0.0, 1.0], 1.0, 1.0), grey);
        scale(node.albedo, 0.3 + 0.7 * light / level)
    }

    /// Colour of fresh water at a node.
    fn river(&self, node: &Node, p: V3, d: V3, footprint: f32, open: f32) -> V3 {
        let unit_m = self.stage.extent / 260.0;
        let (wave, _) = crate::water::waves(p[0], p[1], unit_m, footprint);
        let normal = unit([-node.rise[0] - 0.4 * wave[0], -node.rise[1] - 0.4 * wave[1], 1.0]);
        let cos = -dot(d, normal);
        let light = self.irradiance(normal, node.sun, open);
        let path = 1.2 + 1.0 / refracted_cos(cos.clamp(0.0, 1.0));
        let mut deep = self.stage.fresh_water.upwelling(node.albedo, node.fresh, path);
        if self.stage.has_streams() {
            // Torrents are white; only lines know where they run.
            let slope = node.rise[0].hypot(node.rise[1]) / self.stage.exaggeration;
            deep = mix(deep, [0.30, 0.36, 0.40], 0.6 * smoothstep(0.02, 0.35, slope));
        }
        let body = mul(deep, light);
        let reflected = add(d, scale(normal, 2.0 * cos));
        let f = fresnel(cos.max(0.12));
        add(scale(body, 1.0 - f), scale(self.stage.sky.clear(reflected), f * open))
    }

    /// Depth added near and beyond the rim so that the open sea shows no corner of the grid, m.
    pub(crate) fn fall_off(&self, x: f32, y: f32) -> f32 {
        if self.stage.block {
            return 0.0;
        }
        let e = self.surface.extent();
        let half = [0.5 * e[0], 0.5 * e[1]];
        let margin = 0.11 * half[0].min(half[1]);
        let corner = 0.75 * half[0].min(half[1]);
        let q = [(x - half[0]).abs() - half[0] + corner, (y - half[1]).abs() - half[1] + corner];
        let outside = q[0].max(0.0).hypot(q[1].max(0.0)) + q[0].max(q[1]).min(0.0) - corner;
        if outside < -3.0 * margin {
            return 0.0;
        }
        let wander = 1.25 * margin * fbm(5.0 * x / self.stage.extent, 5.0 * y / self.stage.extent, 4, 61);
        let t = smoothstep(-1.6 * margin, 1.4 * margin, outside + wander);
        4.0 * self.stage.clarity * t * t
    }
}
