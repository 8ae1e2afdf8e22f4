//! The generator that reads a height map. It lives here because the land crate touches no files.

use crate::backend::io::{self, ReadOptions};
use crate::builtin;
use eyot_core::process::{Entry, Generator, Site};
use eyot_core::{Edge, Error, Field, Georeference, Grid, Limits, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A height map from a file: GeoTIFF, TIFF, PNG, EXR, NPY, Zarr, or raw numbers (R16, R32).
///
/// A file of another size than the grid is resampled to it: averaged when it is finer, interpolated when it is coarser.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Import {
    /// The file, relative to the recipe's folder; `builtin:NAME` is one of the height maps that come with Eyot.
    #[schemars(length(min = 1))]
    pub file: String,
    /// Height of black in a picture of whole numbers. Default: what the file says of itself, else its numbers as metres.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub low_m: Option<f64>,
    /// Height of white in a picture of whole numbers; see `low_m`.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub high_m: Option<f64>,
}

/// The registry line of [`Import`].
pub(crate) const IMPORT: Entry<dyn Generator> = Entry::<dyn Generator>::generator::<Import>("import", &[]);

impl Generator for Import {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        let fault = |reason: String| Error::BadParameter { owner: "import".into(), field: "file".into(), reason };
        let options = ReadOptions { low_m: self.low_m, high_m: self.high_m, ..ReadOptions::default() };
        let raster = read(&self.file, &options, &Limits::default()).map_err(fault)?;
        site.control.check()?;
        Ok(resample(&raster.field, &site.grid))
    }
}

/// Reads a raster by path or by `builtin:NAME`. The error is one sentence with its remedy.
pub(crate) fn read(file: &str, options: &ReadOptions, limits: &Limits) -> std::result::Result<io::Raster, String> {
    let Some(name) = file.strip_prefix("builtin:") else {
        return io::read_raster(Path::new(file), options, limits).map_err(|e| e.to_string());
    };
    let data = builtin::data(name).ok_or_else(|| missing_builtin(name))?;
    let unpack = || -> std::io::Result<(tempfile::TempDir, PathBuf)> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join(name);
        std::fs::write(&path, data)?;
        Ok((folder, path))
    };
    let (_folder, path) =
        unpack().map_err(|e| format!("cannot unpack `{file}` into the temporary folder: {e}; make room there"))?;
    io::read_raster(&path, options, limits).map_err(|e| e.to_string())
}

/// The path that a recipe in `folder` means, or a sentence about why there is no such file, and a remedy.
pub(crate) fn resolve(file: &str, folder: &Path) -> std::result::Result<String, (String, String)> {
    if let Some(name) = file.strip_prefix("builtin:") {
        return match builtin::data(name) {
            Some(_) => Ok(file.to_owned()),
            None => Err((format!("Eyot brings no height map `{name}`"), missing_builtin(name))),
        };
    }
    let path = folder.join(file);
    match std::fs::metadata(&path) {
        Ok(m) if m.is_file() || io::is_zarr(&path) => Ok(path.display().to_string()),
        Ok(_) => Err((
            format!("`{}` is not a file", path.display()),
            "give the name of a height map, such as .tif, .png, .exr, .npy, .r16 or .r32, or a Zarr store".into(),
        )),
        Err(e) => {
            let reason = if e.kind() == std::io::ErrorKind::NotFound {
                "there is no such file".to_owned()
            } else {
                e.to_string()
            };
            Err((
                format!("cannot read `{}`: {reason}", path.display()),
                "file names are relative to the recipe's folder".into(),
            ))
        }
    }
}

fn missing_builtin(name: &str) -> String {
    let all: Vec<&str> = builtin::DATA.iter().map(|d| d.0).collect();
    match crate::diagnostic::nearest(name, all.iter().copied()) {
        Some(n) => format!("did you mean `builtin:{n}`?"),
        None if all.is_empty() => "give the name of a file".to_owned(),
        None => format!("there is {}", crate::diagnostic::alternatives(all)),
    }
}

/// The georeference of the same extent in other cells.
pub(crate) fn rescaled(g: &Georeference, from: (usize, usize), to: (usize, usize)) -> Georeference {
    let (sx, sy) = (from.0 as f64 / to.0 as f64, from.1 as f64 / to.1 as f64);
    let t = g.transform;
    Georeference { transform: [t[0], t[1] * sx, t[2] * sy, t[3], t[4] * sx, t[5] * sy], ..g.clone() }
}

/// Fits a field to a grid of the same extent: the mean over bilinear samples, as many a cell as the field is finer.
pub(crate) fn resample(field: &Field, grid: &Grid) -> Field {
    if (field.width(), field.height()) == (grid.width, grid.height) {
        return field.clone();
    }
    let axis = |n: usize, to: usize, edge: Edge| -> Vec<Vec<(usize, usize, f64)>> {
        let ratio = n as f64 / to as f64;
        let samples = (ratio.ceil() as usize).max(1);
        let place = |i: isize| match edge {
            Edge::Wrap => i.rem_euclid(n as isize) as usize,
            Edge::Closed | Edge::Open => i.clamp(0, n as isize - 1) as usize,
        };
        let sample = |c: usize, s: usize| {
            let at = (c as f64 + (s as f64 + 0.5) / samples as f64) * ratio - 0.5;
            (place(at.floor() as isize), place(at.floor() as isize + 1), at - at.floor())
        };
        (0..to).map(|c| (0..samples).map(|s| sample(c, s)).collect()).collect()
    };
    // One axis after the other: the mean of products is the product of means here.
    let columns = axis(field.width(), grid.width, grid.rim.x);
    let rows = axis(field.height(), grid.height, grid.rim.y);
    let mean = |samples: &[(usize, usize, f64)], value: &dyn Fn(usize) -> f64| {
        let sum: f64 = samples.iter().map(|&(a, b, t)| value(a) * (1.0 - t) + value(b) * t).sum();
        sum / samples.len() as f64
    };
    let narrow = Field::from_fn(grid.width, field.height(), |x, y| {
        let row = field.row(y);
        mean(&columns[x], &|i| f64::from(row[i])) as f32
    });
    Field::from_fn(grid.width, grid.height, |x, y| mean(&rows[y], &|i| f64::from(narrow.get(x, i))) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::Rim;

    fn grid(w: usize, h: usize, rim: Rim) -> Grid {
        Grid::new(w, h, 1.0, rim, &Limits::default()).unwrap()
    }

    #[test]
    fn resampling_keeps_constants_and_means() {
        let flat = Field::new(7, 5, 3.5);
        assert!(resample(&flat, &grid(16, 3, Rim::CLOSED)).iter().all(|v| v == 3.5));
        let f = Field::from_fn(8, 8, |x, y| (x * 3 + y) as f32);
        let half = resample(&f, &grid(4, 4, Rim::WRAP));
        assert!((half.sum() / 16.0 - f.sum() / 64.0).abs() < 1e-4, "{} {}", half.sum() / 16.0, f.sum() / 64.0);
    }

    #[test]
    fn resampling_to_the_same_size_keeps_the_bits() {
        let f = Field::from_fn(3, 2, |x, y| 0.1 + x as f32 / (y + 1) as f32);
        assert_eq!(resample(&f, &grid(3, 2, Rim::CLOSED)), f);
    }

    #[test]
    fn one_cell_files_fill_any_grid() {
        assert!(resample(&Field::new(1, 1, 2.0), &grid(5, 4, Rim::OPEN)).iter().all(|v| v == 2.0));
    }
}
