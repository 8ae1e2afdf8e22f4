//! Components of worlds, as checkpoints hold them behind their checksums.

use crate::limits;
use crate::states::NASTY;
use eyot::{Boundary, Grid, Limits, component_kinds};
use eyot_core::component::{Columns, Decoder, Encoder, Graph, Numbers, Points, Run, Table, Type};
use eyot_core::{Component, ComponentKind};
use std::sync::Arc;

/// A byte that says which kind, one for the version, and the component's own.
pub(crate) fn read(bytes: &[u8]) -> bool {
    let [kind, version, rest @ ..] = bytes else { return false };
    let kinds = component_kinds();
    let all: Vec<&ComponentKind> = kinds.iter().collect();
    let kind = all[usize::from(*kind) % all.len()];
    let Ok(component) = decode(kind.name, u32::from(*version), rest) else { return false };
    // What can be read can be written, and is then the same.
    let again = encode(&*component);
    let back = decode(kind.name, kind.version, &again).expect("a component of our own");
    assert_eq!(encode(&*back), again);
    for (name, _) in component.views() {
        assert!(component.view(name).is_some(), "{}: {name}", kind.name);
    }
    true
}

fn decode(kind: &str, version: u32, mut bytes: &[u8]) -> eyot_core::Result<Arc<dyn Component>> {
    let (grid, limits, length) = (grid(), limits(), bytes.len() as u64);
    component_kinds().decode(kind, version, &mut Decoder::new("input", &mut bytes, length, &grid, &limits))
}

fn encode(component: &dyn Component) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes);
    component.encode(&mut encoder);
    encoder.finish().expect("room for a component");
    bytes
}

fn grid() -> Grid {
    Grid::new(3, 2, 10.0, Boundary::CLOSED, &Limits::default()).expect("a sound grid")
}

/// One of each kind of the core, and the shortest lists of numbers that worlds once kept of reefs and plates.
pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let mut table = Table::new([("month", "month", Type::U64), ("cover", "1", Type::F64)]);
    table.push(&[1.0, 0.5]).expect("a row");
    let mut points = Points::new([("radius", "m", Type::F32)]);
    points.push([1.0, 2.0, 3.0], &[0.5]).expect("a point");
    let mut graph = Graph::new(points.clone(), [("flow", "m3/s", Type::U8)]);
    graph.push_edge(0, 0, &[1.0]).expect("an edge");
    let mut columns = Columns::new(6, 3, &Limits::default()).expect("columns");
    columns.deposit(2, Run { material: 1, thickness_m: 4.0 }).expect("a run");
    let core: [&dyn Component; 5] = [&Numbers(vec![1.0]), &table, &points, &graph, &columns];
    let reef = Numbers([1.0, 3.0, 7.0, 0.0, 0.0, 1.0, 4.0, 1.0, 9.0, 1.0, 0.5].to_vec());
    let plates = Numbers([&[1.0][..], &[0.0; 8 + 13 + 3 + 1]].concat());
    let kinds = component_kinds();
    let number = |name: &str| kinds.iter().position(|k| k.name == name).expect("a known kind") as u8;
    let of = |kind: &str, version: u8, bytes: Vec<u8>| [&[number(kind), version][..], &bytes].concat();
    let mut seeds: Vec<Vec<u8>> = core.iter().map(|c| of(c.kind().name, 1, encode(*c))).collect();
    for (kind, numbers) in [("reef.population", reef), ("plates.state", plates)] {
        let former = encode(&numbers);
        let now = encode(&*decode(kind, 1, &former).expect("a sound list"));
        seeds.extend([of(kind, 1, former), of(kind, 2, now)]);
    }
    seeds
}

/// Puts each of some bad numbers into each field of one component of each kind, one at a time, and hands over the input that does so.
pub fn component_by_component(mut each: impl FnMut(&[u8])) {
    for seed in seeds() {
        for at in 2..seed.len() {
            for nasty in NASTY.iter().filter(|n| at + n.len() <= seed.len()) {
                let mut input = seed.clone();
                input[at..at + nasty.len()].copy_from_slice(nasty);
                each(&input);
            }
        }
    }
}
