//! Reading a raster of any known format.

use crate::error::{Error, Result};
use crate::{geotiff_read, png_read, r32};
use eyot_core::{Field, Georeference, Limits};
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// A raster from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Values, row 0 north, all finite.
    pub field: Field,
    /// East-west and north-south size of a cell, m, if the file says; for geographic coordinates in the middle of the
    /// grid.
    pub cell_m: Option<(f64, f64)>,
    /// Where the raster lies, if the file says.
    pub georeference: Option<Georeference>,
    /// Cells that were missing in the file and have been filled from their neighbours.
    pub filled: usize,
}

/// What the file itself may leave open.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct ReadOptions {
    /// Value that black stands for in a PNG, m; by default what the file says.
    pub low_m: Option<f64>,
    /// Value that white stands for in a PNG, m; by default what the file says.
    pub high_m: Option<f64>,
    /// Value that marks missing cells; by default what the file says. Only GeoTIFF has such a value.
    pub nodata: Option<f64>,
}

/// Reads a raster. The format is told from the content, never from the name: TIFF and GeoTIFF (one band of any integer
/// or floating type), grey PNG of up to 16 bits, and R32 with its JSON file beside it.
///
/// Missing cells (the file's nodata value or `options.nodata`) are filled smoothly from their neighbours and counted.
/// Rasters that are stored from south to north or from east to west are turned over, together with their georeference.
///
/// # Errors
/// If the file cannot be read, is of no known format, broken, truncated, larger than `limits`, has several bands or
/// colours, no valid cell at all, or a value that is not finite and not marked as missing; the message names the file,
/// the problem and the remedy. Sizes are checked before anything of that size is allocated.
pub fn read_raster(path: &Path, options: &ReadOptions, limits: &Limits) -> Result<Raster> {
    let metadata = fs::metadata(path).map_err(Error::io(path, "read"))?;
    if metadata.is_dir() {
        return Err(Error::format(path, "this is a folder", "give the name of a file in it"));
    }
    if !metadata.is_file() {
        return Err(Error::format(path, "this is no ordinary file", "copy its content to a file first"));
    }
    let mut file = File::open(path).map_err(Error::io(path, "read"))?;
    if metadata.len() == 0 {
        return Err(Error::format(path, "the file is empty", "copy, download or export it again"));
    }
    // Before the signatures: raw floats can look like anything.
    if let Some(raster) = r32::read_if_described(path, &mut file, metadata.len(), limits)? {
        return finite(path, raster);
    }
    let mut start = Vec::with_capacity(8);
    Read::by_ref(&mut file).take(8).read_to_end(&mut start).map_err(Error::io(path, "read"))?;
    let raster = match start.as_slice() {
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => {
            drop(file);
            geotiff_read::read(path, metadata.len(), options, limits)
        }
        b"\x89PNG\r\n\x1a\n" => png_read::read(path, file, options, limits),
        _ => Err(unknown(path, &start)),
    }?;
    finite(path, raster)
}

/// Checks the size of a field before it is made. Rows are padded for the engine, by up to 80 values each, which is what
/// counts for narrow grids.
pub(crate) fn check_size(path: &Path, width: usize, height: usize, limits: &Limits) -> Result<u128> {
    const PADDING: u128 = 80;
    limits.check_cells(width, height).map_err(Error::core(path))?;
    let bytes = (width as u128 + PADDING) * (height as u128 + 2) * 4;
    limits.check_bytes("the raster", bytes).map_err(Error::core(path))?;
    Ok(bytes)
}

fn unknown(path: &Path, start: &[u8]) -> Error {
    if path.extension().is_some_and(|e| e == "r32") {
        let problem = format!("an R32 file needs its description in `{}`", r32::sidecar_path(path).display());
        return Error::format(path, problem, "copy both files together");
    }
    let (problem, remedy) = match start {
        [b'{', ..] if path.extension().is_some_and(|e| e == "json") => {
            ("this is a JSON file, not a raster", "give the name of the raster beside it")
        }
        [0x89, b'P', b'N', b'G', ..] => {
            ("the PNG signature is damaged", "it was copied as text: copy it again as binary")
        }
        [0xff, 0xd8, ..] => ("this is a JPEG image, which cannot hold heights", "convert it to 16-bit grey PNG"),
        _ => ("this is no GeoTIFF, PNG or R32 file", "convert it to GeoTIFF, for example with gdal_translate"),
    };
    Error::format(path, problem, remedy)
}

fn finite(path: &Path, raster: Raster) -> Result<Raster> {
    match raster.field.find_not_finite() {
        None => Ok(raster),
        Some((x, y, value)) => Err(Error::NotFinite {
            path: path.to_owned(),
            value,
            x,
            y,
            remedy: "mark missing cells with a nodata value, for example with gdal_translate -a_nodata nan",
        }),
    }
}
