//! Turf: a film of small algae on the ground, cell by cell.

use super::index::Index;
use super::parallel::map_mut;
use super::parameters::{Community, Turf};
use super::random::Draws;
use super::site::Site;
use eyot_core::{Control, Result};

/// Cover of turf on square cells.
#[derive(Clone, Debug)]
pub(super) struct TurfGrid {
    columns: usize,
    rows: usize,
    cell: f32,
    cover: Vec<f32>,
}

impl TurfGrid {
    /// Cells of the site with random cover.
    pub(super) fn new(site: &Site, rules: &Turf, draws: Draws) -> Self {
        let count = |side: f64| ((side / f64::from(rules.cell)).ceil() as usize).max(1);
        let (columns, rows) = (count(site.width_m), count(site.length_m));
        let cover = (0..columns as u64 * rows as u64).map(|i| draws.unit(i)).collect();
        Self { columns, rows, cell: rules.cell, cover }
    }

    /// Cover of each cell, row by row from the north.
    pub(super) fn cover(&self) -> &[f32] {
        &self.cover
    }

    pub(super) fn into_cover(self) -> Vec<f32> {
        self.cover
    }

    pub(super) fn cover_mut(&mut self) -> &mut [f32] {
        &mut self.cover
    }

    /// Cover at a place, 0..=1; outside none.
    pub(super) fn at(&self, x: f32, y: f32) -> f32 {
        if x < 0.0 || y < 0.0 {
            return 0.0;
        }
        let (i, j) = ((x / self.cell) as usize, (y / self.cell) as usize);
        if i < self.columns && j < self.rows { self.cover[j * self.columns + i] } else { 0.0 }
    }

    /// Grows for a month under the corals as they stand.
    pub(super) fn grow(&mut self, community: &Community, corals: &Index, control: &Control<'_>) -> Result<()> {
        let (cell, columns, rules) = (self.cell, self.columns, &community.turf);
        map_mut(&mut self.cover, |n, cover| {
            if control.check().is_err() {
                return;
            }
            let [x, y] = [(n % columns) as f32, (n / columns) as f32].map(|i| (i + 0.5) * cell);
            let (mut growth, mut covered) = (rules.growth, false);
            // Far enough for the corners.
            corals.visit(x, y, cell * std::f32::consts::FRAC_1_SQRT_2, |coral| {
                let (dx, dy) = ((coral.x - x).abs(), (coral.y - y).abs());
                let r2 = coral.radius * coral.radius;
                let far = (dx + 0.5 * cell).powi(2) + (dy + 0.5 * cell).powi(2);
                let near = (dx - 0.5 * cell).max(0.0).powi(2) + (dy - 0.5 * cell).max(0.0).powi(2);
                covered |= far <= r2;
                if near < r2 && 2.0 * coral.radius > cell {
                    growth *= rules.shade;
                }
            });
            *cover = if covered { 0.0 } else { (*cover + growth).min(1.0) };
        });
        control.check()
    }

    /// Grazers visit each cell with this probability.
    pub(super) fn graze(&mut self, rules: &Turf, probability: f32, draws: Draws) {
        for (n, cover) in self.cover.iter_mut().enumerate() {
            if draws.chance(n as u64, probability) {
                *cover = (*cover - rules.grazed).max(0.0);
            }
        }
    }

    /// Mean cover, 0..=1.
    pub(super) fn mean(&self) -> f64 {
        self.cover.iter().map(|&c| f64::from(c)).sum::<f64>() / self.cover.len() as f64
    }

    /// Sets the cover of every cell.
    pub(super) fn set(&mut self, cover: f32) {
        self.cover.fill(cover);
    }
}
