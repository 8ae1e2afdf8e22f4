//! The stream function of the wind's eddies: periodic value noise of several octaves, zero at the equator and the poles.

use crate::wind::TURBULENCE;
use eyot_core::rng::Key;
use eyot_core::{Field, Result, World, math};
use eyot_noise::ring;

/// Lattice cells of the first octave along the equator and from pole to pole, as the source's domain of its noise.
const LATTICE: (u32, u32) = (8, 6);
/// Stream of the world's random numbers.
const STREAM: u32 = 0x7769_6e64;

/// Fills the layer `turbulence` if it is empty.
pub(crate) fn prepare(world: &mut World, octaves: u32, roughness: f32) -> Result<()> {
    let (seed, domain) = (world.seed, world.domain());
    let layer = &mut world.layer_mut(&TURBULENCE.name)?.field;
    if layer.min_max() == (0.0, 0.0) {
        let (width, height) = (domain.global().width, domain.global().height);
        *layer = Field::from_fn(layer.width(), layer.height(), |x, y| {
            let (x, y) = (domain.column(x as isize), domain.row(y as isize));
            // The south-eastern corner, in shares of the grid.
            let (u, v) = ((x + 1) as f32 / width as f32, (y + 1) as f32 / height as f32);
            let calm = math::sin(std::f32::consts::TAU * v).abs();
            // Slopes of the noise are what blows: a cell is so much of the lattice.
            width as f32 / LATTICE.0 as f32 * 0.5 * calm * noise(seed, octaves, roughness, u, v)
        });
    }
    Ok(())
}

/// Sum of octaves within -1..=1, each with slopes of the same strength before its weight.
fn noise(seed: u64, octaves: u32, roughness: f32, u: f32, v: f32) -> f32 {
    let (mut total, mut weights, mut weight) = (0.0, 0.0, 1.0);
    for octave in 0..octaves {
        // Lattices finer than any grid add nothing.
        let scale = 1u32 << octave.min(12);
        let (across, down) = (LATTICE.0 * scale, LATTICE.1 * scale);
        let key = Key::new(seed, STREAM.wrapping_add(octave), 0);
        let n = ring::value(key, u * across as f32, v * down as f32, [across, down]);
        total += weight * n / scale as f32;
        weights += weight;
        weight *= roughness;
    }
    total / weights
}
