//! The metadata of what is written: arrays of layers, their coordinates and place, and the group around them.

use super::{ATTRIBUTES, CHUNK, PLACE, SECONDS, SHARD, SYSTEM, TIME, pack};
use crate::about::About;
use eyot_core::CoordinateSystem;
use eyot_core::process::SECONDS_PER_YEAR;
use serde_json::{Map, Value, json};

/// NaN as xarray writes it into attributes: the bytes of an `f64` in base 64.
const NAN_OF_XARRAY: &str = "AAAAAAAA+H8=";

/// Rows or columns of an array: their number, and the coordinate that they are named after.
#[derive(Clone, Copy)]
pub(crate) struct Axis {
    pub(crate) name: &'static str,
    pub(crate) n: usize,
}

impl Axis {
    /// Rows and columns of cells.
    pub(crate) fn of_cells((width, height): (usize, usize)) -> [Self; 2] {
        [Self { name: Y, n: height }, Self { name: X, n: width }]
    }

    /// True for rows or columns of faces, which lie between those of cells and at their ends.
    fn is_faces(self) -> bool {
        self.name.ends_with(FACES)
    }
}

/// The coordinate of columns of cells.
pub(crate) const X: &str = "x";
/// The coordinate of rows of cells.
pub(crate) const Y: &str = "y";
/// How names of coordinates of faces end.
pub(crate) const FACES: &str = "_face";
/// The coordinate of faces towards the next column.
pub(crate) const X_FACE: &str = "x_face";
/// The coordinate of faces towards the next row.
pub(crate) const Y_FACE: &str = "y_face";

/// The root of a store: its attributes beside those of CF, and the arrays' metadata once more, which spares readers over a
/// network one request each.
pub(crate) fn group(attributes: &Map<String, Value>, arrays: &Map<String, Value>) -> Value {
    let mut root = Map::new();
    root.insert("Conventions".to_owned(), json!("CF-1.11"));
    root.extend(attributes.clone());
    let consolidated = json!({ "kind": "inline", "must_understand": false, "metadata": arrays });
    json!({ "zarr_format": 3, "node_type": "group", "attributes": root, "consolidated_metadata": consolidated })
}

/// A layer over `times` steps of time; with `holes` if cells can be missing.
pub(crate) fn layer(about: &About, times: usize, [rows, columns]: [Axis; 2], holes: bool) -> Value {
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
    if place(about).is_some() {
        attributes.insert("grid_mapping".to_owned(), json!(PLACE));
    }
    if holes {
        attributes.insert("_FillValue".to_owned(), json!(NAN_OF_XARRAY));
    }
    let little = json!({ "name": "bytes", "configuration": { "endian": "little" } });
    let crc32c = json!({ "name": "crc32c" });
    let sharding = json!({
        "chunk_shape": [1, CHUNK, CHUNK],
        "codecs": [little, pack::codec(), crc32c],
        "index_codecs": [little, crc32c],
        "index_location": "end",
    });
    array(
        json!([times, rows.n, columns.n]),
        "float32",
        json!([1, SHARD, SHARD]),
        json!([{ "name": "sharding_indexed", "configuration": sharding }]),
        json!("NaN"),
        attributes,
        json!([TIME, rows.name, columns.name]),
    )
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

/// Middles of columns or rows, or the faces between them. Rotated grids have none of their own: distances along the grid's
/// axes. `height` is the number of rows of cells.
pub(crate) fn values_along(place: &About, height: usize, axis: Axis) -> Vec<f64> {
    let t = place.transform(height);
    let rotated = (t[2], t[4]) != (0.0, 0.0);
    let (x, y) = if rotated { ((0.0, place.cell_m.0), (0.0, -place.cell_m.1)) } else { ((t[0], t[1]), (t[3], t[5])) };
    let (start, step) = if axis.name.starts_with('x') { x } else { y };
    let shift = if axis.is_faces() { 0.0 } else { 0.5 };
    (0..axis.n).map(|i| start + (i as f64 + shift) * step).collect()
}

/// A coordinate.
pub(crate) fn coordinate(place: &About, along: Axis) -> Value {
    let Axis { name, n } = along;
    let (axis, words) = if name.starts_with('x') { ("X", ["east", "longitude"]) } else { ("Y", ["north", "latitude"]) };
    let (unit, standard) = match &place.georeference {
        Some(g) if g.geographic => (format!("degrees_{}", words[0]), words[1].to_owned()),
        _ => ("m".to_owned(), format!("projection_{}_coordinate", name.trim_end_matches(FACES))),
    };
    let mut attributes = Map::new();
    // One axis of each kind is what CF knows.
    if !along.is_faces() {
        attributes.insert("axis".to_owned(), json!(axis));
    }
    attributes.insert("units".to_owned(), json!(unit));
    attributes.insert("standard_name".to_owned(), json!(standard));
    let codecs = json!([{ "name": "bytes", "configuration": { "endian": "little" } }, pack::codec()]);
    array(json!([n]), "float64", json!([n]), codecs, json!(0.0), attributes, json!([name]))
}

/// Steps of time that are longer than this are counted in years, s.
const LONG_STEP: f64 = 0.1 * SECONDS_PER_YEAR;

/// `n` steps of time in pieces of `piece`. The numbers are steps of simulation; where the attributes of the root say how long
/// one takes, readers that know CF make times of them.
pub(crate) fn time(n: usize, piece: usize, root: &Map<String, Value>) -> Value {
    let attributes = match root.get(SECONDS).and_then(Value::as_f64).filter(|s| s.is_finite() && *s > 0.0) {
        Some(seconds) if seconds < LONG_STEP => json!({
            "axis": "T", "standard_name": "time", "long_name": "simulated time, kept in steps",
            // The year that it begins in is a convention.
            "units": "seconds since 2000-01-01 00:00:00", "calendar": "proleptic_gregorian", "scale_factor": seconds,
        }),
        // No calendar goes so far.
        Some(seconds) => json!({
            "axis": "T", "standard_name": "time", "long_name": "simulated time, kept in steps",
            "units": "years", "scale_factor": seconds / SECONDS_PER_YEAR,
        }),
        None => json!({
            "axis": "T", "long_name": "steps of simulation done", "units": "1",
            "comment": "the processes of this run share no clock, so steps have no length in time",
        }),
    };
    let codecs = json!([{ "name": "bytes", "configuration": { "endian": "little" } }]);
    let attributes = attributes.as_object().cloned().unwrap_or_default();
    array(json!([n]), "int64", json!([piece]), codecs, json!(0), attributes, json!([TIME]))
}

/// Where a store lies, if it has a place on Earth.
pub(crate) fn place(about: &About) -> Option<Value> {
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
    match &g.system {
        // As others have it, and for them.
        Some(CoordinateSystem::Text(words)) if g.epsg.is_none() => {
            attributes.insert("spatial_ref".to_owned(), json!(words));
            attributes.insert("crs_wkt".to_owned(), json!(words));
        }
        Some(system) => {
            attributes.extend(serde_json::to_string(system).ok().map(|text| (SYSTEM.to_owned(), json!(text))));
        }
        None => {}
    }
    if let Some(nodata) = g.nodata.filter(|v| v.is_finite()) {
        attributes.insert("source_nodata".to_owned(), json!(nodata));
    }
    let codecs = json!([{ "name": "bytes", "configuration": { "endian": "little" } }]);
    Some(array(json!([]), "int32", json!([]), codecs, json!(0), attributes, json!([])))
}
