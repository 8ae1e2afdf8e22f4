//! Circle algorithm: round hills are heaped on each other, few large ones and then many small ones.
//!
//! # Equations
//! `d` distance from a disc's centre, `R_0` radius of the largest discs, in metres.
//! 1. `h = offset + sum_l f_l (cos(pi d / R_l) + 1)` over all discs nearer than `R_l`.
//! 2. `R_l = R_0 2^-l`, `f_l = gain^l height / 2`.
//!
//! Each level strews as many discs as cover a place `cover` times on average, so their number grows fourfold from level to level.
//!
//! # Source
//! A common algorithm without a known author.
//!
//! # Scale
//! Radii are shares of the extent. Of levels whose discs are no larger than two cells only the mean remains, `cover f_l (1 - 4 / pi^2)`.

use super::{check, scale_m};
use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::{LaneBlock, WIDTH};
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::rng::{Key, hash, unit};
use eyot_core::{BoundaryCondition, Error, Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Round hills of all sizes heaped on each other.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Circles {
    /// Sizes of discs, each half as large as the one before.
    #[schemars(range(min = 1, max = 16), extend("unit" = "1"))]
    pub sizes: u32,
    /// Radius of the largest discs as a share of the grid's longer side.
    #[schemars(range(min = 0.0001, max = 1.0), extend("unit" = "1"))]
    pub radius: f32,
    /// Radius of the largest discs in metres. 0 takes `radius` instead.
    #[schemars(range(min = 0.0, max = 1e7), extend("unit" = "m"))]
    pub radius_m: f32,
    /// How many discs of a size cover a place on average.
    #[schemars(range(min = 0.01, max = 64.0), extend("unit" = "1"))]
    pub cover: f32,
    /// Height of a disc relative to one twice as large.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub gain: f32,
    /// Height of one of the largest discs, in its middle.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub height: f32,
    /// Height of the ground between the discs.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub offset: f32,
}

impl Default for Circles {
    fn default() -> Self {
        Self { sizes: 8, radius: 0.2, radius_m: 0.0, cover: 2.5, gain: 0.5, height: 400.0, offset: 0.0 }
    }
}

/// cos(pi sqrt(q)) + 1 as a polynomial of q within 0..=1: its Taylor series, good to 2e-7.
const BUMP: [f32; 10] = [
    2.0,
    -4.934_802,
    4.058_712,
    -1.335_262_8,
    0.235_330_63,
    -0.025_806_89,
    0.001_929_574_3,
    -0.000_104_638_1,
    4.303_07e-6,
    -1.387_895e-7,
];

/// Mean of cos(pi d) + 1 over a disc: 1 - 4 / pi^2.
const MEAN: f32 = 0.594_715_3;

/// The part of a disc that lies in a row.
struct Span<'a> {
    cells: &'a mut [f32],
    /// Distance of the first cell from the middle, in radii, east positive; and from cell to cell.
    first: f32,
    step: f32,
    /// Square of the row's distance from the middle, in radii.
    dy2: f32,
    height: f32,
}

impl LaneTask for Span<'_> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let mut start = self.first;
        for cells in self.cells.chunks_mut(WIDTH) {
            let dx = L::of(start) + L::index() * L::of(self.step);
            // Beyond the disc, where the polynomial would go on, it stays at its end.
            let q = (dx * dx + L::of(self.dy2)).min(L::of(1.0));
            let mut bump = L::of(BUMP[9]);
            for c in BUMP[..9].iter().rev() {
                bump = bump * q + L::of(*c);
            }
            let bump = (bump.positive() * L::of(self.height)).to_array();
            cells.iter_mut().zip(bump).for_each(|(v, b)| *v += b);
            start += self.step * WIDTH as f32;
        }
    }
}

/// Discs of one size, strewn over squares about as large as their radius.
struct Size {
    radius_m: f64,
    height: f32,
    /// Sides of a square, m, and how many there are before a wrapping axis is round.
    side_m: [f64; 2],
    around: [Option<i64>; 2],
    /// Places for discs in a square, and the chance that there is one.
    places: u32,
    chance: f32,
    keys: [Key; 3],
}

impl Size {
    fn new(g: &Grid, radius_m: f64, height: f32, cover: f32, seed: u64, level: u64) -> Self {
        let extent: [f64; 2] = g.extent_m().into();
        let edges = [g.rim.x, g.rim.y];
        let around =
            [0, 1].map(|a| (edges[a] == BoundaryCondition::Wrap).then(|| (extent[a] / radius_m).round().max(1.0)));
        let side_m = [0, 1].map(|a| around[a].map_or(radius_m, |n| extent[a] / n));
        let discs = f64::from(cover) * side_m[0] * side_m[1] / (std::f64::consts::PI * radius_m * radius_m);
        let places = discs.ceil().max(1.0);
        Self {
            radius_m,
            height: 0.5 * height,
            side_m,
            around: around.map(|a| a.map(|n| n as i64)),
            places: places as u32,
            chance: (discs / places) as f32,
            keys: [0, 1, 2].map(|stream| Key::new(seed, stream, level)),
        }
    }

    /// Squares along an axis whose discs may reach from `low_m` to `high_m`.
    fn squares(&self, axis: usize, low_m: f64, high_m: f64) -> std::ops::RangeInclusive<i64> {
        let number = |m: f64| (m / self.side_m[axis]).floor() as i64;
        number(low_m - self.radius_m)..=number(high_m + self.radius_m)
    }

    /// Adds the discs to the row at `y_m`.
    fn row(&self, g: &Grid, y_m: f64, isa: Isa, row: &mut [f32]) {
        let on = |axis: usize, i: i64| self.around[axis].map_or(i, |n| i.rem_euclid(n)) as u32;
        for j in self.squares(1, y_m, y_m) {
            for i in self.squares(0, 0.0, g.extent_m().0) {
                let square = on(0, i).wrapping_mul(0x9e37_79b1) ^ on(1, j).wrapping_mul(0x85eb_ca77).rotate_left(13);
                for place in 0..self.places {
                    let random = |k: usize| unit::<f32>(hash(self.keys[k], square.wrapping_add(place * 0x27d4_eb2f)));
                    if random(2) >= self.chance {
                        continue;
                    }
                    let dy = y_m - (j as f64 + f64::from(random(1))) * self.side_m[1];
                    let half = self.radius_m * self.radius_m - dy * dy;
                    if half <= 0.0 {
                        continue;
                    }
                    let (half, middle) = (half.sqrt(), (i as f64 + f64::from(random(0))) * self.side_m[0]);
                    let cell = |m: f64| (m / g.cell_x_m - 0.5).ceil().clamp(0.0, row.len() as f64) as usize;
                    let (from, to) = (cell(middle - half), cell(middle + half));
                    if from < to {
                        let first = (from as f64 + 0.5) * g.cell_x_m - middle;
                        let span = Span {
                            cells: &mut row[from..to],
                            first: (first / self.radius_m) as f32,
                            step: (g.cell_x_m / self.radius_m) as f32,
                            dy2: (dy * dy / (self.radius_m * self.radius_m)) as f32,
                            height: self.height,
                        };
                        run_lanes(isa, span);
                    }
                }
            }
        }
    }
}

impl Generator for Circles {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let g = site.grid;
        let (mut radius_m, mut height) = (scale_m(&g, self.radius, self.radius_m), self.height);
        let (mut sizes, mut ground) = (Vec::new(), self.offset);
        for level in 0..self.sizes {
            if radius_m > 2.0 * g.cell_x_m.max(g.cell_y_m) {
                sizes.push(Size::new(&g, radius_m, height, self.cover, site.seed, u64::from(level)));
            } else {
                ground += self.cover * 0.5 * height * MEAN;
            }
            radius_m *= 0.5;
            height *= self.gain;
        }
        let isa = Isa::best();
        Field::from_rows(g.width, site.rows.clone(), site.control, |y, row| {
            row.fill(ground);
            let y_m = (y as f64 + 0.5) * g.cell_y_m;
            sizes.iter().for_each(|s| s.row(&g, y_m, isa, row));
        })
    }

    fn check(&self, grid: &Grid) -> Result<()> {
        check("circles", self)?;
        // Work grows with the square of the radius, as every disc that reaches the land counts, on a ring many times over.
        let (w, h) = grid.extent_m();
        let most = 4.0 * w.max(h);
        if f64::from(self.radius_m) > most {
            return Err(Error::BadParameter {
                owner: "circles".into(),
                field: "radius_m".into(),
                reason: format!(
                    "{} m is more than four times the longer side of the land; choose at most {most} m",
                    self.radius_m
                ),
            });
        }
        Ok(())
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
