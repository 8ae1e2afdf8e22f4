//! Poisson faulting: the land is cut along random lines, and one side rises.
//!
//! # Equations
//! 1. `h = offset + sum_i g_i s(phi_i)`, with Gaussian jumps `g_i` of deviation `amplitude / sqrt(faults)` and
//!    `phi_i` the distance from the i-th line; `s` is -1 on one side, 1 on the other and rises smoothly within `width` around it.
//!
//! Lines have all directions and all distances from the middle of the land alike. The limit of many faults is Brownian: mean
//! squared differences of heights grow in proportion to the distance, `H = 1/2`.
//!
//! # Source
//! Mandelbrot 1975; Voss 1985.
//!
//! # Wrapping rims
//! A line that closes on a torus has no sides, two of them have: there `phi` counts the turns around the torus along a direction
//! `(p, q)` of small whole numbers, and `s` is 1 for a share of each turn, -1 for the rest, less its mean.
//!
//! # Speed
//! A row meets a line in one place, so a row costs the sum of cells and lines and not their product.

use super::check;
use eyot_core::math::{cos, ln, sin};
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::real::Bits;
use eyot_core::rng::{Key, hash, unit};
use eyot_core::{BoundaryCondition, Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Poisson faulting: blocks of land along straight fault lines.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Faulting {
    /// Number of fault lines. With few each scarp is seen, thousands make mountains.
    #[schemars(range(min = 1, max = 100_000), extend("unit" = "1"))]
    pub faults: u32,
    /// Distance over which the land rises at a fault, as a share of the grid's longer side. 0 makes cliffs.
    #[schemars(range(min = 0.0, max = 0.25), extend("unit" = "1"))]
    pub width: f32,
    /// Standard deviation of the heights.
    #[schemars(range(min = 0.0, max = 12000.0), extend("unit" = "m"))]
    pub amplitude: f32,
    /// Added to the heights.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub offset: f32,
}

impl Default for Faulting {
    fn default() -> Self {
        Self { faults: 1000, width: 0.01, amplitude: 500.0, offset: 0.0 }
    }
}

/// One line, or on a wrapping rim two.
struct Fault {
    /// phi = x across[0] + y across[1] + shift, with x and y in metres.
    across: [f64; 2],
    shift: f64,
    /// Half of the zone in which the land rises, in units of phi.
    half: f64,
    /// Share of a turn that is raised, where phi counts turns.
    share: Option<f64>,
    jump: f64,
}

/// Half of the zone of a line without one: as good as nothing, and no division by zero.
const SHARP: f64 = 1e-9;

/// From -1 to 1 while t does.
fn scarp(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    0.5 * t * (3.0 - t * t)
}

impl Fault {
    /// s: -1 to 1.
    fn side(&self, phi: f64) -> f64 {
        let half = self.half.max(SHARP);
        let Some(share) = self.share else { return scarp(phi / half) };
        let turn = phi - phi.floor();
        let (up, down) = (if turn < 0.5 { turn } else { turn - 1.0 }, turn - share);
        if up.abs() < down.abs() { scarp(up / half) } else { -scarp(down / half) }
    }

    /// Adds the row at `y_m` to `sum`, whose cells are differences to the cell before, and to `zone`, whose cells are heights.
    fn row(&self, g: &Grid, y_m: f64, sum: &mut [f64], zone: &mut [f64]) {
        let width = zone.len();
        let step = self.across[0] * g.cell_x_m;
        let first = 0.5 * step + self.across[1] * y_m + self.shift;
        let last = first + step * (width - 1) as f64;
        // On average nothing is raised.
        let mean = self.share.map_or(0.0, |s| 2.0 * s - 1.0);
        sum[0] -= self.jump * mean;
        if (last - first).abs() < 1e-9 * self.half.max(1e-3) {
            sum[0] += self.jump * self.side(first);
            return;
        }
        // The lines that the row meets, and whether s rises with phi there; from west to east.
        let (low, high) = (first.min(last) - self.half, first.max(last) + self.half);
        let mut lines = match self.share {
            None => vec![(0.0, true)],
            Some(share) => (low.floor() as i64 - 1..=high.ceil() as i64 + 1)
                .flat_map(|turn| [(turn as f64, true), (turn as f64 + share, false)])
                .collect(),
        };
        lines.retain(|(phi, _)| (low..=high).contains(phi));
        if step < 0.0 {
            lines.reverse();
        }
        // Before the first line the row lies on the other side of it.
        let east = |rises: bool| if rises == (step > 0.0) { self.jump } else { -self.jump };
        sum[0] += lines.first().map_or_else(|| self.jump * self.side(first), |&(_, rises)| -east(rises));
        let (half, reach) = (self.half.max(SHARP), self.half / step.abs());
        for (phi, rises) in lines {
            let x = (phi - first) / step;
            let from = (x - reach).ceil().clamp(0.0, width as f64) as usize;
            let to = ((x + reach).floor() + 1.0).clamp(from as f64, width as f64) as usize;
            sum[from] += east(rises);
            sum[to] += east(rises);
            // The zones of two lines never meet, so within one the height is a cubic of the distance from this line.
            let (start, pace) = ((first + step * from as f64 - phi) / half, step / half);
            let rise = if rises { self.jump } else { -self.jump };
            for (x, v) in zone[from..to].iter_mut().enumerate() {
                *v += rise * scarp(start + pace * x as f64);
            }
        }
    }
}

/// Directions in which a line closes on a torus after few turns.
fn turns() -> impl Iterator<Item = (i32, i32)> {
    let divisible = |a: i32, b: i32| (2..=3).any(|d| a % d == 0 && b % d == 0);
    (0..=3)
        .flat_map(|p| (-3..=3).map(move |q| (p, q)))
        .filter(move |&(p, q)| (p > 0 || q > 0) && p * p + q * q <= 13 && !divisible(p, q))
}

impl Faulting {
    fn list(&self, g: &Grid, seed: u64) -> Vec<Fault> {
        let (w, h) = g.extent_m();
        let width_m = f64::from(self.width) * w.max(h);
        let deviation = f64::from(self.amplitude) / f64::from(self.faults).sqrt();
        let line = |i: u32| {
            let random = |stream: u32| f64::from(unit::<f32>(hash(Key::new(seed, stream, 0), u32::of(i))));
            let turn = std::f32::consts::TAU * random(0) as f32;
            let (c, s) = (f64::from(cos(turn)), f64::from(sin(turn)));
            // Box and Muller; 1 - u is never 0.
            let length = (-2.0 * ln(1.0 - random(1) as f32)).sqrt();
            let jump = deviation * f64::from(length * cos(std::f32::consts::TAU * random(2) as f32));
            let place = random(3);
            let share = 0.3 + 0.4 * random(4);
            let (across, shift, periodic) =
                match (g.rim.x == BoundaryCondition::Wrap, g.rim.y == BoundaryCondition::Wrap) {
                    (false, false) => {
                        // Lines that hit the circle around the land.
                        let away = (place - 0.5) * (w * w + h * h).sqrt();
                        ([c, s], -(0.5 * w * c + 0.5 * h * s) - away, false)
                    }
                    (true, true) => {
                        let (mut best, mut direction) = (-1.0, (1, 0));
                        for (p, q) in turns() {
                            let (x, y) = (f64::from(p) / w, f64::from(q) / h);
                            let along = ((x * c + y * s) / (x * x + y * y).sqrt()).abs();
                            if along > best {
                                (best, direction) = (along, (p, q));
                            }
                        }
                        ([f64::from(direction.0) / w, f64::from(direction.1) / h], place, true)
                    }
                    (wrap_x, _) => {
                        // About one and a half turns along the longer side; whole ones around the ring.
                        let dense = 1.5 / w.max(h);
                        let (ring, c, s) = if wrap_x { (w, c, s) } else { (h, s, c) };
                        let around = (dense * ring * c).round();
                        let free = dense * if around == 0.0 { 1f64.copysign(s) } else { s };
                        (if wrap_x { [around / ring, free] } else { [free, around / ring] }, place, true)
                    }
                };
            let per_metre = (across[0] * across[0] + across[1] * across[1]).sqrt();
            let half = 0.5 * width_m * per_metre;
            // Zones of neighbouring lines must not overlap.
            let half = if periodic { half.min(0.14) } else { half };
            Fault { across, shift, half, share: periodic.then_some(share), jump }
        };
        (0..self.faults).map(line).collect()
    }
}

impl Generator for Faulting {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let g = site.grid;
        let faults = self.list(&g, site.seed);
        Field::from_rows(g.width, site.rows.clone(), site.control, |y, row| {
            let y_m = (y as f64 + 0.5) * g.cell_y_m;
            let (mut sum, mut zone) = (vec![0.0; g.width + 1], vec![0.0; g.width]);
            faults.iter().for_each(|f| f.row(&g, y_m, &mut sum, &mut zone));
            let mut height = f64::from(self.offset);
            for ((v, rise), zone) in row.iter_mut().zip(&sum).zip(&zone) {
                height += rise;
                *v = (height + zone) as f32;
            }
        })
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("faulting", self)
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
