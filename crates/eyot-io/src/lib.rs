//! File formats of Eyot, in and out.
//!
//! Everything that touches a file is here, and nothing else is. Three promises hold for all of it:
//! - a file that is written exists whole or not at all ([`write_atomically`]);
//! - a file that is read meets [`eyot_core::Limits`] before anything large is allocated, and a broken or hostile one
//!   gives an [`Error`] that names the file, what is wrong with it and what to do, never a panic;
//! - rasters go through `f32` unchanged where the format can hold them (GeoTIFF, Zarr, EXR, NPY, R32), and within half a
//!   step of the scale where it cannot (16-bit PNG, R16).
//!
//! Formats that need much code are features, on by default; see `Cargo.toml`. A program that is built without one refuses its
//! files with an [`Error`] that says so.
//!
//! Writers take their values from [`Rows`], band by band, so that a raster need not fit in memory. Files go to a [`Target`] and come from an
//! [`Input`]: a path, a [`storage`], or any writer and reader.
//!
//! ```
//! use eyot_core::{ComponentKinds, Field, Grid, Limits, Boundary, World, layer::known};
//! use eyot_io::{RasterFormat, ReadOptions, checkpoint, read_raster, write_layer};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let limits = Limits::default();
//! let mut world = World::new(Grid::new(64, 48, 10.0, Boundary::CLOSED, &limits)?, 7);
//! world.put(&known::HEIGHT, Field::from_fn(64, 48, |x, y| (x * y) as f32))?;
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("height.tif");
//! write_layer(&path, &world, world.layer("height")?, RasterFormat::GeoTiff)?;
//! let raster = read_raster(&path, &ReadOptions::default(), &limits)?;
//! assert_eq!(raster.field, world.layer("height")?.field);
//! assert_eq!(raster.cell_m, Some((10.0, 10.0)));
//!
//! let path = folder.path().join("run.ckpt");
//! checkpoint::save(&path, &world, "name = \"Hill\"", &serde_json::json!({"entry": 0}))?;
//! assert_eq!(checkpoint::load(&path, &limits, &ComponentKinds::core())?.world, world);
//! # Ok(())
//! # }
//! ```

mod about;
#[cfg(not(all(feature = "exr", feature = "parquet", feature = "tiff", feature = "vector")))]
mod absent;
mod atomic;
pub mod checkpoint;
mod error;
#[cfg(feature = "exr")]
mod exr_read;
#[cfg(feature = "exr")]
mod exr_write;
mod fill;
mod format;
mod georef;
mod geotiff;
#[cfg(feature = "tiff")]
mod geotiff_read;
mod glb;
mod head;
mod input;
mod masks;
mod npy;
mod obj;
mod options;
mod origin;
#[cfg(feature = "parquet")]
mod parquet;
mod ply;
mod png_read;
mod png_write;
mod raster;
mod raw;
mod rows;
pub mod run_folder;
mod sample;
mod scale;
mod scene;
mod sidecar;
mod source;
pub mod storage;
mod table;
mod target;
pub mod timeline;
mod vector;
mod zarr;

#[cfg(not(feature = "tiff"))]
use absent::geotiff_read;
#[cfg(not(feature = "parquet"))]
use absent::parquet;
#[cfg(not(feature = "vector"))]
pub use absent::vector::{write_flatgeobuf, write_geopackage};
#[cfg(not(feature = "exr"))]
use absent::{exr_read, exr_write};

pub use about::About;
pub use atomic::{check_place, remove_leftovers, write_atomically};
pub use checkpoint::Checkpoint;
pub use error::{Error, Result};
pub use exr_write::write_exr;
pub use format::{RasterFormat, write_layer, write_rows};
pub use georef::lossy_georef;
pub use glb::{TerrainParts, write_scene_glb, write_terrain_glb};
pub use input::Input;
pub use masks::{Weights, shares, write_mask, write_splat};
pub use obj::{write_scene_obj, write_terrain_obj};
pub use options::WriteOptions;
pub use origin::Origin;
pub use parquet::write_parquet;
pub use ply::write_scene_ply;
pub use png_read::read_rgb_png;
pub use png_write::write_rgb_png;
pub use raster::{BEYOND_ALL, Numbers, Raster, ReadOptions, is_zarr, layer_names, read_raster};
pub use rows::Rows;
pub use sample::{ByteOrder, RowOrder, Sample};
pub use scene::{Scene, SceneMaterial, SceneMesh, SceneNode};
pub use source::Source;
pub use table::{Column, Table};
pub use target::{Target, write_text};
pub use vector::{Vectors, write_geojson};
#[cfg(feature = "vector")]
pub use vector::{write_flatgeobuf, write_geopackage};
pub use zarr::{SECONDS, store_attributes, write_store};
