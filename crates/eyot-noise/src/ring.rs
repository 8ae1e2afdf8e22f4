//! Noise of one octave on a lattice of squares that repeats after whole numbers of cells along both axes.

use crate::{blend, fade, floor};
use eyot_core::rng::{self, Key, mix64};

/// Gradient noise, repeating after `period` cells of the lattice; within about -0.7..=0.7. Lattice points are hashed in 64 bits.
#[inline]
pub fn gradient(x: f32, y: f32, period: [i32; 2], seed: u64) -> f32 {
    let (cx, cy) = (floor(x), floor(y));
    let (fx, fy) = (x - cx as f32, y - cy as f32);
    let ring = |i: i32, n: i32| if (0..n).contains(&i) { i } else { i.rem_euclid(n) } as u64;
    let columns = [ring(cx, period[0]), ring(cx + 1, period[0])];
    let rows = [ring(cy, period[1]), ring(cy + 1, period[1])];
    let corner = |i: usize, j: usize| {
        // Sixteen directions: eight would show on maps.
        let (gx, gy) = DIRECTIONS[(mix64(seed ^ (columns[i] << 32 | rows[j])) >> 60) as usize];
        gx * (fx - i as f32) + gy * (fy - j as f32)
    };
    blend([corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)], fade(fx), fade(fy))
}

const S: f32 = 0.382_683_43;
const C: f32 = 0.923_879_5;
const D: f32 = std::f32::consts::FRAC_1_SQRT_2;
const DIRECTIONS: [(f32, f32); 16] = [
    (1.0, 0.0),
    (C, S),
    (D, D),
    (S, C),
    (0.0, 1.0),
    (-S, C),
    (-D, D),
    (-C, S),
    (-1.0, 0.0),
    (-C, -S),
    (-D, -D),
    (-S, -C),
    (0.0, -1.0),
    (S, -C),
    (D, -D),
    (C, -S),
];

/// Value noise within -1..=1 at the place (x, y), which must not be negative, repeating after `period` cells of the lattice.
/// Its numbers are the world's random numbers of `key`, cell by cell of the lattice.
#[inline]
pub fn value(key: Key, x: f32, y: f32, period: [u32; 2]) -> f32 {
    let (i, j) = (x.floor(), y.floor());
    let at = |di: u32, dj: u32| {
        let cell = ((j as u32 + dj) % period[1]) * period[0] + (i as u32 + di) % period[0];
        2.0 * rng::unit::<f32>(rng::hash(key, cell)) - 1.0
    };
    blend([at(0, 0), at(1, 0), at(0, 1), at(1, 1)], fade(x - i), fade(y - j))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_repeat_and_are_continuous() {
        let key = Key::new(3, 7, 0);
        for (x, y) in [(0.0, 0.0), (0.25, 3.5), (4.75, 2.0), (2.0, 0.5)] {
            let at = |x, y| [gradient(x, y, [5, 4], 11), value(key, x, y, [5, 4])];
            assert_eq!(at(x, y), at(x + 5.0, y + 4.0));
            assert_eq!(gradient(x - 10.0, y - 8.0, [5, 4], 11), gradient(x, y, [5, 4], 11));
            for (a, b) in at(x, y).into_iter().zip(at(x + 1e-3, y + 1e-3)) {
                assert!((a - b).abs() < 1e-2, "{a} {b}");
            }
        }
    }
}
