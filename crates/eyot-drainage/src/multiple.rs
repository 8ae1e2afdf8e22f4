//! Multiple-flow shares: water spreads over all lower neighbours, more to the steeper ones.
//!
//! # Equation
//! Neighbour `j` gets the share `s_j^p / sum s_k^p`, `s = (z - z_j) / distance`, over all lower neighbours. The exponent `p`
//! decides how much water gathers: 1 spreads it most (Quinn et al. 1991 without their contour lengths), 1.1 is right on
//! cones (Freeman 1991), towards infinity it becomes D8.
//!
//! # Source
//! Freeman (1991), Calculating catchment area with divergent flow based on a regular grid, Computers & Geosciences 17,
//! 413-422; Quinn, Beven, Chevallier & Planchon (1991), Hydrological Processes 5, 59-79.

use super::spread::Shares;
use super::{Height, Neighbours};
use eyot_core::math;

/// Freeman's rule on a surface.
pub(super) struct Multiple<'a, T> {
    pub(super) z: &'a [T],
    pub(super) near: Neighbours,
    pub(super) p: f64,
}

impl<T: Height> Multiple<'_, T> {
    #[inline]
    fn slope(&self, i: usize, d: usize, j: usize) -> f64 {
        (self.z[i].to_f64() - self.z[j].to_f64()) / self.near.distance_m[d]
    }
}

impl<T: Height> Shares for Multiple<'_, T> {
    #[inline]
    fn receivers(&self, i: usize, mut f: impl FnMut(usize)) {
        self.near.each(i, |_, j| {
            if self.z[j] < self.z[i] {
                f(j);
            }
        });
    }

    #[inline]
    fn shares(&self, i: usize, mut f: impl FnMut(usize, f64)) {
        // Relative to the steepest way: powers of large exponents stay numbers.
        let mut steepest = 0.0_f64;
        self.near.each(i, |d, j| steepest = steepest.max(self.slope(i, d, j)));
        self.near.each(i, |d, j| {
            if self.z[j] < self.z[i] {
                let s = self.slope(i, d, j) / steepest;
                f(j, if self.p == 1.0 { s } else { math::pow(s, self.p) });
            }
        });
    }
}
