//! D-infinity shares: water runs straight down the steepest of eight triangles, to one or two neighbours.
//!
//! # Equations
//! Between a cell `0`, its neighbour `1` across an edge and a neighbour `2` across a corner lies a triangle, with `d_1` from 0
//! to 1 and `d_2` from 1 to 2.
//! 1. Slopes along its legs: `s_1 = (z_0 - z_1) / d_1`, `s_2 = (z_1 - z_2) / d_2`.
//! 2. The steepest way down it: angle from the first leg `r = atan(s_2 / s_1)`, slope `sqrt(s_1^2 + s_2^2)`. Outside of the
//!    triangle (`r < 0` or `r > atan(d_2 / d_1)`) it is the way along the edge on that side.
//! 3. Of the triangle with the steepest way, neighbour 2 gets `r / atan(d_2 / d_1)` and neighbour 1 the rest. Of equally steep
//!    triangles the first counts: clockwise from north, before each edge neighbour counterclockwise of it.
//!
//! # Source
//! Tarboton (1997), A new method for the determination of flow directions and upslope areas in grid digital elevation
//! models, Water Resources Research 33, 309-319.
//!
//! # Differences
//! At the rim, where the corner neighbour is missing, water may still run to the edge neighbour.

use super::spread::Shares;
use super::{Height, Neighbours};

/// Tarboton's rule on a surface.
pub(super) struct Dinf<'a, T> {
    pub(super) z: &'a [T],
    pub(super) near: Neighbours,
}

/// The neighbours that get something, each with its share; the shares sum to 1.
type Pair = [(usize, f64); 2];

impl<T: Height> Dinf<'_, T> {
    #[inline]
    fn steepest(&self, i: usize) -> Pair {
        let fall = |i: usize, j: usize| self.z[i].to_f64() - self.z[j].to_f64();
        let mut around = [None; 8];
        self.near.each(i, |d, j| around[d] = Some(j));
        // Without a lower neighbour nobody gets anything.
        let (mut steepest, mut pair) = (0.0, [(i, 0.0); 2]);
        for edge in [0, 2, 4, 6] {
            let Some(one) = around[edge] else { continue };
            for corner in [(edge + 7) % 8, edge + 1] {
                // The second leg runs along the other axis.
                let (d1, d2) = (self.near.distance_m[edge], self.near.distance_m[(edge + 2) % 8]);
                let s1 = fall(i, one) / d1;
                let along_edge = (s1, [(one, 1.0), (one, 0.0)]);
                let (slope, ways) = match around[corner] {
                    Some(two) => {
                        let s2 = fall(one, two) / d2;
                        if s2 <= 0.0 {
                            along_edge
                        } else if s1 * d2 <= s2 * d1 {
                            (fall(i, two) / self.near.distance_m[corner], [(two, 1.0), (two, 0.0)])
                        } else {
                            let share = atan(s2 / s1) / atan(d2 / d1);
                            ((s1 * s1 + s2 * s2).sqrt(), [(one, 1.0 - share), (two, share)])
                        }
                    }
                    None => along_edge,
                };
                if slope > steepest {
                    (steepest, pair) = (slope, ways);
                }
            }
        }
        pair
    }
}

impl<T: Height> Shares for Dinf<'_, T> {
    #[inline]
    fn receivers(&self, i: usize, mut f: impl FnMut(usize)) {
        self.shares(i, |j, _| f(j));
    }

    #[inline]
    fn shares(&self, i: usize, mut f: impl FnMut(usize, f64)) {
        self.steepest(i).into_iter().filter(|(_, share)| *share > 0.0).for_each(|(j, share)| f(j, share));
    }
}

/// Arc tangent of `x >= 0`, the same bits on every machine; off by less than 1e-15.
fn atan(x: f64) -> f64 {
    // Three times half the angle, then Euler's series, whose terms fall by 25 times.
    let half = |x: f64| x / (1.0 + (1.0 + x * x).sqrt());
    let y = half(half(half(x)));
    let square = y * y;
    let series = (0..12).rev().fold(0.0, |sum, k| 1.0 / f64::from(2 * k + 1) - square * sum);
    8.0 * y * series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arc_tangent_is_one() {
        for k in 0..2000 {
            let x = 1e-6 * 1.02_f64.powi(k);
            assert!((atan(x) - x.atan()).abs() <= 1e-15 * x.atan().max(0.1), "{x}: {} {}", atan(x), x.atan());
        }
        assert_eq!(atan(0.0), 0.0);
    }
}
