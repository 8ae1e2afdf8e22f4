//! Every rule of the living world: lanes = scalar = reference bit by bit on all shapes and rims; the traced graph means
//! the same.

use eyot_core::plan::Plan;
use eyot_core::process::Moment;
use eyot_core::{Boundary, Grid, Limits};
use eyot_testing::climate::world;

eyot_testing::conformance_suite!(eyot_testing::climate::climate_variants, eyot_testing::climate::climate_start);

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
