//! Vectors as GeoJSON (RFC 7946).

use super::{Kind, Vectors};
use crate::error::{Error, Result};
use crate::target::Target;
use eyot_core::component::Values;
use serde_json::{Map, Value, json};

/// Writes a collection of features, one a line. Coordinates have tenths of millimetres, or 1e-9 degrees; what is not known of a feature is
/// `null`. A system of coordinates that is not the standard's longitude and latitude is named by the member `crs` of the format's first
/// version (2008), which GDAL and QGIS read.
///
/// # Errors
/// If the file cannot be written.
pub fn write_geojson<'a>(to: impl Into<Target<'a>>, vectors: &Vectors<'_>) -> Result<()> {
    let to = to.into();
    let path = to.place();
    to.write(|file| {
        let mut line = |text: String| file.write_all(text.as_bytes()).map_err(Error::io(path, "write"));
        line(format!("{{\"type\": \"FeatureCollection\",\n\"name\": {},\n", Value::from(vectors.name)))?;
        if let Some(code) = vectors.epsg().filter(|code| *code != 4326) {
            let crs = json!({ "type": "name", "properties": { "name": format!("urn:ogc:def:crs:EPSG::{code}") } });
            line(format!("\"crs\": {crs},\n"))?;
        }
        line("\"features\": [\n".to_owned())?;
        for i in 0..vectors.len() {
            let end = if i + 1 < vectors.len() { ",\n" } else { "\n" };
            let feature =
                json!({ "type": "Feature", "properties": properties(vectors, i), "geometry": geometry(vectors, i) });
            line(format!("{feature}{end}"))?;
        }
        line("]}\n".to_owned())
    })
}

fn properties(vectors: &Vectors<'_>, i: usize) -> Map<String, Value> {
    let value = |values: &Values| match values {
        Values::U8(v) => json!(v[i]),
        Values::U32(v) => json!(v[i]),
        Values::U64(v) => json!(v[i]),
        // The shortest text that is read back to the same bits of single precision.
        Values::F32(v) => {
            v[i].to_string().parse().ok().filter(|n: &f64| n.is_finite()).map_or(Value::Null, Value::from)
        }
        other => Some(other.number(i)).filter(|n| n.is_finite()).map_or(Value::Null, Value::from),
    };
    vectors.attributes().columns().iter().map(|c| (c.name.clone(), value(&c.values))).collect()
}

fn geometry(vectors: &Vectors<'_>, i: usize) -> Value {
    let unit = if vectors.is_geographic() { 1e9 } else { 1e4 };
    let place = |v: &[f32; 3]| {
        let [x, y, _] = vectors.coordinates(*v);
        let z: f64 = v[2].to_string().parse().unwrap_or_default();
        json!([(x * unit).round() / unit, (y * unit).round() / unit, z])
    };
    let line = |line: &[[f32; 3]]| Value::Array(line.iter().map(place).collect());
    let parts: Vec<Vec<Value>> =
        vectors.parts(i).iter().map(|rings| rings.iter().map(|ring| line(ring)).collect()).collect();
    let first = |parts: Vec<Vec<Value>>| parts.into_iter().flatten().next().unwrap_or_default();
    let (name, coordinates) = match vectors.kind() {
        Kind::Point => ("Point", first(parts).get_mut(0).map(Value::take).unwrap_or_default()),
        Kind::Line => ("LineString", first(parts)),
        Kind::MultiLine => ("MultiLineString", parts.into_iter().flatten().collect()),
        Kind::Polygon => ("Polygon", parts.into_iter().next().unwrap_or_default().into()),
        Kind::MultiPolygon => ("MultiPolygon", parts.into_iter().map(Value::from).collect()),
    };
    json!({ "type": name, "coordinates": coordinates })
}
