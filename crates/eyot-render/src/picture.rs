//! A finished picture: 8-bit sRGB, row by row from the top.

use crate::math::V3;
use eyot_noise::picture::hash;

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

    /// The picture with square pixels, given what its pixels measure across and down: the side with the longer pixels is
    /// stretched, linearly between the pixels.
    pub(crate) fn square(self, pixel_m: [f32; 2]) -> Self {
        let [across, down] = pixel_m;
        let (width, height) = if across > down {
            ((self.width as f32 * across / down).round() as usize, self.height)
        } else {
            (self.width, (self.height as f32 * down / across).round() as usize)
        };
        // Extreme cells would make extreme pictures.
        if width.max(height) > 16384 { self } else { self.resampled(width, height) }
    }

    /// The picture with so many pixels along its longer side, linearly between the pixels; if `even`, with the nearest even sides.
    pub(crate) fn with_longer_side(self, n: usize, even: bool) -> Self {
        let longer = self.width.max(self.height);
        let unit = if even { 2 } else { 1 };
        let side = |old: usize| unit * ((old as f64 * n as f64 / (longer * unit) as f64).round() as usize).max(1);
        let (width, height) = (side(self.width), side(self.height));
        self.resampled(width, height)
    }

    /// The picture with so many pixels along its longer side, each one of those that were there: between classes there is nothing.
    pub(crate) fn picked(self, n: usize) -> Self {
        let longer = self.width.max(self.height);
        let side = |old: usize| ((old as f64 * n as f64 / longer as f64).round() as usize).max(1);
        let (width, height) = (side(self.width), side(self.height));
        let mut out = Self::new(width, height, [0; 3]);
        for (i, p) in out.pixels.iter_mut().enumerate() {
            let (x, y) = (i % width, i / width);
            *p = self.get((2 * x + 1) * self.width / (2 * width), (2 * y + 1) * self.height / (2 * height));
        }
        out
    }

    fn resampled(self, width: usize, height: usize) -> Self {
        if (width, height) == (self.width, self.height) {
            return self;
        }
        let place = |i: usize, new: usize, old: usize| {
            let at = ((i as f32 + 0.5) * old as f32 / new as f32 - 0.5).clamp(0.0, (old - 1) as f32);
            (at as usize, (at as usize + 1).min(old - 1), at.fract())
        };
        let mut out = Self::new(width, height, [0; 3]);
        for y in 0..height {
            let (y0, y1, v) = place(y, height, self.height);
            for x in 0..width {
                let (x0, x1, u) = place(x, width, self.width);
                let corner = |x: usize, y: usize| self.pixels[y * self.width + x].map(f32::from);
                let (a, b, c, d) = (corner(x0, y0), corner(x1, y0), corner(x0, y1), corner(x1, y1));
                out.pixels[y * width + x] = std::array::from_fn(|k| {
                    let (north, south) = (a[k] + u * (b[k] - a[k]), c[k] + u * (d[k] - c[k]));
                    (north + v * (south - north)).round() as u8
                });
            }
        }
        out
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

/// Linear light, 0..1, of a colour on the sRGB curve.
pub fn linear(colour: [u8; 3]) -> V3 {
    colour.map(decode)
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
