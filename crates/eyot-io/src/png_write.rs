//! PNG, out: 16-bit grey for layers, 8-bit RGB for pictures, 8-bit grey and RGBA for masks and weights.

use crate::about::About;
use crate::atomic::watched;
use crate::error::{Error, Result};
use crate::options::{WriteOptions, size_u32};
use crate::rows::{Rows, band_rows, each_band};
use crate::scale::Scale;
use crate::target::Target;
use png::{BitDepth, ColorType, Encoder, EncodingError};
use std::io::Write;
use std::path::Path;

/// Keywords of the text chunks, read back by the importer.
pub(crate) mod key {
    pub(crate) const LAYER: &str = "layer";
    pub(crate) const UNIT: &str = "unit";
    pub(crate) const MEANING: &str = "Description";
    pub(crate) const MIN: &str = "min";
    pub(crate) const MAX: &str = "max";
    pub(crate) const CELL_X: &str = "cell_x_m";
    pub(crate) const CELL_Y: &str = "cell_y_m";
    pub(crate) const GEOREFERENCE: &str = "georeference";
    pub(crate) const TAGS: &str = "tags";
}

/// Writes the values as numbers from 0 to 65535.
pub(crate) fn write_png16(to: &Target<'_>, rows: &mut dyn Rows, about: &About, options: &WriteOptions) -> Result<()> {
    let path = to.place();
    let (width, height) = rows.size();
    let (w, h) = size_u32(path, width, height)?;
    let scale = Scale::of(path, rows, about, options)?;
    let georeference = about.georeference.as_ref().and_then(|g| serde_json::to_string(g).ok());
    let tags = if about.tags.is_empty() { None } else { serde_json::to_string(&about.tags).ok() };
    let texts = [
        ("Software", "Eyot".to_owned()),
        (key::LAYER, about.name.clone()),
        (key::UNIT, about.unit.clone()),
        (key::MEANING, about.meaning.clone()),
        // As f64, which has all digits of the f32: readers that compute in f64 then get the very scale used here.
        (key::MIN, format!("{:?}", scale.low)),
        (key::MAX, format!("{:?}", scale.high)),
        (key::CELL_X, format!("{:?}", about.cell_m.0)),
        (key::CELL_Y, format!("{:?}", about.cell_m.1)),
        (key::GEOREFERENCE, georeference.unwrap_or_default()),
        (key::TAGS, tags.unwrap_or_default()),
    ];
    let encode = |out: &mut dyn Write| {
        let failed = |e| as_error(path, e);
        let mut encoder = Encoder::new(out, w, h);
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
        let (mut numbers, mut bytes) = (Vec::new(), Vec::new());
        each_band(path, rows, band_rows(width, 1), |_, band| {
            scale.quantise(path, band, &mut numbers)?;
            bytes.clear();
            bytes.extend(numbers.iter().flat_map(|n| n.to_be_bytes()));
            stream.write_all(&bytes).map_err(Error::io(path, "write"))
        })?;
        stream.finish().map_err(failed)?;
        writer.finish().map_err(failed)
    };
    to.write(|file| watched(file, path, |mut out| encode(&mut out)))
}

/// Writes an 8-bit picture; `pixels` are sRGB, row by row from the top.
///
/// # Errors
/// If there are not `width * height` pixels, if a side is 0 or beyond what PNG allows, or if the file cannot be
/// written.
pub fn write_rgb_png<'a>(to: impl Into<Target<'a>>, width: usize, height: usize, pixels: &[[u8; 3]]) -> Result<()> {
    let to = to.into();
    if width == 0 || height == 0 || width.checked_mul(height) != Some(pixels.len()) {
        let problem = format!("{} pixels do not make a picture of {width}x{height}", pixels.len());
        return Err(Error::format(to.place(), problem, "give width times height pixels"));
    }
    write_bytes(&to, (width, height), ColorType::Rgb, &mut |first, out: &mut [[u8; 3]]| {
        out.copy_from_slice(&pixels[first * width..][..out.len()]);
        Ok(())
    })
}

/// Whole rows of pixels from a given row on.
pub(crate) type Pixels<'a, const N: usize> = dyn FnMut(usize, &mut [[u8; N]]) -> Result<()> + 'a;

/// Writes bytes that are no colours, such as masks: one channel or four, without any gamma.
pub(crate) fn write_data_png<const N: usize>(
    to: &Target<'_>,
    size: (usize, usize),
    pixels: &mut Pixels<'_, N>,
) -> Result<()> {
    write_bytes(to, size, if N == 1 { ColorType::Grayscale } else { ColorType::Rgba }, pixels)
}

fn write_bytes<const N: usize>(
    to: &Target<'_>,
    (width, height): (usize, usize),
    colour: ColorType,
    pixels: &mut Pixels<'_, N>,
) -> Result<()> {
    let path = to.place();
    let (w, h) = size_u32(path, width, height)?;
    let mut encode = |out: &mut dyn Write| {
        let failed = |e| as_error(path, e);
        let mut encoder = Encoder::new(out, w, h);
        encoder.set_color(colour);
        encoder.set_depth(BitDepth::Eight);
        if colour == ColorType::Rgb {
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        }
        let mut writer = encoder.write_header().map_err(failed)?;
        let mut stream = writer.stream_writer().map_err(failed)?;
        let per_band = band_rows(width, 1).min(height);
        let mut band = vec![[0; N]; width * per_band];
        for first in (0..height).step_by(per_band) {
            let band = &mut band[..width * per_band.min(height - first)];
            pixels(first, band)?;
            stream.write_all(band.as_flattened()).map_err(Error::io(path, "write"))?;
        }
        stream.finish().map_err(failed)?;
        writer.finish().map_err(failed)
    };
    to.write(|file| watched(file, path, |mut out| encode(&mut out)))
}

fn as_error(path: &Path, e: EncodingError) -> Error {
    match e {
        EncodingError::IoError(source) => Error::io(path, "write")(source),
        other => Error::format(path, other.to_string(), "write GeoTIFF or R32 instead"),
    }
}
