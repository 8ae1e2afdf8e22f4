//! What must be known of a streamed world before its files are written: ranges, fingerprint, and an overview.

use super::OVERVIEW;
use super::world::{StreamedLayer, StreamedWorld};
use eyot_core::{Field, Fingerprint, Grid, Result, World};
use eyot_io::Rows;
use eyot_recipe::Recipe;
use rayon::prelude::*;

/// Bytes of rows that are looked at together, about.
const BAND_BYTES: usize = 16 << 20;

/// The findings.
pub(crate) struct Survey {
    /// The world in coarser cells, each the mean over a square; the world itself if it is small enough.
    pub(crate) overview: World,
    /// As [`World::fingerprint`] of the whole world.
    pub(crate) fingerprint: u64,
}

/// The grid of the overview, and how many cells along each side make one of it.
pub(super) fn coarse(grid: &Grid) -> (usize, Grid) {
    let cells = grid.width.max(grid.height).div_ceil(OVERVIEW);
    let coarse = Grid {
        width: grid.width.div_ceil(cells),
        height: grid.height.div_ceil(cells),
        cell_x_m: grid.cell_x_m * cells as f64,
        cell_y_m: grid.cell_y_m * cells as f64,
        rim: grid.rim,
    };
    (cells, coarse)
}

/// Goes once through each layer. Also returns their smallest and largest values.
pub(super) fn survey(
    world: &StreamedWorld<'_>,
    layers: &[StreamedLayer],
    recipe: &Recipe,
) -> Result<(Survey, Vec<(f32, f32)>)> {
    let grid = recipe.grid;
    let (cells, coarse) = coarse(&grid);
    let mut overview = World::new(coarse, recipe.seed);
    overview.sea_level_m = recipe.sea_level_m;
    let size = (coarse.width * cells, coarse.height * cells);
    overview.georeference = recipe.georeference.as_ref().map(|g| g.rescaled(size, (coarse.width, coarse.height)));
    let mut fingerprint = Fingerprint::new(&grid, 0, recipe.sea_level_m);
    let mut ranges = Vec::new();
    for layer in layers {
        fingerprint.begin(&layer.spec.name);
        let mut means = Means::new(cells, &grid);
        let mut range = (f32::INFINITY, f32::NEG_INFINITY);
        each_band(&mut world.rows(layer.stage), |band| {
            let look = || {
                range = wider(range, range_of(band, grid.width));
                means.add(band, grid.width);
            };
            rayon::join(|| fingerprint.values(band), look);
        })?;
        overview.put(&layer.spec, means.field)?;
        ranges.push(range);
    }
    Ok((Survey { overview, fingerprint: fingerprint.value() }, ranges))
}

/// Smallest and largest value.
pub(super) fn range(rows: &mut dyn Rows) -> Result<(f32, f32)> {
    let mut range = (f32::INFINITY, f32::NEG_INFINITY);
    let width = rows.size().0;
    each_band(rows, |band| range = wider(range, range_of(band, width)))?;
    Ok(range)
}

fn each_band(rows: &mut dyn Rows, mut take: impl FnMut(&[f32])) -> Result<()> {
    let (width, height) = rows.size();
    let per_band = (BAND_BYTES / 4 / width).clamp(1, height);
    let mut band = vec![0.0; width * per_band];
    for first in (0..height).step_by(per_band) {
        let values = &mut band[..width * per_band.min(height - first)];
        rows.read(first, values)?;
        take(values);
    }
    Ok(())
}

fn wider(a: (f32, f32), b: (f32, f32)) -> (f32, f32) {
    (a.0.min(b.0), a.1.max(b.1))
}

fn range_of(band: &[f32], width: usize) -> (f32, f32) {
    let of_row = |row: &[f32]| row.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |r, &v| wider(r, (v, v)));
    band.par_chunks(width).map(of_row).reduce(|| (f32::INFINITY, f32::NEG_INFINITY), wider)
}

/// Means over squares of cells, row by row.
struct Means {
    cells: usize,
    /// Sums of the squares under way.
    sums: Vec<f64>,
    /// Rows in them.
    rows: usize,
    /// Rows of the grid that are still to come.
    left: usize,
    /// Row of the field that the squares under way will be.
    at: usize,
    field: Field,
}

impl Means {
    fn new(cells: usize, grid: &Grid) -> Self {
        let field = Field::new(grid.width.div_ceil(cells), grid.height.div_ceil(cells), 0.0);
        Self { cells, sums: vec![0.0; field.width()], rows: 0, left: grid.height, at: 0, field }
    }

    fn add(&mut self, band: &[f32], width: usize) {
        let sums_of = |row: &[f32]| -> Vec<f64> {
            row.chunks(self.cells).map(|c| c.iter().map(|&v| f64::from(v)).sum()).collect()
        };
        let rows: Vec<Vec<f64>> = band.par_chunks(width).map(sums_of).collect();
        for row in rows {
            self.sums.iter_mut().zip(row).for_each(|(sum, more)| *sum += more);
            self.rows += 1;
            self.left -= 1;
            if self.rows == self.cells || self.left == 0 {
                self.finish_row(width);
            }
        }
    }

    fn finish_row(&mut self, width: usize) {
        let (cells, rows) = (self.cells, self.rows);
        for (x, (mean, sum)) in self.field.row_mut(self.at).iter_mut().zip(&mut self.sums).enumerate() {
            let count = cells.min(width - x * cells) * rows;
            *mean = (*sum / count as f64) as f32;
            *sum = 0.0;
        }
        self.rows = 0;
        self.at += 1;
    }
}
