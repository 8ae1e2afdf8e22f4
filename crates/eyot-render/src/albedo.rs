//! Colours of the ground: grass and forest, rock, sand and seabed by height, slope, curvature and water.
//!
//! Every border between two grounds is a smooth blend whose place wanders with a low noise, because in nature
//! no ground ends at a contour line. A layer `aridity` turns the land into desert (`arid.rs`); where there is a climate, it alone says
//! what grows (`climate.rs`).

use crate::arid::arid;
use crate::climate::Climate;
use crate::ground::{Ground, box_mean, quantile};
use crate::math::{V3, lerp, mix, scale, smoothstep};
use eyot_core::layer::known;
use eyot_core::{Result, World};
use eyot_noise::picture::fbm;
use rayon::prelude::*;

// Linear albedos. Photographs of such grounds, darkened where a photograph holds sunlight already.
const FOREST: V3 = [0.020, 0.043, 0.015];
const LUSH: V3 = [0.037, 0.071, 0.020];
const GRASS: V3 = [0.105, 0.128, 0.042];
const DRY_GRASS: V3 = [0.225, 0.195, 0.088];
const ROCK: V3 = [0.142, 0.118, 0.088];
const DARK_ROCK: V3 = [0.066, 0.057, 0.044];
const SCREE: V3 = [0.200, 0.170, 0.128];
const RIVER_BED: V3 = [0.200, 0.175, 0.145];
const SAND: V3 = [0.520, 0.435, 0.300];
const SEABED: V3 = [0.520, 0.490, 0.370];
const DEEP_SEABED: V3 = [0.240, 0.250, 0.220];
const SEAGRASS: V3 = [0.130, 0.150, 0.085];
const REEF_FLAT: V3 = [0.470, 0.470, 0.370];
const CORAL: V3 = [0.165, 0.140, 0.085];
const SNOW: V3 = [0.800, 0.830, 0.870];

/// Snow lies above this height, m; tropical islands stay below it.
const SNOW_LINE_M: f32 = 3000.0;
/// The same where cells are many kilometres wide: no cell is as steep as rock is, and heights are means over whole ranges.
const COARSE_SNOW_LINE_M: f32 = 5000.0;
/// There, land dries, and is bare, from these heights on, m.
const COARSE_DRY_M: f32 = 900.0;
const COARSE_BARE_M: f32 = 2300.0;

/// Linear RGB albedo of every cell, row by row from the north-west.
///
/// Reads `height` and, where they exist, `wetness` (rock where rivers ran), `limestone` and `growth` (reef),
/// `aridity` (beds of bare rock and sand), or temperature, rain and `ice` of a world with a climate.
///
/// # Errors
/// If the world has no layer `height`.
pub fn terrain_colours(world: &World) -> Result<Vec<[f32; 3]>> {
    Ok(albedo(world, &Ground::new(world)?, 1.0))
}

/// As [`terrain_colours`]; `variation` scales the noise.
pub(crate) fn albedo(world: &World, g: &Ground, variation: f32) -> Vec<V3> {
    let (w, h) = (g.width, g.height);
    let layer = |name: &str| world.get(name).map(|f| f.to_vec());
    let wetness = layer(&known::WETNESS.name);
    let limestone = layer(&known::LIMESTONE.name);
    let growth = layer(&known::GROWTH.name);
    let aridity = layer(&known::ARIDITY.name);
    let climate = Climate::of(world);
    let slopes = slopes(g);
    let radius = (w.max(h) / 128).clamp(2, 24);
    let mean = box_mean(&g.z, w, h, radius);
    // How far a cell of usual roughness stands off its surroundings.
    let usual_bump = quantile_of(&g.z, &mean, 0.9).max(1e-6);
    let scales = Scales::new(g, &slopes);
    let seed = world.seed as u32;
    let mut out = vec![[0.0; 3]; w * h];
    out.par_chunks_mut(w).enumerate().for_each(|(y, row)| {
        for (x, c) in row.iter_mut().enumerate() {
            let i = y * w + x;
            let (px, py) = (x as f32 * g.cell[0] / scales.extent, y as f32 * g.cell[1] / scales.extent);
            let site = Site {
                z: g.z[i],
                slope: slopes[i],
                bump: ((g.z[i] - mean[i]) / usual_bump).clamp(-1.5, 1.5),
                broad: variation * fbm(px * 11.0, py * 11.0, 4, seed),
                fine: variation * fbm(px * 90.0, py * 90.0, 3, seed ^ 0x51),
                wetness: value(&wetness, i).clamp(0.0, 1.0),
                aridity: value(&aridity, i).clamp(0.0, 1.0),
                reef: value(&growth, i).clamp(0.0, 1.0).max(smoothstep(0.2, 2.5, value(&limestone, i))),
                zero: g.zero,
            };
            let shore = 0.5 * scales.beach;
            let under = if g.sea { smoothstep(0.1 * shore, -0.1 * shore, site.z) } else { 0.0 };
            let land = match &climate {
                _ if under >= 1.0 => SAND,
                Some(climate) => climate.land(i, site.broad, site.fine, site.slope / scales.rock),
                None => land(&site, &scales, g.sea),
            };
            let sea = if under > 0.0 { seabed(&site, &scales) } else { SEABED };
            *c = mix(land, sea, under);
        }
    });
    out
}

/// What the colour of one cell depends on.
pub(crate) struct Site {
    /// m above the datum.
    pub(crate) z: f32,
    /// Rise over run.
    slope: f32,
    /// Ridge (positive) or hollow (negative), about -1..1.
    pub(crate) bump: f32,
    /// Slow noise, about -0.6..0.6.
    pub(crate) broad: f32,
    /// Quick noise.
    pub(crate) fine: f32,
    wetness: f32,
    aridity: f32,
    reef: f32,
    /// Height of the world's own zero above the datum, m.
    pub(crate) zero: f32,
}

/// What the colours of all cells share.
struct Scales {
    extent: f32,
    low: f32,
    relief: f32,
    /// Height of the beach band, m.
    beach: f32,
    /// Slope where rock begins to show.
    rock: f32,
    /// From 0 where a cell shows slopes to 1 where it holds whole valleys.
    coarse: f32,
}

impl Scales {
    fn new(g: &Ground, slopes: &[f32]) -> Self {
        let land: Vec<f32> = (0..slopes.len())
            .step_by((slopes.len() / 65_536).max(1) | 1)
            .filter(|&i| !g.sea || g.z[i] > 0.0)
            .map(|i| slopes[i])
            .collect();
        // Coarse grids round the slopes off, so rock begins where this land is steep for its kind.
        let rock = if land.is_empty() { 0.9 } else { quantile(&land, 0.92).clamp(0.40, 1.3) };
        let relief = g.relief();
        let low = if g.sea { 0.0 } else { g.land_low };
        let coarse = smoothstep(3_000.0, 20_000.0, g.cell[0].min(g.cell[1]));
        Self { extent: g.extent(), low, relief, beach: (0.006 * relief).clamp(0.02, 4.0), rock, coarse }
    }
}

fn land(s: &Site, k: &Scales, sea: bool) -> V3 {
    let up = (s.z - k.low) / k.relief;
    // Paler and yellower, high and steep and on ridges; lush in hollows.
    let dryness = 0.95 * up + 0.42 * (s.slope / k.rock) + 0.22 * s.bump + 0.75 * s.broad + 0.18 * s.fine;
    let mut c = mix(LUSH, FOREST, smoothstep(-0.35, 0.30, s.broad + 0.5 * s.fine - 0.3 * s.bump));
    c = mix(c, GRASS, smoothstep(0.55, 1.05, dryness));
    c = mix(c, DRY_GRASS, 0.85 * smoothstep(0.95, 1.55, dryness));
    // Meadows and clearings at the foot.
    c = mix(
        c,
        GRASS,
        0.7 * smoothstep(0.10, 0.45, 1.1 * s.broad - 0.5 * s.fine)
            * smoothstep(0.55, 0.15, up)
            * smoothstep(0.45, 0.1, s.slope),
    );
    let altitude = s.z - s.zero;
    let stone = mix(ROCK, DARK_ROCK, smoothstep(-0.3, 0.4, s.fine - 0.5 * s.broad));
    // Green climbs cliffs in the wet lowlands; heights are barer.
    let steep = s.slope / k.rock + 0.50 * s.fine + 0.30 * s.broad + 0.10 * s.bump + 0.30 * (up - 0.55);
    let scree = mix(SCREE, ROCK, smoothstep(-0.2, 0.3, s.fine));
    c = mix(c, scree, 0.65 * smoothstep(0.92, 1.12, steep) * smoothstep(0.35, 0.75, up));
    c = mix(c, stone, smoothstep(1.0, 1.28, steep));
    if k.coarse > 0.0 {
        let at = altitude + 700.0 * s.broad + 300.0 * s.fine;
        c = mix(c, DRY_GRASS, 0.8 * k.coarse * smoothstep(COARSE_DRY_M - 500.0, COARSE_DRY_M + 700.0, at));
        c = mix(c, mix(scree, stone, 0.6), k.coarse * smoothstep(COARSE_BARE_M - 900.0, COARSE_BARE_M + 900.0, at));
    }
    if s.aridity > 0.0 {
        c = mix(c, arid(s, up, k.relief, s.slope / k.rock), s.aridity);
    }
    c = mix(c, mix(RIVER_BED, ROCK, smoothstep(-0.3, 0.3, s.fine)), 0.85 * smoothstep(0.12, 0.65, s.wetness));
    let line = lerp(SNOW_LINE_M, COARSE_SNOW_LINE_M, k.coarse);
    let snow = smoothstep(
        -150.0 - 500.0 * k.coarse,
        350.0 + 700.0 * k.coarse,
        altitude - line + 500.0 * s.broad + 180.0 * s.fine - 120.0 * s.bump,
    );
    c = mix(c, SNOW, snow * smoothstep(1.45, 1.05, steep));
    if sea {
        let band = k.beach * (1.0 + 1.2 * s.broad + 0.5 * s.fine);
        let sand = smoothstep(1.15 * band, 0.55 * band, s.z) * smoothstep(0.42, 0.20, s.slope);
        c = mix(c, mix(SAND, scale(SAND, 0.86), smoothstep(-0.2, 0.4, s.fine)), sand);
    }
    scale(c, 1.0 + 0.14 * s.fine + 0.10 * s.broad)
}

fn seabed(s: &Site, k: &Scales) -> V3 {
    let depth = -s.z;
    let shallow = 1.0 / k.beach;
    let mut c = mix(SEABED, DEEP_SEABED, smoothstep(6.0, 45.0, depth * shallow * 4.0));
    // Patches of weed and coral heads on the sand of the lagoon.
    let patch = smoothstep(0.12, 0.34, s.fine + 0.35 * s.broad) * smoothstep(0.2, 1.2, depth * shallow);
    c = mix(c, SEAGRASS, 0.62 * patch);
    let stone = mix(ROCK, DARK_ROCK, smoothstep(-0.3, 0.3, s.fine));
    c = mix(c, stone, 0.8 * smoothstep(0.9, 1.4, s.slope / k.rock + 0.3 * s.fine));
    if s.reef > 0.0 {
        let mottle = smoothstep(0.02, 0.32, s.fine + 0.25 * s.broad);
        let flat = mix(REEF_FLAT, CORAL, 0.70 * mottle);
        let slope = mix(CORAL, REEF_FLAT, 0.35 * (1.0 - mottle));
        c = mix(c, mix(flat, slope, smoothstep(0.6, 3.0, depth * shallow)), 0.92 * s.reef);
    }
    scale(c, lerp(1.0, 1.0 + 0.16 * s.fine + 0.12 * s.broad, 0.9))
}

/// Rise over run, by central differences; one-sided on the rim.
pub(crate) fn slopes(g: &Ground) -> Vec<f32> {
    let (w, h) = (g.width, g.height);
    let mut out = vec![0.0; w * h];
    out.par_chunks_mut(w).enumerate().for_each(|(y, row)| {
        let (north, south) = (y.saturating_sub(1), (y + 1).min(h - 1));
        let run_y = ((south - north).max(1)) as f32 * g.cell[1];
        for (x, s) in row.iter_mut().enumerate() {
            let (west, east) = (x.saturating_sub(1), (x + 1).min(w - 1));
            let run_x = ((east - west).max(1)) as f32 * g.cell[0];
            let gx = (g.z[y * w + east] - g.z[y * w + west]) / run_x;
            let gy = (g.z[south * w + x] - g.z[north * w + x]) / run_y;
            *s = gx.hypot(gy);
        }
    });
    out
}

fn value(layer: &Option<Vec<f32>>, i: usize) -> f32 {
    layer.as_ref().map_or(0.0, |v| if v[i].is_finite() { v[i] } else { 0.0 })
}

fn quantile_of(a: &[f32], b: &[f32], q: f32) -> f32 {
    let step = (a.len() / 65_536).max(1) | 1;
    let v: Vec<f32> = (0..a.len()).step_by(step).map(|i| (a[i] - b[i]).abs()).collect();
    quantile(&v, q)
}
