//! Worlds for tests.

use eyot_core::engine::CpuEngine;
use eyot_core::process::{Scheduled, Span};
use eyot_core::rng::{self, Key};
use eyot_core::{Boundary, BoundaryCondition, Control, Field, Grid, Limits, World};

/// The default world's rim: a ring with closed poles.
pub(crate) const CYLINDER: Boundary = Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Closed };

/// A planet of the Earth's size.
pub(crate) fn planet(width: usize, rim: Boundary) -> World {
    let grid = Grid::new(width, width / 2, 4e7 / width as f64, rim, &Limits::default()).unwrap();
    World::new(grid, 5)
}

/// Sets a layer of the world that `processes` make.
pub(crate) fn fill(world: &mut World, processes: &[Scheduled], layer: &str, f: impl FnMut(usize, usize) -> f32) {
    let spec = processes.iter().flat_map(|p| p.process.layers()).map(|l| l.spec).find(|l| l.name == layer).unwrap();
    let (w, h) = (world.grid.width, world.grid.height);
    world.put(&spec, Field::from_fn(w, h, f)).unwrap();
}

pub(crate) fn run(world: &mut World, processes: &[Scheduled], steps: u64) {
    CpuEngine::default().simulate(world, processes, Span { from: 0, steps }, &Control::none()).unwrap();
}

/// A number in 0..1 for a cell.
pub(crate) fn random(stream: u32, x: usize, y: usize) -> f32 {
    rng::unit::<f32>(rng::hash(Key::new(9, stream, 0), (y * 65_536 + x) as u32))
}

/// Continents and mountains, the same north and south of the equator.
pub(crate) fn mirrored_land(width: usize) -> impl FnMut(usize, usize) -> f32 {
    let height = width / 2;
    move |x, y| {
        let row = y.min(height - 1 - y);
        let (u, v) = (x as f32 / width as f32, row as f32 / height as f32);
        let land = (12.0 * u).sin() + (9.0 * v + 1.0).cos() + 0.6 * (31.0 * u + 14.0 * v).sin();
        2000.0 * land + 600.0 * random(1, x, row) - 500.0
    }
}

/// Sum of a layer over the grid, m3.
pub(crate) fn volume(world: &World, layer: &str) -> f64 {
    world.get(layer).unwrap().iter().map(f64::from).sum::<f64>() * world.grid.cell_area_m2()
}
