//! What every drawing of a world shares, whoever draws it: the rays of this crate or a graphics card.

use crate::camera::Camera;
use crate::cover::{Looks, albedo};
use crate::cut::Cut;
use crate::framing::Subject;
use crate::ground::{Ground, box_mean};
use crate::math::{V3, add, direction, scale, smoothstep};
use crate::path::Pose;
use crate::picture::encode;
use crate::sky::Sky;
use crate::streams::{Frame, Streams};
use crate::surface::{Refinement, b_spline};
use crate::view::{Setting, ViewOptions, finite};
use crate::water::Water;
use eyot_core::{Result, World};
use rayon::prelude::*;

/// A world's looks: its heights as drawn, light, water and what stands around it. Lengths in m, heights over the sea or, without
/// one, over the world's zero; the first node is the middle of the north-western cell.
pub struct Stage {
    pub(crate) ground: Ground,
    /// Heights of cells as drawn: exaggerated, rivers and lakes on top.
    tops: Vec<f32>,
    /// True if the sea is drawn; its surface is at height 0.
    pub sea: bool,
    /// True for a relief model in a studio, false for an open sea.
    pub block: bool,
    /// Factor on heights.
    pub exaggeration: f32,
    /// Depth at which the sea's bottom is all but lost.
    pub clarity: f32,
    /// The longer side of the grid.
    pub extent: f32,
    /// Optical depth of the air per metre.
    pub haze: f32,
    /// Factor on the light of the whole picture, before the film's curve.
    pub exposure: f32,
    /// Height of the sun over the horizon, degrees.
    pub sun_elevation_deg: f32,
    /// Bearing of the sun, degrees clockwise from north.
    pub sun_azimuth_deg: f32,
    /// Light of sun and sky.
    pub sky: Sky,
    /// Optics of the sea.
    pub sea_water: Water,
    /// Optics of rivers and lakes.
    pub fresh_water: Water,
    rivers: bool,
    /// Rivers and lakes as lines, if the world keeps them so.
    streams: Option<Streams>,
    looks: Looks,
    /// What the sides of a relief model show, if the world knows its beds.
    pub(crate) cut: Option<Cut>,
    /// What pictures show, as it was when the stage was made.
    pub(crate) subject: Subject,
}

impl Stage {
    /// The looks of `world` as `o` asks for them.
    ///
    /// # Errors
    /// If the world has no layer `height`.
    pub fn new(world: &World, o: &ViewOptions) -> Result<Self> {
        let ground = Ground::new(world)?;
        let extent = ground.extent();
        let sea = ground.sea && o.sea;
        let block = match o.setting {
            Setting::Auto => !sea || ground.rim_land > 0.03,
            Setting::OpenSea => !sea,
            Setting::Block => true,
        };
        let clarity = clarity(o.sea_clarity_m, &ground);
        let sun_elevation_deg = finite(o.sun_elevation_deg, 36.0).clamp(1.0, 89.0);
        let sun_azimuth_deg = finite(o.sun_azimuth_deg, 285.0);
        let sun = direction(sun_azimuth_deg, sun_elevation_deg);
        let mut stage = Self {
            tops: Vec::new(),
            sea,
            block,
            exaggeration: finite(o.vertical_exaggeration, 1.0).clamp(0.01, 1000.0),
            clarity,
            extent,
            haze: if block { 0.0 } else { finite(o.haze, 1.0).max(0.0) * 0.055 / extent },
            exposure: 0.62 * finite(o.exposure, 1.0).max(0.0),
            sun_elevation_deg,
            sun_azimuth_deg,
            sky: Sky::new(sun, if block { 0.0 } else { o.clouds }, world.seed as u32),
            sea_water: Water::sea(clarity),
            fresh_water: Water::fresh(2.0 * ground.river.1),
            rivers: o.fresh_water,
            streams: Streams::of(world),
            looks: o.looks.clone(),
            cut: None,
            subject: Subject::default(),
            ground,
        };
        stage.raise();
        stage.cut(world)?;
        stage.subject = Subject::of(&stage);
        Ok(stage)
    }

    /// Takes over the heights and the water of `world`, a later state of the world that this was made for. What scales the
    /// picture and what places its cameras stays, so that a film of a growing island does not jump.
    ///
    /// # Errors
    /// If the world has no layer `height`, or is of another size.
    pub fn follow(&mut self, world: &World) -> Result<()> {
        self.ground.follow(world)?;
        self.streams = Streams::of(world);
        self.raise();
        self.cut(world)
    }

    fn cut(&mut self, world: &World) -> Result<()> {
        if self.block {
            // Some way below the foot, which follows from a smoother surface.
            let floor = self.datum() + self.foot() / self.exaggeration - 0.1 * self.extent;
            self.cut = Cut::of(world, self.datum(), floor)?;
        }
        Ok(())
    }

    fn raise(&mut self) {
        let (g, exaggeration) = (&self.ground, self.exaggeration);
        self.tops = match self.fresh() {
            // The water's surface, but not the film that rain leaves everywhere.
            Some(w) => g.z.iter().zip(w).map(|(z, d)| (z + d * g.river_cover(*d)) * exaggeration).collect(),
            None => g.z.iter().map(|z| z * exaggeration).collect(),
        };
    }

    /// What stands at height 0, m above the world's own zero: the sea, or that zero itself if the world has none.
    pub fn datum(&self) -> f32 {
        -self.ground.zero
    }

    /// Columns and rows of cells.
    pub fn cells(&self) -> [usize; 2] {
        [self.ground.width, self.ground.height]
    }

    /// Size of a cell, m.
    pub fn cell_m(&self) -> [f32; 2] {
        self.ground.cell
    }

    /// East-west and north-south distance of the outermost nodes, m. A single row or column is a strip of its own width.
    pub fn size_m(&self) -> [f32; 2] {
        let side = |n: usize, cell: f32| (n.max(2) - 1) as f32 * cell;
        [side(self.ground.width, self.ground.cell[0]), side(self.ground.height, self.ground.cell[1])]
    }

    /// Columns and rows of the nodes that the surface is refined to, and how many of them a cell gets.
    pub fn nodes(&self) -> ([usize; 2], usize) {
        let r = Refinement::new(self.ground.width, self.ground.height);
        (r.nodes, r.factor)
    }

    /// Heights of cells as drawn, m, row by row from the north-west.
    pub fn tops(&self) -> &[f32] {
        &self.tops
    }

    /// Depth of fresh water in every cell, m, if it is drawn.
    pub fn fresh(&self) -> Option<&[f32]> {
        self.ground.water.as_deref().filter(|_| self.rivers)
    }

    /// True if rivers are drawn as lines.
    pub(crate) fn has_streams(&self) -> bool {
        self.rivers && self.streams.is_some()
    }

    /// Depth of fresh water at the points of a finer picture, m, and the levels of its lakes above the datum, NaN elsewhere, if the
    /// world keeps its rivers as lines. `ground`: the height of the bare ground there, m.
    pub(crate) fn streams(&self, frame: &Frame, ground: &[f32]) -> Option<(Vec<f32>, Vec<f32>)> {
        let streams = self.streams.as_ref().filter(|_| self.rivers)?;
        let mut levels = streams.levels(frame);
        levels.iter_mut().for_each(|l| *l -= self.datum());
        let (from, to) = self.ground.river;
        let depths = streams.cover(frame).into_iter().zip(levels.iter().zip(ground)).map(|(cover, (level, z))| {
            // A river hides its bed where it fills the point.
            let river = if cover > 0.0 { from + (to - from) * 1.2 * cover } else { 0.0 };
            if level.is_nan() { river } else { river.max(level - z) }
        });
        Some((depths.collect(), levels))
    }

    /// Depths of fresh water between which a river comes into sight, m.
    pub fn river_depths(&self) -> (f32, f32) {
        self.ground.river
    }

    /// Linear colours of the ground, cell by cell.
    pub fn colours(&self, world: &World) -> Vec<V3> {
        albedo(world, &self.ground, &self.looks, 1.0)
    }

    /// Cover of breaking waves for every cell, 0..1; nothing without a sea.
    pub fn foam(&self) -> Option<Vec<f32>> {
        self.sea.then(|| surf(&self.ground, self.clarity))
    }

    /// Base and top of the relief model over heights from `low` to `top`, m.
    pub fn block_span(&self, low: f32, top: f32) -> (f32, f32) {
        let top = if self.sea { top.max(0.0) } else { top };
        (low - (0.040 * self.extent).max(0.16 * (top - low)), top + 1e-3 * self.extent)
    }

    /// Height of the drawn surface at a place, m; places outside are clamped to the rim.
    pub fn height_at(&self, x_m: f32, y_m: f32) -> f32 {
        let [w, h] = self.cells();
        let place = |p: f32, cell: f32, n: usize| {
            let u = (p / cell).clamp(0.0, (n - 1) as f32);
            (u as isize, b_spline(u.fract()))
        };
        let ((x, kx), (y, ky)) = (place(x_m, self.ground.cell[0], w), place(y_m, self.ground.cell[1], h));
        let at = |i: isize, n: usize| i.clamp(0, n as isize - 1) as usize;
        let row = |j: isize| {
            let row = &self.tops[at(y + j - 1, h) * w..][..w];
            (0..4).map(|i| kx[i as usize] * row[at(x + i - 1, w)]).sum::<f32>()
        };
        (0..4).map(|j| ky[j as usize] * row(j)).sum()
    }

    /// The pose that the options describe, with what they leave open: without target and distance the picture shows the land as a whole.
    pub fn pose(&self, o: &ViewOptions) -> Pose {
        let pose = self.asked(o);
        if is_placed(o) { pose } else { self.framed(&pose, o.aspect()) }
    }

    /// As [`Stage::pose`], for a turn around the land: from every side it is in the picture.
    pub(crate) fn pose_all_around(&self, o: &ViewOptions) -> Pose {
        let pose = self.asked(o);
        if is_placed(o) { pose } else { self.framed_all_around(&pose, o.aspect()) }
    }

    fn asked(&self, o: &ViewOptions) -> Pose {
        let automatic = if self.block { (33.0, 1.72, -0.42) } else { (15.0, 1.06, 0.40) };
        Pose {
            azimuth_deg: finite(o.azimuth_deg, 180.0),
            elevation_deg: finite(o.elevation_deg.unwrap_or(automatic.0), automatic.0),
            distance: finite(o.distance.unwrap_or(automatic.1), automatic.1),
            target: o.target.unwrap_or([0.5; 2]).map(|t| finite(t, 0.5)),
            target_height: finite(o.target_height.unwrap_or(automatic.2), automatic.2),
            field_of_view_deg: finite(o.field_of_view_deg, 36.0),
        }
    }

    /// Height of the foot of the relief model, m.
    pub(crate) fn foot(&self) -> f32 {
        let (low, top) = self.tops.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, t), &v| (l.min(v), t.max(v)));
        self.block_span(low, top).0
    }

    /// The camera that the options describe, kept above ground and sea.
    pub fn camera(&self, o: &ViewOptions) -> Camera {
        self.camera_at(&self.pose(o))
    }

    /// The camera of a pose, kept above ground and sea.
    pub fn camera_at(&self, p: &Pose) -> Camera {
        let e = self.size_m();
        let target = [p.target[0] * e[0], p.target[1] * e[1], self.height_of_share(p.target_height)];
        let back = direction(p.azimuth_deg, p.elevation_deg.clamp(1.0, 89.0));
        let mut eye = add(target, scale(back, p.distance.clamp(0.01, 100.0) * self.extent));
        eye[2] = eye[2].max(self.clearance(eye));
        Camera::looking(eye, target, p.field_of_view_deg)
    }

    /// Height as drawn, m, of a share of the relief over the sea or the low end of the land.
    pub fn height_of_share(&self, share: f32) -> f32 {
        let low = if self.sea { 0.0 } else { self.ground.land_low };
        (low + share * self.ground.relief()) * self.exaggeration
    }

    /// The share of the relief that a height as drawn is: the other way round.
    pub(crate) fn share_of_height(&self, z: f32) -> f32 {
        let low = if self.sea { 0.0 } else { self.ground.land_low };
        (z / self.exaggeration - low) / self.ground.relief()
    }

    /// Least height of a camera at a place.
    fn clearance(&self, p: V3) -> f32 {
        let e = self.size_m();
        let over = p[0] >= 0.0 && p[1] >= 0.0 && p[0] <= e[0] && p[1] <= e[1];
        let ground = if over { self.height_at(p[0], p[1]) } else { f32::NEG_INFINITY };
        ground.max(if self.sea { 0.0 } else { f32::NEG_INFINITY }) + 0.004 * self.extent
    }
}

/// Linear colours as bytes on the sRGB curve, with a fourth channel of shares 0..1.
pub fn colour_bytes(colours: &[V3], fourth: Option<&[f32]>) -> Vec<[u8; 4]> {
    let byte = |v: f32| (255.0 * v.clamp(0.0, 1.0)).round() as u8;
    let one = |i: usize| {
        let c = colours[i].map(|v| byte(encode(v.clamp(0.0, 1.0))));
        [c[0], c[1], c[2], fourth.map_or(0, |f| byte(f[i]))]
    };
    (0..colours.len()).into_par_iter().map(one).collect()
}

/// Whether the options say where the camera stands, so that nothing is left to fit.
fn is_placed(o: &ViewOptions) -> bool {
    o.distance.is_some() || o.target.is_some() || o.target_height.is_some()
}

/// Clear tropical water shows its bottom to about 26 m; a small world gets a sea in its own measure, by its relief or by its extent: an atoll of
/// some kilometres has little of the one, and still a lagoon that is paler than the ocean.
pub(crate) fn clarity(given_m: Option<f32>, g: &Ground) -> f32 {
    let lowest = g.z.iter().copied().fold(0.0f32, f32::min);
    let automatic =
        (0.03 * (g.land_high.max(0.0) - lowest)).max(0.004 * g.extent().min(-30.0 * lowest)).clamp(0.05, 26.0);
    given_m.map_or(automatic, |c| finite(c, automatic).max(1e-3))
}

/// Where waves break: shallow places with deep water close by, so outer reefs and open shores but no lagoons.
fn surf(g: &Ground, clarity: f32) -> Vec<f32> {
    let depth: Vec<f32> = g.z.iter().map(|z| (-z).clamp(0.0, 5.0 * clarity)).collect();
    let radius = (g.width.max(g.height) / 40).clamp(2, 48);
    let near = box_mean(&depth, g.width, g.height, radius);
    g.z.iter()
        .zip(&near)
        .map(|(z, mean)| {
            let shallow = smoothstep(0.16, 0.02, -z / clarity) * smoothstep(0.10, 0.02, z / clarity);
            shallow * smoothstep(0.55, 1.2, mean / clarity)
        })
        .collect()
}
