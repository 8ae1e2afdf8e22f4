//! Every rule of the living world: lanes = scalar = reference bit by bit on all shapes and rims; the traced graph means
//! the same.

use eyot_core::conformance;
use eyot_core::plan::Plan;
use eyot_core::process::Moment;
use eyot_core::{Boundary, Grid, Limits};
use eyot_testing::climate::{climate_start, climate_variants, world};

#[test]
fn engine_equals_reference_for_every_rule() {
    for (name, processes) in climate_variants() {
        println!("{name}");
        conformance::check(&processes, &climate_start).unwrap();
    }
}

#[test]
fn steps_keep_to_the_layers_that_they_declare() {
    for (name, processes) in climate_variants() {
        println!("{name}");
        conformance::check_access(&processes, &climate_start).unwrap();
    }
}

/// What a window makes of its inside is what the whole world has there.
#[test]
fn windows_have_the_bytes_of_the_whole_grid() {
    for (name, processes) in climate_variants() {
        println!("{name}");
        assert!(conformance::check_windows(&processes, &climate_start).unwrap(), "{name} is rules");
    }
}

#[test]
fn graphs_mean_what_the_rules_mean() {
    let grid = Grid::new(64, 32, 3.0, Boundary::OPEN, &Limits::default()).unwrap();
    for (_, processes) in climate_variants() {
        conformance::check_graphs(&processes, grid);
    }
}

/// What a step of all processes costs for a cell; `docs/performance.md` gives the numbers that this prints.
#[test]
fn a_step_is_lean() {
    let grid = Grid::new(64, 32, 6e5, Boundary::WRAP, &Limits::default()).unwrap();
    let (mut operations, mut accesses) = (0.0, 0.0);
    for s in world() {
        let mut plan = Plan::default();
        s.process.plan(&Moment::whole(grid, 1, 0.0), &mut plan);
        // Zones are drawn in every tenth step.
        let share = if s.name == "zones" { 0.1 } else { 1.0 };
        for p in plan.passes() {
            let (work, moved) = (p.graph().operations(), p.reads().len() + p.writes().len());
            println!("{:20} {work} operations, {} bytes", p.name(), 4 * moved);
            operations += share * work as f64;
            accesses += share * moved as f64;
        }
    }
    println!("a step: {operations:.0} operations, {:.0} bytes", 4.0 * accesses);
    assert!(operations < 1000.0 && 4.0 * accesses < 400.0, "{operations} operations, {} bytes", 4.0 * accesses);
}
