//! Points, lines and polygons as files, read back.

use eyot_core::component::{Features, Form, Graph, Points, Table, Type, View};
use eyot_core::{Boundary, Georeference, Grid, Limits};
use eyot_io::{Vectors, write_flatgeobuf, write_geojson, write_geopackage};
use serde_json::{Value, json};
use std::borrow::Cow;

fn grid() -> Grid {
    Grid::new(8, 4, 10.0, Boundary::OPEN, &Limits::default()).unwrap()
}

fn utm() -> Georeference {
    let transform = [500_000.0, 10.0, 0.0, 5_200_000.0, 0.0, -10.0];
    Georeference { transform, epsg: Some(32632), geographic: false, nodata: None, system: None }
}

/// A lake with an island, and a pond of which no depth is known.
fn lakes() -> Features {
    let ring = |a: f32, b: f32, turn: bool| {
        let mut ring = [[a, a, 7.25], [a, b, 7.25], [b, b, 7.25], [b, a, 7.25], [a, a, 7.25]];
        if turn {
            ring.reverse();
        }
        ring
    };
    let mut lakes = Features::new(Form::Polygons, [("HYLAK_ID", "1", Type::U32), ("DEPTH_M", "m", Type::F32)]);
    lakes.push(&[&ring(0.0, 30.0, false), &ring(10.0, 20.0, true)], &[1.0, 0.1]).unwrap();
    lakes.push(&[&ring(32.0, 36.0, false)], &[2.0, f64::NAN]).unwrap();
    lakes
}

fn geojson(view: &View<'_>, place: Option<&Georeference>) -> Value {
    let mut bytes = Vec::new();
    write_geojson(&mut bytes, &Vectors::of("layer", view, &grid(), place).unwrap()).unwrap();
    serde_json::from_slice(&bytes).unwrap()
}

#[test]
fn geojson_has_coordinates_of_the_georeference() {
    let lakes = lakes();
    let view = View::Features(Cow::Borrowed(&lakes));
    let there = utm();
    let file = geojson(&view, Some(&there));
    assert_eq!(file["crs"]["properties"]["name"], "urn:ogc:def:crs:EPSG::32632");
    let [lake, pond] = [&file["features"][0], &file["features"][1]];
    assert_eq!(lake["properties"], json!({ "HYLAK_ID": 1, "DEPTH_M": 0.1 }));
    assert_eq!(pond["properties"]["DEPTH_M"], Value::Null);
    assert_eq!(lake["geometry"]["type"], "Polygon");
    let rings = lake["geometry"]["coordinates"].as_array().unwrap();
    assert_eq!(rings.len(), 2);
    assert_eq!(rings[0][1], json!([500_000.0, 5_199_970.0, 7.25]), "30 m south of the north-west corner");
    // Without a place: metres from the south-west corner, and north is up.
    let file = geojson(&view, None);
    assert!(file.get("crs").is_none());
    assert_eq!(file["features"][0]["geometry"]["coordinates"][0][1], json!([0.0, 10.0, 7.25]));
}

#[test]
fn the_simplest_geometry_that_holds_all_is_written() {
    let mut points = Points::new([("id", "1", Type::U64)]);
    points.push([1.0, 2.0, 3.0], &[4.0]).unwrap();
    points.push([5.0, 2.0, 3.0], &[5.0]).unwrap();
    let mut graph = Graph::new(points.clone(), [("flow", "m3/s", Type::F64)]);
    graph.push_edge(0, 1, &[0.5]).unwrap();
    let mut lines = Features::new(Form::Lines, []);
    let (a, b) = ([[0.0; 3], [1.0; 3]], [[2.0; 3], [3.0; 3], [4.0; 3]]);
    lines.push(&[&a], &[]).unwrap();
    let kind = |view: View<'_>| geojson(&view, None)["features"][0]["geometry"]["type"].as_str().unwrap().to_owned();
    assert_eq!(kind(View::Points(Cow::Borrowed(&points))), "Point");
    assert_eq!(kind(View::Lines(Cow::Borrowed(&graph))), "LineString");
    assert_eq!(kind(View::Features(Cow::Borrowed(&lines))), "LineString");
    lines.push(&[&a, &b], &[]).unwrap();
    assert_eq!(kind(View::Features(Cow::Borrowed(&lines))), "MultiLineString");
    let ring = [[0.0, 0.0, 0.0], [0.0, 9.0, 0.0], [9.0, 9.0, 0.0], [0.0, 0.0, 0.0]];
    let mut ponds = Features::new(Form::Polygons, []);
    ponds.push(&[&ring, &ring], &[]).unwrap();
    assert_eq!(kind(View::Features(Cow::Borrowed(&ponds))), "MultiPolygon");
    let table = Table::new([("a", "1", Type::U8)]);
    assert!(Vectors::of("table", &View::Table(Cow::Owned(table)), &grid(), None).is_none(), "a table lies nowhere");
}

#[test]
fn flatgeobuf_comes_back() {
    use flatgeobuf::{FallibleStreamingIterator, FeatureProperties, FgbReader};
    let (lakes, there) = (lakes(), utm());
    let view = View::Features(Cow::Borrowed(&lakes));
    let vectors = Vectors::of("lakes", &view, &grid(), Some(&there)).unwrap();
    let (mut bytes, mut again) = (Vec::new(), Vec::new());
    write_flatgeobuf(&mut bytes, &vectors).unwrap();
    write_flatgeobuf(&mut again, &vectors).unwrap();
    assert_eq!(bytes, again, "the same features are the same bytes");
    let file = FgbReader::open(std::io::Cursor::new(&bytes)).unwrap();
    assert_eq!((file.header().features_count(), file.header().crs().unwrap().code()), (2, 32632));
    // The pond alone, by its place.
    let mut found = file.select_bbox(500_031.0, 5_199_962.0, 500_033.0, 5_199_969.0).unwrap();
    let pond = found.next().unwrap().unwrap();
    assert_eq!(pond.property::<u32>("HYLAK_ID").unwrap(), 2);
    assert!(pond.property::<f32>("DEPTH_M").is_err(), "it is not known");
    assert!(found.next().unwrap().is_none());
    let none = Features::new(Form::Lines, []);
    let view = View::Features(Cow::Borrowed(&none));
    let e = write_flatgeobuf(&mut Vec::new(), &Vectors::of("none", &view, &grid(), None).unwrap()).unwrap_err();
    assert!(e.to_string().contains("`none` has no features"), "{e}");
}

#[test]
fn a_geopackage_is_a_sound_database() {
    let (lakes, there) = (lakes(), utm());
    let none = Features::new(Form::Lines, []);
    let views = [View::Features(Cow::Borrowed(&lakes)), View::Features(Cow::Borrowed(&none))];
    let layers = || {
        let named = ["lakes", "rivers \"of\" none"].into_iter().zip(&views);
        named.map(|(name, view)| Vectors::of(name, view, &grid(), Some(&there)).unwrap()).collect::<Vec<_>>()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gpkg");
    write_geopackage(&path, &layers()).unwrap();
    let file = rusqlite::Connection::open(&path).unwrap();
    let text = |sql: &str| file.query_row(sql, [], |row| row.get::<_, String>(0)).unwrap();
    let number = |sql: &str| file.query_row(sql, [], |row| row.get::<_, f64>(0)).unwrap();
    assert_eq!(text("PRAGMA integrity_check"), "ok");
    assert_eq!(number("PRAGMA application_id"), f64::from(0x4750_4b47));
    assert_eq!(number("SELECT count(*) FROM gpkg_contents"), 2.0);
    assert_eq!(number("SELECT max_y FROM gpkg_contents WHERE table_name = 'lakes'"), 5_200_000.0);
    assert_eq!(number("SELECT srs_id FROM gpkg_geometry_columns WHERE table_name = 'lakes'"), 32632.0);
    assert_eq!(number("SELECT count(*) FROM lakes WHERE DEPTH_M IS NULL"), 1.0);
    assert_eq!(number("SELECT sum(HYLAK_ID) FROM lakes"), 3.0);
    assert_eq!(text("SELECT hex(substr(geom, 1, 2)) FROM lakes WHERE fid = 2"), "4750");
    let bytes = std::fs::read(&path).unwrap();
    write_geopackage(&path, &layers()).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), bytes, "the same features are the same bytes");
    let twice = [&views[0], &views[1]].map(|view| Vectors::of("lakes", view, &grid(), None).unwrap());
    let e = write_geopackage(&mut Vec::new(), &twice).unwrap_err().to_string();
    assert!(e.contains("two layers are called `lakes`"), "{e}");
}
