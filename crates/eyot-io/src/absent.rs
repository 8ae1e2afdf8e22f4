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
    use crate::raster::{Raster, ReadOptions};
    use eyot_core::Limits;
    use std::fs::File;
    use std::path::Path;

    pub(crate) fn read(path: &Path, _: File, _: u64, _: &ReadOptions, _: &Limits) -> Result<Raster> {
        Err(left_out(path, "OpenEXR", "exr", "convert the file to NPY"))
    }

    pub(crate) fn names(path: &Path, _: File) -> Result<Vec<String>> {
        Err(left_out(path, "OpenEXR", "exr", "convert the file to NPY"))
    }
}

#[cfg(not(feature = "exr"))]
pub(crate) mod exr_write {
    use super::left_out;
    use crate::about::About;
    use crate::error::Result;
    use crate::rows::Rows;
    use std::path::Path;

    /// Refuses to write OpenEXR, which this build leaves out.
    ///
    /// # Errors
    /// Always.
    pub fn write_exr(path: &Path, _: &mut [(&About, &mut dyn Rows)]) -> Result<()> {
        Err(left_out(path, "OpenEXR", "exr", "write another format"))
    }
}

#[cfg(not(feature = "tiff"))]
pub(crate) mod geotiff_read {
    use super::left_out;
    use crate::error::Result;
    use crate::raster::{Raster, ReadOptions};
    use eyot_core::Limits;
    use std::path::Path;

    pub(crate) fn read(path: &Path, _: u64, _: &ReadOptions, _: &Limits) -> Result<Raster> {
        Err(left_out(path, "the reading of TIFF", "tiff", "convert the file to NPY"))
    }
}

#[cfg(not(feature = "parquet"))]
pub(crate) mod parquet {
    use super::left_out;
    use crate::error::Result;
    use crate::table::Table;
    use std::path::Path;

    /// Refuses to write Parquet, which this build leaves out.
    ///
    /// # Errors
    /// Always.
    pub fn write_parquet(path: &Path, _: &Table) -> Result<()> {
        Err(left_out(path, "Parquet", "parquet", "write CSV"))
    }
}
