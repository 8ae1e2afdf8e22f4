//! Headerless rasters: R32 (`f32`), R16 (`u16`) and their relatives, with a JSON file beside them.

use crate::about::About;
use crate::atomic::put;
use crate::error::{Error, Result};
use crate::fill::Missing;
use crate::input::Opened;
use crate::options::WriteOptions;
use crate::raster::{Raster, ReadOptions, check_size};
use crate::rows::{Rows, band_rows, each_band, each_band_from_south};
use crate::sample::{ByteOrder, Narrowed, RowOrder, Sample};
use crate::scale::{Meaning, Scale};
use crate::sidecar::{Sidecar, sidecar_path};
use crate::target::Target;
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Setting};
use eyot_core::{Field, Limits};
use std::io::{BufReader, Read, Seek};
use std::path::Path;

/// Formats of descriptions, with what they say of the numbers.
const FORMATS: [(&str, Sample); 2] = [("r32", Sample::F32), ("r16", Sample::U16)];

/// Writes the data, then the sidecar; a crash in between leaves a checksum that does not fit.
pub(crate) fn write(
    to: &Target<'_>,
    rows: &mut dyn Rows,
    about: &About,
    sample: Sample,
    options: &WriteOptions,
) -> Result<()> {
    let path = to.place();
    let scale = if sample == Sample::U16 { Some(Scale::of(path, rows, about, options)?) } else { None };
    let (size, per_band) = (rows.size(), band_rows(rows.size().0, 1));
    let mut crc = crc32fast::Hasher::new();
    let mut range = (f32::INFINITY, f32::NEG_INFINITY);
    to.write(|file| {
        let (mut bytes, mut numbers) = (Vec::new(), Vec::new());
        let mut take = |band: &[f32]| {
            range = band.iter().fold(range, |(lo, hi), &v| (lo.min(v), hi.max(v)));
            bytes.clear();
            let little = options.byte_order == ByteOrder::Little;
            if let Some(scale) = scale {
                scale.quantise(path, band, &mut numbers)?;
                bytes.extend(numbers.iter().flat_map(|n| if little { n.to_le_bytes() } else { n.to_be_bytes() }));
            } else {
                bytes.extend(band.iter().flat_map(|v| if little { v.to_le_bytes() } else { v.to_be_bytes() }));
            }
            crc.update(&bytes);
            put(file, path, &bytes)
        };
        match options.row_order {
            RowOrder::NorthFirst => each_band(path, rows, per_band, |_, band| take(band)),
            RowOrder::SouthFirst => each_band_from_south(path, rows, per_band, take),
        }
    })?;
    let format = FORMATS.iter().find(|(_, s)| *s == sample).map_or("", |(name, _)| name);
    let sidecar = Sidecar {
        min: Some(range.0),
        max: Some(range.1),
        low: scale.map(|s| s.low),
        high: scale.map(|s| s.high),
        byte_order: options.byte_order,
        row_order: options.row_order,
        crc32: Some(format!("{:08x}", crc.finalize())),
        ..Sidecar::of(format, size, about)
    };
    sidecar.write(to)
}

/// Reads an input if a sidecar lies beside it, or if its extension or the options say what it holds; else `None`.
pub(crate) fn read_if_known(opened: &mut Opened<'_>, options: &ReadOptions, limits: &Limits) -> Result<Option<Raster>> {
    let (path, file, bytes) = (&*opened.at.place, &mut opened.input, opened.bytes);
    let sidecar = Sidecar::beside(&opened.at, &FORMATS.map(|(name, _)| name))?;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let named = |name: &str| FORMATS.iter().find(|(n, _)| *n == name).map(|(_, s)| *s);
    let sample = match (&options.sample, &sidecar) {
        (Some(sample), _) => *sample,
        (None, Some(s)) => named(&s.format).or(named(&extension)).unwrap_or(Sample::F32),
        (None, None) if extension == "raw" => Sample::U16,
        (None, None) => match named(&extension) {
            Some(sample) => sample,
            None => return Ok(None),
        },
    };
    let (width, height) = size(path, bytes, sample, sidecar.as_ref(), options)?;
    check_size(path, width, height, limits)?;
    let needed = width as u128 * height as u128 * sample.bytes() as u128;
    if u128::from(bytes) != needed {
        let problem = format!("{width}x{height} cells need {needed} bytes, the file has {bytes}");
        let remedy: Remedy = match (&options.size, &sidecar) {
            (None, Some(_)) => "it is truncated or its .json belongs to another file: export it again".into(),
            _ => {
                remedy!["check the size (", Setting::InputSize, ") and the kind of numbers (", Setting::InputType, ")",]
            }
        };
        return Err(Error::format(path, problem, remedy));
    }
    let s = sidecar.unwrap_or_default();
    let meaning = meaning(path, sample, &s, options)?;
    let byte_order = options.byte_order.unwrap_or(s.byte_order);
    let north_first = options.row_order.unwrap_or(s.row_order) == RowOrder::NorthFirst;

    file.rewind().map_err(Error::io(path, "read"))?;
    let mut input = BufReader::with_capacity(1 << 18, file);
    let mut crc = crc32fast::Hasher::new();
    let mut field = Field::new(width, height, 0.0);
    let mut missing = Missing::new(width, height, options.nodata);
    let mut narrowed = Narrowed::default();
    let mut buffer = vec![0; sample.bytes() * width];
    for i in 0..height {
        input.read_exact(&mut buffer).map_err(Error::io(path, "read"))?;
        crc.update(&buffer);
        let y = if north_first { i } else { height - 1 - i };
        for (x, (v, b)) in field.row_mut(y).iter_mut().zip(buffer.chunks_exact(sample.bytes())).enumerate() {
            let number = sample.number(b, byte_order);
            missing.look_at(x, y, number);
            *v = meaning.map_or_else(|| narrowed.of(number), |m| m.value(number));
        }
    }
    let found = format!("{:08x}", crc.finalize());
    if s.crc32.as_ref().is_some_and(|c| !c.eq_ignore_ascii_case(&found)) {
        return Err(Error::format(path, "the checksum in its .json does not fit the data", "export the file again"));
    }
    let missing = missing.fill(path, &mut field)?;
    let raster = Raster { missing, scale: sample.scale(), rounded_by: narrowed.by(), ..Raster::of(field) };
    Ok(Some(s.describe(match meaning {
        Some(meaning) => meaning.describe(raster),
        None => raster,
    })))
}

/// Columns and rows: what the options say, or the sidecar, or a square.
fn size(
    path: &Path,
    bytes: u64,
    sample: Sample,
    sidecar: Option<&Sidecar>,
    options: &ReadOptions,
) -> Result<(usize, usize)> {
    let (width, height) = match (options.size, sidecar) {
        (Some(size), _) => size,
        (None, Some(s)) => (s.width, s.height),
        (None, None) => {
            let cells = bytes / sample.bytes() as u64;
            let side = cells.isqrt();
            if side * side != cells || cells * sample.bytes() as u64 != bytes {
                let problem = format!(
                    "its {bytes} bytes make no square, and there is no description in `{}`",
                    sidecar_path(path).display()
                );
                let remedy = remedy!["copy both files together, or say the size with ", Setting::InputSize.form()];
                return Err(Error::format(path, problem, remedy));
            }
            (side as usize, side as usize)
        }
    };
    if width == 0 || height == 0 {
        let at = if options.size.is_none() { sidecar_path(path) } else { path.to_owned() };
        return Err(Error::format(&at, format!("a grid of {width}x{height}"), "both sides must be at least 1"));
    }
    Ok((width, height))
}

/// What whole numbers of 8 and 16 bits without sign stand for; others are values as they are.
fn meaning(path: &Path, sample: Sample, s: &Sidecar, options: &ReadOptions) -> Result<Option<Meaning>> {
    let largest = match sample {
        Sample::Unsigned(1) => 255.0,
        Sample::Unsigned(2) => 65535.0,
        _ => return Ok(None),
    };
    Meaning::of(path, largest, s.low, s.high, options).map(Some)
}
