//! Zarr stores, out.

use super::{ATTRIBUTES, CHUNK, METADATA, PLACE, SHARD, STEPS, TIME};
use crate::about::About;
use crate::atomic::write_folder_atomically;
use crate::error::{Error, Result};
use crate::rows::{Rows, each_band};
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

/// The usual balance of zstd.
const ZSTD_LEVEL: i32 = 3;
/// Offset and length of a chunk that a shard leaves out.
const ABSENT: [u8; 16] = [0xff; 16];

/// Writes layers of the same size and place as the arrays of one Zarr v3 store at the folder `path`.
///
/// Beside the layers stand their coordinates `time` (one: the attribute `steps_done`, or 0), `y` and `x` (metres, or degrees
/// for geographic places) and, if they have a place on Earth, `spatial_ref` with its code and transform. `attributes` go to
/// the root, beside those of CF. The store appears whole or not at all; a former store at `path` is replaced.
///
/// # Errors
/// If there is no layer, if layers differ in size, have the same name or one that cannot name a folder, if `rows` fail or
/// give a value that is not finite, if something else than a store is at `path`, or if it cannot be written.
pub fn write_store(path: &Path, layers: &mut [(&About, &mut dyn Rows)], attributes: &Map<String, Value>) -> Result<()> {
    let Some((width, height)) = layers.first().map(|(_, rows)| rows.size()) else {
        return Err(Error::format(path, "no layer is to be written", "name at least one"));
    };
    if layers.iter().any(|(_, rows)| rows.size() != (width, height)) {
        return Err(Error::format(path, "the layers differ in size", "write layers of one world"));
    }
    let mut names: Vec<&str> = layers.iter().map(|(a, _)| name_of(a)).collect();
    for (i, name) in names.iter().enumerate() {
        let letters = name.chars().all(|c| c.is_ascii_alphanumeric() || "_-.".contains(c));
        if !letters
            || name.starts_with(['.', '_'])
            || ["x", "y", TIME, PLACE].contains(name)
            || names[..i].contains(name)
        {
            let problem = format!("`{name}` cannot name an array here");
            return Err(Error::format(path, problem, "use different names of letters, digits and underscores"));
        }
    }
    names.sort_unstable();
    let place = layers[0].0.clone();
    write_folder_atomically(path, METADATA, |folder| {
        let mut known = Map::new();
        for (about, rows) in layers.iter_mut() {
            let name = name_of(about);
            let metadata = layer_metadata(about, (width, height));
            let at = folder.join(name);
            write_layer(path, &at, *rows)?;
            write_metadata(&at, &metadata)?;
            known.insert(name.to_owned(), metadata);
        }
        for (name, n, values) in coordinates(&place, (width, height)) {
            let metadata = coordinate_metadata(&place, name, n);
            let at = folder.join(name);
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            write_piece(&at.join("c/0"), &zstd_of(path, &bytes)?)?;
            write_metadata(&at, &metadata)?;
            known.insert(name.to_owned(), metadata);
        }
        let step = attributes.get(STEPS).and_then(Value::as_i64).unwrap_or(0);
        let at = folder.join(TIME);
        write_piece(&at.join("c/0"), &step.to_le_bytes())?;
        write_metadata(&at, &time_metadata())?;
        known.insert(TIME.to_owned(), time_metadata());
        if let Some(metadata) = place_metadata(&place) {
            let at = folder.join(PLACE);
            write_piece(&at.join("c"), &0i32.to_le_bytes())?;
            write_metadata(&at, &metadata)?;
            known.insert(PLACE.to_owned(), metadata);
        }
        let mut root = Map::new();
        root.insert("Conventions".to_owned(), json!("CF-1.11"));
        root.extend(attributes.clone());
        // The arrays' metadata once more, which spares readers over a network one request each.
        let consolidated = json!({ "kind": "inline", "must_understand": false, "metadata": known });
        let group = json!({
            "zarr_format": 3, "node_type": "group", "attributes": root, "consolidated_metadata": consolidated,
        });
        write_metadata(folder, &group)
    })
}

fn name_of(about: &About) -> &str {
    if about.name.is_empty() { "height" } else { &about.name }
}

/// Writes the shards of one layer, a band of them at a time.
fn write_layer(path: &Path, folder: &Path, rows: &mut dyn Rows) -> Result<()> {
    let width = rows.size().0;
    each_band(path, rows, SHARD, |top, band| {
        let down = top / SHARD;
        let row = folder.join(format!("c/0/{down}"));
        fs::create_dir_all(&row).map_err(Error::io(&row, "make the folder"))?;
        (0..width.div_ceil(SHARD)).into_par_iter().try_for_each(|across| {
            let shard = shard(path, band, width, across * SHARD)?;
            write_piece(&row.join(across.to_string()), &shard)
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
            let packed = zstd_of(path, &bytes)?;
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

fn zstd_of(path: &Path, bytes: &[u8]) -> Result<Vec<u8>> {
    zstd::bulk::compress(bytes, ZSTD_LEVEL).map_err(Error::io(path, "compress"))
}

fn write_piece(path: &Path, bytes: &[u8]) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(Error::io(folder, "make the folder"))?;
    }
    let write = || -> std::io::Result<()> {
        let mut file = File::create(path)?;
        file.write_all(bytes)?;
        file.sync_all()
    };
    write().map_err(Error::io(path, "write"))
}

fn write_metadata(folder: &Path, value: &Value) -> Result<()> {
    write_piece(&folder.join(METADATA), format!("{value:#}\n").as_bytes())
}

fn layer_metadata(about: &About, (width, height): (usize, usize)) -> Value {
    let mut attributes = Map::new();
    attributes.insert("long_name".to_owned(), json!(about.meaning));
    attributes.insert("units".to_owned(), json!(about.unit));
    if about.name == "height" || about.name.is_empty() {
        attributes.insert("standard_name".to_owned(), json!("surface_altitude"));
    }
    for (key, text) in about.tags.iter().filter(|(key, _)| !ATTRIBUTES.contains(&key.as_str())) {
        attributes.insert(key.clone(), json!(text));
    }
    attributes.insert("cell_x_m".to_owned(), json!(about.cell_m.0));
    attributes.insert("cell_y_m".to_owned(), json!(about.cell_m.1));
    if place_metadata(about).is_some() {
        attributes.insert("grid_mapping".to_owned(), json!(PLACE));
    }
    let little = json!({ "name": "bytes", "configuration": { "endian": "little" } });
    let crc32c = json!({ "name": "crc32c" });
    let sharding = json!({
        "chunk_shape": [1, CHUNK, CHUNK],
        "codecs": [little, zstd_metadata(), crc32c],
        "index_codecs": [little, crc32c],
        "index_location": "end",
    });
    array(
        json!([1, height, width]),
        "float32",
        json!([1, SHARD, SHARD]),
        json!([{ "name": "sharding_indexed", "configuration": sharding }]),
        json!("NaN"),
        attributes,
        json!([TIME, "y", "x"]),
    )
}

fn zstd_metadata() -> Value {
    json!({ "name": "zstd", "configuration": { "level": ZSTD_LEVEL, "checksum": false } })
}

fn array(
    shape: Value,
    kind: &str,
    piece: Value,
    codecs: Value,
    fill: Value,
    attributes: Map<String, Value>,
    dimensions: Value,
) -> Value {
    json!({
        "zarr_format": 3,
        "node_type": "array",
        "shape": shape,
        "data_type": kind,
        "chunk_grid": { "name": "regular", "configuration": { "chunk_shape": piece } },
        "chunk_key_encoding": { "name": "default", "configuration": { "separator": "/" } },
        "fill_value": fill,
        "codecs": codecs,
        "attributes": attributes,
        "dimension_names": dimensions,
        "storage_transformers": [],
    })
}

/// Middles of columns and rows. Rotated grids have none of their own: distances along the grid's axes.
fn coordinates(place: &About, (width, height): (usize, usize)) -> [(&'static str, usize, Vec<f64>); 2] {
    let t = place.transform(height);
    let rotated = (t[2], t[4]) != (0.0, 0.0);
    let (x, y) = if rotated { ((0.0, place.cell_m.0), (0.0, -place.cell_m.1)) } else { ((t[0], t[1]), (t[3], t[5])) };
    let middles = |(start, step): (f64, f64), n: usize| (0..n).map(|i| start + (i as f64 + 0.5) * step).collect();
    [("x", width, middles(x, width)), ("y", height, middles(y, height))]
}

fn coordinate_metadata(place: &About, name: &str, n: usize) -> Value {
    let (axis, words) = if name == "x" { ("X", ["east", "longitude"]) } else { ("Y", ["north", "latitude"]) };
    let (unit, standard) = match &place.georeference {
        Some(g) if g.geographic => (format!("degrees_{}", words[0]), words[1].to_owned()),
        _ => ("m".to_owned(), format!("projection_{name}_coordinate")),
    };
    let mut attributes = Map::new();
    attributes.insert("axis".to_owned(), json!(axis));
    attributes.insert("units".to_owned(), json!(unit));
    attributes.insert("standard_name".to_owned(), json!(standard));
    let codecs = json!([{ "name": "bytes", "configuration": { "endian": "little" } }, zstd_metadata()]);
    array(json!([n]), "float64", json!([n]), codecs, json!(0.0), attributes, json!([name]))
}

fn time_metadata() -> Value {
    let attributes = json!({ "long_name": "steps of simulation done", "units": "1" });
    let codecs = json!([{ "name": "bytes", "configuration": { "endian": "little" } }]);
    let attributes = attributes.as_object().cloned().unwrap_or_default();
    array(json!([1]), "int64", json!([1]), codecs, json!(0), attributes, json!([TIME]))
}

fn place_metadata(about: &About) -> Option<Value> {
    let g = about.georeference.as_ref()?;
    let mut attributes = Map::new();
    // In GDAL's order of the six numbers, with all their digits.
    attributes.insert("GeoTransform".to_owned(), json!(g.transform.map(|v| format!("{v:?}")).join(" ")));
    // A number: netCDF, to which xarray copies attributes, has no truth values.
    attributes.insert("geographic".to_owned(), json!(u8::from(g.geographic)));
    if g.geographic {
        attributes.insert("grid_mapping_name".to_owned(), json!("latitude_longitude"));
    }
    if let Some(code) = g.epsg {
        attributes.insert("spatial_ref".to_owned(), json!(format!("EPSG:{code}")));
        attributes.insert("epsg".to_owned(), json!(code));
    }
    if let Some(nodata) = g.nodata.filter(|v| v.is_finite()) {
        attributes.insert("source_nodata".to_owned(), json!(nodata));
    }
    let codecs = json!([{ "name": "bytes", "configuration": { "endian": "little" } }]);
    Some(array(json!([]), "int32", json!([]), codecs, json!(0), attributes, json!([])))
}
