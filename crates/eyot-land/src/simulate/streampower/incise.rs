//! Rivers cut, and lay down a part of what they carry.
//!
//! # Equations
//! With `h*` the height after uplift, `w` that of the receiver, `c = K A^m T / L^n`, `g = G a / A` (`a` area of a cell) and `V`
//! what the cells upstream lose in the step, as metres of one cell:
//! 1. `h = h* + g / (1 + g) V - c / (1 + g) (h - w)^n`, which is `dh/dt = U - K A^m S^n + G Q / A`, implicit in all heights.
//!
//! Without deposition one way from the outlets upstream solves it. With it, `V` depends on all heights upstream: turns from the
//! outlets upstream with the `V` of the turn before (Gauss and Seidel), until no height changes any more.
//!
//! # Beds
//! Where the cut of (1) reaches below the bed at the surface, `b` thick and of erodibility `K_1`, the time for the bed and the time for
//! what is cut of the next one, of `K_2`, add up to the step:
//! 2. `b / K_1 + (h* - b - h) / K_2 = A^m T / L^n (h - w)^n`, which is (1) with `K_2` for ground that begins at `h* - b + b K_2 / K_1`.
//!
//! So a thin hard bed holds for as long as it should, however long the step; equal beds are one, and nothing is cut below its receiver.
//!
//! # Source
//! Braun and Willett 2013; Yuan, Braun, Guerit, Rouby and Cordonnier (2019), A new efficient method to solve the stream power
//! law model taking into account sediment deposition, Journal of Geophysical Research: Earth Surface 124, 1346-1365.
//!
//! # Conserves
//! A cell lays down less than what comes from upstream, whatever the number of turns.

use super::Streampower;
use super::law::Law;
use super::stack::Stack;
use eyot_core::math64::pow;
use eyot_core::{Control, Field, Grid, Result};
use eyot_drainage::Routing;
use rayon::prelude::*;

/// Changes below this end the turns, m.
const STILL_M: f64 = 1e-6;
/// Each turn divides the error by a few, more for small `G`.
const MAX_TURNS: usize = 200;

/// Sums over the grid, m.
pub(super) struct Cut {
    pub(super) incised: f64,
    pub(super) deposited: f64,
}

/// What rivers need to know, by position in the stack.
struct Rivers<'a> {
    stack: Stack,
    law: Law,
    /// What [`Law::left`] needs.
    prepared: Vec<f64>,
    sea_level_m: f64,
    rock: Option<Rock<'a>>,
}

/// What is known of the rock, as layers.
pub(super) struct Rock<'a> {
    /// Erodibility at the surface, over that of the whole.
    pub(super) here: &'a Field,
    /// How far down that goes, m, and erodibility below it; where it is known.
    pub(super) below: Option<(&'a Field, &'a Field)>,
}

impl Rock<'_> {
    /// Factor on K at the surface of a cell.
    fn factor(&self, i: usize) -> f64 {
        factor(self.here, i)
    }

    /// How far down the bed at the surface of a cell goes, m, and the erodibility of the next one over its own.
    fn bed(&self, i: usize) -> Option<(f64, f64)> {
        let (left, below) = self.below?;
        let left = f64::from(at(left, i)).max(0.0);
        Some((left, factor(below, i) / self.factor(i)))
    }
}

fn at(field: &Field, i: usize) -> f32 {
    field.get(i % field.width(), i / field.width())
}

fn factor(field: &Field, i: usize) -> f64 {
    f64::from(at(field, i).max(0.0))
}

impl Rivers<'_> {
    /// Heights after the step of ground that starts at `start`, of which what exceeds `lifted` is laid down; of lakes the surface.
    fn cut(&self, start: &mut [f64], lifted: Option<&[f64]>) {
        self.stack.climb(start, |p, z, base| match base {
            Some(base) if z > base => {
                let laid = lifted.map_or(0.0, |lifted| (z - lifted[p]).max(0.0));
                base + self.left(p, z - base, laid)
            }
            // Under the surface of a lake or the sea.
            Some(base) => base,
            None => z.max(self.sea_level_m),
        });
    }

    /// What is left of a drop of `d` metres, of which the upper `laid` metres were laid down in this step, m.
    fn left(&self, p: usize, d: f64, laid: f64) -> f64 {
        let left = d * self.law.left(self.prepared[p], d);
        let Some((bed, ratio)) = self.rock.as_ref().and_then(|rock| rock.bed(self.stack.cell[p] as usize)) else {
            return left;
        };
        let bed = bed + laid;
        if d - left <= bed {
            return left;
        }
        // (2) More than nothing is left above the receiver, since the cut of (1) ended above it and below the bed.
        let d = (d - bed) + bed * ratio;
        d * self.law.left(self.law.scaled(self.prepared[p], ratio), d)
    }

    /// Heights after the step of ground at `lifted`, of which each cell keeps `share` of what is cut upstream.
    fn cut_and_deposit(&self, lifted: &[f64], share: &[f64], control: &Control<'_>) -> Result<Vec<f64>> {
        let (mut ground, mut lost, mut level) = (lifted.to_vec(), vec![0.0; lifted.len()], lifted.to_vec());
        for _ in 0..MAX_TURNS {
            control.check()?;
            lost.par_iter_mut().zip(lifted).zip(&ground).for_each(|((lost, z), h)| *lost = z - h);
            self.stack.descend(&mut lost);
            // `lost` includes the cell itself; from here on it is where the ground starts.
            let cells = lost.par_iter_mut().zip(lifted).zip(&ground).zip(share);
            cells.for_each(|(((lost, z), h), share)| *lost = z + share * (*lost - (z - h)));
            level.copy_from_slice(&lost);
            self.cut(&mut level, Some(lifted));
            let cells = ground.par_iter_mut().zip(&level).zip(&lost);
            // The level lies above the ground where there is a lake.
            let turn =
                cells.map(|((h, &level), &start)| (level.min(start) - std::mem::replace(h, level.min(start))).abs());
            if turn.reduce(|| 0.0, f64::max) <= STILL_M {
                break;
            }
        }
        Ok(ground)
    }
}

impl Streampower {
    /// Lets the rivers cut and deposit, and returns the sums of both.
    pub(super) fn incise(
        &self,
        z: &mut [f64],
        grid: &Grid,
        routing: &Routing,
        sea_level_m: f64,
        rock: Option<Rock<'_>>,
        control: &Control<'_>,
    ) -> Result<Cut> {
        let (m, n) = (f64::from(self.area_exponent), f64::from(self.slope_exponent));
        let (law, stack) = (Law::new(n), Stack::new(routing, grid));
        let reach = f64::from(self.erodibility) * f64::from(self.years_per_step);
        let deposition = f64::from(self.deposition);

        // c = K A^m T / L^n, by number of cells for small areas and by direction for the distance.
        let cell_area = grid.cell_area_m2();
        let least = f64::from(self.channel_area);
        let power = |cells: u32| {
            let area = f64::from(cells) * cell_area;
            let power = if area < least { 0.0 } else { reach * pow(area, m) };
            power / (1.0 + deposition / f64::from(cells.max(1)))
        };
        let small: Vec<f64> = (0..1024).map(power).collect();
        let per_length = routing.steps_m().map(|l| if l > 0.0 { pow(l, -n) } else { 0.0 });
        let directions = routing.directions();
        let (mut level, mut prepared) = (vec![0.0; z.len()], vec![0.0; z.len()]);
        level.par_iter_mut().zip(&mut prepared).zip(&stack.cell).for_each(|((level, c), &i)| {
            let i = i as usize;
            let cells = stack.upstream[i];
            let a = small.get(cells as usize).copied().unwrap_or_else(|| power(cells));
            let k = rock.as_ref().map_or(1.0, |rock| rock.factor(i));
            *level = z[i];
            *c = law.prepared(a * k * per_length[usize::from(directions[i])]);
        });
        let rivers = Rivers { stack, law, prepared, sea_level_m, rock };
        if deposition > 0.0 {
            let kept = |&i: &u32| {
                let g = deposition / f64::from(rivers.stack.upstream[i as usize]);
                // What arrives at outlets leaves.
                if routing.is_outlet(i as usize) { 0.0 } else { g / (1.0 + g) }
            };
            let share: Vec<f64> = rivers.stack.cell.par_iter().map(kept).collect();
            level = rivers.cut_and_deposit(&level, &share, control)?;
        } else {
            rivers.cut(&mut level, None);
        }
        Ok(put_back(z, &level, &rivers.stack.position, grid.width, deposition > 0.0))
    }
}

/// Puts levels in stack order back into the grid. Only with deposition may the ground rise; else a higher level is a lake's.
fn put_back(z: &mut [f64], level: &[f64], position: &[u32], width: usize, may_rise: bool) -> Cut {
    let rows: Vec<Cut> = z
        .par_chunks_exact_mut(width)
        .zip(position.par_chunks_exact(width))
        .map(|(row, positions)| {
            let mut cut = Cut { incised: 0.0, deposited: 0.0 };
            for (z, &p) in row.iter_mut().zip(positions) {
                let new = if may_rise { level[p as usize] } else { level[p as usize].min(*z) };
                cut.incised += (*z - new).max(0.0);
                cut.deposited += (new - *z).max(0.0);
                *z = new;
            }
            cut
        })
        .collect();
    Cut { incised: rows.iter().map(|r| r.incised).sum(), deposited: rows.iter().map(|r| r.deposited).sum() }
}
