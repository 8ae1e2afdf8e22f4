//! Ice that flows: one time step of the shallow ice approximation with sliding.
//!
//! A step goes along the rows and then along the columns, or the other way round in every second step. Each is Newton's first step of
//! the implicit scheme on its axis: coefficients count the flux's dependence on the slope (three times the diffusion along the flow)
//! and on the ice upstream. What is solved for is the change of the thickness; the fluxes through faces follow, and no cell gives
//! more than it has and gets.

use crate::balance::Balance;
use crate::lines::{self, Faces};
use crate::padded::Padded;
use eyot_core::{BoundaryCondition, Grid};
use rayon::prelude::*;

/// Weight of a metre of ice over an area, Pa.
const WEIGHT: f64 = 910.0 * 9.81;
/// Thinner ice counts as this thick where thickness divides, m.
const THIN_M: f32 = 0.1;
/// Density of ice over that of the sea.
const FLOATS: f32 = 0.9;
/// Square of the slope beyond which ice flows no faster: it breaks and falls.
const STEEP: f32 = 0.25;
/// Turns in which cells that pass on what they get learn how much that is.
const LIMITING: usize = 3;

/// Ice on its bed.
pub struct Sheet {
    grid: Grid,
    /// Height of the bed, m.
    pub bed: Padded,
    /// Thickness of the ice, m.
    pub ice: Padded,
    /// Height of its surface, m.
    pub surface: Padded,
    /// Sliding over the cube of slope and of thickness, 1/(m2 a).
    pub slip: Padded,
    /// The part of what wants to leave a cell that it has.
    part: Padded,
    next: Padded,
    x: Axis,
    y: Axis,
    change: Vec<f32>,
    deform: f32,
    turn: bool,
}

/// Faces of one axis: flux of a step (m of the cells' thickness), and how it depends on either cell.
struct Axis {
    flux: Vec<f32>,
    forward: Vec<f32>,
    back: Vec<f32>,
    ring: bool,
}

impl Axis {
    fn new(faces: usize, edge: BoundaryCondition) -> Self {
        let zero = || vec![0.0; faces];
        Self { flux: zero(), forward: zero(), back: zero(), ring: edge == BoundaryCondition::Wrap }
    }

    fn faces(&self) -> Faces<'_> {
        Faces { forward: &self.forward, back: &self.back, ring: self.ring }
    }
}

/// What came and went in some steps, sums of thickness over cells, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Snow that became ice.
    pub snow: f64,
    /// Ice that melted.
    pub melted: f64,
    /// Ice that broke off into the sea.
    pub calved: f64,
    /// Ice that left over open rims.
    pub left: f64,
}

impl std::ops::AddAssign for Sums {
    fn add_assign(&mut self, other: Self) {
        self.snow += other.snow;
        self.melted += other.melted;
        self.calved += other.calved;
        self.left += other.left;
    }
}

/// What of a face's constants does not differ along a row.
#[derive(Clone, Copy)]
struct Face {
    /// One over the spacing across the face, and over four spacings along it, 1/m.
    across: f32,
    along: f32,
    /// Years over the spacing, a/m.
    rate: f32,
    deform: f32,
}

impl Face {
    /// Flux and its two coefficients. `s`, `h`, `slip`: surface, thickness and sliding before and after the face; `t`: differences of the
    /// surface along it, of both cells.
    #[inline(always)]
    fn flux(self, s: (f32, f32), t: f32, h: (f32, f32), slip: (f32, f32)) -> (f32, f32, f32) {
        let slope = (s.1 - s.0) * self.across;
        let aside = t * self.along;
        let square = (slope * slope + aside * aside).min(STEEP);
        let mean = 0.5 * (h.0 + h.1);
        let from = if slope < 0.0 { h.0 } else { h.1 };
        // Thick ice below does not make more flow from thin ice above.
        let moving = mean.min(2.0 * from);
        let diffusivity = (self.deform * mean + 0.5 * (slip.0 + slip.1)) * (mean * mean * mean) * square * moving;
        let flux = -(self.rate * diffusivity) * slope;
        let spread =
            self.rate * self.across * diffusivity * (1.0 + 2.0 * ((slope * slope) / (square + 1e-12)).min(1.0));
        let carry = flux.abs() * (2.5 / mean.max(THIN_M)).max(1.0 / from.max(THIN_M));
        let (ahead, behind) = if flux > 0.0 { (carry, 0.0) } else { (0.0, carry) };
        (flux, spread + ahead, spread + behind)
    }
}

/// The part of what wants to leave a cell that it has: `before` and `after` are those of the cells before and after it.
#[inline(always)]
fn share(f: f32, g: f32, ice: f32, before: f32, after: f32) -> f32 {
    let out = (-f).max(0.0) + g.max(0.0);
    let has = ice + (f.max(0.0) * before + (-g).max(0.0) * after);
    if out > has { has / out } else { 1.0 }
}

/// What goes through a face.
#[inline(always)]
fn moved(flux: f32, before: f32, after: f32) -> f32 {
    flux * if flux > 0.0 { before } else { after }
}

impl Sheet {
    /// `softness`: the flow law's rate factor A, Pa^-3 a^-1; `slip`: as [`Sheet::slip`].
    pub fn new(grid: &Grid, bed: Padded, ice: Padded, slip: Padded, softness: f64) -> Self {
        let (w, h) = (grid.width, grid.height);
        let mut sheet = Self {
            grid: *grid,
            surface: Padded::new(grid),
            part: Padded::new(grid),
            next: Padded::new(grid),
            x: Axis::new((w + 1) * h, grid.rim.x),
            y: Axis::new(w * (h + 1), grid.rim.y),
            change: vec![0.0; w * h],
            deform: (0.4 * softness * WEIGHT * WEIGHT * WEIGHT) as f32,
            turn: false,
            bed,
            ice,
            slip,
        };
        sheet.surface_of_ice();
        sheet
    }

    /// The rate of sliding for [`Sheet::slip`] from that of the sliding law, m/a and Pa^-3.
    pub fn slip_of(sliding: f64) -> f32 {
        (sliding * WEIGHT * WEIGHT * WEIGHT) as f32
    }

    /// Lets the ice flow and fall for `years`, then snow and melt. `repose`: the steepest slope that snow keeps, as a tangent.
    pub fn step(&mut self, years: f64, balance: &Balance, repose: f32, sea_level_m: f32) -> Sums {
        if self.turn {
            self.along_columns(years);
            self.along_rows(years);
        } else {
            self.along_rows(years);
            self.along_columns(years);
        }
        self.turn = !self.turn;
        let sums = self.weather(years as f32, balance, sea_level_m);
        self.surface_of_ice();
        self.avalanche(repose);
        sums
    }

    fn surface_of_ice(&mut self) {
        self.ice.ghosts(&self.grid);
        let (bed, ice) = (&self.bed.values, &self.ice.values);
        let p = self.surface.stride;
        self.surface.values.par_chunks_exact_mut(p).enumerate().for_each(|(y, row)| {
            let here = y * p..(y + 1) * p;
            row.iter_mut().zip(&bed[here.clone()]).zip(&ice[here]).for_each(|((s, b), i)| *s = b + i);
        });
    }

    /// Flux and coefficients of faces along one axis.
    fn face(&self, years: f64, across_m: f64, along_m: f64) -> Face {
        Face {
            across: (1.0 / across_m) as f32,
            along: (0.25 / along_m) as f32,
            rate: (years / across_m) as f32,
            deform: self.deform,
        }
    }

    /// Lets the ice flow along rows.
    fn along_rows(&mut self, years: f64) {
        let w = self.grid.width;
        let face = self.face(years, self.grid.cell_x_m, self.grid.cell_y_m);
        let (s, ice, slip, axis) = (&self.surface, &self.ice, &self.slip, &mut self.x);
        let ring = axis.ring;
        let rows = axis.flux.par_chunks_exact_mut(w + 1).zip(axis.forward.par_chunks_exact_mut(w + 1));
        let rows = rows.zip(axis.back.par_chunks_exact_mut(w + 1)).zip(self.change.par_chunks_exact_mut(w));
        rows.enumerate().for_each(|(y, (((flux, forward), back), change))| {
            let (a, b, c) = (s.framed(y), s.framed(y + 1), s.framed(y + 2));
            let (i, k) = (ice.framed(y + 1), slip.framed(y + 1));
            let out = flux.iter_mut().zip(forward.iter_mut()).zip(back.iter_mut());
            let pairs = b.windows(2).zip(a.windows(2)).zip(c.windows(2)).zip(i.windows(2)).zip(k.windows(2));
            for (((f, g), r), ((((b, a), c), i), k)) in out.zip(pairs) {
                let t = (c[0] - a[0]) + (c[1] - a[1]);
                (*f, *g, *r) = face.flux((b[0], b[1]), t, (i[0], i[1]), (k[0], k[1]));
            }
            if !ring {
                for end in [0, w] {
                    (flux[end], forward[end], back[end]) = (0.0, 0.0, 0.0);
                }
            }
            change.iter_mut().zip(flux.windows(2)).for_each(|(v, f)| *v = f[0] - f[1]);
        });
        lines::rows(&mut self.change, w, axis.faces());
        let (change, forward, back) = (&self.change, &axis.forward, &axis.back);
        axis.flux.par_chunks_exact_mut(w + 1).enumerate().for_each(|(r, flux)| {
            let (row, at) = (&change[r * w..(r + 1) * w], r * (w + 1));
            for i in 1..w {
                flux[i] += forward[at + i] * row[i - 1] - back[at + i] * row[i];
            }
            if ring {
                flux[0] += forward[at] * row[w - 1] - back[at] * row[0];
                flux[w] = flux[0];
            }
        });
        let flux = &self.x.flux;
        for turn in 0..LIMITING {
            let (grid, ice) = (&self.grid, &self.ice);
            let old = std::mem::take(&mut self.part);
            self.next.rows_mut().for_each(|(r, part)| {
                let (f, p) = (&flux[r * (w + 1)..(r + 1) * (w + 1)], old.framed(r + 1));
                for (i, (part, ice)) in part.iter_mut().zip(ice.row(r)).enumerate() {
                    let (before, after) = if turn > 0 { (p[i], p[i + 2]) } else { (0.0, 0.0) };
                    *part = share(f[i], f[i + 1], *ice, before, after);
                }
            });
            self.part = std::mem::replace(&mut self.next, old);
            self.part.ghosts(grid);
        }
        let part = &self.part;
        self.ice.rows_mut().for_each(|(r, row)| {
            let (f, p) = (&flux[r * (w + 1)..(r + 1) * (w + 1)], part.framed(r + 1));
            for (i, ice) in row.iter_mut().enumerate() {
                *ice = (*ice + (moved(f[i], p[i], p[i + 1]) - moved(f[i + 1], p[i + 1], p[i + 2]))).max(0.0);
            }
        });
        self.surface_of_ice();
    }

    /// Lets the ice flow along columns.
    fn along_columns(&mut self, years: f64) {
        let (w, h) = (self.grid.width, self.grid.height);
        let face = self.face(years, self.grid.cell_y_m, self.grid.cell_x_m);
        let (s, ice, slip, axis) = (&self.surface, &self.ice, &self.slip, &mut self.y);
        let ring = axis.ring;
        let rows = axis.flux.par_chunks_exact_mut(w).zip(axis.forward.par_chunks_exact_mut(w));
        rows.zip(axis.back.par_chunks_exact_mut(w)).enumerate().for_each(|(y, ((flux, forward), back))| {
            if !ring && (y == 0 || y == h) {
                return;
            }
            let (a, b) = (s.framed(y), s.framed(y + 1));
            let (i, j) = (&ice.framed(y)[1..], &ice.framed(y + 1)[1..]);
            let (k, l) = (&slip.framed(y)[1..], &slip.framed(y + 1)[1..]);
            let out = flux.iter_mut().zip(forward.iter_mut()).zip(back.iter_mut());
            let cells = a.windows(3).zip(b.windows(3)).zip(i.iter().zip(j)).zip(k.iter().zip(l));
            for (((f, g), r), (((a, b), (i, j)), (k, l))) in out.zip(cells) {
                let t = (a[2] - a[0]) + (b[2] - b[0]);
                (*f, *g, *r) = face.flux((a[1], b[1]), t, (*i, *j), (*k, *l));
            }
        });
        let flux = &axis.flux;
        self.change.par_chunks_exact_mut(w).enumerate().for_each(|(r, row)| {
            let (above, below) = (&flux[r * w..(r + 1) * w], &flux[(r + 1) * w..(r + 2) * w]);
            row.iter_mut().zip(above.iter().zip(below)).for_each(|(v, (a, b))| *v = a - b);
        });
        lines::columns(&mut self.change, w, axis.faces());
        let (change, forward, back) = (&self.change, &axis.forward, &axis.back);
        axis.flux.par_chunks_exact_mut(w).enumerate().for_each(|(r, flux)| {
            if (r == 0 || r == h) && !ring {
                return;
            }
            let (above, below) = ((r + h - 1) % h * w, r % h * w);
            for (i, f) in flux.iter_mut().enumerate() {
                *f += forward[r * w + i] * change[above + i] - back[r * w + i] * change[below + i];
            }
        });
        let flux = &self.y.flux;
        for turn in 0..LIMITING {
            let (grid, ice) = (&self.grid, &self.ice);
            let old = std::mem::take(&mut self.part);
            self.next.rows_mut().for_each(|(r, part)| {
                let (f, g) = (&flux[r * w..(r + 1) * w], &flux[(r + 1) * w..(r + 2) * w]);
                let (p, q) = (&old.framed(r)[1..], &old.framed(r + 2)[1..]);
                for (i, (part, ice)) in part.iter_mut().zip(ice.row(r)).enumerate() {
                    let (before, after) = if turn > 0 { (p[i], q[i]) } else { (0.0, 0.0) };
                    *part = share(f[i], g[i], *ice, before, after);
                }
            });
            self.part = std::mem::replace(&mut self.next, old);
            self.part.ghosts(grid);
        }
        let part = &self.part;
        self.ice.rows_mut().for_each(|(r, row)| {
            let (f, g) = (&flux[r * w..(r + 1) * w], &flux[(r + 1) * w..(r + 2) * w]);
            let (p, q, o) = (&part.framed(r)[1..], &part.framed(r + 1)[1..], &part.framed(r + 2)[1..]);
            for (i, ice) in row.iter_mut().enumerate() {
                *ice = (*ice + (moved(f[i], p[i], q[i]) - moved(g[i], q[i], o[i]))).max(0.0);
            }
        });
        self.surface_of_ice();
    }

    /// Snow and melting, the sea, and open rims.
    fn weather(&mut self, years: f32, balance: &Balance, sea_level_m: f32) -> Sums {
        let (w, h) = (self.grid.width, self.grid.height);
        let open = |edge: BoundaryCondition| edge == BoundaryCondition::Open;
        let (open_x, open_y) = (open(self.grid.rim.x), open(self.grid.rim.y));
        let bed = &self.bed;
        let rows = self.ice.rows_mut().map(|(y, row)| {
            let bed = bed.row(y);
            let mut sums = Sums::default();
            for (x, ice) in row.iter_mut().enumerate() {
                let change = years * balance.rate(y * w + x, bed[x] + *ice);
                let sea = sea_level_m - bed[x];
                let snow = if sea > 0.0 && *ice <= 0.0 { 0.0 } else { change.max(0.0) };
                let melted = (-change).max(0.0).min(*ice);
                let mut left = (*ice + snow) - melted;
                (sums.snow, sums.melted) = (sums.snow + f64::from(snow), sums.melted + f64::from(melted));
                if sea > 0.0 && FLOATS * left < sea {
                    sums.calved += f64::from(left);
                    left = 0.0;
                }
                if (open_x && (x == 0 || x + 1 == w)) || (open_y && (y == 0 || y + 1 == h)) {
                    sums.left += f64::from(left);
                    left = 0.0;
                }
                *ice = left;
            }
            sums
        });
        let mut all = Sums::default();
        rows.collect::<Vec<_>>().into_iter().for_each(|s| all += s);
        all
    }

    /// Snow and ice fall from slopes that are too steep for them.
    fn avalanche(&mut self, repose: f32) {
        let (dx, dy) = (self.grid.cell_x_m as f32, self.grid.cell_y_m as f32);
        let keep = [repose * dx, repose * dy, repose * (dx * dx + dy * dy).sqrt()];
        let (ice, surface) = (&self.ice, &self.surface);
        let mut next = std::mem::take(&mut self.next);
        let (w, h, ring) = (self.grid.width, self.grid.height, (self.x.ring, self.y.ring));
        next.rows_mut().for_each(|(r, row)| {
            let s = [surface.framed(r), surface.framed(r + 1), surface.framed(r + 2)];
            let i = [ice.framed(r), ice.framed(r + 1), ice.framed(r + 2)];
            for (x, out) in row.iter_mut().enumerate() {
                let (here, has) = (s[1][x + 1], i[1][x + 1]);
                // Positive if it falls to this cell.
                let fall = |row: usize, column: usize, keep: f32| {
                    let (there, its) = (s[row][x + column], i[row][x + column]);
                    let comes = (0.1 * (there - here - keep)).max(0.0).min(0.125 * its);
                    let goes = (0.1 * (here - there - keep)).max(0.0).min(0.125 * has);
                    comes - goes
                };
                // Nothing falls over a rim that is no ring.
                let west = f32::from(u8::from(ring.0 || x > 0));
                let east = f32::from(u8::from(ring.0 || x + 1 < w));
                let north = f32::from(u8::from(ring.1 || r > 0));
                let south = f32::from(u8::from(ring.1 || r + 1 < h));
                let sides = (west * fall(1, 0, keep[0]) + east * fall(1, 2, keep[0]))
                    + (north * fall(0, 1, keep[1]) + south * fall(2, 1, keep[1]));
                let corners = (north * west * fall(0, 0, keep[2]) + south * east * fall(2, 2, keep[2]))
                    + (north * east * fall(0, 2, keep[2]) + south * west * fall(2, 0, keep[2]));
                *out = (has + (sides + corners)).max(0.0);
            }
        });
        self.next = std::mem::replace(&mut self.ice, next);
        self.surface_of_ice();
    }
}
