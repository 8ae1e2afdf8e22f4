//! What a picture needs to know of a world: sound heights, the sea, and how water is spread over the land.

use eyot_core::layer::known;
use eyot_core::{Error, Field, Result, World};
use rayon::prelude::*;

/// Heights made sound, with the statistics that scale colours to the world at hand.
pub(crate) struct Ground {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Size of a cell, m.
    pub(crate) cell: [f32; 2],
    /// Solid ground, m above the datum: the sea level, or the world's own zero if there is no sea.
    pub(crate) z: Vec<f32>,
    /// True if some cell lies below the sea level.
    pub(crate) sea: bool,
    /// Low end of the land, m above the datum.
    pub(crate) land_low: f32,
    /// High end of the land, m above the datum.
    pub(crate) land_high: f32,
    /// Height of the world's zero above the datum, m.
    pub(crate) zero: f32,
    /// Fresh water depth, m, if the world has that layer.
    pub(crate) water: Option<Vec<f32>>,
    /// Water depths at which a river begins and ends to show, m.
    pub(crate) river: (f32, f32),
    /// Share of rim cells that stand above the sea.
    pub(crate) rim_land: f32,
}

/// Depths at which water shows in worlds that say where their rivers and lakes are: there is no film of rain to tell them from, m.
const LINES: (f32, f32) = (0.03, 0.3);

impl Ground {
    /// Reads `height` and, if there is one, `water`.
    pub(crate) fn new(world: &World) -> Result<Self> {
        let field = &world.layer(&known::HEIGHT.name)?.field;
        let (width, height) = (field.width(), field.height());
        let (lo, _) = finite_range(field);
        let sea_level = world.sea_level_m as f32;
        let sea = lo < sea_level && sea_level.is_finite();
        let datum = if sea { sea_level } else { 0.0 };
        let z: Vec<f32> = field.iter().map(|h| if h.is_finite() { h } else { lo } - datum).collect();
        let land: Vec<f32> = sample(&z).filter(|&h| !sea || h > 0.0).collect();
        let (land_low, land_high) =
            if land.is_empty() { (0.0, 1.0) } else { (quantile(&land, 0.005), quantile(&land, 0.999)) };
        let water = depths(world);
        let river = if world.components.contains("rivers") {
            LINES
        } else {
            water.as_ref().map_or((1.0, 2.0), |w: &Vec<f32>| river_depths(w, &z, sea, world.grid.cell_x_m as f32))
        };
        let rim = (0..width)
            .flat_map(|x| [x, (height - 1) * width + x])
            .chain((0..height).flat_map(|y| [y * width, y * width + width - 1]));
        let rim_land = rim.filter(|&i| z[i] > 0.0).count() as f32 / (2 * (width + height)) as f32;
        let cell = [world.grid.cell_x_m as f32, world.grid.cell_y_m as f32];
        let zero = -datum;
        Ok(Self { width, height, cell, z, sea, land_low, land_high, zero, water, river, rim_land })
    }

    /// Takes the heights and the water of a later state of the same world; what scales colours stays.
    pub(crate) fn follow(&mut self, world: &World) -> Result<()> {
        let field = &world.layer(&known::HEIGHT.name)?.field;
        if (field.width(), field.height()) != (self.width, self.height) {
            return Err(Error::Shape {
                what: format!("the layer `height` of a scene of {}x{} cells", self.width, self.height),
                expected: self.width * self.height,
                found: field.width() * field.height(),
            });
        }
        let (lo, _) = finite_range(field);
        let datum = -self.zero;
        self.z = field.iter().map(|h| if h.is_finite() { h } else { lo } - datum).collect();
        self.water = depths(world);
        Ok(())
    }

    /// Height of the land from its low to its high end, m; never 0.
    pub(crate) fn relief(&self) -> f32 {
        let base = if self.sea { 0.0 } else { self.land_low };
        (self.land_high - base).max(1e-3 * self.cell[0].min(self.cell[1]))
    }

    /// The longer side of the grid, m.
    pub(crate) fn extent(&self) -> f32 {
        (self.width as f32 * self.cell[0]).max(self.height as f32 * self.cell[1])
    }

    /// How much of a river or lake a depth of fresh water makes, 0..1.
    pub(crate) fn river_cover(&self, depth: f32) -> f32 {
        crate::math::smoothstep(self.river.0, self.river.1, depth)
    }
}

/// How much of each cell pictures draw as water, 0..1, row by row from the north-west: 1 in the sea, and of fresh water what stands out from the
/// film that rain leaves.
///
/// # Errors
/// If the world has no layer `height`.
pub fn water_cover(world: &World) -> Result<Vec<f32>> {
    let g = Ground::new(world)?;
    let fresh = |i: usize| g.water.as_ref().map_or(0.0, |w| g.river_cover(w[i]));
    Ok(g.z.iter().enumerate().map(|(i, &z)| if g.sea && z < 0.0 { 1.0 } else { fresh(i) }).collect())
}

/// Depths of fresh water, m.
fn depths(world: &World) -> Option<Vec<f32>> {
    let field = world.get(&known::WATER.name)?;
    Some(field.iter().map(|d| if d.is_finite() { d.max(0.0) } else { 0.0 }).collect())
}

/// A world under rain wears a film of water everywhere. What counts as a river stands out from that film,
/// or is half a metre deep in any case; in cells of many kilometres, whose wetlands are as deep, some metres.
fn river_depths(water: &[f32], z: &[f32], sea: bool, cell_m: f32) -> (f32, f32) {
    let step = (water.len() / 65_536).max(1);
    let on_land: Vec<f32> = (0..water.len()).step_by(step).filter(|&i| !sea || z[i] > 0.0).map(|i| water[i]).collect();
    if on_land.is_empty() {
        return (1.0, 2.0);
    }
    let (usual, deep) = (quantile(&on_land, 0.9), quantile(&on_land, 0.999));
    let from = (1.5 * usual).max(0.06 * deep).clamp(1e-4, 0.5f32.max(cell_m / 10_000.0));
    (from, (3.0 * from).max(0.25 * deep).min(8.0 * from))
}

/// Smallest and largest finite value; (0, 0) if there is none.
pub(crate) fn finite_range(field: &Field) -> (f32, f32) {
    let (lo, hi) = field
        .iter()
        .filter(|v| v.is_finite())
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if lo <= hi { (lo, hi) } else { (0.0, 0.0) }
}

/// Every so many values, so that statistics of large grids stay cheap.
fn sample(values: &[f32]) -> impl Iterator<Item = f32> + '_ {
    // An odd step does not line up with rows of even length.
    values.iter().copied().step_by((values.len() / 65_536).max(1) | 1)
}

/// The value below which the share `q` of `values` lies. The values are finite and at least one.
pub(crate) fn quantile(values: &[f32], q: f32) -> f32 {
    eyot_core::math::ordered(values, ((values.len() - 1) as f32 * q).round() as usize)
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

/// Mean over a square of `2 radius + 1` cells, borders repeated; two passes of running sums.
pub(crate) fn box_mean(values: &[f32], width: usize, height: usize, radius: usize) -> Vec<f32> {
    let r = radius as isize;
    let norm = 1.0 / (2 * radius + 1) as f32;
    let mut rows = vec![0.0; values.len()];
    rows.par_chunks_mut(width).zip(values.par_chunks(width)).for_each(|(out, row)| {
        let at = |x: isize| row[x.clamp(0, width as isize - 1) as usize];
        let mut sum: f64 = (-r..=r).map(|x| f64::from(at(x))).sum();
        for x in 0..width {
            out[x] = sum as f32 * norm;
            sum += f64::from(at(x as isize + r + 1)) - f64::from(at(x as isize - r));
        }
    });
    // Columns: a band of rows starts from its own full sum, so the bands may run on any thread.
    let mut out = vec![0.0; values.len()];
    out.par_chunks_mut(width * 64).enumerate().for_each(|(band, chunk)| {
        let row = |y: isize| &rows[y.clamp(0, height as isize - 1) as usize * width..][..width];
        let y0 = (band * 64) as isize;
        let mut sum = vec![0.0f64; width];
        (y0 - r..=y0 + r).for_each(|y| sum.iter_mut().zip(row(y)).for_each(|(s, v)| *s += f64::from(*v)));
        for (k, line) in chunk.chunks_mut(width).enumerate() {
            let y = y0 + k as isize;
            line.iter_mut().zip(&sum).for_each(|(o, s)| *o = *s as f32 * norm);
            sum.iter_mut()
                .zip(row(y + r + 1))
                .zip(row(y - r))
                .for_each(|((s, a), b)| *s += f64::from(*a) - f64::from(*b));
        }
    });
    out
}
