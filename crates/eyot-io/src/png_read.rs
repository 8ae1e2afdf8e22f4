//! PNG, in: grey images of 8 or 16 bits as heights.

use crate::error::{Error, Result};
use crate::png_write::key;
use crate::raster::{Raster, ReadOptions, check_size};
use eyot_core::{Field, Limits};
use png::{BitDepth, ColorType, Decoder, DecodingError, Transformations};
use std::fs::File;
use std::io::{BufReader, Seek};
use std::path::Path;

/// Text and colour profiles may use this much; images meet the limits of the caller.
const METADATA_BYTES: usize = 16 << 20;

pub(crate) fn read(path: &Path, mut file: File, options: &ReadOptions, limits: &Limits) -> Result<Raster> {
    file.rewind().map_err(Error::io(path, "read"))?;
    let failed = |e| as_error(path, e);
    let mut decoder = Decoder::new_with_limits(BufReader::new(file), png::Limits { bytes: METADATA_BYTES });
    // Grey of 1, 2 and 4 bits becomes 8 bits; a palette becomes RGB and is refused below.
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(failed)?;
    let (width, height) = (header.width as usize, header.height as usize);
    let field = check_size(path, width, height, limits)?;
    // Two bytes and up to four channels a pixel.
    limits.check_bytes("the decoded image", width as u128 * height as u128 * 8 + field).map_err(Error::core(path))?;
    let mut reader = decoder.read_info().map_err(failed)?;
    let (colour, depth) = reader.output_color_type();
    let channels = match colour {
        ColorType::Grayscale => 1,
        ColorType::GrayscaleAlpha => 2,
        other => {
            let problem = format!("this is a colour image ({other:?}), heights must be grey");
            return Err(Error::format(path, problem, "convert it to 16-bit grey"));
        }
    };
    let range = value_range(path, &reader, options)?;
    let metadata = Metadata::of(&reader);

    let too_large = || Error::format(path, "the image does not fit in memory", "convert it to a smaller one");
    let mut bytes = Vec::new();
    let size = reader.output_buffer_size().ok_or_else(too_large)?;
    bytes.try_reserve_exact(size).map_err(|_| too_large())?;
    bytes.resize(size, 0);
    let line = reader.next_frame(&mut bytes).map_err(failed)?.line_size;

    let steps = if depth == BitDepth::Sixteen { 65535.0 } else { 255.0 };
    let to_value = |sample: f64| (range.0 + sample / steps * (range.1 - range.0)) as f32;
    let mut field = Field::new(width, height, 0.0);
    for (row, samples) in field.rows_mut().zip(bytes.chunks_exact(line)) {
        if depth == BitDepth::Sixteen {
            for (v, s) in row.iter_mut().zip(samples.chunks_exact(2 * channels)) {
                *v = to_value(f64::from(u16::from_be_bytes([s[0], s[1]])));
            }
        } else {
            for (v, s) in row.iter_mut().zip(samples.chunks_exact(channels)) {
                *v = to_value(f64::from(s[0]));
            }
        }
    }
    Ok(Raster { field, cell_m: metadata.cell_m, georeference: metadata.georeference, filled: 0 })
}

/// Values of black and white: what the caller says, or what the file says.
fn value_range(path: &Path, reader: &png::Reader<BufReader<File>>, options: &ReadOptions) -> Result<(f64, f64)> {
    let low = options.low_m.or_else(|| number(reader, key::MIN));
    let high = options.high_m.or_else(|| number(reader, key::MAX));
    match low.zip(high) {
        Some((low, high)) if (low as f32).is_finite() && (high as f32).is_finite() => Ok((low, high)),
        Some((low, high)) => Err(Error::format(
            path,
            format!("black is {low} and white is {high}"),
            "give finite numbers for low_m and high_m",
        )),
        None => Err(Error::format(
            path,
            "the file does not say which heights black and white stand for",
            "import it in a recipe: generate = \"import\" with low_m and high_m",
        )),
    }
}

struct Metadata {
    cell_m: Option<(f64, f64)>,
    georeference: Option<eyot_core::Georeference>,
}

impl Metadata {
    fn of(reader: &png::Reader<BufReader<File>>) -> Self {
        let cell_m = number(reader, key::CELL_X).zip(number(reader, key::CELL_Y));
        Self {
            cell_m: cell_m.filter(|&(x, y)| x > 0.0 && y > 0.0),
            georeference: text(reader, key::GEOREFERENCE).and_then(|t| serde_json::from_str(t).ok()),
        }
    }
}

fn text<'a>(reader: &'a png::Reader<BufReader<File>>, keyword: &str) -> Option<&'a str> {
    reader.info().uncompressed_latin1_text.iter().find(|t| t.keyword == keyword).map(|t| t.text.as_str())
}

fn number(reader: &png::Reader<BufReader<File>>, keyword: &str) -> Option<f64> {
    text(reader, keyword)?.trim().parse().ok().filter(|v: &f64| v.is_finite())
}

fn as_error(path: &Path, e: DecodingError) -> Error {
    match e {
        DecodingError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            Error::format(path, "the PNG ends too early", "it is truncated: copy or download it again")
        }
        DecodingError::IoError(source) => Error::io(path, "read")(source),
        other => Error::format(path, format!("broken PNG: {other}"), "copy, download or export it again"),
    }
}
