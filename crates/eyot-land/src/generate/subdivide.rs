//! Surfaces by subdivision: a coarse lattice of random heights, refined level by level, with something random added to all
//! points of each level.
//!
//! What is added to a point is a hash of level and place, so a window of rows needs only the lattice points around it.

use super::noise::{COLUMN, ROW, hash};
use eyot_core::process::Site;
use eyot_core::rng::mix64;
use eyot_core::{BoundaryCondition, Field, Grid, Result};
use rayon::prelude::*;
use std::ops::Range;

/// One axis of a lattice: point i lies `(i + shift) spacing_m` from the rim.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) spacing_m: f64,
    pub(super) shift: f64,
    /// Points after which the axis is a ring.
    period: Option<i64>,
}

impl Axis {
    /// Points about `spacing_m` apart; on a wrapping rim a whole number of them, at least one.
    pub(super) fn new(extent_m: f64, edge: BoundaryCondition, spacing_m: f64, shift: f64) -> Self {
        if edge == BoundaryCondition::Wrap {
            let points = (extent_m / spacing_m).round().max(1.0);
            Self { spacing_m: extent_m / points, shift, period: Some(points as i64) }
        } else {
            Self { spacing_m, shift, period: None }
        }
    }

    /// Twice as many points.
    pub(super) fn halved(&self) -> Self {
        Self { spacing_m: 0.5 * self.spacing_m, period: self.period.map(|n| 2 * n), ..self.clone() }
    }
}

/// Columns and rows of a lattice.
pub(super) type Lattice = [Axis; 2];

/// How a point's height follows from the points of the level before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Blend {
    /// Between the nearest two along each axis. With points at one and three quarters this is the subdivision whose limit
    /// is a quadratic B-spline.
    Linear,
    /// Quadratic B-spline from the nearest three along each axis: no kinks wherever the points lie.
    Spline,
}

/// What is added to the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Random {
    /// Anything from -1 to 1 alike.
    Uniform,
    /// A bell with standard deviation 1: the sum of four uniform numbers, within 3.5 deviations.
    Bell,
}

/// One level: its points, and the size of what is added to them.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub(super) lattice: Lattice,
    pub(super) range: f32,
}

/// Nearest point of the coarse axis before the fine point `i`, and the weights of it and its two neighbours.
fn taps(coarse: &Axis, fine: &Axis, i: i64, blend: Blend) -> (i64, [f32; 3]) {
    let u = (i as f64 + fine.shift) * (fine.spacing_m / coarse.spacing_m) - coarse.shift;
    let nearest = (u + 0.5).floor();
    let f = u - nearest;
    let weights = match blend {
        Blend::Linear => [(-f).max(0.0), 1.0 - f.abs(), f.max(0.0)],
        Blend::Spline => [0.5 * (0.5 - f) * (0.5 - f), 0.75 - f * f, 0.5 * (0.5 + f) * (0.5 + f)],
    };
    (nearest as i64, weights.map(|w| w as f32))
}

/// Points of the coarse axis that the fine points `held` need.
fn needed(coarse: &Axis, fine: &Axis, held: &Range<i64>) -> Range<i64> {
    taps(coarse, fine, held.start, Blend::Linear).0 - 1..taps(coarse, fine, held.end - 1, Blend::Linear).0 + 2
}

/// Heights of a rectangle of lattice points.
struct Patch {
    held: [Range<i64>; 2],
    values: Vec<f32>,
}

impl Patch {
    fn row(&self, y: i64) -> &[f32] {
        let width = (self.held[0].end - self.held[0].start) as usize;
        &self.values[(y - self.held[1].start) as usize * width..][..width]
    }
}

/// Looks fine points up in a coarse patch.
struct Refine<'a> {
    coarse: &'a Patch,
    columns: Vec<(usize, [f32; 3])>,
}

impl<'a> Refine<'a> {
    fn new(coarse: &'a Patch, from: &Axis, to: &Axis, held: &Range<i64>, blend: Blend) -> Self {
        let first = coarse.held[0].start;
        let columns = held.clone().map(|i| {
            let (nearest, weights) = taps(from, to, i, blend);
            ((nearest - 1 - first) as usize, weights)
        });
        Self { coarse, columns: columns.collect() }
    }

    /// The fine row whose taps along the other axis are given.
    fn row(&self, (nearest, w): (i64, [f32; 3]), scratch: &mut Vec<f32>, out: &mut [f32]) {
        let [a, b, c] = [-1, 0, 1].map(|k| self.coarse.row(nearest + k));
        scratch.clear();
        scratch.extend(a.iter().zip(b).zip(c).map(|((a, b), c)| w[0] * a + w[1] * b + w[2] * c));
        for (v, (at, w)) in out.iter_mut().zip(&self.columns) {
            if let [a, b, c] = scratch[*at..*at + 3] {
                *v = w[0] * a + w[1] * b + w[2] * c;
            }
        }
    }
}

/// Adds what is random to one row of a level.
fn shake(level: &Level, key: [u32; 2], random: Random, held: &Range<i64>, y: i64, out: &mut [f32]) {
    let on = |axis: &Axis, i: i64| axis.period.map_or(i, |n| i.rem_euclid(n)) as u32;
    let row = on(&level.lattice[1], y).wrapping_mul(ROW).wrapping_add(key[1]);
    for (i, v) in held.clone().zip(out) {
        let h = hash(on(&level.lattice[0], i).wrapping_mul(COLUMN).wrapping_add(key[0]), row);
        *v += level.range
            * match random {
                Random::Uniform => (h as i32 >> 8) as f32 * (1.0 / 8_388_608.0),
                Random::Bell => {
                    let other = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
                    let other = (other ^ (other >> 13)).wrapping_mul(0x297a_2d39);
                    let sum = (h >> 16) + (h & 0xffff) + (other >> 16) + (other & 0xffff);
                    // Four times the variance of a uniform number, 65536^2 / 12, is one third of 65536^2.
                    (sum as f32 - 131_070.0) * (1.732_050_8 / 65_536.0)
                }
            };
    }
}

/// The surface at the cells of the site's rows.
pub(super) fn surface(site: &Site<'_>, levels: &[Level], blend: Blend, random: Random) -> Result<Field> {
    let g = &site.grid;
    let cells = [g.cell_x_m, g.cell_y_m].map(|spacing_m| Axis { spacing_m, shift: 0.5, period: None });
    let wanted = [0..g.width as i64, site.rows.start as i64..site.rows.end as i64];
    // From the cells up: the points of each level that the next one needs.
    let mut held = vec![wanted.clone()];
    let mut fine = &cells;
    for level in levels.iter().rev() {
        let below = &held[held.len() - 1];
        held.push([0, 1].map(|a| needed(&level.lattice[a], &fine[a], &below[a])));
        fine = &level.lattice;
    }
    let mut before: Option<(Patch, &Lattice)> = None;
    for (l, (level, held)) in levels.iter().zip(held.iter().rev()).enumerate() {
        site.control.check()?;
        let key = mix64(mix64(site.seed) ^ l as u64);
        let key = [key as u32, (key >> 32) as u32];
        let width = (held[0].end - held[0].start) as usize;
        let mut values = vec![0.0; width * (held[1].end - held[1].start) as usize];
        let refine = before
            .as_ref()
            .map(|(patch, from)| (Refine::new(patch, &from[0], &level.lattice[0], &held[0], blend), &from[1]));
        values.par_chunks_mut(width).enumerate().for_each_init(Vec::new, |scratch, (i, out)| {
            let y = held[1].start + i as i64;
            if let Some((refine, from)) = &refine {
                refine.row(taps(from, &level.lattice[1], y, blend), scratch, out);
            }
            shake(level, key, random, &held[0], y, out);
        });
        before = Some((Patch { held: held.clone(), values }, &level.lattice));
    }
    let Some((patch, from)) = &before else { return Ok(Field::new(g.width, site.rows.len(), 0.0)) };
    let refine = Refine::new(patch, &from[0], &cells[0], &wanted[0], Blend::Spline);
    Field::from_rows(g.width, site.rows.clone(), site.control, |y, out| {
        refine.row(taps(&from[1], &cells[1], y as i64, Blend::Spline), &mut Vec::new(), out);
    })
}

/// Cell sizes along both axes, m.
pub(super) fn cells_m(grid: &Grid) -> [f64; 2] {
    [grid.cell_x_m, grid.cell_y_m]
}
