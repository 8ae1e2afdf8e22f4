//! PNG, out: 16-bit grey for layers, 8-bit RGB for pictures.

use crate::atomic::{Watched, watched, write_atomically};
use crate::error::{Error, Result};
use crate::format::size_u32;
use eyot_core::{Layer, World};
use png::{BitDepth, ColorType, Encoder, EncodingError};
use std::io::Write;
use std::path::Path;

/// Keywords of the text chunks, read back by the importer.
pub(crate) mod key {
    pub(crate) const MIN: &str = "min";
    pub(crate) const MAX: &str = "max";
    pub(crate) const CELL_X: &str = "cell_x_m";
    pub(crate) const CELL_Y: &str = "cell_y_m";
    pub(crate) const GEOREFERENCE: &str = "georeference";
}

/// Largest value of a 16-bit sample.
pub(crate) const STEPS: f64 = 65535.0;

/// Writes `layer` with its smallest value as 0 and its largest as 65535.
pub(crate) fn write_png16(path: &Path, world: &World, layer: &Layer) -> Result<()> {
    let field = &layer.field;
    let (width, height) = size_u32(path, field.width(), field.height())?;
    let (min, max) = field.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    // In f64: the range of finite f32 values can overflow f32.
    let (low, range) = (f64::from(min), f64::from(max) - f64::from(min));
    let per_metre = if range > 0.0 { STEPS / range } else { 0.0 };
    let georeference = world.georeference.as_ref().and_then(|g| serde_json::to_string(g).ok());
    let texts = [
        ("Software", "Eyot".to_owned()),
        ("layer", layer.spec.name.to_string()),
        ("unit", layer.spec.unit.to_string()),
        ("Description", layer.spec.meaning.to_string()),
        // As f64, which has all digits of the f32: readers that compute in f64 then get the very scale used here.
        (key::MIN, format!("{low:?}")),
        (key::MAX, format!("{:?}", f64::from(max))),
        (key::CELL_X, format!("{:?}", world.grid.cell_x_m)),
        (key::CELL_Y, format!("{:?}", world.grid.cell_y_m)),
        (key::GEOREFERENCE, georeference.unwrap_or_default()),
    ];
    let encode = |out: Watched<'_>| {
        let failed = |e| as_error(path, e);
        let mut encoder = Encoder::new(out, width, height);
        encoder.set_color(ColorType::Grayscale);
        encoder.set_depth(BitDepth::Sixteen);
        for (keyword, text) in texts.into_iter().filter(|(_, text)| !text.is_empty()) {
            // A tEXt chunk holds Latin-1; most readers show iTXt as well, but the numbers must be where all look.
            let keyword = keyword.to_owned();
            if text.is_ascii() { encoder.add_text_chunk(keyword, text) } else { encoder.add_itxt_chunk(keyword, text) }
                .map_err(failed)?;
        }
        let mut writer = encoder.write_header().map_err(failed)?;
        let mut stream = writer.stream_writer().map_err(failed)?;
        let mut bytes = Vec::with_capacity(2 * field.width());
        for row in field.rows() {
            bytes.clear();
            bytes.extend(row.iter().flat_map(|&v| (((f64::from(v) - low) * per_metre).round() as u16).to_be_bytes()));
            stream.write_all(&bytes).map_err(Error::io(path, "write"))?;
        }
        stream.finish().map_err(failed)?;
        writer.finish().map_err(failed)
    };
    write_atomically(path, |file| watched(file, path, encode))
}

/// Writes an 8-bit picture; `pixels` are sRGB, row by row from the top.
///
/// # Errors
/// If there are not `width * height` pixels, if a side is 0 or beyond what PNG allows, or if the file cannot be
/// written.
pub fn write_rgb_png(path: &Path, width: usize, height: usize, pixels: &[[u8; 3]]) -> Result<()> {
    if width == 0 || height == 0 || width.checked_mul(height) != Some(pixels.len()) {
        let problem = format!("{} pixels do not make a picture of {width}x{height}", pixels.len());
        return Err(Error::format(path, problem, "give width times height pixels"));
    }
    let (w, h) = size_u32(path, width, height)?;
    let encode = |out: Watched<'_>| {
        let failed = |e| as_error(path, e);
        let mut encoder = Encoder::new(out, w, h);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(pixels.as_flattened()).map_err(failed)?;
        writer.finish().map_err(failed)
    };
    write_atomically(path, |file| watched(file, path, encode))
}

fn as_error(path: &Path, e: EncodingError) -> Error {
    match e {
        EncodingError::IoError(source) => Error::io(path, "write")(source),
        other => Error::format(path, other.to_string(), "write GeoTIFF or R32 instead"),
    }
}
