//! Height from thickness and age: crust floats on the mantle, and the sea floor sinks as it cools.
//!
//! # Equations
//! 1. `dry = A crust + w theta(age) - level`, with `A = 1 - rho_crust / rho_mantle` (Airy)
//! 2. `height = dry` above the sea, `dry L` below it, with `L = rho_mantle / (rho_mantle - rho_water)`: water weighs on it
//! 3. `theta(age) = (d_0 - depth(age)) / L + theta_0`, in which `depth = 2500 + 350 sqrt(age)` up to 70 million years and
//!    `6400 - 3200 exp(-age / 62.8)` beyond
//! 4. `w` falls from 1 at oceanic crust to 0 at 35 km: continents do not sink with age
//!
//! For a given age the height grows with thickness, in pieces that are straight, so it can be inverted without iteration.
//!
//! # Source
//! Airy (1855) for 1; Parsons and Sclater (1977), equations 21 and 22, for 3. The exponential is the 1024th power of
//! `1 - x / 1024`, which is 1 m off at most and the same on every machine.

use crate::crust::{OCEANIC_M, metres};

const RHO_CRUST: f32 = 2800.0;
const RHO_MANTLE: f32 = 3300.0;
const RHO_WATER: f32 = 1030.0;
/// Rise of dry ground for each metre of crust.
const A: f32 = 1.0 - RHO_CRUST / RHO_MANTLE;
/// Depth under water for each metre of depth when dry.
const L: f32 = RHO_MANTLE / (RHO_MANTLE - RHO_WATER);
/// Crust from which on age no longer matters, m.
const AGELESS_M: f32 = 35_000.0;
/// So that a ridge lies 2500 m below the sea where crust of 36 km stands 500 m above it.
const THETA_0: f32 = A * (36_000.0 - OCEANIC_M) - 500.0 - 2500.0 / L;
/// The oldest floor that an imported depth can stand for, Myr.
const OLDEST_MYR: f32 = 180.0;

/// Age up to which the floor sinks with the root of its age, Myr.
const YOUNG_MYR: f32 = 70.0;

/// Depth of the sea floor, m, at an age in Myr.
#[inline(always)]
pub fn depth_m(age_myr: f32) -> f32 {
    if age_myr < YOUNG_MYR { young_depth_m(age_myr) } else { old_depth_m(age_myr) }
}

#[inline(always)]
fn young_depth_m(age_myr: f32) -> f32 {
    2500.0 + 350.0 * age_myr.sqrt()
}

#[inline(always)]
fn old_depth_m(age_myr: f32) -> f32 {
    let mut e = (1.0 - age_myr * (1.0 / (62.8 * 1024.0))).max(0.0);
    for _ in 0..10 {
        e *= e;
    }
    6400.0 - 3200.0 * e
}

/// [`height_m`] of several cells. Where all are of one kind, and most neighbours are, there is less to do.
pub(crate) fn heights_m(crust: &[i32], age: &[f32], level: f32, height: &mut [f32]) {
    let ageless = crust.iter().fold(true, |all, &c| all & (metres(c) >= AGELESS_M));
    let young = age.iter().fold(true, |all, &a| all & (a < YOUNG_MYR));
    let old = age.iter().fold(true, |all, &a| all & (a >= YOUNG_MYR));
    if ageless {
        fill_heights(crust, age, level, height, |_| 2500.0);
    } else if young {
        fill_heights(crust, age, level, height, young_depth_m);
    } else if old {
        fill_heights(crust, age, level, height, old_depth_m);
    } else {
        fill_heights(crust, age, level, height, depth_m);
    }
}

#[inline(always)]
fn fill_heights(crust: &[i32], age: &[f32], level: f32, height: &mut [f32], depth: impl Fn(f32) -> f32) {
    for ((&c, &a), h) in crust.iter().zip(age).zip(height) {
        *h = height_above(A * metres(c) + weight(metres(c)) * theta(depth(a)) - level);
    }
}

/// Age, Myr, at which the sea floor lies so deep, m; 0 above the ridges, 180 below the oldest floor.
pub fn age_of_depth(depth: f32) -> f32 {
    let (mut low, mut high) = (0.0f32, OLDEST_MYR);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if depth_m(middle) < depth { low = middle } else { high = middle }
    }
    low
}

/// Share of the effect of age that crust of this thickness feels.
#[inline(always)]
fn weight(crust_m: f32) -> f32 {
    ((AGELESS_M - crust_m) * (1.0 / (AGELESS_M - OCEANIC_M))).clamp(0.0, 1.0)
}

#[inline(always)]
fn theta(depth_m: f32) -> f32 {
    (2500.0 - depth_m) * (1.0 / L) + THETA_0
}

/// Height of dry ground above an arbitrary level, m.
#[inline(always)]
pub(crate) fn buoyancy(crust_m: f32, age_myr: f32) -> f32 {
    A * crust_m + weight(crust_m) * theta(depth_m(age_myr))
}

/// Height above the sea, m, of crust with that thickness (m) and age (Myr) when the sea stands at `level` of its buoyancy.
#[inline(always)]
pub fn height_m(crust_m: f32, age_myr: f32, level: f32) -> f32 {
    height_above(buoyancy(crust_m, age_myr) - level)
}

/// The height of ground that a rise of the level by so much would bring to the sea, m: what is under water stands higher without.
#[inline(always)]
pub(crate) fn height_above(rise: f32) -> f32 {
    if rise < 0.0 { rise * L } else { rise }
}

/// By how much ground at this height would stand above the level without water on it, m.
#[inline(always)]
pub(crate) fn dry_m(height: f32) -> f32 {
    if height < 0.0 { height / L } else { height }
}

/// Thickness, m, that stands at `height`; not below 0.
#[inline(always)]
pub fn crust_m(height: f32, age_myr: f32, level: f32) -> f32 {
    let buoyancy = level + dry_m(height);
    let theta = theta(depth_m(age_myr));
    let per_m = theta / (AGELESS_M - OCEANIC_M);
    // Each of the three pieces, of which one is right: so there is no branch.
    let (ageless, thin) = (buoyancy / A, (buoyancy - theta) / A);
    let between = (buoyancy - per_m * AGELESS_M) / (A - per_m);
    let young = if thin <= OCEANIC_M { thin.max(0.0) } else { between };
    if ageless >= AGELESS_M { ageless } else { young }
}

/// Rise of the land for each metre of crust, where age plays no part.
pub(crate) const RISE: f32 = A;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sea_floor_sinks_as_published() {
        for (age, depth) in [(0.0, 2500.0), (1.0, 2850.0), (25.0, 4250.0), (64.0, 5300.0)] {
            assert!((depth_m(age) - depth).abs() < 0.01, "{age}");
        }
        for age in [70.0f32, 100.0, 150.0, 300.0] {
            let exact = 6400.0 - 3200.0 * (-f64::from(age) / 62.8).exp();
            assert!((f64::from(depth_m(age)) - exact).abs() < 1.0, "{age}: {} {exact}", depth_m(age));
        }
        let level = A * 36_000.0 - 500.0;
        assert!((height_m(OCEANIC_M, 0.0, level) + 2500.0).abs() < 1.0);
        assert!((height_m(36_000.0, 500.0, level) - 500.0).abs() < 0.01);
        assert!((height_m(OCEANIC_M, 100.0, level) + depth_m(100.0)).abs() < 1.0);
        assert!((depth_m(age_of_depth(4000.0)) - 4000.0).abs() < 1.0);
    }

    #[test]
    fn height_grows_with_thickness_and_can_be_inverted() {
        for level in [3000.0f32, 4900.0, 6000.0] {
            for age in [0.0, 5.0, 69.9, 70.1, 400.0] {
                let mut last = f32::NEG_INFINITY;
                for t in (0..900).map(|i| i as f32 * 100.0) {
                    let h = height_m(t, age, level);
                    assert!(h > last, "{level} {age} {t}");
                    last = h;
                    assert!((crust_m(h, age, level) - t).abs() < 0.3, "{t} {age} {}", crust_m(h, age, level));
                }
            }
        }
    }
}
