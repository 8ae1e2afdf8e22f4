//! Plates as a process: in step with others, through checkpoints, with a ledger.

use eyot_core::engine::CpuEngine;
use eyot_core::process::{Action, ActionInstance, Locality, Moment, Process, Scheduled, Span};
use eyot_core::{
    Boundary, BoundaryCondition, Cancel, Control, Field, Grid, Limits, Result, World, layer::known::HEIGHT,
};
use eyot_plates::{Drift, Tectonics, report};

fn world() -> World {
    let rim = Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Closed };
    World::new(Grid::new(96, 48, 4e7 / 96.0, rim, &Limits::default()).unwrap(), 11)
}

/// Lowers all land by a hundredth, as rivers might.
#[derive(Clone)]
struct Wear;

impl Process for Wear {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![HEIGHT.changed(0.0)]
    }

    fn action(&self) -> Option<&dyn Action> {
        Some(self)
    }
}

impl Action for Wear {
    fn instantiate(&self, _world: &World) -> Result<Box<dyn ActionInstance>> {
        Ok(Box::new(self.clone()))
    }

    fn locality(&self) -> Locality {
        Locality::Cell
    }

    fn bytes_per_cell(&self) -> usize {
        0
    }
}

impl ActionInstance for Wear {
    fn act(&mut self, _: &Moment, world: &mut World, control: &Control<'_>) -> Result<()> {
        control.check()?;
        world.layer_mut("height")?.field.map_in_place(|h| if h > 0.0 { 0.99 * h } else { h });
        Ok(())
    }
}

fn processes(every: u64) -> Vec<Scheduled> {
    vec![
        Scheduled { name: "wear", process: Box::new(Wear), every: 1 },
        Scheduled {
            name: "plates",
            process: Box::new(Drift::new(Tectonics { cycle: 30.0, ..Tectonics::default() })),
            every,
        },
    ]
}

fn simulate(world: &mut World, from: u64, steps: u64) {
    CpuEngine::default().simulate(world, &processes(2), Span { from, steps }, &Control::none()).unwrap();
}

/// What a checkpoint keeps of a world, and nothing else.
fn stored(world: &World) -> World {
    let mut copy = World::new(world.grid, world.seed);
    (copy.step, copy.sea_level_m, copy.ledger) = (world.step, world.sea_level_m, world.ledger.clone());
    for l in world.layers() {
        copy.put(&l.spec, Field::from_slice(96, 48, &l.field.to_vec()).unwrap()).unwrap();
    }
    copy.components = world.components.clone();
    copy
}

/// The volume of crust is what the ledger says.
fn balance(world: &World) {
    let volume = world.layer("crust").unwrap().field.sum() * world.grid.cell_area_m2();
    let net = world.ledger.net("crust");
    assert!((volume - net).abs() < 1e-9 * volume, "{volume} {net}");
}

#[test]
fn plates_keep_to_the_layers_that_they_declare() {
    let mut world = world();
    simulate(&mut world, 0, 3);
    let drift = Scheduled { name: "plates", process: Box::new(Drift::new(Tectonics::default())), every: 1 };
    assert_eq!(drift.process.action().map(|a| a.locality()), Some(Locality::Whole));
    eyot_core::conformance::check_access_in(&world, &[drift]).unwrap();
}

#[test]
fn a_world_goes_on_from_a_checkpoint_as_if_nothing_had_happened() {
    let mut whole = world();
    simulate(&mut whole, 0, 80);
    let mut part = world();
    for from in [0, 31, 50] {
        simulate(
            &mut part,
            from,
            if from == 0 {
                31
            } else if from == 31 {
                19
            } else {
                30
            },
        );
        part = stored(&part);
    }
    assert_eq!(part.fingerprint(), whole.fingerprint());
    assert!(part == whole);
    balance(&whole);
    let accounts = ["crust.start", "crust.ridges", "crust.subducted", "crust.removed"];
    accounts.iter().for_each(|a| assert!(whole.ledger.amount(a) > 0.0, "{a}"));
    let report = report(&whole).unwrap().unwrap();
    assert_eq!((report.steps, report.cycle), (40, 2));
    assert!((report.hypsometry.land - 0.3).abs() < 0.03 && report.plates.len() > 5);
    assert!(eyot_plates::report(&world()).unwrap().is_none());
}

#[test]
fn a_step_that_is_stopped_leaves_plates_as_they_were() {
    let mut straight = world();
    simulate(&mut straight, 0, 12);
    let mut stopped = world();
    let cancel = Cancel::default();
    let at_seven = |done: u64, _: u64| {
        if done >= 7 {
            cancel.raise();
        }
    };
    let control = Control::new(cancel.clone(), &at_seven);
    assert!(CpuEngine::default().simulate(&mut stopped, &processes(2), Span { from: 0, steps: 12 }, &control).is_err());
    let done = stopped.step;
    assert!((7..12).contains(&done), "{done}");
    simulate(&mut stopped, done, 12 - done);
    assert_eq!(stopped.fingerprint(), straight.fingerprint());
}

/// Given land is not touched before the first step, and the sea of the world is the datum.
#[test]
fn a_given_land_gets_the_crust_that_carries_it() {
    let mut w = world();
    w.sea_level_m = 100.0;
    let land =
        Field::from_fn(96, 48, |x, y| if (20..60).contains(&x) && (10..40).contains(&y) { 700.0 } else { -4500.0 });
    w.put(&HEIGHT, land.clone()).unwrap();
    let p = Tectonics { land: 0.26, speed: 0.0, erosion: 0.0, coast: 0.0, denudation: 0.0, ..Tectonics::default() };
    let p = vec![Scheduled { name: "plates", process: Box::new(Drift::new(p)), every: 1 }];
    eyot_core::stepper::prepare(&mut CpuEngine::default().runner(), &mut w, &p).unwrap();
    assert!(w.layer("height").unwrap().field == land);
    CpuEngine::default().simulate(&mut w, &p, Span { from: 0, steps: 1 }, &Control::none()).unwrap();
    let moved =
        w.layer("height").unwrap().field.iter().zip(land.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(moved < 50.0, "{moved}: a million years make the floor sink, and the level look for the asked share");
    balance(&w);
}

/// Whoever makes the step, and on which threads: beside the world, waited for, by the same process on another world, or anew.
#[test]
fn a_step_made_ahead_is_the_step() {
    let mut straight = world();
    simulate(&mut straight, 0, 40);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut other = world();
        pool.install(|| simulate(&mut other, 0, 40));
        assert!(other == straight, "{threads} threads");
    }
    // Set back with a step at hand that is ten turns on, and given another world with as many turns behind it.
    let processes = processes(2);
    let go = |world: &mut World, from, steps| {
        CpuEngine::default().simulate(world, &processes, Span { from, steps }, &Control::none()).unwrap();
    };
    let (mut first, mut elsewhere) = (world(), World::new(world().grid, 12));
    go(&mut first, 0, 20);
    let kept = first.clone();
    go(&mut first, 20, 20);
    go(&mut elsewhere, 0, 20);
    let mut again = kept;
    go(&mut again, 20, 20);
    assert!(first == straight && again == straight);
    let mut alone = World::new(world().grid, 12);
    simulate(&mut alone, 0, 20);
    assert!(elsewhere == alone);
}

/// Raises a patch of the land once.
#[derive(Clone)]
struct Pile;

impl Process for Pile {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![HEIGHT.changed(0.0)]
    }

    fn action(&self) -> Option<&dyn Action> {
        Some(self)
    }
}

impl Action for Pile {
    fn instantiate(&self, _world: &World) -> Result<Box<dyn ActionInstance>> {
        Ok(Box::new(self.clone()))
    }

    fn locality(&self) -> Locality {
        Locality::Whole
    }

    fn bytes_per_cell(&self) -> usize {
        0
    }
}

impl ActionInstance for Pile {
    fn act(&mut self, moment: &Moment, world: &mut World, _: &Control<'_>) -> Result<()> {
        if moment.turn == 20 {
            let field = &mut world.layer_mut("height")?.field;
            (0..96 * 48)
                .filter(|c| c % 13 == 0)
                .for_each(|c| field.set(c % 96, c / 96, field.get(c % 96, c / 96) + 80.0));
        }
        Ok(())
    }
}

/// While the step is made that will carry it, land is raised: it is found on its plate, where that has gone.
#[test]
fn what_others_do_meanwhile_moves_on_with_the_plate() {
    let p = Tectonics { erosion: 0.0, coast: 0.0, ..Tectonics::default() };
    let after = |piled: bool| {
        let mut w = world();
        let mut scheduled = vec![Scheduled { name: "plates", process: Box::new(Drift::new(p.clone())), every: 4 }];
        if piled {
            scheduled.push(Scheduled { name: "pile", process: Box::new(Pile), every: 1 });
        }
        let heights = |w: &World| w.layer("height").unwrap().field.to_vec();
        CpuEngine::default().simulate(&mut w, &scheduled, Span { from: 0, steps: 21 }, &Control::none()).unwrap();
        let raised = heights(&w);
        CpuEngine::default().simulate(&mut w, &scheduled, Span { from: 21, steps: 4 }, &Control::none()).unwrap();
        balance(&w);
        (raised, heights(&w))
    };
    let ((before, natural), (raised, carried)) = (after(false), after(true));
    let lifted =
        |a: &[f32], b: &[f32]| -> Vec<usize> { (0..a.len()).filter(|&c| (b[c] - a[c] - 80.0).abs() < 1.0).collect() };
    let (put, found) = (lifted(&before, &raised), lifted(&natural, &carried));
    assert_eq!(put.len(), (96 * 48_usize).div_ceil(13));
    assert!(found.len() > put.len() * 9 / 10, "{} of {} are there", found.len(), put.len());
    // Some plates have gone a cell further, some have not.
    let moved = found.iter().filter(|c| *c % 13 != 0).count();
    assert!(moved > put.len() / 10, "{moved} have moved");
}
