//! Zarr v3 stores: folders with one JSON file an array and compressed pieces of it.
//!
//! Formats: <https://zarr-specs.readthedocs.io/en/latest/v3/core/> and the codec `sharding_indexed`. Arrays have the
//! dimensions (time, y, x), with one step of time, CF attributes and coordinates; their pieces are shards of 512 x 512
//! values, each with 16 chunks of 128 x 128 that can be read alone; [`crate::timeline`] puts many steps into one store.
//! Written here instead of with a library because metadata of others must meet the limits before anything is allocated.

mod array;
mod codec;
pub(crate) mod metadata;
mod pack;
mod read;
mod write;

pub(crate) use array::{Array, metadata_from as node_from};
pub use read::store_attributes;
pub(crate) use read::{is_node, names, read};
pub use write::write_store;
pub(crate) use write::{check_name, write_coordinates, write_layer};

/// The name of every metadata file.
pub(crate) const METADATA: &str = "zarr.json";
/// Rows and columns of a shard, the piece that is a file.
pub(crate) const SHARD: usize = 512;
/// Rows and columns of a chunk, the piece that is compressed.
pub(crate) const CHUNK: usize = 128;
/// Attributes of an array that have a meaning in CF or here; others are words that go along.
const ATTRIBUTES: [&str; 12] = [
    "long_name",
    "units",
    "standard_name",
    "grid_mapping",
    "coordinates",
    "cell_x_m",
    "cell_y_m",
    "scale_factor",
    "add_offset",
    "_FillValue",
    "missing_value",
    "_ARRAY_DIMENSIONS",
];
/// What the root says of how long a step of simulation takes, s, if that is known.
pub const SECONDS: &str = "seconds_per_step";
/// What the root says of how many steps of simulation were done, which is the coordinate along [`TIME`].
const STEPS: &str = "steps_done";
/// The first dimension.
pub(crate) const TIME: &str = "time";
/// Array whose attributes say where a store lies, as CF and GDAL have it.
const PLACE: &str = "spatial_ref";
/// Attribute of [`PLACE`] with what only a GeoTIFF can say of its coordinate system, as JSON.
const SYSTEM: &str = "geotiff_system";
