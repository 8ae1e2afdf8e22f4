//! Plates as a process: in step with others, through checkpoints, with a ledger.

use eyot_core::engine::CpuEngine;
use eyot_core::process::{Action, Moment, Process, Scheduled, Span};
use eyot_core::{Cancel, Control, Edge, Field, Grid, LayerSpec, Limits, Result, Rim, World, layer::known::HEIGHT};
use eyot_plates::{Tectonics, report};

fn world() -> World {
    let rim = Rim { x: Edge::Wrap, y: Edge::Closed };
    World::new(Grid::new(96, 48, 4e7 / 96.0, rim, &Limits::default()).unwrap(), 11)
}

/// Lowers all land by a hundredth, as rivers might.
struct Wear;

impl Process for Wear {
    fn layers(&self) -> Vec<(LayerSpec, f32)> {
        vec![(HEIGHT, 0.0)]
    }

    fn action(&self) -> Option<&dyn Action> {
        Some(self)
    }
}

impl Action for Wear {
    fn act(&self, _: &Moment, world: &mut World, control: &Control<'_>) -> Result<()> {
        control.check()?;
        world.layer_mut("height")?.field.map_in_place(|h| if h > 0.0 { 0.99 * h } else { h });
        Ok(())
    }

    fn bytes_per_cell(&self) -> usize {
        0
    }
}

fn processes(every: u64) -> Vec<Scheduled> {
    vec![
        Scheduled { name: "wear", process: Box::new(Wear), every: 1 },
        Scheduled { name: "plates", process: Box::new(Tectonics { cycle: 30.0, ..Tectonics::default() }), every },
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
    copy.features = world.features.clone();
    copy
}

/// The volume of crust is what the ledger says.
fn balance(world: &World) {
    let volume = world.layer("crust").unwrap().field.sum() * world.grid.cell_area_m2();
    let net = world.ledger.net("crust");
    assert!((volume - net).abs() < 1e-9 * volume, "{volume} {net}");
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
    let p = vec![Scheduled { name: "plates", process: Box::new(p), every: 1 }];
    eyot_core::process::prepare(&mut w, &p, &Limits::default()).unwrap();
    assert!(w.layer("height").unwrap().field == land);
    CpuEngine::default().simulate(&mut w, &p, Span { from: 0, steps: 1 }, &Control::none()).unwrap();
    let moved =
        w.layer("height").unwrap().field.iter().zip(land.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(moved < 50.0, "{moved}: a million years make the floor sink, and the level look for the asked share");
    balance(&w);
}
