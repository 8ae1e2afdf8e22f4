//! A finished picture: 8-bit sRGB, row by row from the top.

use crate::math::V3;
use crate::noise::hash;

/// An 8-bit sRGB picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Colours, row by row from the top.
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// A picture of one colour.
    pub fn new(width: usize, height: usize, colour: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// The colour at (column, row).
    ///
    /// # Panics
    /// If the pixel is outside the picture.
    pub fn get(&self, x: usize, y: usize) -> [u8; 3] {
        assert!(x < self.width && y < self.height, "pixel ({x}, {y}) of a {}x{} picture", self.width, self.height);
        self.pixels[y * self.width + x]
    }

    /// The bytes of all pixels, as image encoders take them.
    pub fn bytes(&self) -> &[u8] {
        self.pixels.as_flattened()
    }
}

/// Linear light in 0..1 to the sRGB curve, still as a float.
pub(crate) fn encode(c: f32) -> f32 {
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// sRGB byte to linear light.
pub(crate) fn decode(b: u8) -> f32 {
    let c = f32::from(b) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// A filmic curve (Narkowicz' fit of the ACES reference): soft shoulder, slight toe, then the sRGB curve.
pub(crate) fn tone_map(c: V3) -> V3 {
    c.map(|x| {
        let x = x.max(0.0);
        encode((x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0))
    })
}

/// Encoded 0..1 values to bytes; `x`, `y` key a dither of half a step that keeps skies from banding.
pub(crate) fn quantise(c: V3, x: usize, y: usize) -> [u8; 3] {
    let d = (hash(x as i32, y as i32, 77) & 0xffff) as f32 / 65536.0;
    c.map(|v| (v * 255.0 + d).clamp(0.0, 255.0) as u8)
}
