//! Domain warp: every place gets the value of another place nearby (filter).
//!
//! # Equations
//! 1. `h'(p) = h(p + strength * scale * (u(p), v(p)))` with two noises `u` and `v` within -1..=1; octaves as for `fbm`.
//!
//! Between the cells the layer is interpolated: linear (stays within the layer's range, but creases at cell borders when the
//! warp stretches the land), or cubic after Catmull and Rom (smooth; may overshoot beside a cliff by an eighth of its height).
//! Beyond a closed or open rim the border cell goes on; a wrapping rim is a ring.
//!
//! # Source
//! Distorted lookups as in Ebert et al. 2003.
//!
//! # Layers
//! Reads the layer that it changes; uses the seed of its step.

use super::fractal::Octaves;
use super::noise::{PIECE, PIECE_COLUMNS, Piece, Sum};
use super::{check, scale_m};
use eyot_core::isa::Isa;
use eyot_core::lanes::WIDTH;
use eyot_core::process::{Around, Generator, Reach, Site};
use eyot_core::{BoundaryCondition, Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a layer is read between its cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Interpolation {
    /// From the nearest 2x2 cells.
    Linear,
    /// From the nearest 4x4 cells (Catmull-Rom).
    #[default]
    Cubic,
}

/// Bends the land: every place gets the value of another place nearby.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Warp {
    /// Largest displacement, in feature sizes. Above 1 the land is torn to shreds.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    pub strength: f32,
    /// The noise that displaces.
    #[serde(flatten)]
    pub noise: Octaves,
    /// How the layer is read between its cells.
    pub interpolation: Interpolation,
}

impl Default for Warp {
    fn default() -> Self {
        let noise = Octaves { octaves: 3, ..Octaves::default() };
        Self { strength: 0.3, noise, interpolation: Interpolation::Cubic }
    }
}

/// The cell before the place `cell + away` and the fraction after it.
fn split(cell: usize, away: f32, cells: usize, edge: BoundaryCondition) -> (isize, f32) {
    let whole = away.floor();
    let at = cell as isize + whole as isize;
    // Beyond a wall everything is the border cell's value, so the place is brought back to it.
    if edge != BoundaryCondition::Wrap && at < 0 {
        (0, 0.0)
    } else if edge != BoundaryCondition::Wrap && at >= cells as isize - 1 {
        (cells as isize - 1, 0.0)
    } else {
        (at, away - whole)
    }
}

fn linear(base: &Around<'_>, g: &Grid, x: (isize, f32), y: (isize, f32)) -> f32 {
    let columns = [0, 1].map(|i| g.wrap_x(x.0 + i));
    let [a, b] = [0, 1].map(|j| {
        let row = base.row(g.wrap_y(y.0 + j));
        let [a, b] = columns.map(|c| row[c]);
        a + x.1 * (b - a)
    });
    a + y.1 * (b - a)
}

/// Catmull-Rom through b and c, with a and d for the slopes.
fn spline([a, b, c, d]: [f32; 4], t: f32) -> f32 {
    b + 0.5 * t * ((c - a) + t * ((2.0 * a - 5.0 * b + 4.0 * c - d) + t * (3.0 * (b - c) + d - a)))
}

fn cubic(base: &Around<'_>, g: &Grid, x: (isize, f32), y: (isize, f32)) -> f32 {
    let columns = [-1, 0, 1, 2].map(|i| g.wrap_x(x.0 + i));
    let lines = [-1, 0, 1, 2].map(|j| {
        let row = base.row(g.wrap_y(y.0 + j));
        spline(columns.map(|c| row[c]), x.1)
    });
    spline(lines, y.1)
}

impl Generator for Warp {
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let g = site.grid;
        let noise = self.noise.noise(Sum::Fbm, &g, site.seed);
        let strength_m = f64::from(self.strength) * noise.scale_m;
        let away = noise.displacement(self.noise.octaves).map(|n| n.prepare(&g, Isa::best()));
        let (per_x, per_y) = ((strength_m / g.cell_x_m) as f32, (strength_m / g.cell_y_m) as f32);
        let base = Around::new(site, self.reach(&g), base)?;
        Field::from_rows(g.width, site.rows.clone(), site.control, |y, row| {
            for (x0, piece) in (0..).step_by(PIECE_COLUMNS).zip(row.chunks_mut(PIECE_COLUMNS)) {
                let mut shift: [Piece; 2] = [[[0.0; WIDTH]; PIECE]; 2];
                for (noise, shift) in away.iter().zip(&mut shift) {
                    noise.piece(x0, y, piece.len().div_ceil(WIDTH), None, shift);
                }
                let [dx, dy] = shift.each_ref().map(|s| s.as_flattened());
                for (i, v) in piece.iter_mut().enumerate() {
                    let x = split(x0 + i, dx[i] * per_x, g.width, g.rim.x);
                    let y = split(y, dy[i] * per_y, g.height, g.rim.y);
                    *v = match self.interpolation {
                        Interpolation::Linear => linear(&base, &g, x, y),
                        Interpolation::Cubic => cubic(&base, &g, x, y),
                    };
                }
            }
        })
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("warp", self)
    }

    fn reach(&self, grid: &Grid) -> Reach {
        // The displacement stays within -1..=1 times the strength; two rows more for the interpolation.
        let strength_m = f64::from(self.strength) * scale_m(grid, self.noise.scale, self.noise.scale_m);
        Reach::Rows((strength_m / grid.cell_y_m).ceil() as usize + 2)
    }

    fn is_filter(&self) -> bool {
        true
    }
}
