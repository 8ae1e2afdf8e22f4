//! Reading a raster of any known format.

use crate::about::About;
use crate::error::{Error, Result};
use crate::georef::is_sound;
use crate::input::Input;
use crate::rows::Rows;
use crate::sample::{ByteOrder, RowOrder, Sample};
use crate::{exr_read, geotiff_read, npy, png_read, raw, zarr};
use eyot_core::remedy;
use eyot_core::remedy::{Action, Remedy, Setting};
use eyot_core::{Field, Georeference, Limits};
use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::Path;

/// A file this much smaller than its content has lost its data or never had any. Deflate reaches 1032, LZW about 2700.
const MAX_COMPRESSION: u128 = 4096;
/// How OpenEXR files begin.
const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Keyword under which files of floats keep [`Raster::scale`].
pub(crate) const SCALE_TAG: &str = "scale_of_16_bits";

/// Numbers that files of heights use for missing cells.
const USUAL_MARKS: [f32; 6] = [-9999.0, -99999.0, -32768.0, -32767.0, 32767.0, 65535.0];
/// No number of any landscape, whatever its unit.
pub const BEYOND_ALL: f32 = 1e30;

/// What the numbers in a file are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Numbers {
    /// The values themselves.
    #[default]
    Values,
    /// Whole numbers that stand for values, as the file or the options say.
    Scaled,
    /// Whole numbers of which nothing says what they stand for, taken for the values; see [`ReadOptions::bare_numbers`].
    Bare,
}

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
    /// Which cells, row by row from the north, the file has no value for: they have been filled from their neighbours.
    pub missing: Option<Vec<bool>>,
    /// Name of the layer, or empty if the file does not say.
    pub name: String,
    /// Unit of the values, or empty.
    pub unit: String,
    /// What the values mean, or empty.
    pub meaning: String,
    /// What else the file says of itself, by keyword.
    pub tags: BTreeMap<String, String>,
    /// Values that 0 and 65535 stand for in a file of 16 bits that holds exactly these values: of whole numbers of 8 or 16
    /// bits, and of values that once were such numbers.
    pub scale: Option<(f64, f64)>,
    /// What the numbers in the file are.
    pub numbers: Numbers,
    /// How many rasters the file holds one after the other, the last of which this is; 1 but for stores with a time.
    pub steps: u64,
    /// The farthest that a value of the file is from the `f32` here; 0 unless the file holds wider numbers.
    pub rounded_by: f64,
}

impl Raster {
    /// Bare values of which nothing else is known.
    pub fn of(field: Field) -> Self {
        Self {
            field,
            cell_m: None,
            georeference: None,
            missing: None,
            name: String::new(),
            unit: String::new(),
            meaning: String::new(),
            tags: BTreeMap::new(),
            scale: None,
            numbers: Numbers::Values,
            steps: 1,
            rounded_by: 0.0,
        }
    }

    /// How many cells have been filled from their neighbours.
    pub fn filled(&self) -> usize {
        self.missing.iter().flatten().filter(|&&m| m).count()
    }

    /// A number at either end of the values that usually marks missing cells, and how many cells hold it; for files that do not say
    /// so of themselves. Of values in the file's own unit: before [`Raster::to_metres`].
    pub fn suspect(&self) -> Option<(f32, usize)> {
        let (low, high) = self.field.min_max();
        let marks = |v: &f32| USUAL_MARKS.contains(v) || v.abs() >= BEYOND_ALL;
        let mark = [low, high].into_iter().find(marks)?;
        Some((mark, self.field.iter().filter(|v| *v == mark).count()))
    }

    /// Turns heights in feet into metres. True if there was something to do.
    pub fn to_metres(&mut self) -> bool {
        let Some(factor) = metres_per(&self.unit) else { return false };
        self.field.rows_mut().flatten().for_each(|v| *v = (f64::from(*v) * factor) as f32);
        self.scale = self.scale.map(|(low, high)| (low * factor, high * factor));
        self.unit = "m".to_owned();
        true
    }

    /// The values for a writer, with the cells that the file had no value for.
    pub fn rows(&self) -> impl Rows {
        Holed { field: &self.field, missing: self.missing.as_deref() }
    }

    /// What a file made of it can say.
    pub fn about(&self) -> About {
        let mut tags = self.tags.clone();
        if let Some((low, high)) = self.scale {
            tags.insert(SCALE_TAG.to_owned(), format!("{low:?} {high:?}"));
        }
        About {
            name: self.name.clone(),
            unit: self.unit.clone(),
            meaning: self.meaning.clone(),
            cell_m: self.cell_m.unwrap_or((1.0, 1.0)),
            georeference: self.georeference.clone(),
            tags,
            range: None,
        }
    }
}

struct Holed<'a> {
    field: &'a Field,
    missing: Option<&'a [bool]>,
}

impl Rows for Holed<'_> {
    fn size(&self) -> (usize, usize) {
        (self.field.width(), self.field.height())
    }

    fn read(&mut self, first: usize, out: &mut [f32]) -> eyot_core::Result<()> {
        (&mut self.field).read(first, out)
    }

    fn missing(&self) -> Option<&[bool]> {
        self.missing
    }
}

/// Takes the scale out of the tags, where [`Raster::about`] has put it for formats of floats.
fn scale_of(tags: &mut BTreeMap<String, String>) -> Option<(f64, f64)> {
    let text = tags.remove(SCALE_TAG)?;
    let (low, high) = text.split_once(' ')?;
    let number = |s: &str| s.parse::<f64>().ok().filter(|v| v.is_finite());
    number(low).zip(number(high)).filter(|(low, high)| low <= high)
}

/// Metres in a unit of feet.
fn metres_per(unit: &str) -> Option<f64> {
    match unit.trim().to_ascii_lowercase().as_str() {
        "ft" | "foot" | "feet" | "international foot" => Some(0.3048),
        "us survey foot" | "us survey feet" | "us-ft" | "us_ft" | "ftus" | "foot_us" | "survey_foot" => {
            Some(1200.0 / 3937.0)
        }
        _ => None,
    }
}

/// What the file itself may leave open.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct ReadOptions {
    /// Value that 0 (black) stands for in a file of whole numbers of 8 or 16 bits, m; by default what the file says.
    pub low_m: Option<f64>,
    /// Value that the largest number (white) stands for; by default what the file says.
    pub high_m: Option<f64>,
    /// Takes whole numbers of 8 or 16 bits for the values themselves if nothing says what they stand for; such files are
    /// refused otherwise.
    pub bare_numbers: bool,
    /// Number in the file that marks missing cells; by default what the file says.
    pub nodata: Option<f64>,
    /// Which band of a TIFF that has several, from 1.
    pub band: Option<usize>,
    /// Which array of a Zarr store or channel of an EXR; by default the height, or the only one.
    pub layer: Option<String>,
    /// Columns and rows of a headerless file; by default what the file beside it says, or a square.
    pub size: Option<(usize, usize)>,
    /// Numbers of a headerless file; by default what the file beside it or the extension says.
    pub sample: Option<Sample>,
    /// Order of bytes of a headerless file; by default what the file beside it says, or little-endian.
    pub byte_order: Option<ByteOrder>,
    /// Order of rows of a headerless file; by default what the file beside it says, or north first.
    pub row_order: Option<RowOrder>,
}

/// True if the folder is a Zarr store, of whatever version.
pub fn is_zarr(folder: &Path) -> bool {
    zarr::is_node(folder) || [".zarray", ".zgroup"].iter().any(|f| folder.join(f).exists())
}

/// The names of the arrays of a Zarr store or of the channels of an EXR that holds several; none for other files.
///
/// # Errors
/// If the file cannot be read.
pub fn layer_names<'a>(from: impl Into<Input<'a>>) -> Result<Vec<String>> {
    let from = from.into();
    if let Some(path) = from.path().filter(|p| p.is_dir()) {
        return if zarr::is_node(path) { zarr::names(path) } else { Ok(Vec::new()) };
    }
    let mut start = [0; 4];
    let mut opened = from.open()?;
    match opened.input.read_exact(&mut start) {
        Ok(()) if start == EXR => exr_read::names(&mut opened),
        _ => Ok(Vec::new()),
    }
}

/// Reads a raster. The format is told from the content: TIFF and GeoTIFF (one band, or `options.band`, of any integer or floating type), grey
/// PNG of up to 16 bits, OpenEXR, NPY and Zarr v3 (a folder, by its path alone); and, as they have nothing that could tell, headerless files
/// by the JSON file beside them, by their extension (`.r32`, `.r16`, `.raw`) or by `options.sample`.
///
/// Missing cells (the file's nodata value or `options.nodata`, and what the mask inside a TIFF leaves out) are filled smoothly from their neighbours and counted.
/// Rasters that are stored from south to north or from east to west are turned over, together with their georeference.
///
/// # Errors
/// If the file cannot be read, is of no known format, broken, truncated, larger than `limits`, has several bands or
/// colours and none is chosen, no valid cell at all, or a value that is not finite and not marked as missing; the message names the file,
/// the problem and the remedy. Sizes are checked before anything of that size is allocated.
pub fn read_raster<'a>(from: impl Into<Input<'a>>, options: &ReadOptions, limits: &Limits) -> Result<Raster> {
    let from = from.into();
    if let Some(path) = from.path()
        && fs::metadata(path).map_err(Error::io(path, "read"))?.is_dir()
    {
        return read_folder(path, options, limits);
    }
    let mut opened = from.open()?;
    let path = &*opened.at.place.clone();
    if opened.bytes == 0 {
        return Err(Error::format(path, "the file is empty", "copy, download or export it again"));
    }
    // Before the signatures: raw numbers can look like anything.
    if let Some(raster) = raw::read_if_known(&mut opened, options, limits)? {
        return checked(path, raster);
    }
    let mut start = Vec::with_capacity(8);
    Read::by_ref(&mut opened.input).take(8).read_to_end(&mut start).map_err(Error::io(path, "read"))?;
    let raster = match start.as_slice() {
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => geotiff_read::read(opened, options, limits),
        b"\x89PNG\r\n\x1a\n" => png_read::read(&mut opened, options, limits),
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => npy::read(&mut opened, options, limits),
        start if start.starts_with(&EXR) => exr_read::read(&mut opened, options, limits),
        _ => Err(unknown(path, &start)),
    }?;
    checked(path, raster)
}

/// Reads a Zarr store, the only raster that is a folder.
fn read_folder(path: &Path, options: &ReadOptions, limits: &Limits) -> Result<Raster> {
    if zarr::is_node(path) {
        return checked(path, zarr::read(path, options, limits)?);
    }
    if is_zarr(path) {
        let problem = "this is a Zarr store of version 2, this program reads version 3";
        return Err(Error::format(path, problem, "write it again with zarr_format=3"));
    }
    Err(Error::format(path, "this is a folder", "give the name of a file in it"))
}

/// Checks the size of a field before it is made. Rows are padded for the engine, by up to 80 values each, which is what
/// counts for narrow grids.
pub(crate) fn check_size(path: &Path, width: usize, height: usize, limits: &Limits) -> Result<u128> {
    const PADDING: u128 = 80;
    limits.check_cells(width, height).map_err(Error::beyond(path))?;
    let bytes = (width as u128 + PADDING) * (height as u128 + 2) * 4;
    limits.check_bytes("the raster", bytes).map_err(Error::beyond(path))?;
    Ok(bytes)
}

/// Refuses files that are far too small for their content, before memory is taken for it.
pub(crate) fn check_compression(path: &Path, width: usize, height: usize, image: u128, file_bytes: u64) -> Result<()> {
    if image <= MAX_COMPRESSION * u128::from(file_bytes) {
        return Ok(());
    }
    let problem = format!("the file has {file_bytes} bytes, which cannot hold its {width}x{height} cells");
    Err(Error::format(path, problem, "it is truncated or damaged: copy, download or export it again"))
}

fn unknown(path: &Path, start: &[u8]) -> Error {
    let (problem, remedy): (_, Remedy) = match start {
        [b'{', ..] if path.extension().is_some_and(|e| e == "json") => {
            ("this is a JSON file, not a raster", "give the name of the raster beside it".into())
        }
        [0x89, b'P', b'N', b'G', ..] => {
            ("the PNG signature is damaged", "it was copied as text: copy it again as binary".into())
        }
        [0xff, 0xd8, ..] => ("this is a JPEG image, which cannot hold heights", "convert it to 16-bit grey PNG".into()),
        _ => (
            "this is no GeoTIFF, PNG, EXR, NPY, R16 or R32 file",
            remedy![
                "convert it to GeoTIFF, for example with gdal_translate, or say which bare numbers it holds (",
                Setting::InputType,
                ")",
            ],
        ),
    };
    Error::format(path, problem, remedy)
}

/// Every value must be finite; a cell size or place of no use is only unknown.
fn checked(path: &Path, mut raster: Raster) -> Result<Raster> {
    raster.cell_m = raster.cell_m.filter(|&(x, y)| x.is_finite() && y.is_finite() && x > 0.0 && y > 0.0);
    raster.georeference = raster.georeference.filter(is_sound);
    raster.scale = raster.scale.or(scale_of(&mut raster.tags));
    match raster.field.find_not_finite() {
        None => Ok(raster),
        Some((x, y, value)) => Err(Error::NotFinite {
            path: path.to_owned(),
            value,
            x,
            y,
            remedy: if value.is_nan() {
                remedy![
                    "if it marks missing cells, say so with ",
                    Setting::Nodata,
                    " (",
                    Action::Converter,
                    "), or in the file, for example with gdal_translate -a_nodata nan",
                ]
            } else {
                remedy![
                    "numbers beyond 3.4e38 do not fit the 32 bits of heights; if the file's own number marks missing \
                     cells, say so with ",
                    Setting::Nodata,
                    " (",
                    Action::Converter,
                    ")",
                ]
            },
        }),
    }
}
