//! Cloud Optimised GeoTIFF, out: `f32`, deflate with the floating-point predictor, tiles of 256, overviews.

use crate::about::About;
use crate::atomic::{watched, write_atomically};
use crate::error::{Error, Result};
use crate::format::{WriteOptions, size_u32};
use crate::rows::{Rows, band_rows, each_band};
use geotiff_writer::{
    CogBuilder, Compression, GeoTiffBuilder, GeoTransform, Predictor, RasterType, Resampling, TiffVariant,
};
use ndarray::{ArrayView2, s};
use std::path::Path;

const TILE: usize = 256;
/// What GIS users expect where nothing else is said.
const USUAL_NODATA: f32 = -9999.0;

/// Writes the values, all of which are valid, so the nodata value must be one that does not occur: the caller's, or the
/// source file's, -9999, or the lowest `f32`, whichever is free first.
pub(crate) fn write(path: &Path, rows: &mut dyn Rows, about: &About, options: &WriteOptions) -> Result<()> {
    let (width, height) = rows.size();
    let (w, h) = size_u32(path, width, height)?;
    let t = about.transform(height);
    let mut builder = GeoTiffBuilder::new(w, h)
        .tile_size(TILE as u32, TILE as u32)
        .compression(Compression::Deflate)
        .predictor(Predictor::FloatingPoint)
        .tiff_variant(TiffVariant::Auto)
        .transform(GeoTransform {
            origin_x: t[0],
            pixel_width: t[1],
            skew_x: t[2],
            origin_y: t[3],
            skew_y: t[4],
            pixel_height: t[5],
        });
    if let Some(value) = free_nodata(path, rows, about, options)? {
        builder = builder.nodata(&format!("{:?}", f64::from(value)));
    }
    // Pixel-is-area is the default. Saying so without a CRS makes GDAL invent a local one of unknown unit.
    if let Some(g) = &about.georeference
        && let Some(code) = g.epsg
    {
        // GeoTIFF keys have 16 bits; larger codes are not EPSG's own and cannot be said.
        if let Ok(code) = u16::try_from(code) {
            builder = builder.raster_type(RasterType::PixelIsArea);
            builder = if g.geographic { builder.geographic_epsg(code) } else { builder.projected_epsg(code) };
        }
    }
    let cog = CogBuilder::new(builder).overview_levels(overview_levels(w.max(h))).resampling(Resampling::Average);
    write_atomically(path, |file| {
        watched(file, path, |out| {
            let failed = |e| as_error(path, e);
            let mut tiles = cog.tile_writer::<f32, _>(out).map_err(failed)?;
            each_band(path, rows, TILE, |top, band| {
                let view = ArrayView2::from_shape((band.len() / width, width), band)
                    .map_err(|e| Error::format(path, e.to_string(), "this is a fault in eyot-io"))?;
                for left in (0..width).step_by(TILE) {
                    let tile = view.slice(s![.., left..(left + TILE).min(width)]);
                    tiles.write_tile(left, top, &tile).map_err(failed)?;
                }
                Ok(())
            })?;
            tiles.finish().map_err(failed).map(|_| ())
        })
    })
}

/// Halved until the smallest fits in one tile, which is what validators of the format ask for.
fn overview_levels(longer_side: u32) -> Vec<u32> {
    (1..31).map(|n| 1 << n).take_while(|level| longer_side.div_ceil(level / 2) > TILE as u32).collect()
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

fn as_error(path: &Path, e: geotiff_writer::Error) -> Error {
    match e {
        // Not of `path` itself, which is watched: the encoder keeps its blocks in a temporary file.
        geotiff_writer::Error::Io(source) => Error::io(&std::env::temp_dir(), "write temporary data to")(source),
        other => Error::format(path, other.to_string(), "check the world's georeference, or write R32"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overviews_halve_down_to_one_tile() {
        assert_eq!(overview_levels(1), [0u32; 0]);
        assert_eq!(overview_levels(256), [0u32; 0]);
        assert_eq!(overview_levels(257), [2]);
        assert_eq!(overview_levels(512), [2]);
        assert_eq!(overview_levels(1025), [2, 4, 8]);
    }
}
