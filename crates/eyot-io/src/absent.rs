//! Formats that this build leaves out: the functions of their modules, which say so.

use crate::error::Error;
use std::path::Path;

/// The error of a file that only a build with `feature` can read or write.
fn left_out(path: &Path, what: &str, feature: &str, instead: &str) -> Error {
    let problem = format!("this program was built without {what}");
    Error::format(path, problem, format!("{instead}, or build it with the feature `{feature}`"))
}

#[cfg(not(feature = "exr"))]
pub(crate) mod exr_read {
    use super::left_out;
    use crate::error::Result;
    use crate::input::Opened;
    use crate::raster::{Raster, ReadOptions};
    use eyot_core::Limits;

    pub(crate) fn read(opened: &mut Opened<'_>, _: &ReadOptions, _: &Limits) -> Result<Raster> {
        Err(left_out(&opened.at.place, "OpenEXR", "exr", "convert the file to NPY"))
    }

    pub(crate) fn names(opened: &mut Opened<'_>) -> Result<Vec<String>> {
        Err(left_out(&opened.at.place, "OpenEXR", "exr", "convert the file to NPY"))
    }
}

#[cfg(not(feature = "exr"))]
pub(crate) mod exr_write {
    use super::left_out;
    use crate::about::About;
    use crate::error::Result;
    use crate::rows::Rows;
    use crate::target::Target;

    /// Refuses to write OpenEXR, which this build leaves out.
    ///
    /// # Errors
    /// Always.
    pub fn write_exr<'a>(to: impl Into<Target<'a>>, _: &mut [(&About, &mut dyn Rows)]) -> Result<()> {
        Err(left_out(to.into().place(), "OpenEXR", "exr", "write another format"))
    }
}

#[cfg(not(feature = "tiff"))]
pub(crate) mod geotiff_read {
    use super::left_out;
    use crate::error::Result;
    use crate::input::Opened;
    use crate::raster::{Raster, ReadOptions};
    use eyot_core::Limits;

    pub(crate) fn read(opened: Opened<'_>, _: &ReadOptions, _: &Limits) -> Result<Raster> {
        Err(left_out(&opened.at.place, "the reading of TIFF", "tiff", "convert the file to NPY"))
    }
}

#[cfg(not(feature = "parquet"))]
pub(crate) mod parquet {
    use super::left_out;
    use crate::error::Result;
    use crate::table::Table;
    use crate::target::Target;

    /// Refuses to write Parquet, which this build leaves out.
    ///
    /// # Errors
    /// Always.
    pub fn write_parquet<'a>(to: impl Into<Target<'a>>, _: &Table) -> Result<()> {
        Err(left_out(to.into().place(), "Parquet", "parquet", "write CSV"))
    }
}

#[cfg(not(feature = "vector"))]
pub(crate) mod vector {
    use super::left_out;
    use crate::error::Result;
    use crate::target::Target;
    use crate::vector::Vectors;

    /// Refuses to write FlatGeobuf, which this build leaves out.
    ///
    /// # Errors
    /// Always.
    pub fn write_flatgeobuf<'a>(to: impl Into<Target<'a>>, _: &Vectors<'_>) -> Result<()> {
        Err(left_out(to.into().place(), "FlatGeobuf", "vector", "write GeoJSON"))
    }

    /// Refuses to write a GeoPackage, which this build leaves out.
    ///
    /// # Errors
    /// Always.
    pub fn write_geopackage<'a>(to: impl Into<Target<'a>>, _: &[Vectors<'_>]) -> Result<()> {
        Err(left_out(to.into().place(), "GeoPackage", "vector", "write GeoJSON"))
    }
}
