//! Forests and plants.

mod conformance;
mod forest;
mod measures;
mod plants;
mod trees;

use eyot_core::engine::CpuEngine;
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::{Scheduled, Span};
use eyot_core::{Boundary, Control, Field, Grid, Limits, World};
use eyot_testing::one as scheduled;

fn world(size: [usize; 2], cell_m: f64, ground: impl Fn(usize, usize) -> f32) -> World {
    let grid = Grid::new(size[0], size[1], cell_m, Boundary::CLOSED, &Limits::default()).unwrap();
    let mut world = World::new(grid, 1);
    world.put(&HEIGHT, Field::from_fn(size[0], size[1], ground)).unwrap();
    world
}

fn go(world: &mut World, processes: &[Scheduled], steps: u64) {
    let from = world.step;
    CpuEngine::default().simulate(world, processes, Span { from, steps }, &Control::none()).unwrap();
}

fn value(world: &World, layer: &str, x: usize, y: usize) -> f32 {
    world.get(layer).unwrap().get(x, y)
}

/// Mean of a layer.
fn mean(world: &World, layer: &str) -> f64 {
    let field = world.get(layer).unwrap();
    field.sum() / (field.width() * field.height()) as f64
}
