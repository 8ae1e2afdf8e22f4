//! Lanes = scalar = reference bit by bit on all shapes and rims; windows have the bytes of the whole; graphs mean what the rules mean.

use eyot_core::{Boundary, Grid, Limits, conformance};
use eyot_testing::plants::{start, variants};

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
