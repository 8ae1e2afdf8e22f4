//! Raster formats by name, and the functions that write a layer in any of them.

use crate::about::About;
use crate::error::{Error, Result};
use crate::options::WriteOptions;
use crate::raster::SCALE_TAG;
use crate::rows::Rows;
use crate::sample::Sample;
use crate::target::Target;
use crate::{exr_write, geotiff, npy, png_write, raw, zarr};
use eyot_core::{Layer, World};

/// Formats that a layer can be written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum RasterFormat {
    /// 16-bit grey PNG; the scale is kept in text chunks.
    Png16,
    /// Cloud Optimised GeoTIFF of `f32`, exact.
    GeoTiff,
    /// Headerless `f32` with a JSON file beside it, exact.
    R32,
    /// Headerless `u16` with a JSON file beside it that says the scale.
    R16,
    /// OpenEXR with one channel of `f32`, exact.
    Exr,
    /// NumPy's array file of `f32` with a JSON file beside it, exact.
    Npy,
    /// Zarr v3 store, a folder, with one array of `f32` and its coordinates, exact.
    Zarr,
}

impl RasterFormat {
    /// All formats.
    pub const ALL: [Self; 7] = [Self::Png16, Self::GeoTiff, Self::R32, Self::R16, Self::Exr, Self::Npy, Self::Zarr];
    /// Their names in recipes, in the order of [`RasterFormat::ALL`].
    pub const NAMES: [&'static str; 7] = ["png16", "geotiff", "r32", "r16", "exr", "npy", "zarr"];

    /// The format with this name in recipes.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }

    /// The format that files with this extension (without the dot, any case) are in.
    pub fn from_extension(extension: &str) -> Option<Self> {
        Some(match extension.to_ascii_lowercase().as_str() {
            "tiff" => Self::GeoTiff,
            "raw" => Self::R16,
            other => Self::ALL.into_iter().find(|f| f.extension() == other)?,
        })
    }

    /// Name in recipes.
    pub const fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Usual file name extension, without the dot.
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Png16 => "png",
            Self::GeoTiff => "tif",
            Self::R32 => "r32",
            Self::R16 => "r16",
            Self::Exr => "exr",
            Self::Npy => "npy",
            Self::Zarr => "zarr",
        }
    }

    /// True if values are stored as whole numbers of 16 bits.
    pub const fn is_quantised(self) -> bool {
        matches!(self, Self::Png16 | Self::R16)
    }
}

/// Writes one layer of a world with the usual options; see [`write_rows`].
///
/// # Errors
/// If the layer has another size than the world's grid, and as [`write_rows`].
pub fn write_layer<'a>(to: impl Into<Target<'a>>, world: &World, layer: &Layer, format: RasterFormat) -> Result<()> {
    let to = to.into();
    let (grid, field) = (&world.grid, &layer.field);
    if (field.width(), field.height()) != (grid.width, grid.height) || grid.cells() == 0 {
        let problem = format!(
            "layer `{}` has {}x{} cells, the world's grid {}x{}",
            layer.spec.name,
            field.width(),
            field.height(),
            grid.width,
            grid.height
        );
        return Err(Error::format(to.place(), problem, "write layers of this world only"));
    }
    write_rows(to, &mut &layer.field, &About::of(world, layer), format, &WriteOptions::default())
}

/// Writes a raster band by band: a grid of any size needs a few dozen megabytes beside what `rows` holds itself.
///
/// R32, R16 and NPY also write `PATH.json`; Zarr makes a folder. All but the 16-bit formats hold the values exactly, those
/// within half of a 65535th of the scale.
///
/// # Errors
/// If `rows` fails or gives a value that is not finite, if values leave the given scale, if the raster is too large for
/// the format, or if the file cannot be written. A file that was there before is then unharmed.
pub fn write_rows<'a>(
    to: impl Into<Target<'a>>,
    rows: &mut dyn Rows,
    about: &About,
    format: RasterFormat,
    options: &WriteOptions,
) -> Result<()> {
    let to = to.into();
    let (width, height) = rows.size();
    if width == 0 || height == 0 {
        return Err(Error::format(
            to.place(),
            format!("a raster of {width}x{height} cells"),
            "both sides must be at least 1",
        ));
    }
    // A file of whole numbers says its own scale.
    let mut own = about.clone();
    own.tags.retain(|key, _| key != SCALE_TAG || !format.is_quantised());
    let about = &own;
    match format {
        RasterFormat::Png16 => png_write::write_png16(&to, rows, about, options),
        RasterFormat::GeoTiff => geotiff::write(&to, rows, about, options),
        RasterFormat::R32 => raw::write(&to, rows, about, Sample::F32, options),
        RasterFormat::R16 => raw::write(&to, rows, about, Sample::U16, options),
        RasterFormat::Npy => npy::write(&to, rows, about),
        RasterFormat::Exr => exr_write::write_exr(to, &mut [(about, rows)]),
        RasterFormat::Zarr => zarr::write_store(to, &mut [(about, rows)], &serde_json::Map::new()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_formats_are_in_the_same_order() {
        for (format, name) in RasterFormat::ALL.into_iter().zip(RasterFormat::NAMES) {
            assert_eq!(format.name(), name);
            assert_eq!(RasterFormat::from_name(name), Some(format));
            assert_eq!(RasterFormat::from_extension(format.extension()), Some(format));
        }
        assert_eq!(RasterFormat::from_name("tiff"), None);
        assert_eq!(RasterFormat::from_extension("TIFF"), Some(RasterFormat::GeoTiff));
    }
}
