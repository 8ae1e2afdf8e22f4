//! Colour maps for layers, as control points in sRGB with straight lines between them.

/// A colour map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ColourMap {
    /// Dark blue over green to yellow; even steps to the eye.
    Viridis,
    /// Black over purple to pale yellow; even steps to the eye.
    Magma,
    /// Blue over grey to yellow; reads alike with and without colour blindness.
    Cividis,
    /// Blue over white to red, for values on both sides of a middle.
    Diverging,
    /// Land tints over sea tints, for heights; the middle of the map is the shore.
    Heights,
    /// White to deep blue, for water.
    Blues,
}

const VIRIDIS: [u32; 17] = [
    0x440154, 0x48186a, 0x472d7b, 0x424086, 0x3b528b, 0x33638d, 0x2c728e, 0x26828e, 0x21918c, 0x1fa088, 0x28ae80,
    0x3fbc73, 0x5ec962, 0x84d44b, 0xaddc30, 0xd8e219, 0xfde725,
];
const MAGMA: [u32; 17] = [
    0x000004, 0x0b0924, 0x20114b, 0x3b0f70, 0x57157e, 0x721f81, 0x8c2981, 0xa8327d, 0xc43c75, 0xde4968, 0xf1605d,
    0xfa7f5e, 0xfe9f6d, 0xfebf84, 0xfddea0, 0xfcedb0, 0xfcfdbf,
];
const CIVIDIS: [u32; 10] =
    [0x00224e, 0x123570, 0x3b496c, 0x575d6d, 0x707173, 0x8a8678, 0xa59c74, 0xc3b369, 0xe1cc55, 0xfee838];
const DIVERGING: [u32; 11] =
    [0x053061, 0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xf7f7f7, 0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b, 0x67001f];
const SEA: [u32; 7] = [0x12294f, 0x1b3f73, 0x28609a, 0x3f86b8, 0x66abd0, 0x97cbe2, 0xc9e6ef];
const LAND: [u32; 9] = [0x5f9158, 0x7da866, 0xa3bd76, 0xcbd08c, 0xe3d39a, 0xd2b07c, 0xb08a63, 0x9d8478, 0xf3f1ee];
const BLUES: [u32; 9] = [0xf7fbff, 0xdeebf7, 0xc6dbef, 0x9ecae1, 0x6baed6, 0x4292c6, 0x2171b5, 0x08519c, 0x08306b];

impl ColourMap {
    /// The colour at `t` in 0..1, as encoded sRGB in 0..1.
    pub fn at(self, t: f32) -> [f32; 3] {
        match self {
            Self::Viridis => along(&VIRIDIS, t),
            Self::Magma => along(&MAGMA, t),
            Self::Cividis => along(&CIVIDIS, t),
            Self::Diverging => along(&DIVERGING, t),
            Self::Blues => along(&BLUES, t),
            Self::Heights if t < 0.5 => along(&SEA, 2.0 * t),
            Self::Heights => along(&LAND, 2.0 * t - 1.0),
        }
    }

    /// True if the middle of the map has a meaning of its own.
    pub(crate) fn has_middle(self) -> bool {
        matches!(self, Self::Diverging | Self::Heights)
    }
}

fn along(points: &[u32], t: f32) -> [f32; 3] {
    let t = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 } * (points.len() - 1) as f32;
    let i = (t as usize).min(points.len() - 2);
    let rgb = |p: u32| [16, 8, 0].map(|s| ((p >> s) & 255) as f32 / 255.0);
    crate::math::mix(rgb(points[i]), rgb(points[i + 1]), t - i as f32)
}
