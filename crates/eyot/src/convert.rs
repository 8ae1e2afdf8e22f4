//! From one file format to another, and to the files of a preset.

use crate::registry::component_kinds;
use eyot_core::Limits;
use eyot_session::RunError;
use std::path::Path;

pub use eyot_export::convert::{ConvertOptions, Converted};

/// As [`eyot_export::convert::convert`].
///
/// # Errors
/// If the input cannot be read, the output's format is not known, an option cannot apply, or the output cannot be written.
pub fn convert(input: &Path, output: &Path, options: &ConvertOptions, limits: &Limits) -> Result<Converted, RunError> {
    eyot_export::convert::convert(input, output, options, limits, &component_kinds()).map_err(RunError::from)
}
