//! Records of the network stream, and what clients send.

use eyot::live::{
    Alga, Body, Changed, Colony, Ending, HEADER, Hello, LayerInfo, Mirror, Moment, Order, Permission, Record,
    SpeciesInfo, Status, Tile, Why,
};

pub(crate) const WORDS: &[&str] = &["EYST", "\u{2}\0", "\0\0\0\0", "height", "m", "sea_level", "null"];

/// Cells of a mirror's layers: far below what an input may allocate.
const CELLS: u64 = 1 << 22;

/// Several records, one after the other, to a client. What can be read is written as the same bytes.
pub(crate) fn read(mut bytes: &[u8]) -> bool {
    let mut mirror = Mirror::within(CELLS);
    let mut sound = !bytes.is_empty();
    while !bytes.is_empty() {
        // Messages have a length of their own; here the records' must do, wherever it leads.
        let length = bytes.get(8..12).map_or(0, |b| u32::from_le_bytes(b.try_into().expect("four bytes"))) as usize;
        let (record, rest) = bytes.split_at(length.clamp(HEADER.min(bytes.len()), bytes.len()));
        bytes = rest;
        match Record::decode(record) {
            Ok(read) => {
                assert_eq!(read.encode(), record, "{read:?}");
                // A mirror must bear what no server sends.
                sound &= mirror.take(read).is_ok();
                drop(mirror.scene());
            }
            Err(e) => {
                assert!(e.at <= record.len().max(HEADER), "{e}");
                sound = false;
            }
        }
    }
    sound
}

/// A client's message to a server.
pub(crate) fn read_order(bytes: &[u8]) -> bool {
    match Order::decode(bytes) {
        Ok(order) => {
            assert_eq!(Record::from(Body::Order(order)).encode(), bytes);
            true
        }
        Err(_) => false,
    }
}

/// A connection from its hello to its end.
pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let hello = Hello {
        size: [6, 4],
        every: 1,
        rays: true,
        may: Permission::Change,
        engine: "0.1.0".into(),
        recipe: "Reef".into(),
        species: vec![SpeciesInfo { name: "Porites".into(), ..SpeciesInfo::default() }],
        layers: vec![LayerInfo { name: "height".into(), unit: "m".into(), ..LayerInfo::default() }],
        columns: vec!["month".into()],
        ..Hello::default()
    };
    let moment = |number, living| Moment { number, living, census: vec![1.0], ..Moment::default() };
    let colony = |id, radius| Colony { id, radius, ..Colony::default() };
    let colonies = |why, rays, rows| Body::Colonies { why, rays, rows };
    let tile =
        |at, size: [u32; 2]| Tile { at, size, values: vec![0.5; (size[0] * size[1]) as usize], ..Tile::default() };
    let moments: [Vec<Body>; 2] = [
        vec![
            Body::Snapshot(moment(7, [2, 1])),
            colonies(Why::All, true, vec![colony(1, 0.1), colony(2, 0.2)]),
            Body::Algae { why: Why::All, rows: vec![Alga { id: 3, ..Alga::default() }] },
            Body::Tile(tile([0, 0], [6, 4])),
        ],
        vec![
            Body::Step(moment(8, [2, 0])),
            Body::Gone(vec![1, 3]),
            colonies(Why::Born, false, vec![colony(4, 0.1)]),
            colonies(Why::Changed, false, vec![colony(2, 0.3)]),
            Body::Tile(tile([2, 1], [3, 2])),
        ],
    ];
    let mut all = vec![Record::from(Body::Hello(hello)), Body::Status(Status::Paused).into()];
    for bodies in moments {
        let count = bodies.len();
        all.extend(bodies.into_iter().enumerate().map(|(i, body)| Record { more: (count - 1 - i) as u32, body }));
    }
    all.push(Body::Refused("no".into()).into());
    all.push(Body::Changed(Changed { recipe_step: 2, step: 8, set: "sea_level = 3.0".into() }).into());
    all.push(Body::End { how: Ending::Done, message: "the run is done".into() }.into());
    vec![all.iter().flat_map(Record::encode).collect()]
}

pub(crate) fn orders() -> Vec<Vec<u8>> {
    let set = Order::Set { path: "hydraulic.rain".into(), value: "0.004".into() };
    [Order::Pause, Order::Resume, Order::Step(12), set].map(|o| Record::from(Body::Order(o)).encode()).into()
}
