//! Random numbers of the community: a hash of seed, stream, month and individual, without state.

use eyot_core::rng::{Key, hash, unit};

/// What a number is for. Numbers of different streams have nothing to do with each other.
#[derive(Clone, Copy, Debug)]
#[repr(u32)]
pub(super) enum Stream {
    Placing = 0x5eef_0000,
    Bleaching,
    HeatDeath,
    Turf,
    Order,
    Breakage,
    Fragmentation,
    FragmentPlace,
    Settling,
    AlgaSettling,
    AlgaShade,
    AlgaFragments,
    Grazing,
    TurfGrazing,
    Disturbance,
    Interval,
    Year,
    Weather,
}

/// All numbers of one stream and month.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draws(Key);

impl Draws {
    pub(super) const fn new(seed: u64, stream: Stream, month: u64) -> Self {
        Self(Key::new(seed, stream as u32, month))
    }

    /// 32 mixed bits of an individual.
    pub(super) fn bits(self, who: u64) -> u32 {
        hash(Key { low: self.0.low ^ (who >> 32) as u32, high: self.0.high }, who as u32)
    }

    /// A number in [0, 1) of an individual.
    pub(super) fn unit(self, who: u64) -> f32 {
        unit(self.bits(who))
    }

    /// True with this probability; never for 0 and always for 1.
    pub(super) fn chance(self, who: u64, probability: f32) -> bool {
        self.unit(who) < probability
    }

    /// A place within a rectangle from the origin, m.
    pub(super) fn place(self, who: u64, width: f64, length: f64) -> [f32; 2] {
        [(f64::from(self.unit(2 * who)) * width) as f32, (f64::from(self.unit(2 * who + 1)) * length) as f32]
    }

    /// A number of mean 0 and standard deviation 1: the sum of twelve uniform ones, which never leaves -6..=6.
    pub(super) fn normal(self, who: u64) -> f64 {
        (0..12).map(|i| f64::from(self.unit(who * 12 + i))).sum::<f64>() - 6.0
    }
}
