//! Worlds and runs that the tests share.

use eyot_core::engine::CpuEngine;
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::{Scheduled, Span};
use eyot_core::{Boundary, Control, Field, Grid, Limits, World};
use eyot_ice::Glaciers;

/// A world with heights, far above the sea.
pub(crate) fn world(size: (usize, usize), cell_m: f64, rim: Boundary, z: impl FnMut(usize, usize) -> f32) -> World {
    let mut world = World::new(Grid::new(size.0, size.1, cell_m, rim, &Limits::default()).unwrap(), 3);
    world.sea_level_m = -10_000.0;
    world.put(&HEIGHT, Field::from_fn(size.0, size.1, z)).unwrap();
    world
}

/// Runs some rounds.
pub(crate) fn run(world: &mut World, glaciers: &Glaciers, steps: u64) -> eyot_core::Result<()> {
    let all = [Scheduled { name: "glaciers", process: Box::new(glaciers.clone()), every: 1 }];
    all[0].process.check(&world.grid)?;
    CpuEngine::default().simulate(world, &all, Span { from: 0, steps }, &Control::none()).map(drop)
}

/// The values of a layer.
pub(crate) fn layer(world: &World, name: &str) -> Vec<f32> {
    world.get(name).unwrap().to_vec()
}
