//! A height map from a file: GeoTIFF, TIFF, PNG or raw floats.
//!
//! # Equations
//! 1. A file with the grid's size is taken over to the bit.
//! 2. Another size, per axis: `h(i) = mean over s of lerp(f, a + (i + (s + 1/2) / n) r - 1/2)` with `r` the file's cells per cell of
//!    the grid, `a` the first cell of the window and `n = max(1, ceil(r))` samples: averages where the file is finer, interpolates
//!    where it is coarser. What a window leaves out is looked at where it borders on it.
//!
//! # Source
//! Linear interpolation.
//!
//! # Layers
//! Cells without a value (the number that marks them, the mask inside a GeoTIFF or beside it as `.msk`) are filled from their neighbours. Where a height
//! map is imported, the layer `missing` keeps them, and exports leave them empty; the process `holes` makes them an open rim, without it they are land. A grid that is taken `from` a file keeps its place on Earth.
//! Heights that the file says are feet become metres; other units stay as they are.

use eyot_core::process::{Entry, Generator, Site};
use eyot_core::remedy::Remedy;
use eyot_core::{BoundaryCondition, Error, Field, Grid, Limits, Result, about};
use eyot_io::{self as io, ReadOptions, RowOrder, Sample};
use eyot_recipe::{DATA, FirstRow, RasterInfo, Refusal, Resolver, alternatives, data, nearest};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A height map from a file: GeoTIFF, TIFF, PNG, EXR, NPY, Zarr, or raw numbers (R16, R32).
///
/// A file of another size than the grid is resampled to it: averaged when it is finer, interpolated when it is coarser. Heights
/// in feet become metres. A window takes a part of a large landscape, such as a slope of an island, for a finer grid.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Import {
    /// The file, relative to the recipe's folder; `builtin:NAME` is one of the height maps that come with Eyot.
    #[schemars(length(min = 1))]
    pub file: String,
    /// Height of black in a picture of whole numbers. Default: what the file says of itself; needed if it says nothing.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub low_m: Option<f64>,
    /// Height of white in a picture of whole numbers; see `low_m`.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub high_m: Option<f64>,
    /// The part of the file to take: distance of its western side from the file's, of its northern side from the file's, width
    /// and height. Default: all of it.
    #[schemars(inner(range(min = 0.0, max = 1e8)), extend("unit" = "m"))]
    pub window: Option<[f64; 4]>,
    /// Number in the file that marks missing cells. Default: what the file says. Missing cells are filled from their neighbours, and
    /// stay marked: the layer `missing` is 1 there, and exports of layers as GeoTIFF and Zarr leave them empty.
    #[schemars(extend("unit" = "1"))]
    pub nodata: Option<f64>,
    /// Band of a TIFF that has several, from 1. Default: the only one.
    #[schemars(range(min = 1, max = 65535), extend("unit" = "1"))]
    pub band: Option<u32>,
    /// Array of a Zarr store or channel of an EXR. Default: the height, or the only one.
    pub channel: Option<String>,
    /// Columns and rows of a file without header. Default: what the JSON file beside it says, or a square.
    #[schemars(inner(range(min = 1)), extend("unit" = "1"))]
    pub columns_rows: Option<[u32; 2]>,
    /// Numbers of a file without header, such as `u16le`, `i16be` or `f32le`. Default: what the JSON file or the extension says.
    #[schemars(regex(pattern = r"^[uif](8|16|32|64)(le|be)?$"))]
    pub numbers: Option<String>,
    /// Which row of a file without header comes first. Default: what the JSON file says, or the north.
    pub first_row: Option<FirstRow>,
    /// Memory that the file may take; the run's limit, no key of a recipe.
    #[schemars(skip)]
    pub(crate) max_bytes: Option<u64>,
    /// What the last reading found, so that it need not be read again for each question.
    #[serde(skip)]
    #[schemars(skip)]
    pub(crate) found: Seen,
}

/// What a file held beside its values when it was last read. A copy of an import has not read anything yet.
#[derive(Debug, Default)]
pub(crate) struct Seen(Mutex<Option<Arc<Found>>>);

impl Clone for Seen {
    fn clone(&self) -> Self {
        Self::default()
    }
}

#[derive(Debug)]
struct Found {
    /// What was asked for.
    file: String,
    options: ReadOptions,
    /// Columns and rows.
    size: (usize, usize),
    cell_m: Option<(f64, f64)>,
    /// Cells without a value.
    missing: Option<Vec<bool>>,
    /// How many these are.
    filled: usize,
    /// A number that usually marks such cells, and how many hold it.
    suspect: Option<(f32, usize)>,
}

/// The registry line of [`Import`]; it is here because the land crate touches no files.
pub static IMPORT: Entry<dyn Generator> =
    Entry::<dyn Generator>::generator::<Import>("import", about!("import.rs"), &[]);

impl Generator for Import {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        let (found, mut raster) = self.read(&site.grid)?;
        raster.to_metres();
        site.control.check()?;
        self.fit(&found, raster.field, &site.grid)
    }

    /// Reads the file: nothing less tells whether a run could, and a run may come to it after hours.
    fn check(&self, grid: &Grid) -> Result<()> {
        let found = self.found(grid)?;
        if let Some((mark, cells)) = found.suspect.filter(|(mark, _)| mark.abs() >= io::BEYOND_ALL) {
            let reason = format!(
                "{cells} cells hold {mark:e}, which is no height; if it marks missing cells, add nodata = {mark:e}"
            );
            return Err(Error::BadParameter { owner: "import".into(), field: "nodata".into(), reason });
        }
        self.cells(&found).map(drop)
    }

    fn missing(&self, grid: &Grid) -> Result<Option<Field>> {
        let found = self.found(grid)?;
        let Some(missing) = &found.missing else { return Ok(None) };
        let (width, height) = found.size;
        let marks = Field::from_fn(width, height, |x, y| f32::from(u8::from(missing[y * width + x])));
        let mut marks = self.fit(&found, marks, grid)?;
        // A cell that is mostly made up is missing.
        marks.map_in_place(|share| if share >= 0.5 { 1.0 } else { 0.0 });
        let any = marks.iter().any(|m| m > 0.0);
        Ok(any.then_some(marks))
    }

    fn doubts(&self, grid: &Grid) -> Vec<Remedy> {
        let Ok(found) = self.found(grid) else { return Vec::new() };
        let mut all = Vec::new();
        if found.missing.is_some() {
            let cells = found.filled;
            all.push(
                format!(
                    "{cells} cells of `{}` have no value: they are filled in, and exports leave them empty",
                    self.file
                )
                .into(),
            );
        }
        if let Some((mark, cells)) = found.suspect {
            all.push(
                format!(
                    "{cells} cells of `{}` hold {mark}, which usually marks missing cells and is taken for a height here; if it does, \
                     add nodata = {mark}",
                    self.file
                )
                .into(),
            );
        }
        all
    }

    fn bytes_per_cell(&self, _grid: &Grid) -> usize {
        // A file of the grid's size, the result, and what is decoded at a time. Larger files meet the limit when they are read.
        12
    }
}

/// A part of a raster in cells: first column, first row, columns and rows.
type Window = [f64; 4];

impl Import {
    /// The window in the file's cells; all of them without one.
    fn cells(&self, found: &Found) -> Result<Window> {
        let (w, h) = (found.size.0 as f64, found.size.1 as f64);
        let Some(window) = self.window else { return Ok([0.0, 0.0, w, h]) };
        let fault = |reason: String| Error::BadParameter { owner: "import".into(), field: "window".into(), reason };
        let Some((x, y)) = found.cell_m else {
            return Err(fault(format!("`{}` does not say how large its cells are", self.file)));
        };
        let [west, north, width, height] = window;
        let (east, south) = (west + width, north + height);
        // A hair beyond the border is rounding.
        let fits = width > 0.0 && height > 0.0 && east <= w * x * (1.0 + 1e-9) && south <= h * y * (1.0 + 1e-9);
        if !fits {
            let reason = format!(
                "a window from {west} to {east} m and from {north} to {south} m is not within `{}`, which measures {} x {} m",
                self.file,
                w * x,
                h * y
            );
            return Err(fault(reason));
        }
        Ok([west / x, north / y, width / x, height / y])
    }

    /// Values of the file, or of its window, on the grid.
    fn fit(&self, found: &Found, field: Field, grid: &Grid) -> Result<Field> {
        Ok(match self.window {
            Some(_) => resample_window(&field, self.cells(found)?, grid),
            None if found.size == (grid.width, grid.height) => field,
            None => resample(&field, grid),
        })
    }

    /// What the file holds beside its values: as it was read last, or else it is read for that.
    fn found(&self, grid: &Grid) -> Result<Arc<Found>> {
        let last = self.found.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match last {
            Some(found) if found.file == self.file && found.options == self.options()? => Ok(found),
            _ => self.read(grid).map(|(found, _)| found),
        }
    }

    fn options(&self) -> Result<ReadOptions> {
        let numbers = match self.numbers.as_deref() {
            None => None,
            Some(text) => Some(Sample::parse(text).ok_or_else(|| Error::BadParameter {
                owner: "import".into(),
                field: "numbers".into(),
                reason: format!("`{text}` is no kind of numbers; write u16le, u16be, i16le, u8, f32le or f64be"),
            })?),
        };
        Ok(ReadOptions {
            low_m: self.low_m,
            high_m: self.high_m,
            nodata: self.nodata,
            band: self.band.map(|b| b as usize),
            layer: self.channel.clone(),
            size: self.columns_rows.map(|[w, h]| (w as usize, h as usize)),
            sample: numbers.map(|n| n.0),
            byte_order: numbers.map(|n| n.1),
            row_order: self.first_row.map(row_order),
            ..ReadOptions::default()
        })
    }

    fn read(&self, grid: &Grid) -> Result<(Arc<Found>, io::Raster)> {
        let options = self.options()?;
        let mut limits = Limits::default();
        limits.max_bytes = self.max_bytes.unwrap_or(limits.max_bytes);
        let mut raster = read_raster(&self.file, &options, &limits).map_err(|reason| Error::BadFile {
            owner: "import".into(),
            field: "file".into(),
            reason,
        })?;
        // The file, the file in the grid's columns, and the result.
        let [file, narrow, result] = [
            (raster.field.width(), raster.field.height()),
            (grid.width, raster.field.height()),
            (grid.width, grid.height),
        ]
        .map(|(w, h)| Field::bytes_of(w, h));
        limits.check_bytes(&format!("fitting `{}` to the grid", self.file), file + narrow + result)?;
        let found = Arc::new(Found {
            file: self.file.clone(),
            options,
            size: (raster.field.width(), raster.field.height()),
            cell_m: raster.cell_m,
            filled: raster.filled(),
            suspect: raster.suspect(),
            missing: raster.missing.take(),
        });
        *self.found.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(found.clone());
        Ok((found, raster))
    }
}

/// Reads a raster by path or by `builtin:NAME`.
///
/// # Errors
/// One sentence with its remedy.
pub fn read_raster(file: &str, options: &ReadOptions, limits: &Limits) -> std::result::Result<io::Raster, Remedy> {
    let Some(name) = file.strip_prefix("builtin:") else {
        return io::read_raster(Path::new(file), options, limits).map_err(Remedy::from);
    };
    let found = data(name).ok_or_else(|| missing_builtin(name))?;
    let unpack = || -> std::io::Result<(tempfile::TempDir, PathBuf)> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join(name);
        std::fs::write(&path, found.bytes)?;
        Ok((folder, path))
    };
    let (_folder, path) =
        unpack().map_err(|e| format!("cannot unpack `{file}` into the temporary folder: {e}; make room there"))?;
    io::read_raster(&path, options, limits).map_err(Remedy::from)
}

/// The files of this machine, and the height maps that come with Eyot as `builtin:NAME`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Files;

impl Resolver for Files {
    fn text(&self, file: &str, folder: &Path) -> std::result::Result<String, Refusal> {
        eyot_recipe::fs::text(file, folder)
    }

    fn locate(&self, file: &str, folder: &Path) -> std::result::Result<String, Refusal> {
        if let Some(name) = file.strip_prefix("builtin:") {
            return match data(name) {
                Some(_) => Ok(file.to_owned()),
                None => Err(Refusal::new(format!("Eyot brings no height map `{name}`"), missing_builtin(name))),
            };
        }
        let path = folder.join(file);
        match std::fs::metadata(&path) {
            Ok(m) if m.is_file() || io::is_zarr(&path) => Ok(path.display().to_string()),
            Ok(_) => Err(Refusal::new(
                format!("`{}` is not a file", path.display()),
                "give the name of a height map, such as .tif, .png, .exr, .npy, .r16 or .r32, or a Zarr store",
            )),
            Err(e) => {
                let reason = if e.kind() == std::io::ErrorKind::NotFound {
                    "there is no such file".to_owned()
                } else {
                    e.to_string()
                };
                let help = eyot_recipe::fs::name_help(file);
                Err(Refusal::new(format!("cannot read `{}`: {reason}", path.display()), help))
            }
        }
    }

    fn raster(&self, located: &str, limits: &Limits) -> std::result::Result<RasterInfo, Refusal> {
        // Only size and place count here, so a picture need not say which heights its greys are, nor a file which band.
        let any_heights = ReadOptions { low_m: Some(0.0), high_m: Some(1.0), band: Some(1), ..ReadOptions::default() };
        let raster = read_raster(located, &any_heights, limits).map_err(|reason| {
            Refusal::new(reason, "it must be a height map: GeoTIFF, TIFF, PNG, EXR, NPY, Zarr, R16 or R32")
        })?;
        Ok(RasterInfo {
            width: raster.field.width(),
            height: raster.field.height(),
            cell_m: raster.cell_m,
            georeference: raster.georeference,
        })
    }
}

/// The order of rows in the words of the files.
pub(crate) fn row_order(first: FirstRow) -> RowOrder {
    match first {
        FirstRow::North => RowOrder::NorthFirst,
        FirstRow::South => RowOrder::SouthFirst,
    }
}

fn missing_builtin(name: &str) -> String {
    let all: Vec<&str> = DATA.iter().map(|d| d.name).collect();
    match nearest(name, all.iter().copied()) {
        Some(n) => format!("did you mean `builtin:{n}`?"),
        None if all.is_empty() => "give the name of a file".to_owned(),
        None => format!("there is {}", alternatives(all)),
    }
}

/// Fits a field to a grid of the same extent: the mean over bilinear samples, as many a cell as the field is finer.
pub(crate) fn resample(field: &Field, grid: &Grid) -> Field {
    if (field.width(), field.height()) == (grid.width, grid.height) {
        return field.clone();
    }
    resample_window(field, [0.0, 0.0, field.width() as f64, field.height() as f64], grid)
}

/// As [`resample`], for a part of the field.
fn resample_window(field: &Field, [left, top, columns, rows]: Window, grid: &Grid) -> Field {
    let axis =
        |n: usize, (from, size): (f64, f64), to: usize, edge: BoundaryCondition| -> Vec<Vec<(usize, usize, f64)>> {
            let ratio = size / to as f64;
            let samples = (ratio.ceil() as usize).max(1);
            // Only a whole field can be a ring.
            let is_ring = edge == BoundaryCondition::Wrap && size == n as f64;
            let place = |i: isize| if is_ring { i.rem_euclid(n as isize) } else { i.clamp(0, n as isize - 1) } as usize;
            let sample = |c: usize, s: usize| {
                let at = from + (c as f64 + (s as f64 + 0.5) / samples as f64) * ratio - 0.5;
                (place(at.floor() as isize), place(at.floor() as isize + 1), at - at.floor())
            };
            (0..to).map(|c| (0..samples).map(|s| sample(c, s)).collect()).collect()
        };
    // One axis after the other: the mean of products is the product of means here.
    let columns = axis(field.width(), (left, columns), grid.width, grid.rim.x);
    let rows = axis(field.height(), (top, rows), grid.height, grid.rim.y);
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
    use eyot_core::Boundary;

    fn grid(w: usize, h: usize, rim: Boundary) -> Grid {
        Grid::new(w, h, 1.0, rim, &Limits::default()).unwrap()
    }

    #[test]
    fn resampling_keeps_constants_and_means() {
        let flat = Field::new(7, 5, 3.5);
        assert!(resample(&flat, &grid(16, 3, Boundary::CLOSED)).iter().all(|v| v == 3.5));
        let f = Field::from_fn(8, 8, |x, y| (x * 3 + y) as f32);
        let half = resample(&f, &grid(4, 4, Boundary::WRAP));
        assert!((half.sum() / 16.0 - f.sum() / 64.0).abs() < 1e-4, "{} {}", half.sum() / 16.0, f.sum() / 64.0);
    }

    #[test]
    fn resampling_to_the_same_size_keeps_the_bits() {
        let f = Field::from_fn(3, 2, |x, y| 0.1 + x as f32 / (y + 1) as f32);
        assert_eq!(resample(&f, &grid(3, 2, Boundary::CLOSED)), f);
    }

    #[test]
    fn a_window_is_a_part_of_the_whole() {
        // A plane is itself under linear interpolation, away from the border.
        let plane = Field::from_fn(12, 10, |x, y| (2 * x + 5 * y) as f32);
        let part = resample_window(&plane, [3.0, 2.0, 4.0, 5.0], &grid(16, 20, Boundary::WRAP));
        let at = |i: usize, j: usize| {
            2.0 * (3.0 + (i as f64 + 0.5) / 4.0 - 0.5) + 5.0 * (2.0 + (j as f64 + 0.5) / 4.0 - 0.5)
        };
        for (i, j) in (0..16).flat_map(|i| (0..20).map(move |j| (i, j))) {
            assert!((f64::from(part.get(i, j)) - at(i, j)).abs() < 1e-5, "{i} {j}");
        }
        let same = resample_window(&plane, [3.0, 2.0, 4.0, 5.0], &grid(4, 5, Boundary::CLOSED));
        assert_eq!(same, Field::from_fn(4, 5, |x, y| plane.get(x + 3, y + 2)));
    }

    #[test]
    fn windows_beyond_the_file_are_refused() {
        let file = |window: [f64; 4]| Import {
            file: "builtin:island-reef.tif".into(),
            window: Some(window),
            ..Import::default()
        };
        let check = |window: [f64; 4]| file(window).check(&grid(8, 8, Boundary::CLOSED)).map_err(Remedy::from);
        assert_eq!(check([10.0, 10.0, 100.0, 50.0]), Ok(()));
        for window in [[0.0, 0.0, 1e6, 50.0], [1e5, 0.0, 10.0, 50.0], [0.0, 0.0, 0.0, 50.0]] {
            let e = check(window).unwrap_err();
            assert!(e.to_string().contains("window") && e.to_string().contains("m is not within"), "{e}");
        }
    }

    #[test]
    fn one_cell_files_fill_any_grid() {
        assert!(resample(&Field::new(1, 1, 2.0), &grid(5, 4, Boundary::OPEN)).iter().all(|v| v == 2.0));
    }
}
