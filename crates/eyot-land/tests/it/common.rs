//! What several tests of generators need.

use eyot_core::process::{Generator, Site};
use eyot_core::{Boundary, Control, Field, Grid, Limits, World};
use eyot_land::generate::GENERATORS;
use serde_json::Value;

pub(crate) fn grid(width: usize, height: usize, cell_m: f64, rim: Boundary) -> Grid {
    Grid::new(width, height, cell_m, rim, &Limits::default()).unwrap()
}

/// The field that a generator makes from `base` on the whole grid.
pub(crate) fn make(what: &dyn Generator, base: &Field, grid: Grid, seed: u64) -> Field {
    let (world, control) = (World::new(grid, seed), Control::none());
    what.generate(&Site::whole(grid, seed, &world, &control), base).unwrap()
}

/// The field of the generator with this name.
pub(crate) fn make_named(name: &str, parameters: &Value, grid: Grid, seed: u64) -> Field {
    let entry = GENERATORS.iter().find(|e| e.name == name).unwrap();
    make(&*(entry.make)(parameters.clone()).unwrap(), &Field::new(grid.width, grid.height, 0.0), grid, seed)
}

/// Mean and standard deviation.
pub(crate) fn spread(f: &Field) -> (f64, f64) {
    let n = (f.width() * f.height()) as f64;
    let mean = f.sum() / n;
    (mean, (f.iter().map(|v| (f64::from(v) - mean).powi(2)).sum::<f64>() / n).sqrt())
}

/// Mean squared difference of values at a distance of (dx, dy).
pub(crate) fn structure(f: &Field, dx: isize, dy: isize) -> f64 {
    let (w, h) = (f.width() as isize, f.height() as isize);
    let (mut sum, mut n) = (0.0, 0.0);
    for y in 0..h - dy {
        for x in (-dx).max(0)..(w - dx).min(w) {
            let d = f.get(x as usize, y as usize) - f.get((x + dx) as usize, (y + dy) as usize);
            sum += f64::from(d * d);
            n += 1.0;
        }
    }
    sum / n
}
