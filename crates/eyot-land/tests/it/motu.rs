//! Waves build islets on a ring of reef: to windward, behind its edge, no higher than the crest, and by what the ledger says.

use eyot_core::control::Control;
use eyot_core::engine::CpuEngine;
use eyot_core::layer::known::{HEIGHT, LIMESTONE};
use eyot_core::process::{Process, Scheduled, Span};
use eyot_core::{Boundary, Field, Grid, Limits, World};
use eyot_land::simulate::Motu;

const CELLS: usize = 96;
const CELL_M: f64 = 40.0;

/// An atoll: a ring of limestone a metre under the sea, a lagoon 20 m deep, an ocean of 200 m.
fn atoll() -> World {
    let grid = Grid::new(CELLS, CELLS, CELL_M, Boundary::CLOSED, &Limits::default()).unwrap();
    let mut w = World::new(grid, 1);
    let r = |x: usize, y: usize| (x as f64 - 47.5).hypot(y as f64 - 47.5) * CELL_M;
    let on_ring = |x: usize, y: usize| (1000.0..1400.0).contains(&r(x, y));
    let height = |x, y| {
        if on_ring(x, y) {
            -1.0
        } else if r(x, y) < 1200.0 {
            -20.0
        } else {
            -200.0
        }
    };
    w.put(&HEIGHT, Field::from_fn(CELLS, CELLS, height)).unwrap();
    w.put(&LIMESTONE, Field::from_fn(CELLS, CELLS, |x, y| if on_ring(x, y) { 30.0 } else { 0.0 })).unwrap();
    w
}

fn run(w: &mut World, motu: Motu) {
    let motu: Box<dyn Process> = Box::new(motu);
    let all = [Scheduled { name: "motu", process: motu, every: 1 }];
    CpuEngine::default().simulate(w, &all, Span { from: 0, steps: 400 }, &Control::none()).unwrap();
}

#[test]
fn islets_stand_on_the_windward_reef_and_no_higher_than_the_crest() {
    let mut w = atoll();
    let before = w.get("height").unwrap().sum();
    run(&mut w, Motu { wind: 90.0, ..Motu::default() });
    let (height, sand) = (w.get("height").unwrap(), w.get("sand").unwrap());
    assert!(height.min_max().1 > 1.0 && height.min_max().1 <= 3.5, "islets of {} m", height.min_max().1);
    let dry = |half: std::ops::Range<usize>| {
        half.flat_map(|x| (0..CELLS).map(move |y| (x, y))).filter(|&(x, y)| height.get(x, y) > 0.5).count()
    };
    let (west, east) = (dry(0..48), dry(48..CELLS));
    assert!(east > 20 && east > 3 * west, "{east} dry cells to windward, {west} to leeward");
    // The edge of the reef stays under the sea, and so do lagoon and ocean.
    assert!(height.get(47 + 34, 47) < 0.0 && height.get(47, 47) == -20.0 && height.get(2, 2) == -200.0);
    let risen = (height.sum() - before) * w.grid.cell_area_m2();
    let arrived = w.ledger.amount("ground.motu");
    assert!((risen - arrived).abs() < 1e-4 * arrived, "{risen} m3 rose, {arrived} m3 arrived");
    assert!((sand.sum() * w.grid.cell_area_m2() - risen).abs() < 1e-4 * risen);
}

#[test]
fn there_is_no_lee_where_waves_come_from_all_sides_and_no_islet_without_supply() {
    let mut w = atoll();
    run(&mut w, Motu { bend: 1.0, ..Motu::default() });
    let height = w.get("height").unwrap();
    for (x, y) in (0..CELLS).flat_map(|y| (0..CELLS).map(move |x| (x, y))) {
        let (a, b) = (height.get(x, y), height.get(CELLS - 1 - x, CELLS - 1 - y));
        assert!((a - b).abs() < 1e-3, "{a} and {b} on opposite sides");
    }
    let mut bare = atoll();
    run(&mut bare, Motu { supply: 0.0, ..Motu::default() });
    assert_eq!(bare.get("height"), atoll().get("height"));
}
