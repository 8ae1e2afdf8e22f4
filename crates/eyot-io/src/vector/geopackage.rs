//! Vectors as GeoPackage (OGC 12-128r19): tables of features in one SQLite file.

use super::geometry::Feature;
use super::{Kind, Vectors};
use crate::atomic::put;
use crate::error::{Error, Result};
use crate::target::Target;
use eyot_core::component::{Type, Values};
use geozero::wkb::{WkbDialect, WkbWriter};
use geozero::{CoordDimensions, GeozeroGeometry};
use rusqlite::types::Value;
use rusqlite::{Connection, params, params_from_iter};

/// Number of a system of coordinates that is known by its text alone.
const OWN_SYSTEM: i32 = 100_000;
/// Coordinates of an unknown system in metres.
const CARTESIAN: i32 = -1;
/// When the content changed. Files of equal worlds are equal, so that it is always the same moment.
const CHANGED: &str = "1970-01-01T00:00:00.000Z";

/// The tables that the standard asks for (its annex C).
const TABLES: &str = "
PRAGMA application_id = 1196444487;
PRAGMA user_version = 10300;
CREATE TABLE gpkg_spatial_ref_sys (
  srs_name TEXT NOT NULL, srs_id INTEGER PRIMARY KEY, organization TEXT NOT NULL,
  organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT);
CREATE TABLE gpkg_contents (
  table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE, description TEXT DEFAULT '',
  last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')),
  min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER,
  CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));
CREATE TABLE gpkg_geometry_columns (
  table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL,
  z TINYINT NOT NULL, m TINYINT NOT NULL, CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name),
  CONSTRAINT uk_gc_table_name UNIQUE (table_name),
  CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name),
  CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id));
INSERT INTO gpkg_spatial_ref_sys VALUES
  ('Undefined Cartesian', -1, 'NONE', -1, 'undefined', NULL),
  ('Undefined geographic', 0, 'NONE', 0, 'undefined', NULL),
  ('WGS 84', 4326, 'EPSG', 4326, 'GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433],AUTHORITY[\"EPSG\",\"4326\"]]', NULL);
";

/// Writes layers, one table of features each. What is not known of a feature is NULL. There is no index of places: programs add one where
/// they want it.
///
/// # Errors
/// If two layers have the same name; if the file cannot be written.
pub fn write_geopackage<'a>(to: impl Into<Target<'a>>, layers: &[Vectors<'_>]) -> Result<()> {
    let to = to.into();
    let path = to.place();
    if let Some(twice) = layers.iter().enumerate().find(|(i, l)| layers[..*i].iter().any(|o| o.name == l.name)) {
        let problem = format!("two layers are called `{}`", twice.1.name);
        return Err(Error::format(path, problem, "give each a name of its own"));
    }
    let bytes = encode(layers)
        .map_err(|e| Error::format(path, format!("the features cannot be encoded: {e}"), "write GeoJSON"))?;
    to.write(|file| put(file, path, &bytes))
}

fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

fn encode(layers: &[Vectors<'_>]) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let mut file = Connection::open_in_memory()?;
    file.execute_batch(TABLES)?;
    let all = file.transaction()?;
    for layer in layers {
        write_layer(&all, layer)?;
    }
    all.commit()?;
    Ok(file.serialize("main")?.to_vec())
}

fn write_layer(file: &Connection, layer: &Vectors<'_>) -> Result<(), Box<dyn std::error::Error>> {
    let system = system(file, layer)?;
    let columns = layer.attributes().columns();
    let table = quoted(layer.name);
    let mut fields = vec!["fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL".to_owned(), "geom BLOB".to_owned()];
    let sql_type = |of: Type| match of {
        Type::U8 => "SMALLINT",
        Type::F32 => "FLOAT",
        Type::F64 => "DOUBLE",
        _ => "INTEGER",
    };
    fields.extend(columns.iter().map(|c| format!("{} {}", quoted(&c.name), sql_type(c.values.of()))));
    file.execute(&format!("CREATE TABLE {table} ({})", fields.join(", ")), [])?;
    let mut extent: Option<[f64; 4]> = None;
    let holes = vec!["?"; columns.len() + 2].join(", ");
    let mut insert = file.prepare(&format!("INSERT INTO {table} VALUES ({holes})"))?;
    for i in 0..layer.len() {
        let mut around = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        for vertex in layer.parts(i).iter().flatten().flat_map(|part| part.iter()) {
            let [x, y, _] = layer.coordinates(*vertex);
            around = [around[0].min(x), around[1].max(x), around[2].min(y), around[3].max(y)];
        }
        let e = extent.get_or_insert(around);
        *e = [e[0].min(around[0]), e[1].max(around[1]), e[2].min(around[2]), e[3].max(around[3])];
        let mut geometry = Vec::new();
        let mut writer = WkbWriter::with_opts(
            &mut geometry,
            WkbDialect::Geopackage,
            CoordDimensions::xyz(),
            Some(system),
            around.to_vec(),
        );
        Feature { vectors: layer, i }.process_geom(&mut writer)?;
        let value = |values: &Values| match values {
            Values::F32(_) | Values::F64(_) if values.number(i).is_nan() => Value::Null,
            Values::F32(_) | Values::F64(_) => Value::Real(values.number(i)),
            _ => Value::Integer(values.number(i) as i64),
        };
        let row = [Value::Integer(i as i64 + 1), Value::Blob(geometry)];
        insert.execute(params_from_iter(row.into_iter().chain(columns.iter().map(|c| value(&c.values)))))?;
    }
    let side = |n: usize| extent.map(|e| e[n]);
    file.execute(
        "INSERT INTO gpkg_contents VALUES (?, 'features', ?, '', ?, ?, ?, ?, ?, ?)",
        params![layer.name, layer.name, CHANGED, side(0), side(2), side(1), side(3), system],
    )?;
    let kind = match layer.kind() {
        Kind::Point => "POINT",
        Kind::Line => "LINESTRING",
        Kind::MultiLine => "MULTILINESTRING",
        Kind::Polygon => "POLYGON",
        Kind::MultiPolygon => "MULTIPOLYGON",
    };
    file.execute(
        "INSERT INTO gpkg_geometry_columns VALUES (?, 'geom', ?, ?, 1, 0)",
        params![layer.name, kind, system],
    )?;
    Ok(())
}

/// The number of the layer's system of coordinates, which is in the file afterwards.
fn system(file: &Connection, layer: &Vectors<'_>) -> rusqlite::Result<i32> {
    let add = |name: &str, id: i32, of: &str, definition: &str| {
        file.execute(
            "INSERT OR IGNORE INTO gpkg_spatial_ref_sys VALUES (?, ?, ?, ?, ?, NULL)",
            params![name, id, of, id, definition],
        )
    };
    match (layer.epsg().and_then(|code| i32::try_from(code).ok()), layer.wkt()) {
        (Some(code), wkt) => {
            // Programs look codes of EPSG up themselves.
            add(&format!("EPSG:{code}"), code, "EPSG", wkt.unwrap_or("undefined"))?;
            Ok(code)
        }
        (None, Some(wkt)) => {
            add("Of the elevation data", OWN_SYSTEM, "NONE", wkt)?;
            Ok(OWN_SYSTEM)
        }
        (None, None) => Ok(if layer.is_geographic() { 0 } else { CARTESIAN }),
    }
}
