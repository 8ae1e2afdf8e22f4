//! NPY, NumPy's array files: a short text header and the numbers.
//!
//! Format: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>. Place and meaning go to a JSON file
//! beside the array.

use crate::about::About;
use crate::atomic::put;
use crate::error::{Error, Result};
use crate::fill::Missing;
use crate::input::Opened;
use crate::raster::{Raster, ReadOptions, check_size};
use crate::rows::{Rows, band_rows, each_band};
use crate::sample::{ByteOrder, Narrowed, Sample};
use crate::sidecar::Sidecar;
use crate::target::Target;
use eyot_core::{Field, Limits};
use std::io::{BufReader, Read, Seek};
use std::path::Path;

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// Headers of plain arrays have a hundred bytes.
const MAX_HEADER_BYTES: usize = 1 << 16;
const FORMAT: &str = "npy";

/// Writes an array of (rows, columns), then the JSON file.
pub(crate) fn write(to: &Target<'_>, rows: &mut dyn Rows, about: &About) -> Result<()> {
    let path = to.place();
    let (width, height) = rows.size();
    let mut text = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({height}, {width}), }}");
    // The numbers start at a multiple of 64 bytes; the last byte of the header is a line break.
    let padded = (10 + text.len() + 1).next_multiple_of(64) - 11;
    text = format!("{text:<padded$}\n");
    let mut crc = crc32fast::Hasher::new();
    let mut range = (f32::INFINITY, f32::NEG_INFINITY);
    to.write(|file| {
        let head = [MAGIC, &[1, 0][..], &(text.len() as u16).to_le_bytes(), text.as_bytes()].concat();
        crc.update(&head);
        put(file, path, &head)?;
        let mut bytes = Vec::new();
        each_band(path, rows, band_rows(width, 1), |_, band| {
            range = band.iter().fold(range, |(lo, hi), &v| (lo.min(v), hi.max(v)));
            bytes.clear();
            bytes.extend(band.iter().flat_map(|v| v.to_le_bytes()));
            crc.update(&bytes);
            put(file, path, &bytes)
        })
    })?;
    let sidecar = Sidecar {
        min: Some(range.0),
        max: Some(range.1),
        crc32: Some(format!("{:08x}", crc.finalize())),
        ..Sidecar::of(FORMAT, (width, height), about)
    };
    sidecar.write(to)
}

/// Reads an array of two dimensions and of any real number type.
pub(crate) fn read(opened: &mut Opened<'_>, options: &ReadOptions, limits: &Limits) -> Result<Raster> {
    let (path, file, bytes) = (&*opened.at.place, &mut opened.input, opened.bytes);
    let io = || Error::io(path, "read");
    file.rewind().map_err(io())?;
    let mut input = BufReader::with_capacity(1 << 18, file);
    let (header, data_at) = header(path, &mut input)?;
    check_size(path, header.width, header.height, limits)?;
    let needed = header.width as u128 * header.height as u128 * header.kind.bytes() as u128;
    let there = bytes.saturating_sub(data_at);
    if u128::from(there) != needed {
        let problem = format!("an array of {}x{} needs {needed} bytes, {there} are there", header.height, header.width);
        return Err(Error::format(path, problem, "it is truncated or damaged: save it again with numpy.save"));
    }
    let (width, height) = (header.width, header.height);
    let mut field = Field::new(width, height, 0.0);
    let mut missing = Missing::new(width, height, options.nodata);
    let mut narrowed = Narrowed::default();
    // Fortran's order: column by column.
    let (outer, inner) = if header.fortran { (width, height) } else { (height, width) };
    let size = header.kind.bytes();
    let mut buffer = vec![0; inner * size];
    for i in 0..outer {
        input.read_exact(&mut buffer).map_err(io())?;
        for (j, b) in buffer.chunks_exact(size).enumerate() {
            let (x, y) = if header.fortran { (i, j) } else { (j, i) };
            let number = header.kind.number(b, header.order);
            missing.look_at(x, y, number);
            field.set(x, y, narrowed.of(number));
        }
    }
    let missing = missing.fill(path, &mut field)?;
    let s =
        Sidecar::beside(&opened.at, &[FORMAT])?.filter(|s| (s.width, s.height) == (width, height)).unwrap_or_default();
    Ok(s.describe(Raster { missing, scale: header.kind.scale(), rounded_by: narrowed.by(), ..Raster::of(field) }))
}

struct Header {
    kind: Sample,
    order: ByteOrder,
    fortran: bool,
    width: usize,
    height: usize,
}

/// The header and where the numbers start.
fn header(path: &Path, input: &mut impl Read) -> Result<(Header, u64)> {
    let broken = |what: &str| Error::format(path, format!("broken NPY: {what}"), "save it again with numpy.save");
    let io = || Error::io(path, "read");
    let mut prefix = [0; 8];
    input.read_exact(&mut prefix).map_err(|_| broken("it ends in its header"))?;
    let mut length = [0; 4];
    let of_length = match prefix[6] {
        1 => 2,
        2 | 3 => 4,
        v => return Err(broken(&format!("format version {v} is not known"))),
    };
    input.read_exact(&mut length[..of_length]).map_err(|_| broken("it ends in its header"))?;
    let length = u32::from_le_bytes(length) as usize;
    if length > MAX_HEADER_BYTES {
        return Err(broken(&format!("a header of {length} bytes")));
    }
    let mut text = Vec::new();
    input.take(length as u64).read_to_end(&mut text).map_err(io())?;
    let text = String::from_utf8(text).map_err(|_| broken("the header is no text"))?;
    if text.len() != length {
        return Err(broken("it ends in its header"));
    }
    // A Python literal: {'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }
    let after = |key: &str| {
        let at = text.find(&format!("'{key}'")).or_else(|| text.find(&format!("\"{key}\"")));
        at.map(|i| text[i + key.len() + 2..].trim_start().trim_start_matches(':').trim_start())
            .ok_or_else(|| broken(&format!("the header does not say `{key}`")))
    };
    let descr = after("descr")?;
    let descr = match descr.chars().next() {
        Some(quote @ ('\'' | '"')) => descr[1..].split(quote).next().unwrap_or(""),
        _ => {
            return Err(Error::format(path, "an array of records", "save one of its fields, of a plain number type"));
        }
    };
    let (order, code) = descr.split_at(descr.len().min(1));
    let kind = match code {
        "b1" => Sample::Unsigned(1),
        "u1" | "u2" | "u4" | "u8" => Sample::Unsigned(usize::from(code.as_bytes()[1] - b'0')),
        "i1" | "i2" | "i4" | "i8" => Sample::Signed(usize::from(code.as_bytes()[1] - b'0')),
        "f2" | "f4" | "f8" => Sample::Float(usize::from(code.as_bytes()[1] - b'0')),
        _ => {
            let problem = format!("an array of `{descr}`");
            return Err(Error::format(path, problem, "convert it, for example with .astype('float32')"));
        }
    };
    let order = match order {
        "<" | "|" => ByteOrder::Little,
        ">" => ByteOrder::Big,
        _ => return Err(broken(&format!("unknown order of bytes in `{descr}`"))),
    };
    let fortran = after("fortran_order")?.starts_with("True");
    let shape = after("shape")?.strip_prefix('(').and_then(|s| s.split(')').next());
    let shape = shape.ok_or_else(|| broken("the header's shape is no tuple"))?;
    let shape: Option<Vec<usize>> =
        shape.split(',').map(str::trim).filter(|s| !s.is_empty()).map(|s| s.parse().ok()).collect();
    // (1, rows, columns) is what many tools make of one band.
    let (height, width) = match shape.as_deref() {
        Some([h, w]) => (*h, *w),
        Some([1, h, w]) if !fortran => (*h, *w),
        Some(other) => {
            let problem = format!("an array of {} dimensions {other:?}, heights need (rows, columns)", other.len());
            return Err(Error::format(path, problem, "save one slice of it"));
        }
        None => return Err(broken("the header's shape holds no sizes")),
    };
    if width == 0 || height == 0 {
        return Err(Error::format(path, format!("an array of {height}x{width}"), "both sides must be at least 1"));
    }
    Ok((Header { kind, order, fortran, width, height }, (6 + 2 + of_length + length) as u64))
}
