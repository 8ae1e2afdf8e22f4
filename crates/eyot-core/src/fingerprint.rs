//! A number that tells worlds apart, made bit by bit.

use crate::grid::Grid;

/// [`World::fingerprint`](crate::World::fingerprint) of a world that is not in memory as a whole: layers in their order, rows from the north.
#[derive(Clone, Debug)]
pub struct Fingerprint(u64);

impl Fingerprint {
    /// The fingerprint of a world without layers.
    pub fn new(grid: &Grid, step: u64, sea_level_m: f64) -> Self {
        let mut print = Self(0xcbf2_9ce4_8422_2325);
        [grid.width as u64, grid.height as u64, step, sea_level_m.to_bits()].into_iter().for_each(|w| print.add(w));
        print
    }

    /// Goes on with the layer or component `name`.
    pub fn begin(&mut self, name: &str) {
        name.bytes().for_each(|b| self.add(u64::from(b)));
    }

    /// Goes on with the next values of the layer.
    pub fn values(&mut self, values: &[f32]) {
        values.iter().for_each(|v| self.add(u64::from(v.to_bits())));
    }

    /// Goes on with a number of a component.
    pub fn number(&mut self, number: f64) {
        self.add(number.to_bits());
    }

    /// Goes on with any 64 bits of a component.
    pub fn word(&mut self, word: u64) {
        self.add(word);
    }

    /// The fingerprint so far.
    pub fn value(&self) -> u64 {
        self.0
    }

    fn add(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        self.0 ^= self.0 >> 29;
    }
}
