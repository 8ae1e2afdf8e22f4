//! Cloud Optimised GeoTIFF, out: `f32`, deflate with the floating-point predictor, tiles of 256, overviews.

use crate::atomic::{watched, write_atomically};
use crate::error::{Error, Result};
use crate::format::size_u32;
use eyot_core::{Field, Layer, World};
use geotiff_writer::{
    CogBuilder, Compression, GeoTiffBuilder, GeoTransform, Predictor, RasterType, Resampling, TiffVariant,
};
use ndarray::ArrayView2;
use std::path::Path;

const TILE: u32 = 256;
/// What GIS users expect where nothing else is said.
const USUAL_NODATA: f32 = -9999.0;

/// Writes `layer`. All its values are valid, so the nodata value is one that does not occur in it: the source file's,
/// -9999, or the lowest `f32`, whichever is free first.
pub(crate) fn write(path: &Path, world: &World, layer: &Layer) -> Result<()> {
    let (width, height) = (layer.field.width(), layer.field.height());
    let (w, h) = size_u32(path, width, height)?;
    let mut builder = GeoTiffBuilder::new(w, h)
        .tile_size(TILE, TILE)
        .compression(Compression::Deflate)
        .predictor(Predictor::FloatingPoint)
        .tiff_variant(TiffVariant::Auto)
        .transform(transform(world));
    if let Some(value) = free_nodata(world, &layer.field) {
        builder = builder.nodata(&format!("{:?}", f64::from(value)));
    }
    // Pixel-is-area is the default. Saying so without a CRS makes GDAL invent a local one of unknown unit.
    if let Some(g) = &world.georeference
        && let Some(code) = g.epsg
    {
        // GeoTIFF keys have 16 bits; larger codes are not EPSG's own and cannot be said.
        if let Ok(code) = u16::try_from(code) {
            builder = builder.raster_type(RasterType::PixelIsArea);
            builder = if g.geographic { builder.geographic_epsg(code) } else { builder.projected_epsg(code) };
        }
    }
    let cog = CogBuilder::new(builder).overview_levels(overview_levels(w.max(h))).resampling(Resampling::Average);
    let values = layer.field.to_vec();
    let view = ArrayView2::from_shape((height, width), &values)
        .map_err(|e| Error::format(path, e.to_string(), "this is a fault in eyot-io"))?;
    write_atomically(path, |file| watched(file, path, |out| cog.write_2d_to(out, view).map_err(|e| as_error(path, e))))
}

/// Halved until the smallest fits in one tile, which is what validators of the format ask for.
fn overview_levels(longer_side: u32) -> Vec<u32> {
    (1..31).map(|n| 1 << n).take_while(|level| longer_side.div_ceil(level / 2) > TILE).collect()
}

/// The world's georeference, or metres with the south-west corner at (0, 0).
fn transform(world: &World) -> GeoTransform {
    let t = match &world.georeference {
        Some(g) => g.transform,
        None => {
            let g = &world.grid;
            [0.0, g.cell_x_m, 0.0, g.height as f64 * g.cell_y_m, 0.0, -g.cell_y_m]
        }
    };
    GeoTransform { origin_x: t[0], pixel_width: t[1], skew_x: t[2], origin_y: t[3], skew_y: t[4], pixel_height: t[5] }
}

fn free_nodata(world: &World, field: &Field) -> Option<f32> {
    let source = world.georeference.as_ref().and_then(|g| g.nodata).map(|v| v as f32).filter(|v| v.is_finite());
    let occurs = |value: f32| field.rows().any(|r| r.contains(&value));
    source.into_iter().chain([USUAL_NODATA, f32::MIN]).find(|&v| !occurs(v))
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
