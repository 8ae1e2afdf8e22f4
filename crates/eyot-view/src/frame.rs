//! What the shaders of a picture are told: the uniform block of `frame.wgsl`.

use crate::detail::Detail;
use crate::levels::MAX_LEVELS;
use crate::maps::Maps;
use eyot_render::{BLOCK_COLOURS, Camera, Stage};

/// As `Frame` in `frame.wgsl`, field by field.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Frame {
    eye: [f32; 4],
    forward: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    picture: [f32; 4],
    detail: [f32; 4],
    size: [f32; 4],
    scale: [f32; 4],
    tone: [f32; 4],
    block: [f32; 4],
    nodes: [u32; 4],
    flags: [u32; 4],
    sky: [[f32; 4]; 6],
    water: [[f32; 4]; 6],
    model: [[f32; 4]; 4],
    beds: [[f32; 4]; 5],
    levels: [[u32; 4]; MAX_LEVELS],
}

/// What a frame is made of.
pub(crate) struct Parts<'a> {
    pub(crate) stage: &'a Stage,
    pub(crate) maps: &'a Maps,
    pub(crate) detail: &'a Detail,
    pub(crate) camera: &'a Camera,
    /// Columns and rows of the picture.
    pub(crate) size: [u32; 2],
    pub(crate) time_s: f32,
    /// The target itself puts colours on the sRGB curve.
    pub(crate) srgb: bool,
    /// The ground wears the colours of a layer.
    pub(crate) painted: bool,
    /// Base and top of the relief model.
    pub(crate) span: (f32, f32),
    pub(crate) flows: bool,
}

impl Parts<'_> {
    pub(crate) fn frame(&self) -> Frame {
        let (s, c, m) = (self.stage, self.camera, self.maps);
        let [w, h] = self.size.map(|n| n as f32);
        let with = |v: [f32; 3], w: f32| [v[0], v[1], v[2], w];
        let flag = |b: bool| if b { 1.0 } else { 0.0 };
        let extent = s.size_m();
        let step = [0, 1].map(|k| extent[k] / (m.levels.nodes[k] - 1) as f32);
        let (river_from, river_to) = s.river_depths();
        let k = &s.sky;
        let (sea, fresh) = (&s.sea_water, &s.fresh_water);
        Frame {
            eye: with(c.eye, self.time_s),
            forward: with(c.forward, 1e-4 * s.extent),
            right: with(c.right, c.tan * w / h),
            up: with(c.up, c.tan),
            picture: [w, h, c.pixel(self.size[1] as usize), flag(self.srgb)],
            detail: [self.detail.range, self.detail.morph, self.detail.over, flag(self.painted)],
            size: [extent[0], extent[1], step[0], step[1]],
            scale: [s.extent, s.clarity, s.exaggeration, s.haze],
            tone: [s.exposure, river_from, river_to, k.clouds],
            block: [self.span.0, self.span.1, m.light_stride as f32, flag(self.flows)],
            nodes: [m.levels.nodes[0], m.levels.nodes[1], m.levels.top() as u32, k.seed],
            flags: [u32::from(s.sea), u32::from(s.block), m.light_size[0], m.light_size[1]],
            sky: [k.sun, k.sunlight, k.skylight, k.zenith, k.horizon, k.glow].map(|v| with(v, 0.0)),
            water: [sea.absorb, sea.deep, sea.build, fresh.absorb, fresh.deep, fresh.build].map(|v| with(v, 0.0)),
            model: [BLOCK_COLOURS.soil, BLOCK_COLOURS.studio, BLOCK_COLOURS.pane, BLOCK_COLOURS.deep_pane]
                .map(|v| with(v, 0.0)),
            beds: BLOCK_COLOURS.beds.map(|v| with(v, 0.0)),
            levels: m.levels.uniform(),
        }
    }
}
