//! File formats of Eyot, in and out.
//!
//! Everything that touches a file is here, and nothing else is. Three promises hold for all of it:
//! - a file that is written exists whole or not at all ([`write_atomically`]);
//! - a file that is read meets [`eyot_core::Limits`] before anything large is allocated, and a broken or hostile one
//!   gives an [`Error`] that names the file, what is wrong with it and what to do, never a panic;
//! - rasters go through `f32` unchanged where the format can hold them (GeoTIFF, R32), and within half a step of the
//!   value range where it cannot (16-bit PNG).

mod atomic;
pub mod checkpoint;
mod error;
mod fill;
mod format;
mod georef;
mod geotiff_read;
mod geotiff_write;
mod glb;
mod png_read;
mod png_write;
mod r32;
mod raster;

pub use atomic::write_atomically;
pub use checkpoint::Checkpoint;
pub use error::{Error, Result};
pub use format::{RasterFormat, write_layer};
pub use glb::write_terrain_glb;
pub use png_write::write_rgb_png;
pub use raster::{Raster, ReadOptions, read_raster};
