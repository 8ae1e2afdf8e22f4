//! Cloud Optimised GeoTIFF, out: `f32`, deflate with the floating-point predictor, tiles of 256, overviews.
//!
//! The file begins with all that readers need to find tiles (header, GDAL's hints, directories), then come the tiles of the
//! coarsest overview, and so on up to full resolution. Memory holds one band of tiles for each level.

mod directory;
pub(crate) mod keys;
pub(crate) mod metadata;
mod pyramid;

use crate::about::About;
use crate::atomic::{put, watched};
use crate::error::{Error, Result};
use crate::options::{WriteOptions, size_u32};
use crate::rows::{Rows, band_rows, each_band, each_marked_band};
use crate::target::Target;
use directory::{Tagged, directory, header, header_bytes};
use metadata::{GDAL_METADATA, TEXTS};
use pyramid::{Level, Pyramid, TILE};
use std::path::Path;

/// What GIS users expect where nothing else is said.
pub(crate) const USUAL_NODATA: f32 = -9999.0;
/// What GDAL may rely on when it reads the file over a network. The number is the length of what follows.
const GDAL_HINTS: &str = "GDAL_STRUCTURAL_METADATA_SIZE=000140 bytes\n\
LAYOUT=IFDS_BEFORE_DATA\n\
BLOCK_ORDER=ROW_MAJOR\n\
BLOCK_LEADER=SIZE_AS_UINT4\n\
BLOCK_TRAILER=LAST_4_BYTES_REPEATED\n\
KNOWN_INCOMPATIBLE_EDITION=NO\n ";

/// Writes the values. The nodata value must be one that does not occur: the caller's, or the source file's, -9999, or the
/// lowest `f32`, whichever is free first.
pub(crate) fn write(to: &Target<'_>, rows: &mut dyn Rows, about: &About, options: &WriteOptions) -> Result<()> {
    let path = to.place();
    let (width, height) = rows.size();
    size_u32(path, width, height)?;
    let nodata = free_nodata(path, rows, about, options)?;
    let mut more = place(about, height);
    more.extend(words(about));
    let spool = |e| Error::io(to.folder(), "write temporary data to")(e);
    let holes = nodata.filter(|_| rows.missing().is_some());
    to.write(|file| {
        let mut pyramid = Pyramid::new(width, height, holes, to)?;
        each_marked_band(path, rows, TILE, holes, |_, band| pyramid.push(band).map_err(spool))?;
        let head = head(&pyramid.levels, nodata, &more);
        watched(file, path, |mut out| {
            put(&mut out, path, &head)?;
            pyramid.levels.iter_mut().rev().try_for_each(|level| level.copy_to(path, &mut out))
        })
    })
}

/// Everything before the tiles; `more` are tags of the full resolution.
fn head(levels: &[Level], nodata: Option<f32>, more: &[(u16, Tagged)]) -> Vec<u8> {
    let data: u64 = levels.iter().map(|l| l.spooled).sum();
    let build = |big: bool, data_start: u64| {
        let mut at = header_bytes(big) + GDAL_HINTS.len();
        at = at.next_multiple_of(8);
        let mut out = header(at as u64, big);
        out.extend(GDAL_HINTS.as_bytes());
        out.resize(at, 0);
        // In the file, coarser levels come first.
        let mut end = data_start + data;
        for (i, level) in levels.iter().enumerate() {
            end -= level.spooled;
            let tags = tags(level, i > 0, end, nodata, if i == 0 { more } else { &[] });
            let bytes = directory(&tags, out.len() as u64, i + 1 == levels.len(), big);
            out.extend(bytes);
        }
        out
    };
    // Its length does not depend on where the tiles begin.
    let length = |big| build(big, 0).len() as u64;
    let big = length(false) + data > u64::from(u32::MAX);
    build(big, length(big))
}

/// The tags of one level whose tiles begin at `start`, in ascending order.
fn tags(level: &Level, overview: bool, start: u64, nodata: Option<f32>, more: &[(u16, Tagged)]) -> Vec<(u16, Tagged)> {
    use Tagged::{Ascii, Long, Offset, Short};
    let mut tags = vec![
        (254, Long(vec![u32::from(overview)])),
        (256, Long(vec![level.width as u32])),
        (257, Long(vec![level.height as u32])),
        (258, Short(vec![32])),
        // Deflate; grey with black as the smallest value; one number a pixel; floating-point predictor; tiles.
        (259, Short(vec![8])),
        (262, Short(vec![1])),
        (277, Short(vec![1])),
        (284, Short(vec![1])),
        (317, Short(vec![3])),
        (322, Long(vec![TILE as u32])),
        (323, Long(vec![TILE as u32])),
        (324, Offset(level.tiles.iter().map(|t| start + t.offset).collect())),
        (325, Long(level.tiles.iter().map(|t| t.bytes).collect())),
        (339, Short(vec![3])),
    ];
    tags.extend_from_slice(more);
    if let Some(value) = nodata {
        tags.push((42113, Ascii(format!("{:?}", f64::from(value)))));
    }
    tags.sort_by_key(|(tag, _)| *tag);
    tags
}

/// The tags that say in words what the raster is.
fn words(about: &About) -> Vec<(u16, Tagged)> {
    let texts = TEXTS.iter().filter_map(|(tag, name)| Some((*tag, about.tags.get(*name)?.clone())));
    // A zero ends a text.
    let texts = texts.filter(|(_, text)| !text.contains('\0'));
    texts.chain(metadata::xml(about).map(|xml| (GDAL_METADATA, xml))).map(|(tag, t)| (tag, Tagged::Ascii(t))).collect()
}

/// The tags that say where the raster lies.
fn place(about: &About, height: usize) -> Vec<(u16, Tagged)> {
    let t = about.transform(height);
    let mut tags = if t[2] == 0.0 && t[4] == 0.0 && t[1] > 0.0 && t[5] < 0.0 {
        vec![
            (33550, Tagged::Double(vec![t[1], -t[5], 0.0])),
            (33922, Tagged::Double(vec![0.0, 0.0, 0.0, t[0], t[3], 0.0])),
        ]
    } else {
        let matrix = [t[1], t[2], 0.0, t[0], t[4], t[5], 0.0, t[3], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        vec![(34264, Tagged::Double(matrix.to_vec()))]
    };
    // GeoTIFF keys have 16 bits; larger codes are not EPSG's own and cannot be said. Without a code nothing is said:
    // that pixels are areas is the default, and saying so makes GDAL invent a local system of unknown unit.
    let code = about.georeference.as_ref().and_then(|g| Some((u16::try_from(g.epsg?).ok()?, g.geographic)));
    let system = about.georeference.as_ref().and_then(|g| keys::tags(g.system.as_ref()?));
    if let Some(keys) = system {
        tags.extend(keys);
    } else if let Some((code, geographic)) = code {
        let (model, key) = if geographic { (2, 2048) } else { (1, 3072) };
        let keys = vec![1, 1, 0, 3, 1024, 0, 1, model, 1025, 0, 1, 1, key, 0, 1, code];
        tags.push((34735, Tagged::Short(keys)));
    }
    tags
}

/// A value that marks missing cells and does not occur in the data.
fn free_nodata(path: &Path, rows: &mut dyn Rows, about: &About, options: &WriteOptions) -> Result<Option<f32>> {
    let source = about.georeference.as_ref().and_then(|g| g.nodata).map(|v| v as f32).filter(|v| v.is_finite());
    let candidates: Vec<f32> = match options.nodata {
        Some(value) => vec![value],
        None => source.into_iter().chain([USUAL_NODATA, f32::MIN]).collect(),
    };
    let outside = |v: f32| about.range.is_some_and(|(low, high)| v < low || v > high);
    if let Some(&free) = candidates.first().filter(|&&v| outside(v)) {
        return Ok(Some(free));
    }
    let mut occurs = vec![false; candidates.len()];
    let per_band = band_rows(rows.size().0, 1);
    each_band(path, rows, per_band, |_, band| {
        for (found, candidate) in occurs.iter_mut().zip(&candidates).filter(|(found, _)| !**found) {
            *found = band.contains(candidate);
        }
        Ok(())
    })?;
    match (candidates.iter().zip(occurs).find(|(_, found)| !found), options.nodata) {
        (Some((&value, _)), _) => Ok(Some(value)),
        (None, None) => Ok(None),
        (None, Some(value)) => {
            let problem = format!("the value {value}, which is to mark missing cells, occurs in the data");
            Err(Error::format(path, problem, "choose another nodata value"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hints_say_their_own_length() {
        let (line, rest) = GDAL_HINTS.split_once('\n').unwrap();
        assert_eq!(line, format!("GDAL_STRUCTURAL_METADATA_SIZE={:06} bytes", rest.len()));
    }
}
