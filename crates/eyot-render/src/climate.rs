//! Colours of the land by its climate: what grows where it is so warm and rains so much, bare ground where nothing
//! does, and ice.

use crate::ground::box_mean;
use crate::math::{V3, mix, scale, smoothstep};
use eyot_core::World;

// Linear albedos, seen from far above.
const TUNDRA: V3 = [0.150, 0.128, 0.088];
const TAIGA: V3 = [0.042, 0.060, 0.030];
const WOODS: V3 = [0.058, 0.088, 0.030];
const JUNGLE: V3 = [0.026, 0.058, 0.018];
const STEPPE: V3 = [0.235, 0.205, 0.100];
const SAVANNAH: V3 = [0.185, 0.170, 0.066];
const HOT_DESERT: V3 = [0.560, 0.390, 0.215];
const COLD_DESERT: V3 = [0.330, 0.275, 0.205];
const BARE: V3 = [0.185, 0.165, 0.140];
const ICE: V3 = [0.800, 0.850, 0.900];

/// Climate and ice of all cells.
pub(crate) struct Climate {
    warmth: Vec<f32>,
    rain: Vec<f32>,
    ice: Option<Vec<f32>>,
}

impl Climate {
    /// The layers that say so; `None` for a world without climate. Means of some years are best; the moment will do.
    pub(crate) fn of(world: &World) -> Option<Self> {
        let (width, height) = (world.grid.width, world.grid.height);
        let either = |a: &str, b: &str| world.get(a).or_else(|| world.get(b)).map(|f| f.to_vec());
        let warmth = either("temperature_mean", "temperature")?;
        let rain = either("rain_mean", "precipitation")?;
        // Land cover does not follow single cells.
        let rain = box_mean(&rain, width, height, 1);
        Some(Self { warmth, rain, ice: ice(world) })
    }

    /// Colour of land in cell `i`; `broad` and `fine` are noises about -0.6..0.6, `steep` a slope of which 1 is steep here.
    pub(crate) fn land(&self, i: usize, broad: f32, fine: f32, steep: f32) -> V3 {
        let t = self.warmth[i] + 2.5 * broad + 1.5 * fine;
        // Rain against what plants could use, as Holdridge has it; a cold country needs little.
        let wet = self.rain[i].max(0.0) / (58.93 * t.clamp(2.0, 30.0)) * (1.0 + 0.35 * broad + 0.25 * fine);
        let desert = mix(COLD_DESERT, HOT_DESERT, smoothstep(8.0, 20.0, t));
        let grass = mix(STEPPE, SAVANNAH, smoothstep(14.0, 24.0, t));
        let forest = mix(mix(TAIGA, WOODS, smoothstep(3.0, 11.0, t)), JUNGLE, smoothstep(17.0, 25.0, t));
        let mut c = mix(desert, grass, smoothstep(0.16, 0.50, wet));
        c = mix(c, forest, smoothstep(0.55, 1.15, wet));
        c = mix(c, TUNDRA, smoothstep(0.5, -4.0, t));
        c = mix(c, BARE, smoothstep(-6.0, -14.0, t));
        c = mix(c, BARE, 0.5 * smoothstep(0.9, 1.6, steep));
        // Where it hardly ever thaws, snow lies that is too thin to be called ice.
        c = mix(c, ICE, 0.9 * smoothstep(-7.0, -13.0, t));
        c = scale(c, 1.0 + 0.12 * fine + 0.10 * broad);
        mix(c, ICE, self.cover(i))
    }

    /// How much of cell `i` ice covers, 0..1.
    pub(crate) fn cover(&self, i: usize) -> f32 {
        self.ice.as_ref().map_or(0.0, |ice| cover(ice[i]))
    }
}

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
