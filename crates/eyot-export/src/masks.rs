//! Masks for painting the ground that are no shares of materials: where water flows and flowed, what it took and left, and the shore.
//!
//! | Mask | 0 | 1 | From |
//! | --- | --- | --- | --- |
//! | `flow` | only the cell's own rain runs through | all the grid's would | the height: logarithm of the cells that drain through this one over that of all cells |
//! | `wear` | nothing was taken | the value in the list beside | `ground_before`: how far the ground lies below it, m |
//! | `deposit` | nothing was left | the value in the list beside | `ground_before`: how far the ground lies above it, m |
//! | `river` | no fresh water that shows | all covered | `water`: what pictures draw as rivers and lakes |
//! | `wetness` | no running water lately | always | the layer of that name |
//! | `shore` | no beach | all beach | the classes `beach` and `wet_sand` of the ground |
//!
//! As layers in files of numbers, `wear` and `deposit` are metres; in a mask, 1 is what a hundredth of the changed cells exceed.

use crate::below;
use crate::materials::Ground;
use eyot_core::{Control, Result, World};
use eyot_drainage::{Base, Routing, fill, outlets};
use eyot_io::Rows;
use eyot_recipe::{Export, GROUND_BEFORE, MASKS, bed_of_top};
use eyot_render::cover::{Cover, Strip};
use eyot_render::{Class, water_cover};
use rayon::prelude::*;

/// Bytes that a mask takes for each cell while it is made.
pub(crate) const BYTES_PER_CELL: u128 = 48;
/// A mask is full where more was taken or left than in so many of the changed cells.
const FULL_SHARE: f32 = 0.99;

/// A mask with its meaning.
pub(crate) struct Mask {
    /// One sentence.
    pub meaning: &'static str,
    /// `m` or `1`.
    pub unit: &'static str,
    /// One a cell, row by row from the north-west.
    pub values: Vec<f32>,
}

impl Mask {
    /// Lowest and highest value.
    pub(crate) fn range(&self) -> (f32, f32) {
        self.values.iter().fold((f32::MAX, f32::MIN), |(a, b), v| (a.min(*v), b.max(*v)))
    }

    /// What 1 stands for in the mask; 1 for those that are shares.
    pub(crate) fn full(&self) -> f32 {
        let changed: Vec<f32> = self.values.iter().copied().filter(|v| *v > 0.0).collect();
        match self.unit {
            "m" if !changed.is_empty() => {
                eyot_core::math::ordered(&changed, ((changed.len() - 1) as f32 * FULL_SHARE) as usize)
            }
            _ => 1.0,
        }
    }

    /// As shares from 0 to 1.
    pub(crate) fn shares(mut self) -> Self {
        let full = self.full();
        self.values.iter_mut().for_each(|v| *v = (*v / full).clamp(0.0, 1.0));
        self
    }
}

/// The mask of this name; `None` if there is no such mask, or the world lacks the layer that it needs.
///
/// # Errors
/// If the world has no height, or one that is not finite.
pub(crate) fn of(world: &World, name: &str, ground: &Ground<'_>) -> Result<Option<Mask>> {
    let share = |meaning, values| Some(Mask { meaning, unit: "1", values });
    let metres = |meaning, sign: f32| {
        let (before, now) = (world.get(GROUND_BEFORE)?, world.get("height")?);
        let values = before.iter().zip(now.iter()).map(|(b, n)| (sign * (n - b)).max(0.0)).collect();
        Some(Mask { meaning, unit: "m", values })
    };
    Ok(match name {
        "flow" => share("How much of the grid drains through the cell, by its logarithm", flow(world)?),
        "wear" => metres("Ground that was taken since `ground_before`", -1.0),
        "deposit" => metres("Ground that was left since `ground_before`", 1.0),
        "river" if world.get("water").is_some() => {
            let sea = world.sea_level_m as f32;
            let height = &world.layer("height")?.field;
            let cover = water_cover(world)?.into_iter().zip(height.iter());
            let fresh = cover.map(|(c, z)| if z < sea { 0.0 } else { c }).collect();
            share("Share of the cell that pictures draw as a river or a lake", fresh)
        }
        "shore" => share("Share of the ground that is beach", shore(world, ground)?),
        _ => None,
    })
}

/// How a recipe gets this mask, if the world lacks the layer for it.
pub(crate) fn missing(world: &World, mask: &str) -> Option<String> {
    let lacks = |layer: &str| world.get(layer).is_none();
    match mask {
        "wetness" if lacks("wetness") => Some("let a step simulate \"wetness\"".to_owned()),
        "river" if lacks("water") => Some("no step leaves a layer `water`, as \"hydraulic\" does".to_owned()),
        "wear" | "deposit" if lacks(GROUND_BEFORE) => Some(format!(
            "it compares the ground with that before the erosion; keep that with [[layer]] name = \"{GROUND_BEFORE}\", unit = \"m\", start = \"height\", \
             next = \"{GROUND_BEFORE}\", and name \"{GROUND_BEFORE}\" in the `simulate` of the step that erodes"
        )),
        name if bed_of_top(name).is_some() && !matches!(below::top(world, name), Ok(Some(_))) => {
            Some("no step with `strata` has such a bed".to_owned())
        }
        _ => None,
    }
}

/// What of a preset's masks is not written, and how to get it, files with one remedy together.
pub(crate) fn all_missing(world: &World, export: &Export) -> Vec<String> {
    let mut told: Vec<(String, String)> = Vec::new();
    for mask in MASKS {
        let Some(remedy) = missing(world, mask) else { continue };
        let file = format!("`{}`", export.mask_file(mask));
        match told.iter_mut().find(|(_, r)| *r == remedy) {
            Some((files, _)) => *files += &format!(", {file}"),
            None => told.push((file, remedy)),
        }
    }
    told.into_iter().map(|(files, remedy)| format!("not written: {files}: {remedy}")).collect()
}

fn flow(world: &World) -> Result<Vec<f32>> {
    let mut height = world.layer("height")?.field.to_vec();
    let sea = world.sea_level_m as f32;
    let land: Vec<bool> = height.iter().map(|z| *z > sea).collect();
    let base = Base { closed_rims: true, sea_level_m: Some(world.sea_level_m), mask: None };
    let (grid, control) = (&world.grid, Control::none());
    let outlets = outlets(&height, grid, &base)?;
    fill(&mut height, grid, &outlets, &control)?;
    let cells = Routing::new(&height, grid, &outlets, &control)?.upstream_cells();
    let all = (grid.cells().max(2) as f32).ln();
    Ok(cells.iter().zip(land).map(|(&n, land)| if land { (n as f32).ln() / all } else { 0.0 }).collect())
}

fn shore(world: &World, ground: &Ground<'_>) -> Result<Vec<f32>> {
    let g = &world.grid;
    let (low, _) = world.layer("height")?.field.min_max();
    let looks = ground.looks.resolved(|name| world.get(name).is_some());
    let cover = Cover::new([g.cell_x_m, g.cell_y_m], low, world.sea_level_m, world.seed, &looks);
    let strip = Strip::whole(world);
    let mut out = vec![0.0; g.cells()];
    out.par_chunks_mut(g.width).enumerate().for_each(|(y, row)| {
        for (x, share) in row.iter_mut().enumerate() {
            let w = cover.weights(&strip, x, y);
            *share = w[Class::WetSand as usize] + w[Class::Sand as usize];
        }
    });
    Ok(out)
}

/// The rows of a mask.
pub(crate) struct Whole {
    pub size: (usize, usize),
    pub values: Vec<f32>,
}

impl Rows for Whole {
    fn size(&self) -> (usize, usize) {
        self.size
    }

    fn read(&mut self, first: usize, out: &mut [f32]) -> Result<()> {
        let from = first * self.size.0;
        out.copy_from_slice(&self.values[from..from + out.len()]);
        Ok(())
    }
}

/// The layers of a world that masks follow from, beside those of the ground.
pub(crate) fn layers(world: &World) -> Vec<&'static str> {
    ["water", GROUND_BEFORE].into_iter().filter(|l| world.get(l).is_some()).collect()
}

/// Masks that there may be in a preset whose world has the layers for them.
pub(crate) fn all() -> impl Iterator<Item = &'static str> {
    MASKS.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::layer::known;
    use eyot_core::{Boundary, Field, Grid, LayerSpec, Limits};
    use eyot_render::{Looks, ReliefOptions, relief};

    /// A coast with a valley whose river runs down to it.
    fn coast() -> World {
        let (w, h) = (120, 80);
        let mut world = World::new(Grid::new(w, h, 10.0, Boundary::CLOSED, &Limits::default()).unwrap(), 5);
        let height = |x: usize, y: usize| 1.1 * (x as f32 - 30.0) + 2.0 * (y as f32 - 40.0).abs();
        world.put(&known::HEIGHT, Field::from_fn(w, h, height)).unwrap();
        let before = LayerSpec::new(GROUND_BEFORE, "m", "", (-12000.0, 12000.0));
        let dug = |x: usize, y: usize| {
            height(x, y)
                + if y == 40 {
                    4.0
                } else if y < 20 {
                    -1.5
                } else {
                    0.0
                }
        };
        world.put(&before, Field::from_fn(w, h, dug)).unwrap();
        let water = |x: usize, y: usize| if (39..=41).contains(&y) && x > 30 { 2.0 } else { 0.001 };
        world.put(&known::WATER, Field::from_fn(w, h, water)).unwrap();
        world
    }

    fn mask(world: &World, name: &str) -> Mask {
        let ground = Ground::new(world, Looks::default());
        of(world, name, &ground).unwrap().unwrap()
    }

    #[test]
    fn masks_are_what_they_say() {
        let world = coast();
        let at = |m: &Mask, x: usize, y: usize| m.values[y * 120 + x];
        let (wear, deposit) = (mask(&world, "wear"), mask(&world, "deposit"));
        assert!((at(&wear, 60, 40) - 4.0).abs() < 1e-4 && at(&wear, 60, 50) == 0.0 && wear.unit == "m");
        assert!((at(&deposit, 60, 10) - 1.5).abs() < 1e-4 && at(&deposit, 60, 40) == 0.0);
        assert!((wear.full() - 4.0).abs() < 1e-4);
        assert!((at(&wear.shares(), 60, 40) - 1.0).abs() < 1e-4);
        let flow = mask(&world, "flow");
        // The mouth drains most of the land, a crest nothing but itself; the sea is no land.
        assert!(at(&flow, 31, 40) > 0.8 && at(&flow, 119, 0) < 0.01 && at(&flow, 5, 40) == 0.0);
        assert!(flow.range().0 >= 0.0 && flow.range().1 <= 1.0);
        let shore = mask(&world, "shore");
        assert!(at(&shore, 30, 40) > 0.5 && at(&shore, 100, 40) < 0.01 && at(&shore, 2, 40) < 0.01);
    }

    /// Where the mask says river the picture changes with the water, and nowhere else.
    #[test]
    fn rivers_of_masks_are_those_of_pictures() {
        let world = coast();
        let river = mask(&world, "river");
        let mut dry = coast();
        dry.put(&known::WATER, Field::new(120, 80, 0.0)).unwrap();
        let options = ReliefOptions { size: Some(120), ..ReliefOptions::default() };
        let [wet, dry] = [&world, &dry].map(|w| relief(w, &options).unwrap());
        let mut seen = [0, 0];
        for (i, share) in river.values.iter().enumerate() {
            let differ = (0..3).map(|k| wet.pixels[i][k].abs_diff(dry.pixels[i][k])).max().unwrap_or(0);
            // Shores are drawn smooth, over some cells.
            let near = (i / 120).abs_diff(40) < 6 && i % 120 > 25;
            if *share > 0.9 {
                seen[0] += usize::from(differ > 10);
            } else if !near {
                assert_eq!((*share, differ), (0.0, 0), "cell {i}");
                seen[1] += 1;
            }
        }
        assert!(seen[0] > 200 && seen[1] > 5000, "{seen:?}");
    }

    #[test]
    fn what_is_missing_is_said_with_what_to_do() {
        let mut world = World::new(Grid::new(9, 9, 10.0, Boundary::CLOSED, &Limits::default()).unwrap(), 5);
        world.put(&known::HEIGHT, Field::new(9, 9, 3.0)).unwrap();
        let export = Export { preset: Some(eyot_recipe::Preset::Godot), ..Export::default() };
        let told = all_missing(&world, &export).join("\n");
        for word in
            ["godot_wetness.png", "simulate \"wetness\"", "godot_river.png", "godot_wear.png", "start = \"height\""]
        {
            assert!(told.contains(word), "{word}: {told}");
        }
        assert!(of(&world, "wear", &Ground::new(&world, Looks::default())).unwrap().is_none());
        assert_eq!(all_missing(&coast(), &export).len(), 1);
    }
}
