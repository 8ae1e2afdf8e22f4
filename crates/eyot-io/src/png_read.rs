//! PNG, in: grey images of 8 or 16 bits as heights.

use crate::error::{Error, Result};
use crate::fill::Missing;
use crate::input::{Input, Opened};
use crate::png_write::key;
use crate::raster::{Raster, ReadOptions, check_compression, check_size};
use crate::scale::Meaning;
use eyot_core::{Field, Limits};
use png::{BitDepth, ColorType, Decoder, DecodingError, Transformations};
use std::io::{BufRead, BufReader, Seek};
use std::path::Path;

/// Reads a colour picture of 8 bits, as [`crate::write_rgb_png`] writes them: columns, rows and pixels.
///
/// # Errors
/// If it cannot be read, is another kind of picture, or exceeds the limits.
pub fn read_rgb_png<'a>(from: impl Into<Input<'a>>, limits: &Limits) -> Result<(usize, usize, Vec<[u8; 3]>)> {
    let Opened { at, input, .. } = from.into().open()?;
    let path = &*at.place;
    let failed = |e| as_error(path, e);
    let decoder = Decoder::new_with_limits(BufReader::new(input), png::Limits { bytes: METADATA_BYTES });
    let mut reader = decoder.read_info().map_err(failed)?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    if reader.output_color_type() != (ColorType::Rgb, BitDepth::Eight) || reader.info().interlaced {
        return Err(Error::format(path, "this is no colour picture of 8 bits", "write it with write_rgb_png"));
    }
    limits.check_bytes("the picture", 3 * width as u128 * height as u128).map_err(Error::beyond(path))?;
    let mut pixels = vec![[0; 3]; width * height];
    reader.next_frame(pixels.as_flattened_mut()).map_err(failed)?;
    Ok((width, height, pixels))
}

/// Text and colour profiles may use this much; images meet the limits of the caller.
const METADATA_BYTES: usize = 16 << 20;

pub(crate) fn read(opened: &mut Opened<'_>, options: &ReadOptions, limits: &Limits) -> Result<Raster> {
    let (path, file, bytes) = (&*opened.at.place, &mut opened.input, opened.bytes);
    file.rewind().map_err(Error::io(path, "read"))?;
    let failed = |e| as_error(path, e);
    let mut decoder = Decoder::new_with_limits(BufReader::new(file), png::Limits { bytes: METADATA_BYTES });
    // Grey of 1, 2 and 4 bits becomes 8 bits; a palette becomes RGB and is refused below.
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(failed)?;
    let (width, height, interlaced) = (header.width as usize, header.height as usize, header.interlaced);
    let held = check_size(path, width, height, limits)?;
    let bits = header.bit_depth as u128 * header.color_type.samples() as u128;
    check_compression(path, width, height, (width as u128 * bits).div_ceil(8) * height as u128, bytes)?;
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
    let (wide, largest) = if depth == BitDepth::Sixteen { (2, 65535.0) } else { (1, 255.0) };
    let meaning = Meaning::of(path, largest, number(&reader, key::MIN), number(&reader, key::MAX), options)?;
    let line = reader.output_line_size(width as u32).unwrap_or(usize::MAX);
    let mut missing = Missing::new(width, height, options.nodata);
    let mut values = |y: usize, row: &mut [f32], samples: &[u8]| {
        for (x, (v, s)) in row.iter_mut().zip(samples.chunks_exact(wide * channels)).enumerate() {
            let number = if wide == 2 { f64::from(u16::from_be_bytes([s[0], s[1]])) } else { f64::from(s[0]) };
            missing.look_at(x, y, number);
            // What cannot be seen has no height; whatever can be seen a little has one.
            if channels == 2 && s[wide..].iter().all(|alpha| *alpha == 0) {
                missing.mark(x, y);
            }
            *v = meaning.value(number);
        }
    };
    let field = if interlaced {
        // The passes of an interlaced image come together only in memory.
        limits
            .check_bytes("the interlaced image", (line as u128) * height as u128 + held)
            .map_err(Error::beyond(path))?;
        let mut bytes = vec![0; line * height];
        reader.next_frame(&mut bytes).map_err(failed)?;
        let mut field = Field::new(width, height, 0.0);
        field.rows_mut().zip(bytes.chunks_exact(line)).enumerate().for_each(|(y, (row, b))| values(y, row, b));
        field
    } else {
        let mut field = Field::new(width, height, 0.0);
        for (y, row) in field.rows_mut().enumerate() {
            let samples = reader.next_row().map_err(failed)?;
            let samples = samples.as_ref().map_or(&[][..], |r| r.data());
            if samples.len() < wide * channels * width {
                return Err(Error::format(
                    path,
                    "the PNG ends too early",
                    "it is truncated: copy or download it again",
                ));
            }
            values(y, row, samples);
        }
        // Checks what follows the last row, its checksums included.
        reader.next_row().map_err(failed)?;
        field
    };
    let text = |keyword: &str| text(&reader, keyword).unwrap_or_default();
    let cell_m = number(&reader, key::CELL_X).zip(number(&reader, key::CELL_Y)).filter(|&(x, y)| x > 0.0 && y > 0.0);
    let mut raster = Raster {
        cell_m,
        georeference: serde_json::from_str(&text(key::GEOREFERENCE)).ok(),
        name: text(key::LAYER),
        unit: text(key::UNIT),
        meaning: text(key::MEANING),
        tags: serde_json::from_str(&text(key::TAGS)).unwrap_or_default(),
        ..meaning.describe(Raster::of(field))
    };
    raster.missing = missing.fill(path, &mut raster.field)?;
    Ok(raster)
}

fn text(reader: &png::Reader<impl BufRead + Seek>, keyword: &str) -> Option<String> {
    let info = reader.info();
    let plain = info.uncompressed_latin1_text.iter().find(|t| t.keyword == keyword).map(|t| t.text.clone());
    // Compressed text could be a bomb, and this crate writes none.
    plain.or_else(|| info.utf8_text.iter().find(|t| t.keyword == keyword && !t.compressed)?.get_text().ok())
}

fn number(reader: &png::Reader<impl BufRead + Seek>, keyword: &str) -> Option<f64> {
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
