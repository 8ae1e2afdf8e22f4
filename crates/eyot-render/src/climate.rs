//! What a climate leaves on the land as maps show it: ice and great rivers.

use crate::ground::box_mean;
use crate::math::{V3, smoothstep};
use eyot_core::World;

const ICE: V3 = [0.800, 0.850, 0.900];

/// Thickness of ice that shows, m, if the world has that layer. A lake that fills a cell's hollow alone is far smaller than the
/// cell, and as white spots such lakes would be all that is seen of a cold plain: ice shows where there is more of it around.
pub(crate) fn ice(world: &World) -> Option<Vec<f32>> {
    let (width, height) = (world.grid.width, world.grid.height);
    let thick: Vec<f32> = world.get("ice")?.iter().map(|d| if d.is_finite() { d.max(0.0) } else { 0.0 }).collect();
    let covers: Vec<f32> = thick.iter().map(|d| cover(*d)).collect();
    let around = box_mean(&covers, width, height, 2);
    Some(thick.iter().zip(around).map(|(d, share)| d.min(ICE_SHOWN) * smoothstep(0.1, 0.4, share)).collect())
}

/// How much of a cell a river fills by its discharge, 0..1, if the world has the layers `flow_x` and `flow_y`.
///
/// Rivers are far narrower than the cells of a planet; as on maps, the great ones are drawn all the same.
pub(crate) fn rivers(world: &World) -> Option<Vec<f32>> {
    let (x, y) = (world.get("flow_x")?, world.get("flow_y")?);
    let (w, h) = (x.width(), x.height());
    let strongest = |cx: usize, cy: usize| {
        let west = x.get((cx + w - 1) % w, cy);
        let north = if cy > 0 { y.get(cx, cy - 1) } else { 0.0 };
        [west, x.get(cx, cy), north, y.get(cx, cy)].into_iter().fold(0.0f32, |m, q| m.max(q.abs()))
    };
    let cells = (0..h).flat_map(|cy| (0..w).map(move |cx| (cx, cy)));
    Some(cells.map(|(cx, cy)| smoothstep(RIVER_M3S.0, RIVER_M3S.1, strongest(cx, cy))).collect())
}

/// Discharges at which a river begins and ends to show: that of the Rhone at Lyons, and that of the Danube.
const RIVER_M3S: (f32, f32) = (1000.0, 6500.0);

/// Thickness from which ice covers a place, m; more of it looks the same.
const ICE_SHOWN: f32 = 0.9;

/// How much of a place ice of this thickness covers, 0..1.
pub(crate) fn cover(thickness: f32) -> f32 {
    smoothstep(0.05, ICE_SHOWN, thickness)
}

/// Colour of ice.
pub(crate) const fn ice_colour() -> V3 {
    ICE
}
