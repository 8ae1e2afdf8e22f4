//! Zarr stores, out.

use super::metadata::Axis;
use super::{CHUNK, METADATA, PLACE, SHARD, STEPS, TIME, metadata, pack};
use crate::about::About;
use crate::error::{Error, Result};
use crate::rows::{Rows, each_marked_band};
use crate::storage::Put;
use crate::target::Target;
use eyot_core::LayerSpec;
use rayon::prelude::*;
use serde_json::{Map, Value};
use std::path::Path;

/// Offset and length of a chunk that a shard leaves out.
const ABSENT: [u8; 16] = [0xff; 16];

/// Writes layers of the same size and place as the arrays of one Zarr v3 store: a folder, or a group of a storage.
///
/// Beside the layers stand their coordinates `time` (one: the attribute `steps_done`, or 0), `y` and `x` (metres, or degrees
/// for geographic places) and, if they have a place on Earth, `spatial_ref` with its code and transform. `attributes` go to
/// the root, beside those of CF. The store appears whole or not at all; a former store there is replaced.
///
/// # Errors
/// If there is no layer, if layers differ in size, have the same name or one that cannot name a folder, if `rows` fail or
/// give a value that is not finite, if something else than a store is there, if the target is a writer, or if it cannot be
/// written.
pub fn write_store<'a>(
    to: impl Into<Target<'a>>,
    layers: &mut [(&About, &mut dyn Rows)],
    attributes: &Map<String, Value>,
) -> Result<()> {
    let to = to.into();
    let path = to.place();
    let Some((storage, group)) = to.storage() else {
        return Err(Error::format(path, "a Zarr store is more than one file", "write it to a folder or a storage"));
    };
    let Some((width, height)) = layers.first().map(|(_, rows)| rows.size()) else {
        return Err(Error::format(path, "no layer is to be written", "name at least one"));
    };
    if layers.iter().any(|(_, rows)| rows.size() != (width, height)) {
        return Err(Error::format(path, "the layers differ in size", "write layers of one world"));
    }
    let names: Vec<&str> = layers.iter().map(|(a, _)| name_of(a)).collect();
    for (i, name) in names.iter().enumerate() {
        if names[..i].contains(name) {
            return Err(bad_name(path, name));
        }
        check_name(path, name)?;
    }
    let place = layers[0].0.clone();
    storage.write_group(group, METADATA, &mut |put| {
        let mut known = Map::new();
        for (about, rows) in layers.iter_mut() {
            let name = name_of(about);
            let metadata = metadata::layer(about, 1, Axis::of_cells((width, height)), rows.missing().is_some());
            write_layer(path, 0, *rows, &|piece, bytes| put(&format!("{name}/{piece}"), bytes))?;
            known.insert(name.to_owned(), metadata);
        }
        write_coordinates(path, &place, height, Axis::of_cells((width, height)), &mut known, put)?;
        let step = attributes.get(STEPS).and_then(Value::as_i64).unwrap_or(0);
        put(&format!("{TIME}/c/0"), &step.to_le_bytes())?;
        known.insert(TIME.to_owned(), metadata::time(1, 1, attributes));
        for (name, metadata) in &known {
            put(&format!("{name}/{METADATA}"), format!("{metadata:#}\n").as_bytes())?;
        }
        put(METADATA, format!("{:#}\n", metadata::group(attributes, &known)).as_bytes())
    })
}

fn name_of(about: &About) -> &str {
    if about.name.is_empty() { "height" } else { &about.name }
}

/// Refuses what cannot name the array of a layer.
pub(crate) fn check_name(path: &Path, name: &str) -> Result<()> {
    let letters = name.chars().all(|c| c.is_ascii_alphanumeric() || "_-.".contains(c));
    if !letters || name.is_empty() || name.starts_with(['.', '_']) || LayerSpec::is_axis(name) {
        return Err(bad_name(path, name));
    }
    Ok(())
}

fn bad_name(path: &Path, name: &str) -> Error {
    let problem = format!("`{name}` cannot name an array here");
    Error::format(path, problem, "use different names of letters, digits and underscores")
}

/// Writes coordinates and place, without their metadata, which go to `known`; those that are there already stay. `folder` is
/// for messages.
pub(crate) fn write_coordinates(
    folder: &Path,
    place: &About,
    height: usize,
    axes: impl IntoIterator<Item = Axis>,
    known: &mut Map<String, Value>,
    put: &Put<'_>,
) -> Result<()> {
    for axis in axes {
        if !known.contains_key(axis.name) {
            let values = metadata::values_along(place, height, axis);
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            put(&format!("{}/c/0", axis.name), &packed(folder, &bytes)?)?;
            known.insert(axis.name.to_owned(), metadata::coordinate(place, axis));
        }
    }
    if let Some(metadata) = metadata::place(place).filter(|_| !known.contains_key(PLACE)) {
        put(&format!("{PLACE}/c"), &0i32.to_le_bytes())?;
        known.insert(PLACE.to_owned(), metadata);
    }
    Ok(())
}

/// Writes the shards of one layer at the index `time`, a band of them at a time. `path` is for messages.
pub(crate) fn write_layer(path: &Path, time: usize, rows: &mut dyn Rows, put: &Put<'_>) -> Result<()> {
    let width = rows.size().0;
    each_marked_band(path, rows, SHARD, Some(f32::NAN), |top, band| {
        let down = top / SHARD;
        (0..width.div_ceil(SHARD)).into_par_iter().try_for_each(|across| {
            let shard = shard(path, band, width, across * SHARD)?;
            put(&format!("c/{time}/{down}/{across}"), &shard)
        })
    })
}

/// The shard whose westernmost column is `left`: its chunks, then their places, then a checksum of those.
fn shard(path: &Path, band: &[f32], width: usize, left: usize) -> Result<Vec<u8>> {
    let height = band.len() / width;
    let mut out = Vec::new();
    let mut index = Vec::new();
    for y0 in (0..SHARD).step_by(CHUNK) {
        for x0 in (left..left + SHARD).step_by(CHUNK) {
            if y0 >= height || x0 >= width {
                index.extend(ABSENT);
                continue;
            }
            let mut bytes = vec![0; 4 * CHUNK * CHUNK];
            let columns = CHUNK.min(width - x0);
            for (y, line) in bytes.chunks_exact_mut(4 * CHUNK).enumerate().take(height - y0) {
                let values = &band[(y0 + y) * width + x0..][..columns];
                line.chunks_exact_mut(4).zip(values).for_each(|(b, v)| b.copy_from_slice(&v.to_le_bytes()));
            }
            let packed = packed(path, &bytes)?;
            index.extend((out.len() as u64).to_le_bytes());
            index.extend((packed.len() as u64 + 4).to_le_bytes());
            out.extend(&packed);
            out.extend(crc32c::crc32c(&packed).to_le_bytes());
        }
    }
    let checksum = crc32c::crc32c(&index);
    out.extend(&index);
    out.extend(checksum.to_le_bytes());
    Ok(out)
}

fn packed(path: &Path, bytes: &[u8]) -> Result<Vec<u8>> {
    pack::pack(bytes).map_err(Error::io(path, "compress"))
}

#[cfg(test)]
mod tests {
    use super::super::metadata::{X_FACE, Y_FACE};
    use super::*;

    #[test]
    fn coordinates_are_no_names_of_layers() {
        for name in ["x", "y", X_FACE, Y_FACE, TIME, PLACE] {
            assert!(LayerSpec::is_axis(name), "{name}");
            assert!(check_name(Path::new("a.zarr"), name).is_err(), "{name}");
        }
        assert!(check_name(Path::new("a.zarr"), "height").is_ok());
    }
}
