//! Heights in double precision, kept in two layers of single precision.
//!
//! A step of a hundred years lifts the ground by millimetres; near a steady state it changes it by a millionth of that. Single
//! precision cannot hold such steps on a mountain, so what it leaves of the height is kept in a layer of its own.

use eyot_core::layer::known::HEIGHT;
use eyot_core::{LayerSpec, Result, World};
use rayon::prelude::*;

/// What single precision leaves of the height.
pub const HEIGHT_REST: LayerSpec =
    LayerSpec::new("height_rest", "m", "What single precision leaves of the height; belongs to it", (-1.0, 1.0));

/// `height` and [`HEIGHT_REST`] together, m, row by row.
pub(super) fn load(world: &World) -> Result<Vec<f64>> {
    let (height, rest) = (&world.layer(&HEIGHT.name)?.field, &world.layer(&HEIGHT_REST.name)?.field);
    let mut z = vec![0.0; world.grid.cells()];
    z.par_chunks_exact_mut(world.grid.width).enumerate().for_each(|(y, row)| {
        let parts = height.row(y).iter().zip(rest.row(y));
        row.iter_mut().zip(parts).for_each(|(z, (&h, &r))| *z = f64::from(h) + f64::from(r));
    });
    Ok(z)
}

/// Puts the heights back.
pub(super) fn store(world: &mut World, z: &[f64]) -> Result<()> {
    let width = world.grid.width;
    let rows = |layer: &'static str, world: &mut World, part: fn(f64) -> f32| -> Result<()> {
        let mut rows: Vec<&mut [f32]> = world.layer_mut(layer)?.field.rows_mut().collect();
        rows.par_iter_mut().zip(z.par_chunks_exact(width)).for_each(|(row, z)| {
            row.iter_mut().zip(z).for_each(|(v, &z)| *v = part(z));
        });
        Ok(())
    };
    rows("height", world, |z| z as f32)?;
    rows("height_rest", world, |z| (z - f64::from(z as f32)) as f32)
}
