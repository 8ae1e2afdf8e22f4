//! Where writers take their values from: whole rows, band by band, so that a grid need not exist in memory.

use crate::error::{Error, Result};
use eyot_core::Field;
use std::path::Path;

/// Bytes of values that a writer holds at a time, about.
const BAND_BYTES: usize = 16 << 20;

/// A grid of values that can be read row by row, several times over.
///
/// Writers read bands of rows, each pass from the first to the last row or, for files that start in the south, from the
/// last to the first. Formats that must know something of all values in advance take one pass more; [`crate::About::range`]
/// spares it.
pub trait Rows {
    /// Columns and rows.
    fn size(&self) -> (usize, usize);

    /// Puts whole rows into `out`, from row `first` (0 is north) on; `out` holds a multiple of the columns and reaches at
    /// most to the last row.
    ///
    /// # Errors
    /// Whatever keeps the values from being made, a stop on request included.
    fn read(&mut self, first: usize, out: &mut [f32]) -> eyot_core::Result<()>;

    /// Cells, row by row from the north, whose values are only filled in. GeoTIFF and Zarr mark them as missing; the other
    /// formats have no mark that readers agree on and hold the filled values.
    fn missing(&self) -> Option<&[bool]> {
        None
    }
}

impl Rows for &Field {
    fn size(&self) -> (usize, usize) {
        (self.width(), self.height())
    }

    fn read(&mut self, first: usize, out: &mut [f32]) -> eyot_core::Result<()> {
        for (i, row) in out.chunks_exact_mut(self.width()).enumerate() {
            row.copy_from_slice(self.row(first + i));
        }
        Ok(())
    }
}

/// How many rows of `width` values make a band: a multiple of `unit`, at least one.
pub(crate) fn band_rows(width: usize, unit: usize) -> usize {
    (BAND_BYTES / 4 / width.max(1) / unit).max(1) * unit
}

/// Hands all rows to `take`, `per_band` at a time, with the first row of the band. All values are finite.
pub(crate) fn each_band(
    path: &Path,
    rows: &mut dyn Rows,
    per_band: usize,
    take: impl FnMut(usize, &[f32]) -> Result<()>,
) -> Result<()> {
    each_marked_band(path, rows, per_band, None, take)
}

/// As [`each_band`], with `mark` in place of the values that are missing.
pub(crate) fn each_marked_band(
    path: &Path,
    rows: &mut dyn Rows,
    per_band: usize,
    mark: Option<f32>,
    mut take: impl FnMut(usize, &[f32]) -> Result<()>,
) -> Result<()> {
    let (width, height) = rows.size();
    let mut band = vec![0.0; width * per_band.min(height)];
    for first in (0..height).step_by(per_band) {
        let values = &mut band[..width * per_band.min(height - first)];
        read_band(path, rows, first, values)?;
        if let (Some(mark), Some(missing)) = (mark, rows.missing()) {
            for (value, _) in values.iter_mut().zip(&missing[first * width..]).filter(|(_, missing)| **missing) {
                *value = mark;
            }
        }
        take(first, values)?;
    }
    Ok(())
}

/// As [`each_band`], from the last band to the first, rows within a band from south to north.
pub(crate) fn each_band_from_south(
    path: &Path,
    rows: &mut dyn Rows,
    per_band: usize,
    mut take: impl FnMut(&[f32]) -> Result<()>,
) -> Result<()> {
    let (width, height) = rows.size();
    let mut band = vec![0.0; width * per_band.min(height)];
    let mut turned = band.clone();
    for first in (0..height).step_by(per_band).rev() {
        let n = width * per_band.min(height - first);
        read_band(path, rows, first, &mut band[..n])?;
        for (to, from) in turned[..n].chunks_exact_mut(width).zip(band[..n].chunks_exact(width).rev()) {
            to.copy_from_slice(from);
        }
        take(&turned[..n])?;
    }
    Ok(())
}

/// Reads one band and makes sure that every value is finite.
pub(crate) fn read_band(path: &Path, rows: &mut dyn Rows, first: usize, out: &mut [f32]) -> Result<()> {
    rows.read(first, out).map_err(Error::core(path))?;
    match out.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(i) => {
            let width = rows.size().0;
            Err(Error::NotFinite {
                path: path.to_owned(),
                value: out[i],
                x: i % width,
                y: first + i / width,
                remedy: "no format can carry it on; this is a fault of the process that made the layer".into(),
            })
        }
    }
}

/// Smallest and largest value, by a pass over all rows.
pub(crate) fn range_of(path: &Path, rows: &mut dyn Rows) -> Result<(f32, f32)> {
    let mut range = (f32::INFINITY, f32::NEG_INFINITY);
    let per_band = band_rows(rows.size().0, 1);
    each_band(path, rows, per_band, |_, band| {
        range = band.iter().fold(range, |(lo, hi), &v| (lo.min(v), hi.max(v)));
        Ok(())
    })?;
    Ok(range)
}
