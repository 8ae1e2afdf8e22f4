//! TIFF and GeoTIFF, in: one band of any number type, and the mask in the file or beside it.

use crate::error::{Error, Result};
use crate::fill::fill;
use crate::georef::{cell_size_m, face_north, is_nowhere, is_sound};
use crate::geotiff::metadata::{GDAL_METADATA, Metadata, TEXTS};
use crate::geotiff::{USUAL_NODATA, keys};
use crate::input::{At, Opened};
use crate::raster::{Raster, ReadOptions, check_compression, check_size};
use crate::sample::{Narrowed, Sample};
use eyot_core::{Field, Georeference, Limits};
use geotiff_reader::crs::ModelType;
use geotiff_reader::{Error as GeoError, GeoTiffFile};
use std::io::{Read, Seek};
use std::path::Path;
use tiff_reader::{Ifd, OpenOptions, ParseBudgets, RasterLayout, TagValue, TiffFile};

const GDAL_NODATA: u16 = 42113;
/// What a directory holds, in bits; this one is a mask.
const NEW_SUBFILE_TYPE: u16 = 254;
const OF_TRANSPARENCY: u32 = 4;
/// Rows of a mask that are decoded at a time.
const MASK_ROWS: usize = 512;
/// Length units of projected coordinates, GeoKey 3076; metres if absent.
const PROJECTED_LINEAR_UNITS: u16 = 3076;
/// The same of heights.
const VERTICAL_UNITS: u16 = 4099;
const FOOT: u16 = 9002;
const SURVEY_FOOT: u16 = 9003;

pub(crate) fn read(opened: Opened<'_>, options: &ReadOptions, limits: &Limits) -> Result<Raster> {
    let Opened { at, mut input, bytes: file_bytes } = opened;
    let path = &*at.place;
    let open = open_options(limits);
    let of_geo = match at.path() {
        Some(path) => GeoTiffFile::open_with_options(path, open),
        None => GeoTiffFile::from_bytes_with_options(hold(path, &mut input, limits)?, open),
    };
    let geo = match of_geo {
        Ok(geo) => Some(geo),
        Err(GeoError::NotGeoTiff) => None,
        Err(e) => return Err(broken(path, e)),
    };
    let plain = match &geo {
        Some(_) => None,
        None => Some(open_plain(&at, path, input, limits)?),
    };
    let (tiff, ifd) = match (&geo, &plain) {
        (Some(g), _) => (g.tiff(), g.tiff().ifd(g.base_ifd_index())),
        (None, Some(t)) => (t, t.ifd(0)),
        (None, None) => return Err(broken(path, GeoError::NotGeoTiff)),
    };
    let ifd = ifd.map_err(|e| broken(path, e))?;
    let layout = ifd.raster_layout().map_err(|e| broken(path, e))?;
    check(path, ifd, &layout, file_bytes, options.band, limits)?;

    let nodata = options.nodata.or_else(|| nodata_of(ifd));
    let Metadata { name, mut unit, meaning, tags, scale, offset } = metadata(ifd);
    let (mut field, mut missing, rounded_by) = decode(path, tiff, ifd, &layout, nodata, options.band.unwrap_or(1) - 1)?;
    mark_masked(path, tiff, &layout, &mut missing)?;
    mark_masked_beside(&at, &layout, options.band, limits, &mut missing)?;
    let (factor, offset) = (scale.unwrap_or(1.0), offset.unwrap_or(0.0));
    if (factor, offset) != (1.0, 0.0) {
        // Missing cells, too: they are filled from the others.
        field.rows_mut().flatten().for_each(|v| *v = (f64::from(*v) * factor + offset) as f32);
    }
    let bytes = usize::from(layout.bits_per_sample).div_ceil(8);
    let scale = match layout.sample_format {
        1 => Sample::Unsigned(bytes).scale(),
        2 => Sample::Signed(bytes).scale(),
        _ => None,
    };
    let scale =
        scale.map(|(low, high)| (low * factor + offset, high * factor + offset)).filter(|(low, high)| low < high);
    if let Some(missing) = &missing {
        fill(&mut field, missing)
            .ok_or_else(|| Error::format(path, "every cell is marked as missing", "check the file's nodata value"))?;
    }
    let mut georeference = geo.as_ref().and_then(|g| georeference(g, ifd, nodata));
    if let Some(g) = &mut georeference {
        face_north(&mut field, &mut missing, g);
    }
    let per_unit = geo.as_ref().map_or(1.0, metres_per_unit);
    // Absurd coordinates can overflow; a grid could not use such a size.
    let usable = |&(x, y): &(f64, f64)| x.is_finite() && y.is_finite() && x > 0.0 && y > 0.0;
    let cell_m = georeference.as_ref().map(|g| cell_size_m(g, layout.width, layout.height, per_unit)).filter(usable);
    if unit == "metre" {
        unit = "m".to_owned();
    } else if unit.is_empty() {
        unit = geo.as_ref().and_then(vertical_unit).unwrap_or_default().to_owned();
    }
    // What the writer says of a grid without a place; its cells are known now.
    let no_more =
        |g: &Georeference| is_nowhere(g, layout.height) && g.nodata.is_none_or(|n| n == f64::from(USUAL_NODATA));
    georeference = georeference.filter(|g| !no_more(g));
    Ok(Raster { cell_m, georeference, missing, name, unit, meaning, tags, scale, rounded_by, ..Raster::of(field) })
}

/// What the file says in words.
fn metadata(ifd: &Ifd) -> Metadata {
    let text = |tag: u16| match &ifd.tag(tag)?.value {
        TagValue::Ascii(text) => Some(text.trim_end_matches('\0')),
        _ => None,
    };
    let mut found = Metadata::parse(text(GDAL_METADATA).unwrap_or(""));
    let texts = TEXTS.iter().filter_map(|(tag, name)| Some((*name, text(*tag)?)));
    found.tags.extend(texts.filter(|(_, t)| !t.is_empty()).map(|(name, t)| (name.to_owned(), t.to_owned())));
    // How values lie in cells, which the transform says already.
    found.tags.remove("AREA_OR_POINT");
    found
}

/// The bytes of what is no file: the decoder reads files where they lie, and others in memory.
fn hold(path: &Path, mut input: impl Read + Seek, limits: &Limits) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    input.rewind().map_err(Error::io(path, "read"))?;
    let most = limits.max_bytes.saturating_add(1);
    input.take(most).read_to_end(&mut bytes).map_err(Error::io(path, "read"))?;
    limits.check_bytes("the file", bytes.len() as u128).map_err(Error::beyond(path))?;
    Ok(bytes)
}

/// A TIFF that lies at `path` if the image does at one, too; else in `input`.
fn open_plain(at: &At<'_>, path: &Path, input: impl Read + Seek, limits: &Limits) -> Result<TiffFile> {
    let open = open_options(limits);
    match at.path() {
        Some(_) => TiffFile::open_with_options(path, open),
        None => TiffFile::from_bytes_with_options(hold(path, input, limits)?, open),
    }
    .map_err(|e| broken(path, e))
}

fn open_options(limits: &Limits) -> OpenOptions {
    OpenOptions {
        block_cache_bytes: cache_bytes(limits) as usize,
        parse_budgets: ParseBudgets {
            // A DEM has one image, its overviews and perhaps masks.
            max_ifds: 64,
            max_ifd_entries: 4096,
            // Offsets of a hundred million cells in the smallest tiles take 3 MB.
            max_tag_value_bytes: 32 << 20,
            max_metadata_value_bytes: 64 << 20,
        },
        // One strip may be the whole image.
        decode_output_bytes: usize::try_from(limits.max_bytes).unwrap_or(usize::MAX),
        ..OpenOptions::default()
    }
}

/// Refuses images that are too large, have no data for their size, or more than one band.
fn check(
    path: &Path,
    ifd: &Ifd,
    layout: &RasterLayout,
    file_bytes: u64,
    band: Option<usize>,
    limits: &Limits,
) -> Result<()> {
    let (width, height) = (layout.width, layout.height);
    let field = check_size(path, width, height, limits)?;
    let cells = width as u128 * height as u128;
    // Filling takes a copy of the values, a mark for each, and both again in coarser levels.
    let fill = 7 * cells;
    let image = cells * layout.bytes_per_sample as u128 * layout.samples_per_pixel as u128;
    limits.check_bytes("the decoded image", image + fill + field).map_err(Error::beyond(path))?;
    let pixel = layout.bytes_per_sample as u128 * layout.samples_per_pixel as u128;
    let bands = layout.samples_per_pixel;
    match band {
        Some(band) if !(1..=bands).contains(&band) => {
            let problem = format!("the file has no band {band}");
            return Err(Error::format(path, problem, format!("choose one from 1 to {bands}")));
        }
        None if bands != 1 => {
            let problem = format!("the file has {bands} bands or colours, heights need one");
            let remedy = "say which with `band` in the step that imports it, or extract one, for example with gdal_translate -b 1";
            return Err(Error::format(path, problem, remedy));
        }
        _ => {}
    }
    // One block is decoded at a time; a hostile header can ask for a huge one in a tiny image.
    let block = match (ifd.tile_width(), ifd.tile_height()) {
        (Some(w), Some(h)) if ifd.is_tiled() => u128::from(w) * u128::from(h),
        _ => width as u128 * (u128::from(ifd.rows_per_strip()).min(height as u128)),
    } * pixel;
    let most = image.max(64 << 20);
    if block > most {
        let problem = format!("blocks of {block} bytes for an image of {image}");
        return Err(Error::format(path, problem, "it is damaged: copy or download it again"));
    }
    // What lies beside the values while they are read: a block as it is stored and unpacked, those that are kept, and the rows that are
    // handed over at a time.
    let kept = u128::from(cache_bytes(limits)).min(image);
    let rows = rows_at_once(ifd, height) as u128 * width as u128 * pixel;
    let held = field + fill + 2 * block + kept + rows;
    limits.check_bytes("the image with what it takes to read it", held).map_err(Error::beyond(path))?;
    check_compression(path, width, height, image, file_bytes)
}

/// Bytes of unpacked blocks that are kept for the next rows.
fn cache_bytes(limits: &Limits) -> u64 {
    // A few rows of tiles; each is needed for one window only.
    (64 << 20).min(limits.max_bytes / 16)
}

/// Rows that are handed over at a time: whole blocks, so that the second copy of the values stays small.
fn rows_at_once(ifd: &Ifd, height: usize) -> usize {
    let block = match ifd.tile_height() {
        Some(h) if ifd.is_tiled() => h as usize,
        _ => ifd.rows_per_strip() as usize,
    };
    let block = block.clamp(1, height.max(1));
    (block * 128usize.div_ceil(block)).min(height.max(1))
}

/// The values, which cells are missing (`None` if none is), and how far the values were rounded.
fn decode(
    path: &Path,
    tiff: &TiffFile,
    ifd: &Ifd,
    layout: &RasterLayout,
    nodata: Option<f64>,
    band: usize,
) -> Result<(Field, Option<Vec<bool>>, f64)> {
    let (width, height) = (layout.width, layout.height);
    let mut field = Field::new(width, height, 0.0);
    let mut missing: Option<Vec<bool>> = None;
    let mut narrowed = Narrowed::default();
    let rows_at_once = rows_at_once(ifd, height);
    let f32_samples = (layout.sample_format, layout.bits_per_sample) == (3, 32);
    let mut top = 0;
    while top < height {
        let rows = rows_at_once.min(height - top);
        // One arm a number type: the value as f32, and whether it is the nodata value in the file's own type.
        macro_rules! window {
            ($t:ty) => {{
                let window = tiff.read_band_window_from_ifd::<$t>(ifd, band, top, 0, rows, width);
                let window = window.map_err(|e| broken(path, e))?;
                for (i, &v) in window.iter().enumerate() {
                    let (x, y) = (i % width, top + i / width);
                    if nodata.is_some_and(|n| is_missing(v as f64, n, f32_samples)) {
                        missing.get_or_insert_with(|| vec![false; width * height])[y * width + x] = true;
                    } else if f32_samples {
                        field.row_mut(y)[x] = v as f32;
                    } else {
                        field.row_mut(y)[x] = narrowed.of(v as f64);
                    }
                }
            }};
        }
        match (layout.sample_format, layout.bits_per_sample) {
            (3, 32) => window!(f32),
            (3, 64) => window!(f64),
            (2, 8) => window!(i8),
            (2, 16) => window!(i16),
            (2, 32) => window!(i32),
            (2, 64) => window!(i64),
            (1, 1..=8) => window!(u8),
            (1, 9..=16) => window!(u16),
            (1, 32) => window!(u32),
            (1, 64) => window!(u64),
            (format, bits) => {
                let kind =
                    ["complex", "unsigned", "signed", "floating-point"].get(format as usize).unwrap_or(&"unknown");
                let problem = format!("{bits}-bit {kind} samples are not supported");
                return Err(Error::format(path, problem, "convert it, for example with gdal_translate -ot Float32"));
            }
        }
        top += rows;
    }
    if nodata.is_some() {
        mark_unwritten(ifd, width, height, &mut missing);
    }
    Ok((field, missing, narrowed.by()))
}

/// Marks the cells that the mask inside the file leaves out: a directory of its own, of the image's size, where 0 is outside.
fn mark_masked(path: &Path, tiff: &TiffFile, layout: &RasterLayout, missing: &mut Option<Vec<bool>>) -> Result<()> {
    let (width, height) = (layout.width, layout.height);
    let is_mask = |ifd: &&Ifd| {
        let kind = match ifd.tag(NEW_SUBFILE_TYPE).map(|t| &t.value) {
            Some(TagValue::Long(v)) => v.first().copied().unwrap_or(0),
            Some(TagValue::Short(v)) => u32::from(v.first().copied().unwrap_or(0)),
            _ => 0,
        };
        // Masks of overviews are smaller.
        kind & OF_TRANSPARENCY != 0
            && ifd.raster_layout().is_ok_and(|l| {
                (l.width, l.height, l.samples_per_pixel, l.sample_format) == (width, height, 1, 1)
                    && l.bits_per_sample <= 8
            })
    };
    match tiff.ifds().iter().find(is_mask) {
        Some(mask) => mark_zeros(path, tiff, mask, 0, (width, height), missing),
        None => Ok(()),
    }
}

/// Marks the cells that a mask beside the file leaves out: GDAL's `NAME.tif.msk`, a TIFF of the image's size with one band for all of its
/// bands, or one for each.
fn mark_masked_beside(
    at: &At<'_>,
    layout: &RasterLayout,
    band: Option<usize>,
    limits: &Limits,
    missing: &mut Option<Vec<bool>>,
) -> Result<()> {
    let Some((storage, name)) = at.beside(".msk") else { return Ok(()) };
    let path = &*storage.place(&name);
    let blob = storage.open(&name).map_err(Error::io(path, "read"))?;
    let tiff = open_plain(at, path, blob.input, limits)?;
    let mask = tiff.ifd(0).map_err(|e| broken(path, e))?;
    let m = mask.raster_layout().map_err(|e| broken(path, e))?;
    let bands = m.samples_per_pixel;
    let fits =
        (m.width, m.height) == (layout.width, layout.height) && (bands == 1 || bands == layout.samples_per_pixel);
    if !fits || m.sample_format != 1 || m.bits_per_sample > 8 {
        let problem = format!(
            "this mask has {} x {} cells in {bands} bands of {} bits, which does not fit the image beside it",
            m.width, m.height, m.bits_per_sample
        );
        return Err(Error::format(path, problem, "make it again from that image, or move it away"));
    }
    let band = if bands == 1 { 0 } else { band.unwrap_or(1) - 1 };
    mark_zeros(path, &tiff, mask, band, (m.width, m.height), missing)
}

/// Marks the cells where a mask is 0.
fn mark_zeros(
    path: &Path,
    tiff: &TiffFile,
    mask: &Ifd,
    band: usize,
    (width, height): (usize, usize),
    missing: &mut Option<Vec<bool>>,
) -> Result<()> {
    // A header may say anything of the mask as well.
    let block = match (mask.tile_width(), mask.tile_height()) {
        (Some(w), Some(h)) if mask.is_tiled() => u128::from(w) * u128::from(h),
        _ => width as u128 * u128::from(mask.rows_per_strip()).min(height as u128),
    };
    let cells = width as u128 * height as u128;
    if block > cells.max(64 << 20) {
        let problem = format!("blocks of {block} cells for a mask of {cells}");
        return Err(Error::format(path, problem, "it is damaged: copy or download it again"));
    }
    // Rows of a band at a time, for a mask is as large as the image.
    for top in (0..height).step_by(MASK_ROWS) {
        let rows = MASK_ROWS.min(height - top);
        let window = tiff.read_band_window_from_ifd::<u8>(mask, band, top, 0, rows, width);
        let window = window.map_err(|e| broken(path, e))?;
        for (i, _) in window.iter().enumerate().filter(|(_, inside)| **inside == 0) {
            missing.get_or_insert_with(|| vec![false; width * height])[top * width + i] = true;
        }
    }
    Ok(())
}

/// Marks the blocks that a sparse file leaves out: they stand for nodata, while the decoder gives zeros.
fn mark_unwritten(ifd: &Ifd, width: usize, height: usize, missing: &mut Option<Vec<bool>>) {
    let (counts, block) = match (ifd.tile_width(), ifd.tile_height()) {
        (Some(w), Some(h)) if ifd.is_tiled() => (ifd.tile_byte_counts(), (w as usize, h as usize)),
        _ => (ifd.strip_byte_counts(), (width, ifd.rows_per_strip() as usize)),
    };
    let block = (block.0.max(1), block.1.clamp(1, height));
    let across = width.div_ceil(block.0);
    for (i, _) in counts.into_iter().flatten().enumerate().filter(|&(_, bytes)| bytes == 0) {
        let (left, top) = (i % across * block.0, i / across * block.1);
        let right = (left + block.0).min(width);
        for y in top..(top + block.1).min(height) {
            missing.get_or_insert_with(|| vec![false; width * height])[y * width + left..y * width + right].fill(true);
        }
    }
}

/// True if `value` is the nodata value. For `f32` files that value is often written with the digits of an `f32`, which
/// name another `f64`.
fn is_missing(value: f64, nodata: f64, f32_samples: bool) -> bool {
    value == nodata || (value.is_nan() && nodata.is_nan()) || (f32_samples && value as f32 == nodata as f32)
}

/// GDAL's nodata tag, which plain TIFF files can have, too: a decimal number or `nan`, perhaps padded.
fn nodata_of(ifd: &Ifd) -> Option<f64> {
    let TagValue::Ascii(text) = &ifd.tag(GDAL_NODATA)?.value else {
        return None;
    };
    text.trim_matches(|c: char| c.is_whitespace() || c == '\0').parse().ok()
}

fn georeference(geo: &GeoTiffFile, ifd: &Ifd, nodata: Option<f64>) -> Option<Georeference> {
    let t = geo.transform()?;
    let transform = [t.origin_x, t.pixel_width, t.skew_x, t.origin_y, t.skew_y, t.pixel_height];
    // A degenerate transform says nothing, nor does the identity, which writers use for images without a place.
    let (epsg, system) = (geo.epsg(), keys::read(ifd, geo.epsg()));
    if transform == [0.0, 1.0, 0.0, 0.0, 0.0, 1.0] && epsg.is_none() && system.is_none() {
        return None;
    }
    let geographic = geo.crs().model_type_enum() == ModelType::Geographic;
    Some(Georeference { transform, epsg, geographic, nodata, system }).filter(is_sound)
}

fn metres_per_unit(geo: &GeoTiffFile) -> f64 {
    match geo.geokeys().get_short(PROJECTED_LINEAR_UNITS) {
        Some(FOOT) => 0.3048,
        Some(SURVEY_FOOT) => 1200.0 / 3937.0,
        _ => 1.0,
    }
}

/// The unit of heights in feet, which a file may say of its vertical datum instead of its band.
fn vertical_unit(geo: &GeoTiffFile) -> Option<&'static str> {
    match geo.geokeys().get_short(VERTICAL_UNITS)? {
        FOOT => Some("ft"),
        SURVEY_FOOT => Some("US survey foot"),
        _ => None,
    }
}

fn broken(path: &Path, e: impl std::error::Error + 'static) -> Error {
    let text = e.to_string();
    // The reader's own words follow; say first what users can act on.
    let (what, remedy) = if text.contains("exceeds decode output budget") {
        ("the TIFF is too large", "raise the limit or make it smaller with gdal_translate -outsize")
    } else if text.contains("unsupported") || text.contains("not supported") {
        ("this kind of TIFF is not read", "convert it with gdal_translate -co COMPRESS=DEFLATE -ot Float32")
    } else {
        ("the TIFF is broken or truncated", "copy or download it again")
    };
    Error::format(path, format!("{what}: {text}"), remedy)
}
