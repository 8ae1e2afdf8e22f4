//! Raster formats by name, and one function that writes a layer in any of them.

use crate::error::{Error, Result};
use crate::{geotiff_write, png_write, r32};
use eyot_core::{Layer, World};
use std::path::Path;

/// Formats that a layer can be written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RasterFormat {
    /// 16-bit grey PNG, smallest value black, largest white; the scale is kept in text chunks.
    Png16,
    /// Cloud Optimised GeoTIFF of `f32`, exact.
    GeoTiff,
    /// Headerless little-endian `f32` with a JSON file beside it, exact.
    R32,
}

impl RasterFormat {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Png16, Self::GeoTiff, Self::R32];
    /// Their names in recipes, in the order of [`RasterFormat::ALL`].
    pub const NAMES: [&'static str; 3] = ["png16", "geotiff", "r32"];

    /// The format with this name in recipes.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
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
        }
    }
}

/// Writes one layer of a world; R32 also writes `PATH.json`.
///
/// Cell size and georeference come from the world. GeoTIFF and R32 hold the layer's values exactly, PNG within half of
/// a 65535th of the layer's value range.
///
/// # Errors
/// If the layer has another size than the world's grid, holds a value that is not finite, is too large for the format,
/// or if the file cannot be written. A file that was there before is then unharmed.
pub fn write_layer(path: &Path, world: &World, layer: &Layer, format: RasterFormat) -> Result<()> {
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
        return Err(Error::format(path, problem, "write layers of this world only"));
    }
    if let Some((x, y, value)) = field.find_not_finite() {
        let remedy = "no format can carry it on; this is a fault of the process that made the layer";
        return Err(Error::NotFinite { path: path.to_owned(), value, x, y, remedy });
    }
    match format {
        RasterFormat::Png16 => png_write::write_png16(path, world, layer),
        RasterFormat::GeoTiff => geotiff_write::write(path, world, layer),
        RasterFormat::R32 => r32::write(path, world, layer),
    }
}

/// Width and height as the 32-bit numbers that PNG and TIFF store.
pub(crate) fn size_u32(path: &Path, width: usize, height: usize) -> Result<(u32, u32)> {
    // PNG allows 2^31 - 1 and TIFF readers commonly the same.
    let fit = |n: usize| u32::try_from(n).ok().filter(|&n| n <= i32::MAX as u32);
    fit(width).zip(fit(height)).ok_or_else(|| {
        Error::format(path, format!("{width}x{height} cells are too many for this format"), "write R32 or fewer cells")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_formats_are_in_the_same_order() {
        for (format, name) in RasterFormat::ALL.into_iter().zip(RasterFormat::NAMES) {
            assert_eq!(format.name(), name);
            assert_eq!(RasterFormat::from_name(name), Some(format));
        }
        assert_eq!(RasterFormat::from_name("tiff"), None);
    }
}
