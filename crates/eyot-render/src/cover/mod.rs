//! What covers the ground: one classification, from which pictures, masks, splat maps and materials of meshes come.
//!
//! [`Cover`] gives every cell a share of each [`Class`]: sea floor and reef, beaches, grass and forest, scree, rock and snow. The shares of
//! a cell sum to 1. They follow from the height above the sea, slope, the side of a slope, hollows and ridges, and, where a world has them, wetness, trees, bushes, grass,
//! limestone, aridity, temperature, rain and ice (`classify.rs`). Every border between two classes wanders with a low noise, because in nature
//! no ground ends at a contour line. [`Looks`] are the choices: a palette with its snow line and tree line, a season, beaches, the slope of rock.
//!
//! A cell's shares depend on the cells up to [`HALO`] rows away and on nothing else of the world, so that they can be made while a world is
//! streamed, and are the same in a window and in the whole.

mod classify;
mod colour;
mod looks;
mod palette;
mod strip;

pub use looks::{Looks, Palette, Season};
pub use strip::{HALO, LAYERS, Strip};

use crate::ground::Ground;
use crate::math::V3;
use eyot_core::World;
use palette::Tints;
use rayon::prelude::*;

/// What a piece of ground is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
#[non_exhaustive]
pub enum Class {
    /// Mud and ooze of the deep sea floor.
    DeepSea,
    /// Sand of the shallow sea floor.
    SeaFloor,
    /// Sea grass and weed.
    Weed,
    /// Corals and reef flat.
    Reef,
    /// Sand that waves keep wet.
    WetSand,
    /// Dry sand of beaches, islets and dunes.
    Sand,
    /// Mud and wetland.
    Mud,
    /// Green grass.
    Grass,
    /// Dry grass, turf of ridges and heights.
    DryGrass,
    /// Bushes and heath.
    Shrub,
    /// Trees; on low tropical islets, palms.
    Forest,
    /// Gravel of river beds.
    Gravel,
    /// Loose stones below cliffs and on heights.
    Scree,
    /// Bare rock.
    Rock,
    /// Bare soil.
    Soil,
    /// Snow and ice.
    Snow,
}

impl Class {
    /// All classes in the order of their shares.
    pub const ALL: [Self; 16] = [
        Self::DeepSea,
        Self::SeaFloor,
        Self::Weed,
        Self::Reef,
        Self::WetSand,
        Self::Sand,
        Self::Mud,
        Self::Grass,
        Self::DryGrass,
        Self::Shrub,
        Self::Forest,
        Self::Gravel,
        Self::Scree,
        Self::Rock,
        Self::Soil,
        Self::Snow,
    ];

    /// The class's name in recipes and files.
    pub fn name(self) -> &'static str {
        [
            "deep_sea",
            "sea_floor",
            "weed",
            "reef",
            "wet_sand",
            "beach",
            "mud",
            "lush_grass",
            "dry_grass",
            "shrub",
            "forest",
            "gravel",
            "scree",
            "bare_rock",
            "soil",
            "snow_cover",
        ][self as usize]
    }

    /// Which of the four materials of splat maps it belongs to: 0 grass, 1 rock, 2 sand, 3 snow.
    pub fn material(self) -> usize {
        match self {
            Self::Mud | Self::Grass | Self::DryGrass | Self::Shrub | Self::Forest => 0,
            Self::Gravel | Self::Scree | Self::Rock => 1,
            Self::DeepSea | Self::SeaFloor | Self::Weed | Self::Reef | Self::WetSand | Self::Sand | Self::Soil => 2,
            Self::Snow => 3,
        }
    }
}

/// The share of each class in a cell, 0..1, in the order of [`Class::ALL`]; they sum to 1.
pub type Weights = [f32; Class::ALL.len()];

/// The shares of grass, rock, sand and snow in a cell with these classes.
pub fn materials(weights: &Weights) -> [f32; 4] {
    let mut out = [0.0; 4];
    for (class, w) in Class::ALL.into_iter().zip(weights) {
        out[class.material()] += w;
    }
    out
}

/// The classification of one world.
pub struct Cover {
    /// East-west and north-south size of a cell, m.
    cell: [f32; 2],
    /// Height of the sea or, without one, of the world's zero, m.
    datum: f32,
    sea: bool,
    /// Stands for heights that are no numbers, m.
    low: f32,
    seed: u32,
    tints: Tints,
    looks: Looks,
    /// Strength of the noise.
    variation: f32,
}

impl Cover {
    /// For a world with cells of `cell_m` (east-west, north-south, m) whose lowest height is `low_m`, with the sea's level in m.
    pub fn new(cell_m: [f64; 2], low_m: f32, sea_level_m: f64, seed: u64, looks: &Looks) -> Self {
        let level = sea_level_m as f32;
        let sea = low_m < level && level.is_finite();
        Self {
            cell: cell_m.map(|c| c as f32),
            datum: if sea { level } else { 0.0 },
            sea,
            low: low_m,
            seed: seed as u32,
            tints: Tints::of(looks),
            looks: looks.clone(),
            variation: 1.0,
        }
    }

    /// The same with noise of another strength; 1 is natural, 0 even.
    pub(crate) fn varied(mut self, variation: f32) -> Self {
        self.variation = variation;
        self
    }

    /// Shares of the classes in the cell of a column and of a row of the world. The strip must hold [`HALO`] rows around it, where the world has them.
    pub fn weights(&self, strip: &Strip, x: usize, y: usize) -> Weights {
        self.classified(&self.site(strip, x, y))
    }

    /// Linear RGB albedo of a cell; see [`Cover::weights`].
    pub fn colour(&self, strip: &Strip, x: usize, y: usize) -> V3 {
        let site = self.site(strip, x, y);
        self.coloured(&site, &self.classified(&site))
    }
}

/// Linear RGB albedo of every cell of a world, row by row from the north-west, by the layers of [`LAYERS`] that it has.
///
/// # Errors
/// If the world has no layer `height`.
pub fn terrain_colours(world: &World, looks: &Looks) -> eyot_core::Result<Vec<V3>> {
    Ok(albedo(world, &Ground::new(world)?, looks, 1.0))
}

/// As [`terrain_colours`]; `variation` scales the noise.
pub(crate) fn albedo(world: &World, g: &Ground, looks: &Looks, variation: f32) -> Vec<V3> {
    let strip = Strip::whole(world);
    let looks = &looks.resolved(|layer| world.get(layer).is_some()).with_rocks_of(world);
    // Of a scene that follows a world: its own zero, which does not jump when the sea rises over a rim.
    let (datum, sea) = (-g.zero, g.sea);
    let low = datum + g.z.iter().copied().fold(f32::INFINITY, f32::min);
    let cover = Cover {
        datum,
        sea,
        ..Cover::new(g.cell.map(f64::from), low, world.sea_level_m, world.seed, looks).varied(variation)
    };
    let mut out = vec![[0.0; 3]; g.width * g.height];
    out.par_chunks_mut(g.width).enumerate().for_each(|(y, row)| {
        row.iter_mut().enumerate().for_each(|(x, c)| *c = cover.colour(&strip, x, y));
    });
    out
}
