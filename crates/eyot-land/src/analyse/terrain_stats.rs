//! All measures of a landscape in one structure.
//!
//! # Land and sea
//! With a sea level, *land* is every cell above it. Submerged cells are outlets and belong to no measure of the land;
//! water and lines of sight meet the sea's surface there, while slopes, curvatures and the spectrum go on over the sea floor.
//!
//! # What is missing
//! A measure that a landscape does not have is `None` (`null` in JSON), never NaN: the skewness of a constant, the spectrum
//! of a tiny grid, the streams of a grid smaller than the channel threshold, anything of a grid without land.
//!
//! # Source
//! Definitions are in the files of the algorithms, `tests/it/analyse_jacksboro.rs` holds them against a real tile.

use super::curvature::curvatures;
use super::geomorphons::{Landform, geomorphons};
use super::hack::hack_exponent;
use super::horton::{horton_ratios, streams_by_order};
use super::moments::{finite, moments, quantile};
use super::pits::count_pits;
use super::score::erosion_score;
use super::slope::slope_deg;
use super::slope_area::concavity;
use super::spectrum::{spectral_beta, spectrum_bytes};
use super::strahler::strahler_orders;
use super::variogram::hurst_exponent;
use eyot_core::{BoundaryCondition, Control, Error, Field, Grid, Limits, Result};
use eyot_drainage::{Base, FlatRule, Routing, fill, outlets};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Thresholds of the measures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TerrainOptions {
    /// Area that must drain through a cell to make it a channel. Default: [`TerrainOptions::default_channel_area_m2`]. Smaller gives
    /// more and shorter first-order streams; the drainage density follows it almost alone, so that only densities with
    /// one area compare.
    #[schemars(extend("unit" = "m2"))]
    pub channel_area_m2: Option<f64>,
    /// Smallest area in the slope-area fit. Default: a fifth of the channel area. Too small lets hillslopes in, whose
    /// slope does not fall with area, and flattens theta.
    #[schemars(extend("unit" = "m2"))]
    pub concavity_area_m2: Option<f64>,
    /// How far geomorphons look. Default: 10 cells.
    #[schemars(range(min = 1, max = 1000), extend("unit" = "cells"))]
    pub geomorphon_radius_cells: usize,
    /// Angles below this are level to geomorphons. Default: 1 degree (Jasiewicz & Stepinski 2013).
    #[schemars(range(min = 0.0, max = 45.0), extend("unit" = "deg"))]
    pub geomorphon_flat_deg: f64,
    /// A cell counts as part of a depression if filling raises it by more than this. Default: 1 cm.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub depression_depth_m: f64,
}

impl Default for TerrainOptions {
    fn default() -> Self {
        Self {
            channel_area_m2: None,
            concavity_area_m2: None,
            geomorphon_radius_cells: 10,
            geomorphon_flat_deg: 1.0,
            depression_depth_m: 0.01,
        }
    }
}

impl TerrainOptions {
    /// Area that makes a channel if none is given, m2: that of 600 cells if the map had 512 x 512 of them, so that a map on a finer or a
    /// coarser grid keeps it; at least that of 10 cells.
    ///
    /// On maps of 512 cells it lies between the 1 km2 at 30 m and the 5 km2 at 90 m of the reference table.
    pub fn default_channel_area_m2(grid: &Grid) -> f64 {
        grid.cell_area_m2() * (grid.cells() as f64 * 600.0 / (512.0 * 512.0)).max(10.0)
    }

    fn check(&self) -> Result<()> {
        let bad = |field: &str, reason: String| {
            Err(Error::BadParameter { owner: "terrain_stats".into(), field: field.into(), reason })
        };
        for (field, area) in [("channel_area_m2", self.channel_area_m2), ("concavity_area_m2", self.concavity_area_m2)]
        {
            if let Some(a) = area.filter(|a| !(a.is_finite() && *a > 0.0)) {
                return bad(field, format!("is {a}, it must be a positive area in m2"));
            }
        }
        if !(1..=1000).contains(&self.geomorphon_radius_cells) {
            return bad(
                "geomorphon_radius_cells",
                format!("is {}, it must lie within 1..=1000", self.geomorphon_radius_cells),
            );
        }
        if !(0.0..=45.0).contains(&self.geomorphon_flat_deg) {
            return bad("geomorphon_flat_deg", format!("is {}, it must lie within 0..=45", self.geomorphon_flat_deg));
        }
        if !(0.0..=1000.0).contains(&self.depression_depth_m) {
            return bad("depression_depth_m", format!("is {}, it must lie within 0..=1000", self.depression_depth_m));
        }
        Ok(())
    }
}

/// Shares of the ten landforms among land cells at least the geomorphon radius away from the rim; they add up to 1.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[allow(missing_docs)] // the names are those of `Landform`, which explains them
pub struct LandformShares {
    pub flat: f64,
    pub peak: f64,
    pub ridge: f64,
    pub shoulder: f64,
    pub spur: f64,
    pub slope: f64,
    pub hollow: f64,
    pub footslope: f64,
    pub valley: f64,
    pub pit: f64,
}

impl LandformShares {
    /// The shares in the order of [`Landform::ALL`].
    pub fn to_array(&self) -> [f64; 10] {
        let Self { flat, peak, ridge, shoulder, spur, slope, hollow, footslope, valley, pit } = *self;
        [flat, peak, ridge, shoulder, spur, slope, hollow, footslope, valley, pit]
    }

    /// Shares in the order of [`Landform::ALL`].
    pub fn from_array(shares: [f64; 10]) -> Self {
        let [flat, peak, ridge, shoulder, spur, slope, hollow, footslope, valley, pit] = shares;
        Self { flat, peak, ridge, shoulder, spur, slope, hollow, footslope, valley, pit }
    }
}

/// Measures of a landscape. `None` where the landscape does not have the measure; never NaN.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TerrainStats {
    /// Cells of the grid.
    pub cells: u64,
    /// Share of the cells that are land, 0..1; 1 without a sea.
    pub land_share: f64,
    /// Lowest land, m.
    pub min_m: Option<f64>,
    /// Highest land, m.
    pub max_m: Option<f64>,
    /// Mean height of the land, m.
    pub mean_m: Option<f64>,
    /// Highest minus lowest land, m.
    pub relief_m: Option<f64>,
    /// Hypsometric integral (mean - min) / (max - min) of the land, 0..1 (Pike & Wilson 1971); `None` on level land.
    pub hypsometric_integral: Option<f64>,
    /// Mean slope of the land, degrees, from central differences.
    pub slope_mean_deg: Option<f64>,
    /// Slope that 95 % of the land does not exceed, degrees.
    pub slope_p95_deg: Option<f64>,
    /// Skewness g1 of the slope in degrees, 1.
    pub slope_skew: Option<f64>,
    /// Erosion score of the land, 1: deviation over mean of each cell's largest step to one of its four neighbours (Olsen 2004); `None`
    /// on level land.
    pub erosion_score: Option<f64>,
    /// Exponent of the radially averaged 2-D periodogram, 1; of the whole grid, sea floor included.
    pub beta_2d: Option<f64>,
    /// Hurst exponent of the variogram over lags of 1..16 cells between land cells, 1.
    pub hurst: Option<f64>,
    /// Skewness g1 of the Laplacian of the height, 1; negative where ridges are sharper than valleys.
    pub curvature_skew: Option<f64>,
    /// Strict local minima per 1000 land cells that the rim does not cut off.
    pub pits_per_1000: Option<f64>,
    /// Share of the land that filling its depressions raises by more than 1 cm, 0..1.
    pub depression_fraction: Option<f64>,
    /// Mean depth by which filling raises the land, untouched cells included, m.
    pub fill_mean_m: Option<f64>,
    /// Mean fill depth over relief, 1; real tiles have 4e-6..3.4e-4, noise has 1.8e-3 and more. `None` on level land.
    pub fill_over_relief: Option<f64>,
    /// Concavity theta of Flint's law S ~ A^-theta, 1.
    pub concavity: Option<f64>,
    /// Hack's exponent h of L ~ A^h over confluences, 1.
    pub hack: Option<f64>,
    /// Area that made a cell a channel, m2.
    pub channel_area_m2: f64,
    /// Highest Strahler order; 0 without channels.
    pub strahler_max: u32,
    /// Horton's bifurcation ratio R_B, 1; from two orders on.
    pub horton_bifurcation: Option<f64>,
    /// Horton's length ratio R_L, 1.
    pub horton_length: Option<f64>,
    /// Area ratio R_A, 1.
    pub horton_area: Option<f64>,
    /// Length of channels over area of land, 1/km; 0 without channels.
    pub drainage_density_per_km: Option<f64>,
    /// Shares of the ten geomorphons; `None` if no land lies far enough from the rim.
    pub landforms: Option<LandformShares>,
}

/// Measures `height` (m) on `grid`. With `sea_level_m`, cells at or below it are sea.
///
/// Uses the threads of the rayon pool it is called in; the result does not depend on their number.
///
/// # Errors
/// If `height` has another size than `grid` or a value that is not finite, an option is out of its range, the sea level is
/// not finite, or the work needs more memory than `limits` allow.
pub fn terrain_stats(
    height: &Field,
    grid: &Grid,
    sea_level_m: Option<f64>,
    options: &TerrainOptions,
    limits: &Limits,
) -> Result<TerrainStats> {
    let ready = Ready::new(height, grid, sea_level_m, options, limits)?;
    let Ready { land, surface, outlets, channel_area_m2 } = &ready;
    let (land_cells, channel_area_m2) = (land.iter().filter(|&&l| l).count(), *channel_area_m2);
    let cell_area_m2 = grid.cell_area_m2();
    let mut stats = TerrainStats {
        cells: grid.cells() as u64,
        land_share: land_cells as f64 / grid.cells() as f64,
        min_m: None,
        max_m: None,
        mean_m: None,
        relief_m: None,
        hypsometric_integral: None,
        slope_mean_deg: None,
        slope_p95_deg: None,
        slope_skew: None,
        erosion_score: None,
        beta_2d: None,
        hurst: None,
        curvature_skew: None,
        pits_per_1000: None,
        depression_fraction: None,
        fill_mean_m: None,
        fill_over_relief: None,
        concavity: None,
        hack: None,
        channel_area_m2,
        strahler_max: 0,
        horton_bifurcation: None,
        horton_length: None,
        horton_area: None,
        drainage_density_per_km: None,
        landforms: None,
    };
    if land_cells == 0 {
        return Ok(stats);
    }
    let (water, shape) = rayon::join(
        || Water::new(surface, grid, land, outlets, channel_area_m2, options),
        || shape(&mut stats, height, surface, grid, land, options),
    );
    shape?;
    let water = water?;
    stats.depression_fraction = Some(water.raised as f64 / land_cells as f64);
    stats.fill_mean_m = finite(water.fill_sum_m / land_cells as f64);
    stats.fill_over_relief = stats.relief_m.filter(|&r| r > 0.0).and_then(|r| finite(stats.fill_mean_m? / r));
    stats.concavity = water.concavity;
    stats.hack = water.hack;
    stats.strahler_max = water.streams.len() as u32;
    let ratios = horton_ratios(&water.streams);
    stats.horton_bifurcation = ratios.map(|r| r.bifurcation);
    stats.horton_length = ratios.map(|r| r.length);
    stats.horton_area = ratios.map(|r| r.area);
    // An empty sum is -0.
    let channels_m = water.streams.iter().fold(0.0, |sum, s| sum + s.length_m);
    stats.drainage_density_per_km = finite(1000.0 * channels_m / (land_cells as f64 * cell_area_m2));
    Ok(stats)
}

/// What measures of rivers and slopes begin with.
struct Ready {
    /// Cells above the sea.
    land: Vec<bool>,
    /// The ground, and the sea's surface.
    surface: Field,
    outlets: Vec<bool>,
    channel_area_m2: f64,
}

impl Ready {
    fn new(
        height: &Field,
        grid: &Grid,
        sea_level_m: Option<f64>,
        options: &TerrainOptions,
        limits: &Limits,
    ) -> Result<Self> {
        options.check()?;
        if (height.width(), height.height()) != (grid.width, grid.height) {
            return Err(Error::Shape {
                what: format!("height of a grid of {}x{}", grid.width, grid.height),
                expected: grid.cells(),
                found: height.width() * height.height(),
            });
        }
        if let Some((x, y, value)) = height.find_not_finite() {
            return Err(Error::NotFinite {
                layer: "height".into(),
                value,
                x,
                y,
                after: "reading the terrain to measure".into(),
            });
        }
        if let Some(sea) = sea_level_m.filter(|s| !s.is_finite()) {
            return Err(Error::BadParameter {
                owner: "terrain_stats".into(),
                field: "sea_level_m".into(),
                reason: format!("is {sea}"),
            });
        }
        // The spectrum, and beside it the network: heights, receivers, distances, order, areas, lengths and flags.
        limits.check_bytes("measuring the terrain", spectrum_bytes(grid.cells()) + 64 * grid.cells() as u128)?;

        let land: Vec<bool> = height.iter().map(|z| sea_level_m.is_none_or(|sea| f64::from(z) > sea)).collect();
        let mut surface = height.clone();
        if let Some(sea) = sea_level_m {
            surface.map_in_place(|z| if f64::from(z) > sea { z } else { sea as f32 });
        }
        // A map was cut out of a larger one, so water leaves over its borders whatever the rim.
        let base = Base { closed_rims: true, sea_level_m, mask: None };
        let outlets = outlets(&height.to_vec(), grid, &base)?;
        let channel_area_m2 = options.channel_area_m2.unwrap_or_else(|| TerrainOptions::default_channel_area_m2(grid));
        Ok(Self { land, surface, outlets, channel_area_m2 })
    }
}

/// The rivers of a landscape.
pub(super) struct Network {
    pub(super) land: Vec<bool>,
    /// The surface without depressions.
    pub(super) filled: Vec<f32>,
    pub(super) flow: Routing,
    /// Cells that drain through each.
    pub(super) cells: Vec<u32>,
    pub(super) channel_area_m2: f64,
    pub(super) channel_cells: f64,
    /// Fewest cells of the slope-area fit.
    pub(super) concavity_cells: f64,
}

impl Network {
    pub(super) fn new(
        height: &Field,
        grid: &Grid,
        sea_level_m: Option<f64>,
        options: &TerrainOptions,
        limits: &Limits,
    ) -> Result<Self> {
        let Ready { land, surface, outlets, channel_area_m2 } = Ready::new(height, grid, sea_level_m, options, limits)?;
        Self::of(&surface, grid, land, &outlets, channel_area_m2, options)
    }

    fn of(
        surface: &Field,
        grid: &Grid,
        land: Vec<bool>,
        outlets: &[bool],
        channel_area_m2: f64,
        options: &TerrainOptions,
    ) -> Result<Self> {
        let mut filled = surface.to_vec();
        fill(&mut filled, grid, outlets, &Control::none())?;
        let flow = Routing::with_flats(&filled, grid, outlets, FlatRule::Shortest, &Control::none())?;
        let cells = flow.upstream_cells();
        let channel_cells = channel_area_m2 / grid.cell_area_m2();
        let concavity_cells = options.concavity_area_m2.map_or(channel_cells / 5.0, |a| a / grid.cell_area_m2());
        let concavity_cells = concavity_cells.max(1.0);
        Ok(Self { land, filled, flow, cells, channel_area_m2, channel_cells, concavity_cells })
    }
}

/// Everything that needs no water: heights, slopes, curvature, spectrum, variogram, pits and landforms.
fn shape(
    stats: &mut TerrainStats,
    height: &Field,
    surface: &Field,
    grid: &Grid,
    land: &[bool],
    options: &TerrainOptions,
) -> Result<()> {
    let on_land = |f: &Field| -> Vec<f32> { f.iter().zip(land).filter(|&(_, &l)| l).map(|(v, _)| v).collect() };

    let heights = on_land(height);
    let (low, high) = heights.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), &z| (a.min(z), b.max(z)));
    let (low, high) = (f64::from(low), f64::from(high));
    stats.min_m = finite(low);
    stats.max_m = finite(high);
    stats.relief_m = finite(high - low);
    stats.mean_m = moments(&heights).map(|m| m.mean);
    stats.hypsometric_integral = stats.mean_m.and_then(|mean| finite((mean - low) / (high - low)));
    drop(heights);

    let mut slopes = on_land(&slope_deg(height, grid)?);
    let slope = moments(&slopes);
    stats.slope_mean_deg = slope.map(|m| m.mean);
    stats.slope_skew = slope.and_then(|m| m.skewness);
    stats.slope_p95_deg = quantile(&mut slopes, 0.95);
    drop(slopes);

    stats.erosion_score = erosion_score(height, grid, |i| land[i])?;
    stats.curvature_skew = moments(&curvatures(height, grid, |i| land[i])?).and_then(|m| m.skewness);
    stats.pits_per_1000 = count_pits(height, grid, |i| land[i])?.per_1000();
    stats.hurst = hurst_exponent(height, grid, land)?;
    stats.beta_2d = spectral_beta(height, grid)?;
    stats.landforms = landform_shares(surface, grid, land, options)?;
    Ok(())
}

fn landform_shares(
    surface: &Field,
    grid: &Grid,
    land: &[bool],
    options: &TerrainOptions,
) -> Result<Option<LandformShares>> {
    let r = options.geomorphon_radius_cells;
    let inside = |i: usize, n: usize, edge: BoundaryCondition| edge == BoundaryCondition::Wrap || (i >= r && i + r < n);
    if !((0..grid.width).any(|x| inside(x, grid.width, grid.rim.x))
        && (0..grid.height).any(|y| inside(y, grid.height, grid.rim.y)))
    {
        return Ok(None);
    }
    let mut count = [0_u64; 10];
    for (i, &form) in geomorphons(surface, grid, r, options.geomorphon_flat_deg)?.iter().enumerate() {
        let (x, y) = (i % grid.width, i / grid.width);
        if land[i] && inside(x, grid.width, grid.rim.x) && inside(y, grid.height, grid.rim.y) {
            count[form as usize] += 1;
        }
    }
    let total: u64 = count.iter().sum();
    debug_assert_eq!(count.len(), Landform::ALL.len());
    Ok((total > 0).then(|| LandformShares::from_array(count.map(|c| c as f64 / total as f64))))
}

/// Everything that needs the drainage network.
struct Water {
    raised: u64,
    fill_sum_m: f64,
    concavity: Option<f64>,
    hack: Option<f64>,
    streams: Vec<super::StreamOrder>,
}

impl Water {
    fn new(
        surface: &Field,
        grid: &Grid,
        land: &[bool],
        outlets: &[bool],
        channel_area_m2: f64,
        options: &TerrainOptions,
    ) -> Result<Self> {
        let n = Network::of(surface, grid, land.to_vec(), outlets, channel_area_m2, options)?;
        let (mut raised, mut fill_sum_m) = (0, 0.0);
        // The sea is never raised: it consists of outlets.
        for (before, after) in surface.iter().zip(&n.filled) {
            let depth_m = f64::from(*after) - f64::from(before);
            raised += u64::from(depth_m > options.depression_depth_m);
            fill_sum_m += depth_m;
        }
        let (flow, cells) = (&n.flow, &n.cells);
        let channel: Vec<bool> = cells.iter().zip(land).map(|(&c, &l)| l && f64::from(c) >= n.channel_cells).collect();
        let streams = streams_by_order(flow, &strahler_orders(flow, &channel)?, cells)?;
        Ok(Self {
            raised,
            fill_sum_m,
            concavity: concavity(&n.filled, flow, land, cells, n.concavity_cells)?,
            hack: hack_exponent(flow, &channel, cells)?,
            streams,
        })
    }
}
