//! The stream function of the wind's eddies: periodic value noise of several octaves, zero at the equator and the poles.

use crate::wind::TURBULENCE;
use eyot_core::rng::{self, Key};
use eyot_core::{Field, Result, World, math};

/// Lattice cells of the first octave along the equator and from pole to pole, as the source's domain of its noise.
const LATTICE: (u32, u32) = (8, 6);
/// Stream of the world's random numbers.
const STREAM: u32 = 0x7769_6e64;

/// Fills the layer `turbulence` if it is empty.
pub(crate) fn prepare(world: &mut World, octaves: u32, roughness: f32) -> Result<()> {
    let seed = world.seed;
    let layer = &mut world.layer_mut(&TURBULENCE.name)?.field;
    if layer.min_max() == (0.0, 0.0) {
        let (width, height) = (layer.width(), layer.height());
        *layer = Field::from_fn(width, height, |x, y| {
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
        let n = value(Key::new(seed, STREAM.wrapping_add(octave), 0), LATTICE.0 * scale, LATTICE.1 * scale, u, v);
        total += weight * n / scale as f32;
        weights += weight;
        weight *= roughness;
    }
    total / weights
}

/// Value noise within -1..=1 on a lattice that repeats.
fn value(key: Key, across: u32, down: u32, u: f32, v: f32) -> f32 {
    let (x, y) = (u * across as f32, v * down as f32);
    let (i, j) = (x.floor(), y.floor());
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (s, t) = (fade(x - i), fade(y - j));
    let at = |di: u32, dj: u32| {
        let cell = ((j as u32 + dj) % down) * across + (i as u32 + di) % across;
        2.0 * rng::unit::<f32>(rng::hash(key, cell)) - 1.0
    };
    let north = at(0, 0) + s * (at(1, 0) - at(0, 0));
    let south = at(0, 1) + s * (at(1, 1) - at(0, 1));
    north + t * (south - north)
}
