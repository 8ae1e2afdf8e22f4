//! Vectors as FlatGeobuf: binary features in the order of an index of places, so that a part of a large file can be read alone.

use super::geometry::Feature;
use super::{Kind, Vectors};
use crate::atomic::put;
use crate::error::{Error, Result};
use crate::target::Target;
use eyot_core::component::Values;
use flatgeobuf::{ColumnType, FgbCrs, FgbWriter, FgbWriterOptions, GeometryType};
use geozero::{ColumnValue, PropertyProcessor};

/// Writes a layer with an index of places. Units of attributes are the descriptions of their columns; what is not known of a feature is
/// left out.
///
/// # Errors
/// If there is no feature, which the format cannot say; if the file cannot be written.
pub fn write_flatgeobuf<'a>(to: impl Into<Target<'a>>, vectors: &Vectors<'_>) -> Result<()> {
    let to = to.into();
    let path = to.place();
    if vectors.is_empty() {
        let problem = format!("`{}` has no features, and FlatGeobuf cannot say where nothing is", vectors.name);
        return Err(Error::format(path, problem, "write GeoJSON or a GeoPackage"));
    }
    let bytes = encode(vectors)
        .map_err(|e| Error::format(path, format!("the features cannot be encoded: {e}"), "write GeoJSON"))?;
    to.write(|file| put(file, path, &bytes))
}

fn encode(vectors: &Vectors<'_>) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let kind = match vectors.kind() {
        Kind::Point => GeometryType::Point,
        Kind::Line => GeometryType::LineString,
        Kind::MultiLine => GeometryType::MultiLineString,
        Kind::Polygon => GeometryType::Polygon,
        Kind::MultiPolygon => GeometryType::MultiPolygon,
    };
    let code = vectors.epsg().and_then(|code| i32::try_from(code).ok()).unwrap_or_default();
    let crs = FgbCrs { code, org: (code != 0).then_some("EPSG"), wkt: vectors.wkt(), ..FgbCrs::default() };
    let options = FgbWriterOptions {
        detect_type: false,
        promote_to_multi: false,
        has_z: true,
        crs,
        ..FgbWriterOptions::default()
    };
    let mut file = FgbWriter::create_with_options(vectors.name, kind, options)?;
    let columns = vectors.attributes().columns();
    for c in columns {
        let of = match &c.values {
            Values::U8(_) => ColumnType::UByte,
            Values::U32(_) => ColumnType::UInt,
            Values::U64(_) => ColumnType::ULong,
            Values::F32(_) => ColumnType::Float,
            _ => ColumnType::Double,
        };
        file.add_column(&c.name, of, |strings, column| column.description = Some(strings.create_string(&c.unit)));
    }
    for i in 0..vectors.len() {
        let mut refused = Ok(false);
        file.add_feature_geom(Feature { vectors, i }, |feature| {
            for (n, c) in columns.iter().enumerate() {
                let value = match &c.values {
                    Values::U8(v) => ColumnValue::UByte(v[i]),
                    Values::U32(v) => ColumnValue::UInt(v[i]),
                    Values::U64(v) => ColumnValue::ULong(v[i]),
                    Values::F32(v) => ColumnValue::Float(v[i]),
                    other => ColumnValue::Double(other.number(i)),
                };
                if c.values.number(i).is_nan() || refused.is_err() {
                    continue;
                }
                refused = feature.property(n, &c.name, &value);
            }
        })?;
        refused?;
    }
    let mut bytes = Vec::new();
    file.write(&mut bytes)?;
    Ok(bytes)
}
