//! Gradient noise that goes on seamlessly where an axis is a ring, over its whole length: no part of it repeats.
//!
//! Perlin (2002) on a lattice whose cells divide the ring, octave by octave, at places bent by two more noises.

use crate::geometry::Geometry;
use eyot_core::rng::mix64;
use eyot_noise::ring;
use rayon::prelude::*;

/// Fractal noise on a grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fractal {
    /// Length of the largest features as a share of the shorter side.
    pub(crate) scale: f64,
    pub(crate) octaves: u32,
    /// Amplitude of an octave relative to the one before it.
    pub(crate) gain: f32,
    /// By how much places are bent, as a share of the largest features.
    pub(crate) warp: f32,
}

impl Fractal {
    /// A value within about -1..=1 for each cell.
    pub(crate) fn field(&self, g: &Geometry, seed: u64) -> Vec<f32> {
        let length = g.width.min(g.height) as f64 * self.scale;
        let lattice = [g.width, g.height].map(|n| (n as f64 / length).round().max(1.0) as i32);
        let step = [lattice[0] as f32 / g.width as f32, lattice[1] as f32 / g.height as f32];
        let mut out = vec![0.0; g.cells()];
        out.par_chunks_mut(g.width).enumerate().for_each(|(row, line)| {
            for (column, v) in line.iter_mut().enumerate() {
                let (x, y) = ((column as f32 + 0.5) * step[0], (row as f32 + 0.5) * step[1]);
                let (u, w) = if self.warp > 0.0 {
                    (self.sum(x, y, lattice, seed ^ 1, 2), self.sum(x, y, lattice, seed ^ 2, 2))
                } else {
                    (0.0, 0.0)
                };
                *v = self.sum(x + self.warp * u, y + self.warp * w, lattice, seed, self.octaves);
            }
        });
        out
    }

    fn sum(&self, x: f32, y: f32, lattice: [i32; 2], seed: u64, octaves: u32) -> f32 {
        let (mut total, mut amplitude, mut norm) = (0.0, 1.0, 0.0);
        for octave in 0..octaves {
            let f = 1 << octave;
            // An offset keeps the zeros of all octaves from falling on each other.
            let shift = 0.37 * octave as f32;
            let (x, y) = (x * f as f32 + shift, y * f as f32 + shift);
            total += amplitude * ring::gradient(x, y, lattice.map(|n| n * f), mix64(seed ^ (u64::from(octave) << 40)));
            norm += amplitude * amplitude;
            amplitude *= self.gain;
        }
        1.6 * total / norm.sqrt()
    }
}

/// The value below which a share of the values lies.
pub(crate) fn quantile(values: &[f32], share: f64) -> f32 {
    let at = (share.clamp(0.0, 1.0) * values.len() as f64) as usize;
    eyot_core::math::ordered(values, at.min(values.len() - 1))
}
