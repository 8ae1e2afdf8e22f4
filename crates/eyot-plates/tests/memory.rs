//! What plates hold beside the world is what they say: runs are refused by this number before they begin.

use eyot_core::process::{Moment, Process};
use eyot_core::{Boundary, BoundaryCondition, Control, Grid, Limits, World};
use eyot_plates::{Drift, Tectonics};
use eyot_testing::counting::{Counting, peak};

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_step_holds_what_it_says() {
    let grid = Grid::new(
        515,
        261,
        78_125.0,
        Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Closed },
        &Limits::default(),
    )
    .unwrap();
    let mut most: f64 = 0.0;
    for (count, cycle) in [(2, 0.0), (10, 300.0), (30, 5.0)] {
        let plates = Drift::new(Tectonics { count, cycle, ..Tectonics::default() });
        let mut world = World::new(grid, 3);
        for l in plates.layers() {
            world.ensure(&l.spec, l.start);
        }
        // What is made ahead is held between steps, too, and new plates are made within them.
        let (bytes, _) = peak(&grid, || {
            plates.prepare(&mut world).unwrap();
            let mut instance = plates.action().unwrap().instantiate(&world).unwrap();
            for step in 0..12 {
                let moment = Moment { turn: step, ..Moment::whole(grid, step, 0.0) };
                instance.act(&moment, &mut world, &Control::none()).unwrap();
            }
        });
        most = most.max(bytes);
        println!("{count} plates: {most:.1} bytes a cell");
    }
    let said = Drift::new(Tectonics::default()).action().unwrap().bytes_per_cell() as f64;
    assert!(most <= 1.05 * said + 1.0 && said <= 1.5 * most + 4.0, "{most} measured, {said} said");
}
