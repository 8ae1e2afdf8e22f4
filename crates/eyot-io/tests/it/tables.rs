//! What components show of themselves, as tables.

use eyot_core::Components;
use eyot_core::component::{Graph, Numbers, Points, Type};
use eyot_io::Table;
use serde_json::Map;

#[test]
fn points_and_lines_are_tables_too() {
    let mut springs = Points::new([("id", "1", Type::U32)]);
    springs.push([1.0, 2.5, -3.0], &[7.0]).unwrap();
    springs.push([4.0, 0.0, 0.5], &[8.0]).unwrap();
    let mut rivers = Graph::new(springs, [("flow", "m3/s", Type::F64)]);
    rivers.push_edge(1, 0, &[12.5]).unwrap();
    let mut world = Components::default();
    world.insert("rivers", rivers);
    world.insert("raw", Numbers(vec![1.0]));
    let table = |name: &str| Table::of_view(&world.view(name).unwrap(), Map::new()).unwrap();
    assert_eq!(table("rivers").csv(), "from,to,flow\n1,0,12.5\n");
    assert_eq!(table("rivers.nodes").csv(), "x,y,z,id\n1,2.5,-3,7\n4,0,0.5,8\n");
    let units: Vec<(String, bool)> = table("rivers.nodes").columns.into_iter().map(|c| (c.unit, c.is_whole)).collect();
    assert_eq!(units[2..], [("m".to_owned(), false), ("1".to_owned(), true)]);
    assert!(world.view("raw").is_none());
}
