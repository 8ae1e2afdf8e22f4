//! The process `drainage`: its layers, its account, and that nothing but the recipe decides what it does.

use eyot_core::engine::CpuEngine;
use eyot_core::process::{Scheduled, Span};
use eyot_core::{Boundary, Cancel, Control, Error, Field, Grid, Limits, World};
use eyot_land::simulate::drainage::Depressions;
use eyot_land::simulate::{Drainage, Hydraulic};

fn world(rim: Boundary) -> World {
    let mut w = World::new(Grid::new(60, 40, 30.0, rim, &Limits::default()).unwrap(), 1);
    let bumps = |x: usize, y: usize| 40.0 + 9.0 * (x as f32 * 0.7).sin() * (y as f32 * 0.9).cos() + 0.3 * x as f32;
    w.put(&eyot_core::layer::known::HEIGHT, Field::from_fn(60, 40, bumps)).unwrap();
    w
}

fn drainage(depressions: Depressions) -> Scheduled {
    let process = Drainage { depressions, max_length: 5000.0, ..Drainage::default() };
    Scheduled { name: "drainage", process: Box::new(process), every: 3 }
}

fn run(w: &mut World, processes: &[Scheduled], from: u64, steps: u64) {
    CpuEngine::default().simulate(w, processes, Span { from, steps }, &Control::none()).unwrap();
}

fn ground(w: &World) -> f64 {
    w.get("height").unwrap().sum() * w.grid.cell_area_m2()
}

#[test]
fn lakes_and_areas_are_kept_and_the_ground_is_accounted_for() {
    for depressions in [Depressions::Keep, Depressions::Fill, Depressions::Breach] {
        let mut w = world(Boundary::OPEN);
        let before = ground(&w);
        run(&mut w, &[drainage(depressions)], 0, 1);
        let grown = w.ledger.amount("ground.filled") - w.ledger.amount("ground.breached");
        assert!((ground(&w) - before - grown).abs() < 1e-9 * before, "{depressions:?}");
        assert!((w.ledger.net("ground") - grown).abs() < 1e-9 * before);
        let (lake, area) = (w.get("lake").unwrap(), w.get("drained_area").unwrap());
        let lakes = lake.iter().filter(|&d| d > 0.0).count();
        match depressions {
            Depressions::Keep => assert!(grown == 0.0 && lakes > 100, "{lakes}"),
            Depressions::Fill => assert!(grown > 0.0 && lakes == 0),
            // measured: 46, which lie lower than every border cell near them
            _ => assert!(grown < 0.0 && lakes < 60, "{lakes}"),
        }
        let rim = |x: usize, y: usize| x == 0 || y == 0 || x == 59 || y == 39;
        let out: f64 = (0..2400)
            .map(|i| (i % 60, i / 60))
            .filter(|&(x, y)| rim(x, y))
            .map(|(x, y)| f64::from(area.get(x, y)))
            .sum();
        assert_eq!(out, 2400.0 * 900.0);
    }
}

fn rain_and_drainage() -> Vec<Scheduled> {
    let rain = Hydraulic { sea: false, ..Hydraulic::default() };
    vec![Scheduled { name: "hydraulic", process: Box::new(rain), every: 1 }, drainage(Depressions::Breach)]
}

#[test]
fn stops_and_goes_on_to_the_same_bytes_on_any_threads() {
    let mut whole = world(Boundary::WRAP);
    run(&mut whole, &rain_and_drainage(), 0, 8);
    let mut parts = world(Boundary::WRAP);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    pool.install(|| {
        run(&mut parts, &rain_and_drainage(), 0, 4);
        run(&mut parts, &rain_and_drainage(), 4, 4);
    });
    assert_eq!(parts.fingerprint(), whole.fingerprint());
    assert_eq!(parts.step, 8);
}

#[test]
fn a_stop_leaves_a_whole_step() {
    let mut w = world(Boundary::OPEN);
    let cancel = Cancel::default();
    let stop_after_two = |done: u64, _: u64| {
        if done >= 2 {
            cancel.raise();
        }
    };
    let control = Control::new(cancel.clone(), &stop_after_two);
    let outcome = CpuEngine::default().simulate(&mut w, &rain_and_drainage(), Span { from: 0, steps: 9 }, &control);
    assert!(matches!(outcome, Err(Error::Cancelled(_))));
    let mut again = world(Boundary::OPEN);
    run(&mut again, &rain_and_drainage(), 0, w.step);
    assert_eq!(w.fingerprint(), again.fingerprint());
}
