//! Small text in pictures: Noto Sans Mono, drawn once by its crate and stored there as grey values.

use crate::picture::Picture;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Height of a line, pixels.
pub(crate) const LINE: usize = RasterHeight::Size16.val();
/// How many times larger large text is.
pub(crate) const LARGE: usize = 2;

/// Width of `text`, pixels.
pub(crate) fn width(text: &str) -> usize {
    text.chars().count() * get_raster_width(FontWeight::Regular, RasterHeight::Size16)
}

/// Draws `text` with its top left corner at (x, y); what lies outside the picture is left out.
pub(crate) fn draw(p: &mut Picture, x: usize, y: usize, text: &str, ink: [u8; 3]) {
    draw_sized(p, x, y, text, ink, RasterHeight::Size16);
}

/// As [`draw`], [`LARGE`] times larger.
pub(crate) fn draw_large(p: &mut Picture, x: usize, y: usize, text: &str, ink: [u8; 3]) {
    draw_sized(p, x, y, text, ink, RasterHeight::Size32);
}

fn draw_sized(p: &mut Picture, x: usize, y: usize, text: &str, ink: [u8; 3], size: RasterHeight) {
    let mut left = x;
    for c in text.chars() {
        let glyph = |c| get_raster(c, FontWeight::Regular, size);
        let Some(g) = glyph(c).or_else(|| glyph('?')) else {
            continue;
        };
        for (dy, row) in g.rows().enumerate() {
            for (dx, &cover) in row.iter().enumerate() {
                let (px, py) = (left + dx, y + dy);
                if px < p.width && py < p.height {
                    let under = &mut p.pixels[py * p.width + px];
                    for k in 0..3 {
                        let (a, b) = (u32::from(under[k]), u32::from(ink[k]));
                        under[k] = ((a * (255 - u32::from(cover)) + b * u32::from(cover) + 127) / 255) as u8;
                    }
                }
            }
        }
        left += g.width();
    }
}
