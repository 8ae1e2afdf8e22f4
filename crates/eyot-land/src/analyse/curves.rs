//! Curves of a landscape, for plots: hypsometry, slope against area, profiles of rivers.
//!
//! # Definition
//! The *hypsometric curve* is the height that a share of the land lies above. *Slope and area* are the medians that the concavity is fitted
//! to (`slope_area.rs`). A *profile* is the filled surface along a river from its mouth up: of the rivers that reach the sea or the rim, those
//! with the largest catchments, each along the branch that drains most, as long as it is a channel.
//!
//! # Source
//! Strahler (1952), Geological Society of America Bulletin 63, 1117-1142 (hypsometry); the head of `slope_area.rs` for the rest.

use super::slope_area::{Fit, SlopeArea, slope_area};
use super::terrain_stats::{Network, TerrainOptions};
use eyot_core::{Field, Grid, Limits, Result};

/// Points of a hypsometric curve.
const HYPSOMETRY: usize = 101;
/// Rivers with a profile.
const RIVERS: usize = 5;
/// Points of a profile at most.
const PROFILE: usize = 1000;

/// What [`terrain_curves`] finds. A curve that a landscape does not have is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TerrainCurves {
    /// Share of the land from 0 to 1, and the height that it lies above, m; from the highest to the lowest.
    pub hypsometry: Vec<[f64; 2]>,
    /// Middle of a bin of drained area, m2, and the median slope in it, rise over run.
    pub slope_area: Vec<[f64; 2]>,
    /// Concavity theta and the slope at 1 m2 of the line through `slope_area`, if there is one: `S = k A^-theta`.
    pub fit: Option<[f64; 2]>,
    /// Rivers, the largest first: distance from the mouth, m, and height, m.
    pub rivers: Vec<Vec<[f64; 2]>>,
    /// Area that made a cell a channel, m2.
    pub channel_area_m2: f64,
}

/// The curves of `height` (m) on `grid`. With `sea_level_m`, cells at or below it are sea.
///
/// # Errors
/// As [`super::terrain_stats`].
pub fn terrain_curves(
    height: &Field,
    grid: &Grid,
    sea_level_m: Option<f64>,
    options: &TerrainOptions,
    limits: &Limits,
) -> Result<TerrainCurves> {
    let n = Network::new(height, grid, sea_level_m, options, limits)?;
    let mut out = TerrainCurves { channel_area_m2: n.channel_area_m2, ..TerrainCurves::default() };
    let mut heights: Vec<f32> = height.iter().zip(&n.land).filter(|(_, l)| **l).map(|(z, _)| z).collect();
    if heights.is_empty() {
        return Ok(out);
    }
    heights.sort_unstable_by(|a, b| b.total_cmp(a));
    let last = heights.len() - 1;
    let share = |i: usize| i as f64 / (HYPSOMETRY - 1) as f64;
    out.hypsometry =
        (0..HYPSOMETRY).map(|i| [share(i), heights[(share(i) * last as f64).round() as usize].into()]).collect();
    drop(heights);

    let SlopeArea { points, fit } = slope_area(&n.filled, &n.flow, &n.land, &n.cells, n.concavity_cells)?;
    let area = grid.cell_area_m2();
    out.slope_area = points.iter().map(|p| [10f64.powf(p[0]) * area, 10f64.powf(p[1])]).collect();
    out.fit = fit.map(|Fit { theta, intercept }| [theta, 10f64.powf(intercept) * area.powf(theta)]);
    out.rivers = rivers(&n);
    Ok(out)
}

fn rivers(n: &Network) -> Vec<Vec<[f64; 2]>> {
    let channel = |i: usize| n.land[i] && f64::from(n.cells[i]) >= n.channel_cells;
    // Of all cells that flow into a cell, the one that drains most; of equals the first.
    let mut above = vec![u32::MAX; n.cells.len()];
    for i in 0..n.cells.len() {
        let to = n.flow.receiver(i);
        if to != i && (above[to] == u32::MAX || n.cells[i] > n.cells[above[to] as usize]) {
            above[to] = i as u32;
        }
    }
    let ends = |i: usize| {
        let to = n.flow.receiver(i);
        to == i || !n.land[to]
    };
    let mut mouths: Vec<usize> = (0..n.cells.len()).filter(|&i| channel(i) && ends(i)).collect();
    mouths.sort_by_key(|&i| (std::cmp::Reverse(n.cells[i]), i));
    mouths.truncate(RIVERS);
    let profile = |mouth: usize| {
        let mut line = vec![[0.0, f64::from(n.filled[mouth])]];
        let (mut at, mut way) = (mouth, 0.0);
        while let Some(up) = Some(above[at]).filter(|u| *u != u32::MAX && channel(*u as usize)) {
            at = up as usize;
            way += n.flow.distance_m(at);
            line.push([way, f64::from(n.filled[at])]);
        }
        let step = line.len().div_ceil(PROFILE);
        let last = line.len() - 1;
        line.into_iter().enumerate().filter(|(i, _)| i % step == 0 || *i == last).map(|(_, p)| p).collect()
    };
    mouths.into_iter().map(profile).collect()
}
