//! Where a world has open water, and how high its surface lies: the sea, lakes, rivers.

use eyot_core::{Control, Field, Result, World};
use eyot_drainage::{Base, Neighbours, fill, outlets};
use eyot_mesh::OpenWater;
use eyot_render::water_cover;

/// Bytes that [`open_water`] takes for each cell beside the world.
pub(crate) const BYTES_PER_CELL: u128 = 29 + 24;
/// Share of a cell that must look like water for it to count as such.
const OPEN: f32 = 0.5;
/// Water that lies at most so far from the middle level of the water in its hollow stands, m. Waves of a simulation are lower, rapids higher.
const STILL_M: f32 = 0.25;
/// Less water at the shore of a lake is a film, m.
const SHALLOW_M: f32 = 0.02;
/// A puddle in fewer cells is no lake.
const LAKE_CELLS: usize = 4;

/// The open water that pictures show, or `None` if there is none.
///
/// The sea lies at its level. A lake lies in a hollow of the ground, as filling finds them: what stands there gets the median of its
/// surfaces, so that it is level to the bit. All other fresh water is as high as ground and water say.
pub(crate) fn open_water(world: &World, control: &Control<'_>) -> Result<Option<OpenWater>> {
    let height = &world.layer("height")?.field;
    let cover = water_cover(world)?;
    if cover.iter().all(|&c| c < OPEN) {
        return Ok(None);
    }
    let sea = world.sea_level_m as f32;
    let bed: Vec<f32> = height.to_vec();
    let fresh = world.get("water").map(Field::to_vec);
    let surface = |i: usize| if bed[i] < sea { sea } else { bed[i] + fresh.as_ref().map_or(0.0, |w| w[i]) };
    let mut level: Vec<f32> =
        cover.iter().enumerate().map(|(i, &c)| if c < OPEN { f32::NAN } else { surface(i) }).collect();
    let mut standing: Vec<bool> = bed.iter().zip(&level).map(|(&z, l)| l.is_finite() && z < sea).collect();
    if fresh.is_some() && bed.iter().all(|z| z.is_finite()) {
        let base = Base { closed_rims: true, sea_level_m: Some(world.sea_level_m), mask: None };
        let outlets = outlets(&bed, &world.grid, &base)?;
        let mut filled = bed.clone();
        fill(&mut filled, &world.grid, &outlets, control)?;
        for lake in hollows(world, &bed, &filled) {
            let open = lake.iter().filter(|&&i| level[i].is_finite() && bed[i] >= sea);
            let surfaces: Vec<f32> = open.map(|&i| level[i]).collect();
            if surfaces.len() < LAKE_CELLS {
                continue;
            }
            let middle = eyot_core::math::ordered(&surfaces, surfaces.len() / 2);
            // Its shallows, too, which pictures show faintly.
            let still = |i: usize| surface(i) - bed[i] > SHALLOW_M && (surface(i) - middle).abs() <= STILL_M;
            for i in lake.into_iter().filter(|&i| bed[i] >= sea && still(i)) {
                (level[i], standing[i]) = (middle, true);
            }
        }
    }
    Ok(Some(OpenWater { level, standing }))
}

/// The cells of each hollow that filling raised to one level.
fn hollows(world: &World, bed: &[f32], filled: &[f32]) -> Vec<Vec<usize>> {
    let neighbours = Neighbours::new(&world.grid);
    let mut seen = vec![false; bed.len()];
    let mut all = Vec::new();
    for start in 0..bed.len() {
        if seen[start] || filled[start] <= bed[start] {
            continue;
        }
        seen[start] = true;
        let mut cells = vec![start];
        let mut next = 0;
        while next < cells.len() {
            let i = cells[next];
            next += 1;
            neighbours.each(i, |_, n| {
                if !seen[n] && filled[n] > bed[n] && filled[n] == filled[i] {
                    seen[n] = true;
                    cells.push(n);
                }
            });
        }
        all.push(cells);
    }
    all
}
