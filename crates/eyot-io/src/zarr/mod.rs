//! placeholder
use crate::about::About;
use crate::error::{Error, Result};
use crate::raster::{Raster, ReadOptions};
use crate::rows::Rows;
use eyot_core::Limits;
use std::path::Path;
pub(crate) fn is_node(_: &Path) -> bool { false }
pub(crate) fn read(path: &Path, _: &ReadOptions, _: &Limits) -> Result<Raster> { Err(Error::format(path, "not yet", "")) }
/// placeholder
pub fn write_store(path: &Path, _: &mut [(&About, &mut dyn Rows)], _: &serde_json::Map<String, serde_json::Value>) -> Result<()> { Err(Error::format(path, "not yet", "")) }
