//! Lanes = scalar = reference bit by bit on all shapes and rims; windows have the bytes of the whole; graphs mean what the rules mean.

use crate::scheduled;
use eyot_core::process::Scheduled;
use eyot_core::{Boundary, Grid, Limits, conformance};
use eyot_strata::{Beds, Fault, Fold, Rockfall};

fn variants() -> Vec<(&'static str, Vec<Scheduled>)> {
    let bent = Beds {
        top: 20.0,
        repeat: true,
        dip: 7.0,
        folds: vec![Fold { wavelength: 11.0, amplitude: 3.0, direction: 30.0, crest: 2.0 }],
        faults: vec![Fault { strike: 20.0, distance: 3.0, throw: -9.0 }],
        soil: 0.001,
        uplift: 0.002,
        years_per_step: 10.0,
        ..Beds::default()
    };
    vec![
        ("beds", vec![scheduled(Beds { top: 10.0, regolith: 0.5, ..Beds::default() })]),
        ("bent beds", vec![scheduled(bent.clone())]),
        ("rockfall", vec![scheduled(Rockfall::default())]),
        ("both", vec![scheduled(bent), scheduled(Rockfall { talus: 20.0, rate: 1.0 })]),
    ]
}

fn start(layer: &str, u: f32) -> f32 {
    match layer {
        "height" => 40.0 * u - 10.0,
        "bedrock" => 40.0 * u - 11.0,
        "bed_datum" => 60.0 * u,
        "rock_slope" => 3.0 * u,
        _ => u,
    }
}

#[test]
fn engine_equals_reference_for_every_rule() {
    for (name, processes) in variants() {
        println!("{name}");
        conformance::check(&processes, &start).unwrap();
    }
}

#[test]
fn steps_keep_to_the_layers_that_they_declare() {
    for (name, processes) in variants() {
        println!("{name}");
        conformance::check_access(&processes, &start).unwrap();
    }
}

#[test]
fn windows_have_the_bytes_of_the_whole_grid() {
    for (name, processes) in variants() {
        assert!(conformance::check_windows(&processes, &start).unwrap(), "{name} is rules");
    }
}

#[test]
fn graphs_mean_what_the_rules_mean() {
    let grid = Grid::new(64, 32, 3.0, Boundary::OPEN, &Limits::default()).unwrap();
    for (_, processes) in variants() {
        conformance::check_graphs(&processes, grid);
    }
}
