//! The way down from each cell; of several that are as good, `place.rs` chooses.

use super::Height;
use super::bands::{around, band_cells, three_rows};
use super::neighbours::Neighbours;
use super::place::Places;
use super::routing::Descent;
use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::LaneBlock;
use eyot_core::{Control, Grid, Result};
use rayon::prelude::*;

/// The direction of outlets.
pub(super) const NOWHERE: u8 = 8;
/// The direction of cells without a lower neighbour, until flats are resolved.
pub(super) const FLAT: u8 = 9;
/// Marks cells of which several ways are equally steep.
const TIED: u8 = 10;

/// The way down from each cell by `rule`: a direction, [`NOWHERE`] at outlets, [`FLAT`] where nothing is lower.
pub(super) fn descent<T: Height>(
    z: &[T],
    grid: &Grid,
    outlets: &[bool],
    rule: Descent,
    control: &Control<'_>,
) -> Result<Vec<u8>> {
    let (isa, w, ways) = (Isa::best(), grid.width, Ways::new(z, grid, rule));
    let mut direction = vec![0; z.len()];
    let cells = band_cells(grid);
    direction.par_chunks_mut(cells).enumerate().try_for_each(|(band, out)| {
        control.check()?;
        let mut lots = vec![0.0; if rule == Descent::Rho8 { w } else { 0 }];
        for (k, out) in out.chunks_exact_mut(w).enumerate() {
            let y = band * cells / w + k;
            lots.iter_mut().enumerate().for_each(|(x, l)| *l = ways.places.of(y * w + x).unit());
            if let Some(rows) = three_rows(z, grid, y) {
                let inner = &mut out[1..w - 1];
                match rule {
                    Descent::D8 => run_lanes(isa, Steepest { rows, per_m: ways.per_m, out: inner }),
                    Descent::Rho8 => {
                        let lots = &lots[1..w - 1];
                        run_lanes(isa, Rho8 { rows, per_m: ways.per_m, diagonal: ways.diagonal, lots, out: inner });
                    }
                }
                (out[0], out[w - 1]) = (TIED, TIED);
            } else {
                out.fill(TIED);
            }
            for (x, o) in out.iter_mut().enumerate().filter(|(_, o)| **o == TIED) {
                *o = ways.down(y * w + x);
            }
            out.iter_mut().zip(&outlets[y * w..]).for_each(|(d, &o)| *d = if o { NOWHERE } else { *d });
        }
        Ok(())
    })?;
    Ok(direction)
}

/// Ways down from single cells.
struct Ways<'a, T> {
    z: &'a [T],
    rule: Descent,
    near: Neighbours,
    places: Places,
    per_m: [f64; 8],
    diagonal: Diagonal,
}

/// How long a diagonal way counts for rho8, m: `a + lot b`.
#[derive(Clone, Copy)]
struct Diagonal {
    /// `a` and `b` where the steepest way beside it runs east or west.
    x: [f64; 2],
    /// The same where that runs north or south.
    y: [f64; 2],
}

impl<'a, T: Height> Ways<'a, T> {
    fn new(z: &'a [T], grid: &Grid, rule: Descent) -> Self {
        let near = Neighbours::new(grid);
        let [dx, dy] = [near.distance_m[2], near.distance_m[0]];
        let diagonal = Diagonal { x: [dx, dy * dy / dx], y: [dy, dx * dx / dy] };
        Self { z, rule, places: Places::new(grid), per_m: near.distance_m.map(|d| 1.0 / d), near, diagonal }
    }

    fn down(&self, i: usize) -> u8 {
        let mut fall = [0.0; 8];
        self.near.each(i, |d, j| fall[d] = self.z[i].to_f64() - self.z[j].to_f64());
        let slope: [f64; 8] = std::array::from_fn(|d| fall[d] * self.per_m[d]);
        let (_, ways) = match self.rule {
            Descent::D8 => best_of(&slope, 0xff),
            Descent::Rho8 => {
                let beside = best_of(&slope, 0b0101_0101);
                let x = beside.1 & 0b0100_0100 != 0;
                // Where both axes are as good, the one with the shorter cells.
                let both = beside.1 == 0 || (x && beside.1 & 0b0001_0001 != 0);
                let [a, b] = if both { self.diagonal.shorter() } else { self.diagonal.along(x) };
                let per_m = 1.0 / (a + self.places.of(i).unit() * b);
                let across = best_of(&fall.map(|f| f * per_m), 0b1010_1010);
                if across.0 > beside.0 { across } else { beside }
            }
        };
        if ways == 0 { FLAT } else { self.places.choose(i, ways, &self.near) as u8 }
    }
}

impl Diagonal {
    #[inline(always)]
    fn along(&self, x: bool) -> [f64; 2] {
        if x { self.x } else { self.y }
    }

    #[inline(always)]
    fn shorter(&self) -> [f64; 2] {
        self.along(self.x[0] < self.y[0])
    }
}

/// The largest of the positive slopes of some directions (one bit each), and those that have it.
fn best_of(slope: &[f64; 8], directions: u8) -> (f64, u8) {
    let (mut best, mut ways) = (0.0, 0);
    for d in (0..8).filter(|d| directions & (1 << d) != 0) {
        if slope[d] > best {
            (best, ways) = (slope[d], 0);
        }
        ways |= u8::from(slope[d] == best && best > 0.0) << d;
    }
    (best, ways)
}

/// The steepest descent from the inner cells of a row; [`TIED`] where several are equally steep.
struct Steepest<'a, T> {
    rows: [&'a [T]; 3],
    per_m: [f64; 8],
    out: &'a mut [u8],
}

impl<T: Height> LaneTask for Steepest<'_, T> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let n = self.out.len();
        let rows = self.rows.map(|r| &r[..n + 2]);
        for x in 0..n {
            let (z, others) = (rows[1][x + 1].to_f64(), around(rows, x));
            let mut best = Best::none();
            for k in 0..8 {
                best.try_way(k, (z - others[k].to_f64()) * self.per_m[k]);
            }
            self.out[x] = best.direction as u8;
        }
    }
}

/// The way down by rho8 from the inner cells of a row; [`TIED`] where several are as good.
struct Rho8<'a, T> {
    rows: [&'a [T]; 3],
    per_m: [f64; 8],
    diagonal: Diagonal,
    lots: &'a [f64],
    out: &'a mut [u8],
}

impl<T: Height> LaneTask for Rho8<'_, T> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let n = self.out.len();
        let (rows, lots) = (self.rows.map(|r| &r[..n + 2]), &self.lots[..n]);
        let [[ax, bx], [ay, by], [a, b]] = [self.diagonal.x, self.diagonal.y, self.diagonal.shorter()];
        for x in 0..n {
            let (z, others) = (rows[1][x + 1].to_f64(), around(rows, x));
            let mut beside = Best::none();
            for k in [0, 2, 4, 6] {
                beside.try_way(k, (z - others[k].to_f64()) * self.per_m[k]);
            }
            let east_west = (beside.direction == 2) | (beside.direction == 6);
            let flat = beside.direction == u64::from(FLAT);
            let (a, b) = if flat {
                (a, b)
            } else if east_west {
                (ax, bx)
            } else {
                (ay, by)
            };
            let per_m = 1.0 / (a + lots[x] * b);
            let mut across = Best::none();
            for k in [1, 3, 5, 7] {
                across.try_way(k, (z - others[k].to_f64()) * per_m);
            }
            let tied = beside.direction == u64::from(TIED);
            let direction = if (across.slope > beside.slope) & !tied { across.direction } else { beside.direction };
            self.out[x] = direction as u8;
        }
    }
}

/// The best way so far.
#[derive(Clone, Copy)]
struct Best {
    slope: f64,
    direction: u64,
}

impl Best {
    #[inline(always)]
    fn none() -> Self {
        Self { slope: 0.0, direction: u64::from(FLAT) }
    }

    #[inline(always)]
    fn try_way(&mut self, k: usize, slope: f64) {
        let (steeper, tied) = (slope > self.slope, (slope == self.slope) & (slope > 0.0));
        self.slope = if steeper { slope } else { self.slope };
        self.direction = if steeper { k as u64 } else { self.direction };
        self.direction = if tied { u64::from(TIED) } else { self.direction };
    }
}
