//! Components: what they keep, and what becomes of bytes that nobody of theirs wrote.

use eyot_core::component::{
    Columns, Decoder, Encoder, Features, Form, Graph, Numbers, Points, Run, Shape, Table, Type, View,
    signed_double_area,
};
use eyot_core::{Boundary, Component, ComponentKinds, Components, Fingerprint, Grid, Limits, Result, World};
use proptest::prelude::*;
use std::sync::Arc;

fn grid() -> Grid {
    Grid::new(3, 2, 1.0, Boundary::CLOSED, &Limits::default()).unwrap()
}

fn table() -> Table {
    let mut table = Table::new([("month", "month", Type::U64), ("cover", "1", Type::F64), ("species", "1", Type::U8)]);
    table.push(&[0.0, 0.25, 3.0]).unwrap();
    table.push(&[1.0, f64::NEG_INFINITY, 255.0]).unwrap();
    table
}

fn points() -> Points {
    let mut points = Points::new([("id", "1", Type::U64), ("radius", "m", Type::F32)]);
    points.push([1.0, 2.5, -3.0], &[7.0, 0.5]).unwrap();
    points.push([0.0, 0.0, 0.0], &[8.0, 0.25]).unwrap();
    points
}

fn graph() -> Graph {
    let mut graph = Graph::new(points(), [("flow", "m3/s", Type::F32), ("order", "1", Type::U32)]);
    let mouth = graph.push_node([5.0, 5.0, -1.0], &[9.0, 2.0]).unwrap();
    graph.push_edge(0, mouth, &[12.5, 1.0]).unwrap();
    graph.push_edge(1, mouth, &[2.0, 1.0]).unwrap();
    graph
}

fn columns() -> Columns {
    let mut columns = Columns::new(6, 3, &Limits::default()).unwrap();
    for (cell, material, thickness_m) in
        [(0, 1, 10.0), (0, 2, 0.5), (3, 9, 1e-3), (5, 1, 2.0), (5, 2, 1.0), (5, 1, 4.0)]
    {
        columns.deposit(cell, Run { material, thickness_m }).unwrap();
    }
    columns
}

/// A lake with an island beside a pond, and a tarn.
fn features() -> Features {
    let square = |x: f32, y: f32, a: f32, turn: bool| {
        let mut ring = [[x, y, 3.0], [x, y + a, 3.0], [x + a, y + a, 3.0], [x + a, y, 3.0], [x, y, 3.0]];
        if turn {
            ring.reverse();
        }
        ring
    };
    let mut lakes = Features::new(Form::Polygons, [("id", "1", Type::U32), ("area", "m2", Type::F32)]);
    let lake = [square(0.0, 0.0, 10.0, false), square(2.0, 2.0, 3.0, true), square(20.0, 0.0, 4.0, false)];
    lakes.push(&lake.each_ref().map(|ring| &ring[..]), &[1.0, 107.0]).unwrap();
    lakes.push(&[&square(30.0, 0.0, 1.0, false)], &[2.0, 1.0]).unwrap();
    lakes
}

fn each() -> Vec<Arc<dyn Component>> {
    let numbers = Numbers(vec![1.5, -0.0, f64::INFINITY]);
    vec![
        Arc::new(numbers),
        Arc::new(table()),
        Arc::new(points()),
        Arc::new(graph()),
        Arc::new(columns()),
        Arc::new(features()),
    ]
}

fn encoded(component: &dyn Component) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes);
    component.encode(&mut encoder);
    encoder.finish().unwrap();
    bytes
}

fn decoded(kind: &str, version: u32, bytes: &[u8]) -> Result<Arc<dyn Component>> {
    let limits = Limits { max_bytes: 1 << 20, ..Limits::default() };
    let (mut input, grid) = (bytes, grid());
    let mut decoder = Decoder::new("thing", &mut input, bytes.len() as u64, &grid, &limits);
    ComponentKinds::core().decode(kind, version, &mut decoder)
}

fn print_of(component: &dyn Component) -> u64 {
    let mut print = Fingerprint::new(&grid(), 0, 0.0);
    component.fingerprint(&mut print);
    print.value()
}

#[test]
fn components_come_back_as_they_were() {
    for component in each() {
        let kind = component.kind();
        let bytes = encoded(&*component);
        let back = decoded(kind.name, kind.version, &bytes).unwrap();
        assert!(back.equals(&*component) && component.equals(&*back), "{}", kind.name);
        assert_eq!(encoded(&*back), bytes, "{}", kind.name);
        assert_eq!(print_of(&*back), print_of(&*component), "{}", kind.name);
        assert!(component.bytes() > 8 && back.bytes() == component.bytes(), "{}", kind.name);
    }
}

#[test]
fn a_component_that_was_cut_short_or_added_to_is_refused_by_name() {
    for component in each() {
        let (kind, bytes) = (component.kind(), encoded(&*component));
        for n in 0..bytes.len() {
            // Numbers know no count: there are as many as there are bytes for.
            if kind.name == "numbers" && n % 8 == 0 {
                continue;
            }
            let e = decoded(kind.name, kind.version, &bytes[..n]).expect_err(kind.name).to_string();
            assert!(e.contains("thing"), "{e}");
        }
        let e = decoded(kind.name, kind.version, &[&bytes[..], &[0]].concat()).unwrap_err().to_string();
        assert!(e.contains("left over") || e.contains("no list of numbers"), "{e}");
    }
}

#[test]
fn kinds_and_versions_that_nobody_knows_are_named() {
    let e = decoded("reef.forest", 1, &[]).unwrap_err().to_string();
    assert!(e.contains("`thing`") && e.contains("`reef.forest`, which this program does not know"), "{e}");
    for version in [0, 2] {
        let e = decoded("table", version, &encoded(&table())).unwrap_err().to_string();
        assert!(e.contains(&format!("of version {version}, this program reads 1 to 1")), "{e}");
    }
}

#[test]
fn counts_and_numbers_that_no_component_has_are_refused() {
    let huge = u64::MAX.to_le_bytes();
    for kind in ["table", "points", "graph", "columns", "features"] {
        for count in [huge, (1u64 << 40).to_le_bytes()] {
            assert!(decoded(kind, 1, &[&count[..], &[0; 64]].concat()).is_err(), "{kind}");
        }
    }
    let refused = |kind: &str, bytes: &[u8], at: usize, value: &[u8], words: &str| {
        let mut bytes = bytes.to_vec();
        bytes[at..at + value.len()].copy_from_slice(value);
        let e = decoded(kind, 1, &bytes).expect_err(words).to_string();
        assert!(e.contains(words), "{e}");
    };
    refused("points", &encoded(&points()), 8, &f32::NAN.to_le_bytes(), "not finite");
    // Rows without columns would take no bytes at all.
    let rows = [&5u64.to_le_bytes()[..], &[0; 4], &[0; 8]].concat();
    assert!(decoded("table", 1, &rows).unwrap_err().to_string().contains("rows without columns"));
    let graph = encoded(&graph());
    let edges = graph.len() - encoded_edges();
    refused("graph", &graph, edges, &3u32.to_le_bytes(), "an edge from 3 to 2 among 3 nodes");
    let columns = encoded(&columns());
    refused("columns", &columns, 0, &5u64.to_le_bytes(), "columns of 5 cells on a grid of 6");
    refused("columns", &columns, 8, &[0], "0 runs in a column");
    refused("columns", &columns, 8, &[65], "65 runs in a column");
    refused("columns", &columns, 9, &[4], "4 runs in cell 0");
    refused("columns", &columns, columns.len() - 4, &(-1.0f32).to_le_bytes(), "a run of -1 m");
    refused("columns", &columns, columns.len() - 4, &f32::NAN.to_le_bytes(), "a run of NaN m");
}

/// Bytes of the two edges of `graph` and of their attributes.
fn encoded_edges() -> usize {
    let heads = 4 + [("flow", "m3/s"), ("order", "1")].iter().map(|(n, u)| 9 + n.len() + u.len()).sum::<usize>();
    2 * 8 + heads + 2 * (4 + 4)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    /// Whatever is read can be written again, and is then the same.
    #[test]
    fn damaged_components_end_in_an_error_or_in_a_component(
        which in 0usize..5, changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)
    ) {
        let component = &each()[which];
        let mut bytes = encoded(&**component);
        changes.iter().for_each(|(at, byte)| { let at = at.index(bytes.len()); bytes[at] = *byte; });
        if let Ok(read) = decoded(component.kind().name, 1, &bytes) {
            let again = encoded(&*read);
            let back = decoded(component.kind().name, 1, &again).unwrap();
            prop_assert_eq!(print_of(&*back), print_of(&*read));
            prop_assert_eq!(encoded(&*back), again);
        }
    }

    /// Nothing is lost or made when runs are laid, joined for want of slots, and taken off.
    #[test]
    fn columns_keep_their_matter(runs in prop::collection::vec((0u8..4, 0.0f32..5.0), 0..40), slots in 1usize..6, off in 0.0f32..60.0) {
        let mut columns = Columns::new(1, slots, &Limits::default()).unwrap();
        let mut laid = 0.0;
        for (material, thickness_m) in runs {
            columns.deposit(0, Run { material, thickness_m }).unwrap();
            laid += f64::from(thickness_m);
            let all: Vec<Run> = columns.runs(0).collect();
            prop_assert!(all.len() <= slots && all.iter().all(|r| r.thickness_m > 0.0));
            prop_assert!(all.windows(2).all(|w| w[0].material != w[1].material), "{:?}", all);
            prop_assert_eq!(columns.top(0), all.last().copied());
        }
        prop_assert!((columns.thickness_m(0) - laid).abs() < 1e-4 * (1.0 + laid));
        prop_assert!((f64::from(columns.thicknesses_m()[0]) - laid).abs() < 1e-4 * (1.0 + laid));
        let mut pieces = 0.0;
        let taken = columns.erode(0, off, |r| pieces += f64::from(r.thickness_m));
        prop_assert!((pieces - f64::from(taken)).abs() < 1e-4 && (columns.thickness_m(0) + pieces - laid).abs() < 1e-3);
        prop_assert!(f64::from(taken) <= laid * 1.0001 && taken <= off);
    }
}

#[test]
fn a_thin_column_gives_no_more_than_it_has() {
    let mut columns = Columns::new(1, 1, &Limits::default()).unwrap();
    columns.deposit(0, Run { material: 0, thickness_m: 0.0059672487 }).unwrap();
    assert_eq!(columns.erode(0, 16.84821, |_| ()), 0.0059672487);
    assert_eq!(columns.thickness_m(0), 0.0);
}

#[test]
fn columns_become_fewer_when_materials_become_the_same() {
    let mut columns = columns();
    columns.replace(2, 1);
    assert_eq!(columns.runs(5).collect::<Vec<_>>(), [Run { material: 1, thickness_m: 7.0 }]);
    assert_eq!(columns.counts(), [1, 0, 0, 1, 0, 1]);
    assert_eq!(columns.plane(0).1, [10.5, 0.0, 0.0, 1e-3, 0.0, 7.0]);
    assert!(columns.deposit(0, Run { material: 1, thickness_m: f32::NAN }).is_err());
    assert!(Columns::new(1 << 40, 64, &Limits::default()).is_err());
}

#[test]
fn rows_go_in_whole_or_not_at_all() {
    let mut table = table();
    let before = table.clone();
    for row in [&[2.0, 0.5][..], &[2.5, 0.5, 1.0], &[-0.0, 0.5, 1.0], &[2.0, 0.5, 256.0], &[f64::NAN, 0.5, 1.0]] {
        assert!(table.push(row).is_err(), "{row:?}");
        assert_eq!(table, before);
    }
    assert_eq!(
        (table.row(0).collect::<Vec<_>>(), table.get("month").unwrap().unit.as_str()),
        (vec![0.0, 0.25, 3.0], "month")
    );
    let mut points = points();
    assert!(points.push([f32::NAN, 0.0, 0.0], &[1.0, 1.0]).is_err());
    points.retain(|i| i == 1);
    assert_eq!(
        (points.positions(), points.attributes().row(0).collect::<Vec<_>>()),
        (&[[0.0; 3]][..], vec![8.0, 0.25])
    );
    let mut graph = graph();
    assert!(graph.push_edge(0, 3, &[1.0, 1.0]).is_err());
    assert_eq!(graph.outgoing(), (vec![0, 1, 2, 2], vec![0, 1]));
}

/// A table was a list of numbers once, and fingerprints are kept for ever.
#[test]
fn a_table_has_the_fingerprint_of_its_numbers() {
    let rows: Vec<f64> = (0..2).flat_map(|i| table().row(i).collect::<Vec<_>>()).collect();
    assert_eq!(print_of(&table()), print_of(&Numbers(rows)));
    let (mut a, mut b) = (World::new(grid(), 1), World::new(grid(), 1));
    assert_eq!(a.fingerprint(), b.fingerprint());
    a.components.insert("x", Numbers(vec![1.0]));
    b.components.insert("y", Numbers(vec![1.0]));
    assert!(a.fingerprint() != b.fingerprint() && a != b);
}

#[test]
fn a_copy_keeps_what_it_was() {
    let mut now = Components::default();
    now.insert("a", Numbers(vec![1.0]));
    now.insert("b", table());
    let before = now.clone();
    now.get_mut::<Numbers>("a").unwrap().unwrap().0[0] = 2.0;
    assert_eq!(before.get::<Numbers>("a").unwrap().unwrap().0, [1.0]);
    assert!(now != before);
    let at = |c: &Components| std::ptr::from_ref(c.get::<Table>("b").unwrap().unwrap());
    assert_eq!(at(&now), at(&before), "what nobody changes is shared");
    now.entry("a", Numbers::default).unwrap().0[0] = 1.0;
    assert_eq!(now, before);
    assert!(now.get::<Points>("none").unwrap().is_none() && now.get_mut::<Points>("none").unwrap().is_none());
    // What is there under another type must not be taken for nothing.
    let e = now.get::<Points>("b").unwrap_err().to_string();
    assert!(e.contains("`b`") && e.contains("`table`"), "{e}");
    assert!(now.get_mut::<Points>("b").is_err() && now.entry("b", Points::default).is_err());
    assert_eq!(now.bytes(), 8 + table().bytes());
    assert!(now.remove("b") && !now.remove("b") && now.len() == 1);
}

#[test]
fn views_are_found_by_name() {
    let mut all = Components::default();
    all.insert("rivers", graph());
    all.insert("rivers.log", table());
    all.insert("raw", Numbers(vec![1.0]));
    let names: Vec<(String, Shape)> = all.views().collect();
    let named = |name: &str, shape| (name.to_owned(), shape);
    let want = [named("rivers", Shape::Lines), named("rivers.nodes", Shape::Points), named("rivers.log", Shape::Table)];
    assert_eq!(names, want);
    assert!(matches!(all.view("rivers"), Some(View::Lines(g)) if g.edges().len() == 2));
    assert!(matches!(all.view("rivers.nodes"), Some(View::Points(p)) if p.len() == 3));
    assert!(matches!(all.view("rivers.log"), Some(View::Table(t)) if t.len() == 2));
    assert!(["raw", "rivers.none", "riverslog", "river"].iter().all(|name| all.view(name).is_none()));
}

#[test]
fn columns_are_seen_as_a_table_of_their_runs() {
    let columns = columns();
    let Some(View::Table(table)) = columns.view("") else { panic!("no table") };
    let names: Vec<&str> = table.columns().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["cell", "run", "material", "bottom_m", "thickness_m"]);
    let mut row = 0;
    for cell in 0..columns.cells() {
        let mut bottom = 0.0;
        for (number, run) in columns.runs(cell).enumerate() {
            let want = [cell as f64, number as f64, f64::from(run.material), bottom, f64::from(run.thickness_m)];
            assert!(table.row(row).zip(want).all(|(a, b)| (a - b).abs() < 1e-6), "row {row}");
            bottom += f64::from(run.thickness_m);
            row += 1;
        }
    }
    assert!(row > 3 && row == table.len());
    assert!(columns.view("other").is_none());
}

#[test]
fn features_are_lines_or_polygons_with_holes() {
    let lakes = features();
    let polygons: Vec<Vec<usize>> =
        (0..2).flat_map(|i| lakes.polygons(i)).map(|p| p.iter().map(|r| r.len()).collect()).collect();
    assert_eq!(polygons, [vec![5, 5], vec![5], vec![5]], "a lake of two polygons, the first with a hole, and a tarn");
    let area: f64 = lakes.parts(0).map(|ring| signed_double_area(ring) / 2.0).sum();
    assert_eq!(area, 100.0 - 9.0 + 16.0);
    assert_eq!(lakes.attributes().row(1).collect::<Vec<_>>(), [2.0, 1.0]);
    assert!(matches!(lakes.view(""), Some(View::Features(f)) if f.len() == 2) && lakes.view("x").is_none());

    let (mut lakes, before) = (lakes.clone(), lakes);
    let ring: Vec<[f32; 3]> = before.parts(1).next().unwrap().to_vec();
    let hole: Vec<[f32; 3]> = ring.iter().rev().copied().collect();
    let open = [&ring[..4], &[[9.0; 3]]].concat();
    let nowhere = [&[[f32::NAN, 0.0, 0.0]], &ring[1..4], &[[f32::NAN, 0.0, 0.0]]].concat();
    for (parts, words) in [
        (vec![], "without parts"),
        (vec![&ring[..3]], "3 vertices, 4 are the least"),
        (vec![&open[..]], "not closed"),
        (vec![&hole[..], &ring[..]], "hole comes before"),
        (vec![&ring[..], &nowhere[..]], "a vertex at"),
    ] {
        let e = lakes.push(&parts, &[3.0, 1.0]).unwrap_err().to_string();
        assert!(e.contains(words), "{e}");
        assert_eq!(lakes, before);
    }
    assert!(lakes.push(&[&ring], &[3.0]).is_err() && lakes == before, "a row that does not fit");
    let mut lines = Features::new(Form::Lines, []);
    assert!(lines.push(&[&ring[..1]], &[]).is_err() && lines.push(&[&hole[..2]], &[]).is_ok());
    assert!(lines.polygons(0).is_empty());
}
