//! Measures of a world of plates.

use crate::plate::PlateInfo;
use serde::Serialize;

/// How heights are distributed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hypsometry {
    /// Lower end of the first bin, m.
    pub lowest_m: f64,
    /// Width of a bin, m.
    pub bin_m: f64,
    /// Share of the cells in each bin.
    pub shares: Vec<f64>,
    /// Share of the cells above 0 m.
    pub land: f64,
    /// The two peaks, if there are two: sea floor and continents, m.
    pub peaks_m: Option<(f64, f64)>,
}

/// What there is to say about a world of plates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Cycles begun, from 1.
    pub cycle: u64,
    /// Steps of the plates.
    pub steps: u64,
    /// All plates.
    pub plates: Vec<PlateInfo>,
    /// Distribution of the heights above the sea.
    pub hypsometry: Hypsometry,
}

/// Distribution of heights above the sea, m, in bins of 250 m, and its peaks.
///
/// There are two peaks where the highest bin below -2000 m and the highest above -1000 m are both at least twice as high as the lowest bin
/// between them. Earth's lie near -4500 and 250 m.
pub fn hypsometry(heights: impl IntoIterator<Item = f32>) -> Hypsometry {
    const BIN: f64 = 250.0;
    const LOWEST: f64 = -12_000.0;
    let mut counts = vec![0u64; 96];
    let (mut cells, mut land) = (0u64, 0u64);
    for h in heights.into_iter().map(f64::from).filter(|h| h.is_finite()) {
        counts[((h - LOWEST) / BIN).clamp(0.0, 95.0) as usize] += 1;
        cells += 1;
        land += u64::from(h > 0.0);
    }
    let shares: Vec<f64> = counts.iter().map(|&c| c as f64 / cells.max(1) as f64).collect();
    let bin = |h: f64| ((h - LOWEST) / BIN) as usize;
    // The higher of equals is the first.
    let highest =
        |from: usize, to: usize| (from..to).rev().max_by(|&a, &b| shares[a].total_cmp(&shares[b])).unwrap_or(from);
    let (sea, ground) = (highest(0, bin(-2000.0)), highest(bin(-1000.0), shares.len()));
    let valley = shares[sea..=ground].iter().copied().fold(f64::INFINITY, f64::min);
    let two = shares[sea].min(shares[ground]) >= 2.0 * valley.max(1e-12);
    let middle = |i: usize| LOWEST + (i as f64 + 0.5) * BIN;
    Hypsometry {
        lowest_m: LOWEST,
        bin_m: BIN,
        peaks_m: two.then(|| (middle(sea), middle(ground))),
        shares,
        land: land as f64 / cells.max(1) as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_are_found_where_there_are_two() {
        let two = (0..1000).map(|i| if i % 3 == 0 { 100.0 } else { -4600.0 } + (i % 40) as f32 * 10.0);
        let h = hypsometry(two);
        let (sea, ground) = h.peaks_m.unwrap();
        assert!((-4700.0..-4000.0).contains(&sea) && (0.0..600.0).contains(&ground), "{sea} {ground}");
        assert!((h.land - 0.334).abs() < 1e-9 && (h.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        let flat = hypsometry((0..8000).map(|i| i as f32 - 6000.0));
        assert_eq!(flat.peaks_m, None);
    }
}
