//! Reliefs: the world from above, drawn as a map maker would.

use crate::climate;
use crate::cover::{Looks, albedo};
use crate::ground::{Ground, quantile};
use crate::hillshade::{Hillshade, automatic_exaggeration};
use crate::light::{Sun, sky_share, sunlight};
use crate::math::{V3, lerp, mix, scale};
use crate::picture::{Picture, quantise, tone_map};
use crate::resample::Raster;
use crate::streams::{Frame, Streams};
use crate::surface::{Refinement, Surface, b_spline};
use crate::view::finite;
use crate::water::Water;
use eyot_core::{Control, Result, World};
use rayon::prelude::*;

/// How a relief is drawn. Angles in degrees, bearings clockwise from north.
#[derive(Clone, Debug, PartialEq)]
pub struct ReliefOptions {
    /// Grids with a longer side above this are averaged down to it, pixels.
    pub max_size: usize,
    /// Grids with a longer side below this are drawn with several pixels a cell, pixels.
    pub min_size: usize,
    /// Pixels of the longer side, instead of the two bounds; pixels are then between cells where whole factors do not fit.
    pub size: Option<usize>,
    /// With a `size`, both sides are whole pairs of pixels, as videos want them.
    pub even: bool,
    /// Bearing of the light. Maps are lit from the north-west by custom.
    pub sun_azimuth_deg: f32,
    /// Height of the light over the horizon, 1 to 89.
    pub sun_elevation_deg: f32,
    /// Factor on heights for shading. `None` fits it to the slopes at hand.
    pub vertical_exaggeration: Option<f32>,
    /// Strength of cast shadows, 0 to 1.
    pub shadows: f32,
    /// Strength of the natural variation of colours; 0 draws even tints.
    pub variation: f32,
    /// Colours of the ground.
    pub looks: Looks,
    /// Draw the sea.
    pub sea: bool,
    /// Depth at which the sea's bottom is all but lost, m. `None` as in perspective views.
    pub sea_clarity_m: Option<f32>,
    /// Depth at which the sea's tint is darkest, m. `None` takes the deepest place.
    pub deepest_m: Option<f32>,
    /// Draw rivers and lakes of the layer `water`.
    pub fresh_water: bool,
}

impl Default for ReliefOptions {
    fn default() -> Self {
        Self {
            max_size: 2048,
            min_size: 512,
            size: None,
            even: false,
            sun_azimuth_deg: 315.0,
            sun_elevation_deg: 42.0,
            vertical_exaggeration: None,
            shadows: 0.45,
            variation: 1.0,
            looks: Looks::default(),
            sea: true,
            sea_clarity_m: None,
            deepest_m: None,
            fresh_water: true,
        }
    }
}

/// The world from above, north up. See [`ReliefOptions`].
///
/// # Errors
/// If the world has no layer `height`.
pub fn relief(world: &World, o: &ReliefOptions) -> Result<Picture> {
    relief_controlled(world, o, &Control::none())
}

/// As [`relief`]; can be stopped.
///
/// # Errors
/// As [`relief`], and on a request to stop.
pub fn relief_controlled(world: &World, o: &ReliefOptions, control: &Control<'_>) -> Result<Picture> {
    let ground = Ground::new(world)?;
    control.check()?;
    let raster = o.raster(ground.width, ground.height);
    let clarity = crate::stage::clarity(o.sea_clarity_m, &ground);
    let sea_water = Water::sea(clarity);
    let fresh_water = Water::fresh(2.0 * ground.river.1);
    let sea = ground.sea && o.sea;

    let colours = albedo(world, &ground, &o.looks, finite(o.variation, 1.0).clamp(0.0, 4.0));
    control.check()?;
    let channels: [Vec<f32>; 3] =
        std::array::from_fn(|k| raster.map(&colours.iter().map(|c| c[k]).collect::<Vec<_>>()));
    let z = raster.map(&ground.z);
    let streams = Streams::of(world).filter(|_| o.fresh_water);
    let water = match &streams {
        Some(_) => None,
        None => ground.water.as_ref().filter(|_| o.fresh_water).map(|w| raster.map(w)),
    };
    let ice = climate::ice(world).map(|ice| raster.map(&ice));
    let rivers = climate::rivers(world).filter(|_| o.fresh_water).map(|q| raster.map(&q));
    let (w, h) = (raster.width, raster.height);
    let cell = raster.pixel_m(&ground);

    let lines = streams.map(|s| {
        let step_m = raster.pixel_m(&ground);
        let frame = Frame { points: [w, h], first_m: step_m.map(|s| 0.5 * s), step_m };
        (s.cover(&frame), s.levels(&frame))
    });

    let exaggeration =
        o.vertical_exaggeration.map_or_else(|| automatic_exaggeration(&ground), |x| finite(x, 1.0).clamp(0.0, 1e3));
    let azimuth = finite(o.sun_azimuth_deg, 315.0);
    let elevation = finite(o.sun_elevation_deg, 42.0).clamp(1.0, 89.0);
    let shade = Hillshade::new(azimuth, elevation, exaggeration);
    control.check()?;
    let (sun, open) = cast(&z, [w, h], cell, sea, azimuth, elevation, exaggeration);
    let shadows = finite(o.shadows, 0.45).clamp(0.0, 1.0);
    // Deep water: the tint goes on falling from the end of sight to the deepest place.
    let deepest = o.deepest_m.map_or_else(|| deepest(&ground), |d| finite(d, 0.0)).max(2.0 * clarity);

    let mut pixels = vec![[0u8; 3]; w * h];
    pixels.par_chunks_mut(w).enumerate().try_for_each(|(y, row)| {
        control.check()?;
        for (x, out) in row.iter_mut().enumerate() {
            let i = y * w + x;
            let slope = crate::hillshade::gradient(&z, w, h, cell, x, y);
            let ground_colour: V3 = std::array::from_fn(|k| channels[k][i].max(0.0));
            let lit = lerp(1.0, sun[i], shadows) * lerp(0.55, 1.0, open[i]);
            let light = 2.9 * shade.at(slope) * lit;
            let mut c = scale(ground_colour, light);
            if let Some(d) = water.as_ref().map(|v| v[i])
                && ground.river_cover(d) > 0.0
            {
                let body = scale(fresh_water.upwelling(ground_colour, d, 2.2), 2.9 * lerp(1.0, sun[i], 0.5 * shadows));
                c = mix(c, [body[0] + 0.008, body[1] + 0.022, body[2] + 0.040], ground.river_cover(d));
            }
            if let Some((cover, levels)) = &lines {
                let lit = 2.9 * lerp(1.0, sun[i], 0.5 * shadows);
                let body = |depth: f32| {
                    let c = scale(fresh_water.upwelling(ground_colour, depth, 2.2), lit);
                    [c[0] + 0.008, c[1] + 0.022, c[2] + 0.040]
                };
                c = mix(c, scale(RIVER, lit), 0.95 * cover[i]);
                if !levels[i].is_nan() {
                    let depth = (levels[i] + ground.zero - z[i]).max(0.0);
                    c = mix(c, body(depth.max(0.4)), 1.0);
                }
            }
            if let Some(river) = rivers.as_ref().map(|v| v[i]).filter(|v| *v > 0.0) {
                c = mix(c, [0.030, 0.105, 0.190], 0.85 * river);
            }
            if sea {
                // The share of the pixel that the shore leaves to the sea.
                let run = (slope[0].abs() * cell[0] + slope[1].abs() * cell[1]).max(1e-6);
                let wet = (0.5 - z[i] / run).clamp(0.0, 1.0);
                if wet > 0.0 {
                    let depth = (-z[i]).max(0.0);
                    let below = sea_tint(&sea_water, ground_colour, depth, depth / deepest);
                    let bed = lerp(1.0, shade.at(slope) / shade.level(), 0.55 * (-0.35 * depth / clarity).exp() + 0.20);
                    c = mix(c, scale(below, bed * lerp(1.0, sun[i], 0.5 * shadows)), wet);
                }
            }
            if let Some(thick) = ice.as_ref().map(|v| v[i]).filter(|v| *v > 0.0) {
                // The sea's bed does not shade what floats on it.
                let slope = if sea && z[i] < 0.0 { [0.0; 2] } else { slope };
                let lit = 2.9 * shade.at(slope) * lerp(1.0, sun[i], shadows);
                c = mix(c, scale(climate::ice_colour(), lit), climate::cover(thick));
            }
            *out = quantise(tone_map(scale(c, 0.76)), x, y);
        }
        Ok(())
    })?;
    let picture = Picture { width: w, height: h, pixels }.square(cell);
    Ok(match o.size {
        Some(n) => picture.with_longer_side(n.clamp(1, 16384), o.even),
        None => picture,
    })
}

/// Rivers as maps draw them: the sky that they mirror.
const RIVER: V3 = [0.030, 0.105, 0.190];

/// Depth of the deepest place, m.
fn deepest(ground: &Ground) -> f32 {
    -quantile(&ground.z, 0.0)
}

impl ReliefOptions {
    /// These options with this world's own numbers for what they leave open, so that reliefs of other states of it have the same scale: the
    /// pictures of a film do not flicker.
    ///
    /// # Errors
    /// If the world has no layer `height`.
    pub fn scaled_to(self, world: &World) -> Result<Self> {
        let ground = Ground::new(world)?;
        let exaggeration = self.vertical_exaggeration.unwrap_or_else(|| automatic_exaggeration(&ground));
        Ok(Self {
            vertical_exaggeration: Some(exaggeration),
            sea_clarity_m: Some(crate::stage::clarity(self.sea_clarity_m, &ground)),
            deepest_m: Some(self.deepest_m.unwrap_or_else(|| deepest(&ground))),
            ..self
        })
    }

    /// How cells become pixels, before the picture is brought to its size.
    pub(crate) fn raster(&self, width: usize, height: usize) -> Raster {
        match self.size {
            None => Raster::new(width, height, self.min_size, self.max_size),
            Some(n) => Raster::around(width, height, n),
        }
    }
}

/// Colour of the sea from above: the bottom while it can be seen, then tints by depth.
fn sea_tint(water: &Water, floor: V3, depth: f32, in_deepest: f32) -> V3 {
    let seen = scale(water.upwelling(floor, depth, 2.2), 2.7);
    let tint = mix([0.030, 0.150, 0.270], [0.010, 0.042, 0.105], in_deepest.clamp(0.0, 1.0).powf(0.45));
    mix(seen, tint, water.opacity(depth).powi(2))
}

/// Cast shadows and open sky for every pixel.
fn cast(
    z: &[f32],
    size: [usize; 2],
    cell: [f32; 2],
    sea: bool,
    azimuth: f32,
    elevation: f32,
    exaggeration: f32,
) -> (Vec<f32>, Vec<f32>) {
    let [w, h] = size;
    if w < 2 || h < 2 {
        return (vec![1.0; w * h], vec![1.0; w * h]);
    }
    let as_is = Refinement { cells: size, factor: 1, nodes: size };
    // Slightly smoothed: single cells would cast specks.
    let drawn = as_is.refine(&z.iter().map(|z| z * exaggeration).collect::<Vec<_>>(), b_spline);
    let surface = Surface::with_step(cell, &as_is, drawn);
    let floor = if sea { 0.0 } else { f32::NEG_INFINITY };
    let sun = sunlight(&surface, &Sun::new(&surface, azimuth, elevation), floor);
    let share = sky_share(&surface, floor);
    let mut open = vec![1.0; w * h];
    open.par_chunks_mut(w).enumerate().for_each(|(y, row)| {
        row.iter_mut().enumerate().for_each(|(x, o)| *o = share.at(x as f32, y as f32));
    });
    (sun, open)
}
