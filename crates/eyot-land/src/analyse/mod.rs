//! Measures of land: what a landscape looks like in numbers, and the algorithms behind them.
//!
//! [`terrain_stats`] computes everything at once; each measure is also a function of its own, one file each. Nothing
//! here changes a world. Neighbourhoods follow the grid's rim: a wrapping axis is a ring, other rims end.
//!
//! ```
//! use eyot_core::{Field, Grid, Limits, Boundary};
//! use eyot_land::analyse::{TerrainOptions, terrain_stats};
//!
//! let limits = Limits::default();
//! let grid = Grid::new(64, 64, 30.0, Boundary::CLOSED, &limits)?;
//! let ramp = Field::from_fn(64, 64, |x, _| 30.0 * x as f32);
//! let stats = terrain_stats(&ramp, &grid, None, &TerrainOptions::default(), &limits)?;
//! assert_eq!(stats.relief_m, Some(1890.0));
//! assert!((stats.slope_mean_deg.unwrap() - 45.0).abs() < 1e-4);
//! assert_eq!(stats.depression_fraction, Some(0.0));
//! # Ok::<(), eyot_core::Error>(())
//! ```

mod contours;
mod curvature;
mod curves;
mod diagonals;
mod geomorphons;
mod hack;
mod horton;
mod moments;
mod pits;
mod score;
mod slope;
mod slope_area;
mod spectrum;
mod strahler;
mod terrain_stats;
mod variogram;

pub use contours::{contours, round_interval};
pub use curvature::curvatures;
pub use curves::{TerrainCurves, terrain_curves};
pub use diagonals::diagonal_share;
pub use geomorphons::{Landform, geomorphons};
pub use hack::hack_exponent;
pub use horton::{HortonRatios, StreamOrder, horton_ratios, streams_by_order};
pub use moments::{Moments, line_slope, moments, quantile};
pub use pits::{PitCount, count_pits};
pub use score::erosion_score;
pub use slope::slope_deg;
pub use slope_area::concavity;
pub use spectrum::spectral_beta;
pub use strahler::strahler_orders;
pub use terrain_stats::{LandformShares, TerrainOptions, TerrainStats, terrain_stats};
pub use variogram::hurst_exponent;

use eyot_core::{Error, Field, Grid, Result};

/// Fails if a field has another shape than the grid.
fn check_fits(height: &Field, grid: &Grid) -> Result<()> {
    if (height.width(), height.height()) == (grid.width, grid.height) {
        return Ok(());
    }
    let what =
        format!("height of {} x {} on a grid of {} x {}", height.width(), height.height(), grid.width, grid.height);
    Err(Error::Shape { what, expected: grid.cells(), found: height.width() * height.height() })
}
