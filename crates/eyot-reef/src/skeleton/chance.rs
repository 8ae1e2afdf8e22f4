//! Random numbers of a colony: a hash of the seed, its number and what they are for. A colony that has grown has the same ones.

use eyot_core::rng::{Key, hash, mix64, unit};

/// Stream of the numbers of bodies.
const STREAM: u32 = 0x5eef_1000;

/// The random numbers of one colony.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chance {
    key: Key,
    seed: u64,
}

impl Chance {
    pub(crate) const fn new(seed: u64, colony: u64) -> Self {
        Self { key: Key::new(seed, STREAM, colony), seed: mix64(mix64(seed) ^ colony) }
    }

    /// Number `i` of part `part`, uniform in `low..high`.
    pub(crate) fn between(self, part: u32, i: u32, low: f32, high: f32) -> f32 {
        low + (high - low) * unit::<f32>(hash(self.key, part << 16 | i))
    }

    /// For grammars.
    pub(crate) const fn seed(self) -> u64 {
        self.seed
    }
}
