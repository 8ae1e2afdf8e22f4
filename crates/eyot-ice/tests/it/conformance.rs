//! Same bytes on all engines and threads, and nothing touched that is not declared.

use crate::common::{run, world};
use eyot_core::process::{Process, Scheduled};
use eyot_core::{Boundary, conformance};
use eyot_ice::Glaciers;

fn quick() -> Glaciers {
    Glaciers { ela: 10.0, ice_years: 5.0, gradient: 0.05, ..Glaciers::default() }
}

fn scheduled() -> Vec<Scheduled> {
    vec![Scheduled { name: "glaciers", process: Box::new(quick()), every: 1 }]
}

/// A plausible value of a layer from a number within 0..1.
fn start(layer: &str, u: f32) -> f32 {
    match layer {
        "height" => 60.0 * u - 4.0,
        "glacier" => (60.0 * u - 30.0).max(0.0),
        "temperature" | "temperature_mean" => 10.0 * u - 12.0,
        "precipitation" | "rain_mean" => 3000.0 * u,
        _ => u,
    }
}

#[test]
fn steps_keep_to_the_layers_that_they_declare() {
    conformance::check_access(&scheduled(), &start).unwrap();
}

#[test]
fn threads_change_nothing() {
    let fingerprint = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut world = world((70, 51), 80.0, Boundary::OPEN, |x, y| {
                900.0 + 25.0 * ((x as f32 - 30.0).abs() + (y as f32 - 20.0).abs()) + ((x * 7 + y * 13) % 5) as f32
            });
            run(&mut world, &Glaciers { ela: 1200.0, ice_years: 20.0, ..Glaciers::default() }, 3).unwrap();
            world.fingerprint()
        })
    };
    let one = fingerprint(1);
    for threads in [2, 3, 8] {
        assert_eq!(fingerprint(threads), one, "{threads} threads");
    }
}

#[test]
fn bad_parameters_are_refused_by_name() {
    let grid = world((8, 8), 10.0, Boundary::OPEN, |_, _| 0.0).grid;
    let refused = |g: Glaciers| g.check(&grid).unwrap_err().to_string();
    assert!(refused(Glaciers { gradient: -1.0, ..quick() }).contains("gradient"));
    assert!(refused(Glaciers { repose: 90.0, ..quick() }).contains("repose"));
    assert!(refused(Glaciers { softness: f64::NAN, ..quick() }).contains("softness"));
    let e = refused(Glaciers { ice_years: 0.5, time_step: 2.0, ..quick() });
    assert!(e.contains("ice_years") && e.contains("time step"), "{e}");
}
