//! Bodies that are a height over the ground: encrusting and free-living colonies.
//!
//! # Equations
//! With the gauge `q` (0 in the middle, 1 on the outline) and the height `h` of the middle:
//! 1. encrusting: `y = h sqrt(1 - q^4) (0.75 + 0.25 n)`, `n` in -1..1 being lumps of several sizes;
//! 2. free-living, as mushroom corals: `y = h sqrt(1 - q^2) (1 - 0.35 e^(-(q / 0.12)^2)) (1 + 0.08 s (1 - q)^(1/4))`, `s` being the septa,
//!    a triangle wave around the middle that begins at `q = 0.15`. The mouth is the hollow.
//!
//! The field is `(y - height) / h`, so that its gradient fits the body's size.

use super::chance::Chance;
use super::outline::Outline;
use eyot_core::math::{cos, exp, sin};
use eyot_core::math64::acos;
use eyot_mesh::{Point, ScalarField};

const LUMP: u32 = 21;
/// Septa of a mushroom coral that are worth drawing.
const SEPTA: f32 = 48.0;

/// Which of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReliefKind {
    Encrusting,
    FreeLiving,
}

/// A height over the ground.
pub(crate) struct Relief<'a> {
    outline: &'a Outline,
    kind: ReliefKind,
    /// Height in the middle, m.
    height: f32,
    waves: [Wave; 6],
}

/// A wave over the ground, in radians.
#[derive(Clone, Copy)]
struct Wave {
    per_m: [f32; 2],
    phase: f32,
    size: f32,
}

impl<'a> Relief<'a> {
    /// A body of this height in the middle, m.
    pub(crate) fn new(outline: &'a Outline, kind: ReliefKind, height: f32, chance: Chance) -> Self {
        let waves = std::array::from_fn(|i| {
            let number = |k: u32| chance.between(LUMP, 8 * i as u32 + k, 0.0, std::f32::consts::TAU);
            let turn = number(0);
            let pace = (3.0 + 2.5 * i as f32) / outline.radius;
            Wave { per_m: [pace * cos(turn), pace * sin(turn)], phase: number(1), size: 1.0 / (3.5 + 1.05 * i as f32) }
        });
        Self { outline, kind, height, waves }
    }

    fn surface(&self, x: f32, z: f32) -> f32 {
        let q = self.outline.gauge(x, z).0;
        let square = q * q;
        match self.kind {
            ReliefKind::Encrusting => dome(1.0 - square * square) * self.height * (0.75 + 0.25 * self.lumps(x, z)),
            ReliefKind::FreeLiving => {
                let mouth = 1.0 - 0.35 * exp(-square / 0.0144);
                let septa = 1.0
                    + 0.08 * self.septa(x, z) * (1.0 - q).max(0.0).sqrt().sqrt() * (4.0 * (q - 0.15)).clamp(0.0, 1.0);
                dome(1.0 - square) * self.height * mouth * septa
            }
        }
    }

    /// -1 to 1, as often as there are septa.
    fn septa(&self, x: f32, z: f32) -> f32 {
        let r = f64::from(x).hypot(f64::from(z));
        if r == 0.0 {
            return 0.0;
        }
        let turn = acos((f64::from(x) / r).clamp(-1.0, 1.0)) / std::f64::consts::TAU;
        let turn = if z < 0.0 { 1.0 - turn } else { turn } as f32;
        let phase = (turn * SEPTA).fract();
        1.0 - 4.0 * (phase - 0.5).abs()
    }

    /// Waves of several lengths in directions of the colony's own, about -1 to 1.
    fn lumps(&self, x: f32, z: f32) -> f32 {
        self.waves.iter().map(|w| w.size * sin(w.per_m[0] * x + w.per_m[1] * z + w.phase)).sum()
    }
}

/// Square root above 0, and as steep below, so that the field goes on falling outside.
fn dome(v: f32) -> f32 {
    if v >= 0.0 { v.sqrt() } else { 2.0 * v.max(-4.0) }
}

impl ScalarField for Relief<'_> {
    fn value(&self, [x, y, z]: Point) -> f32 {
        (self.surface(x, z) - y) / self.height
    }

    fn fill(&self, [xs, ys, zs]: [&[f32]; 3], values: &mut [f32]) {
        let mut surface = vec![0.0; xs.len()];
        for (plane, &z) in values.chunks_exact_mut(xs.len() * ys.len()).zip(zs) {
            surface.iter_mut().zip(xs).for_each(|(s, &x)| *s = self.surface(x, z));
            for (row, &y) in plane.chunks_exact_mut(xs.len()).zip(ys) {
                row.iter_mut().zip(&surface).for_each(|(v, s)| *v = (s - y) / self.height);
            }
        }
    }
}
