//! Concavity of river profiles from slope and area, `S ~ A^-theta` (Flint's law).
//!
//! # Definition
//! The slope of a cell is the fall of the filled surface along the next `REACH_CELLS` (10) cells downstream, or as far as the
//! outlet, over the way's length. Cells fall into bins of `BIN_DECADES` (0.2 decades) of drained area, from the smallest area
//! on; each bin with at least `MIN_CELLS` (20) cells gives one point, its middle and the median slope, zeros included. `-theta`
//! is the slope of the least-squares line through the logarithms.
//!
//! # Source
//! Flint (1974), Water Resources Research 10, 969-973; Wobus et al. (2006), GSA Special Paper 398, 55-74 (smoothing, bins).
//! Medians: a mean would be dominated by few steep cells, and a fixed reach suits coarse heights better than a fixed fall.
//!
//! # Reading
//! 0.37..0.56 in five mountain tiles, 0.01..0.36 in noise. Meaningful only where rivers cut into steep land.
//!
//! Compare theta at several areas (`channel_area_m2`) before a difference is believed. Where most cells of a bin lie in filled hollows, its
//! median is next to nothing, and as logarithms few such bins of the trunk rivers decide the fit. So it is with the recipe `real`: 0.39,
//! 0.45 and 0.83 at 4.15, 5 and 2.5 km2, where the measured tile that it starts from has 0.50, 0.51 and 0.50.

use super::moments::{line_slope, quantile};
use eyot_core::Result;
use eyot_drainage::Routing;
use eyot_drainage::check_length;

/// Cells over which a slope is measured.
const REACH_CELLS: usize = 10;
/// Width of a bin of area, in decades.
const BIN_DECADES: f64 = 0.2;
/// Cells that make a bin count.
const MIN_CELLS: usize = 20;

/// A line through the logarithms of slope and area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fit {
    /// Minus its slope.
    pub theta: f64,
    /// Logarithm of the slope where one cell drains.
    pub intercept: f64,
}

/// The medians of the bins, and the line through them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SlopeArea {
    /// Logarithms of the drained cells and of the median slope.
    pub points: Vec<[f64; 2]>,
    /// With fewer than four points there is no line.
    pub fit: Option<Fit>,
}

/// Concavity theta over cells of `keep` through which at least `min_cells` cells drain; `None` with fewer than four points.
///
/// # Errors
/// If `surface`, `keep` or `accumulation` has another size than the network.
pub fn concavity(
    surface: &[f32],
    flow: &Routing,
    keep: &[bool],
    accumulation: &[u32],
    min_cells: f64,
) -> Result<Option<f64>> {
    Ok(slope_area(surface, flow, keep, accumulation, min_cells)?.fit.map(|f| f.theta))
}

/// What [`concavity`] is the fit of.
///
/// # Errors
/// As [`concavity`].
pub(crate) fn slope_area(
    surface: &[f32],
    flow: &Routing,
    keep: &[bool],
    accumulation: &[u32],
    min_cells: f64,
) -> Result<SlopeArea> {
    check_length("surface", flow.cells(), surface.len())?;
    check_length("cells to keep", flow.cells(), keep.len())?;
    check_length("accumulation", flow.cells(), accumulation.len())?;
    let z = surface;
    let mut bins: Vec<Vec<f32>> = Vec::new();
    for i in (0..z.len()).filter(|&i| keep[i] && f64::from(accumulation[i]) >= min_cells) {
        let (mut end, mut length_m) = (i, 0.0);
        for _ in 0..REACH_CELLS {
            length_m += flow.distance_m(end);
            end = flow.receiver(end);
        }
        if length_m == 0.0 {
            continue;
        }
        let bin = ((f64::from(accumulation[i]) / min_cells).log10() / BIN_DECADES) as usize;
        if bins.len() <= bin {
            bins.resize(bin + 1, Vec::new());
        }
        bins[bin].push(((f64::from(z[i]) - f64::from(z[end])) / length_m) as f32);
    }
    let points: Vec<(f64, f64)> = bins
        .iter_mut()
        .enumerate()
        .filter(|(_, slopes)| slopes.len() >= MIN_CELLS)
        .filter_map(|(b, slopes)| {
            Some(((b as f64 + 0.5) * BIN_DECADES, quantile(slopes, 0.5).filter(|&s| s > 0.0)?.log10()))
        })
        .collect();
    let first = min_cells.log10();
    let fit = if points.len() < 4 { None } else { line_slope(&points) };
    let fit = fit.map(|slope| {
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
        Fit { theta: -slope, intercept: mean(|p| p.1) - slope * (mean(|p| p.0) + first) }
    });
    Ok(SlopeArea { points: points.iter().map(|p| [p.0 + first, p.1]).collect(), fit })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_graded_river_has_the_concavity_it_was_made_with() {
        // One river of 60000 cells in which cell i drains i + 1 cells and falls as (i + 1)^-0.45.
        let n = 60_000;
        let mut z = vec![0.0_f64; n];
        for i in (0..n - 1).rev() {
            z[i] = z[i + 1] + ((i + 1) as f64).powf(-0.45);
        }
        let receiver: Vec<u32> = (1..n as u32).chain([n as u32 - 1]).collect();
        let flow = Routing::by_hand(receiver, std::array::from_fn(|d| if d < 8 { 1.0 } else { 0.0 }));
        let cells = flow.upstream_cells();
        // Heights of hundreds of metres carry steps of 1e-5 m in f32, well below the falls of 0.07 m over a reach.
        let surface: Vec<f32> = z.iter().map(|&z| z as f32).collect();
        let theta = concavity(&surface, &flow, &vec![true; n], &cells, 100.0).unwrap().unwrap();
        assert!((theta - 0.45).abs() < 0.01, "{theta}");
        assert_eq!(concavity(&surface, &flow, &vec![true; n], &cells, 50_000.0).unwrap(), None);
    }
}
