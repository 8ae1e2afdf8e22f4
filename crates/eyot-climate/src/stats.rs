//! What one asks about a planet: its ocean, its heights, its climate by latitude, and the shares of its zones.
//!
//! A world's map is flat: every cell counts the same, also near the poles, where those of a sphere would be smaller.

use crate::zones::classes;
use eyot_core::World;
use eyot_core::layer::known::HEIGHT;
use serde::Serialize;
use std::collections::BTreeMap;

/// Statistics of a planet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Planet {
    /// Share of the cells below the level of the sea.
    pub ocean_share: f64,
    /// Share of the cells under more than a metre of ice.
    pub ice_share: f64,
    /// Heights above the sea, m, that these percentages of the cells do not exceed.
    pub hypsometry_m: BTreeMap<String, f64>,
    /// Mean temperature, degrees Celsius.
    pub temperature_c: f64,
    /// Mean precipitation, mm a year.
    pub rain_mm: f64,
    /// Climate by latitude, from the north.
    pub zonal: Vec<Zonal>,
    /// Share of the land in each class that occurs, for each layer of classes.
    pub zones: BTreeMap<String, BTreeMap<String, f64>>,
}

/// Climate of a belt of fifteen degrees of latitude.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Zonal {
    /// Latitude of its middle, degrees, north positive.
    pub latitude: f64,
    /// Share of land.
    pub land_share: f64,
    /// Mean temperature, degrees Celsius.
    pub temperature_c: f64,
    /// Mean precipitation, mm a year.
    pub rain_mm: f64,
    /// Mean precipitation on land, mm a year; `None` without land.
    pub land_rain_mm: Option<f64>,
}

/// Belts from pole to pole.
const BELTS: usize = 12;

/// Statistics of a world that has heights and a climate; `None` for all others.
pub fn planet(world: &World) -> Option<Planet> {
    let height = world.get(&HEIGHT.name)?;
    let warmth = world.get("temperature_mean").or_else(|| world.get("temperature"))?.to_vec();
    let rain = world.get("rain_mean").or_else(|| world.get("precipitation"))?.to_vec();
    let ice = world.get("ice").map(|f| f.to_vec());
    let above: Vec<f32> = height.iter().map(|h| h - world.sea_level_m as f32).collect();
    let rows = height.height();
    let land = |i: &usize| above[*i] >= 0.0;
    let all: Vec<usize> = (0..above.len()).collect();
    let zonal = (0..BELTS).filter_map(|belt| {
        let cells = &all[height.width() * (belt * rows / BELTS)..height.width() * ((belt + 1) * rows / BELTS)];
        let on_land: Vec<usize> = cells.iter().copied().filter(land).collect();
        (!cells.is_empty()).then(|| Zonal {
            latitude: 90.0 - 180.0 * (belt as f64 + 0.5) / BELTS as f64,
            land_share: on_land.len() as f64 / cells.len() as f64,
            temperature_c: mean(&warmth, cells),
            rain_mm: mean(&rain, cells),
            land_rain_mm: (!on_land.is_empty()).then(|| mean(&rain, &on_land)),
        })
    });
    let mut sorted = above.clone();
    sorted.sort_unstable_by(f32::total_cmp);
    let place = |percent: usize| f64::from(sorted[(sorted.len() - 1) * percent / 100]);
    let on_land: Vec<usize> = all.iter().copied().filter(land).collect();
    let layers = ["zone", "holdridge", "humidity_province", "koeppen"];
    let zones = layers.iter().filter_map(|name| Some(((*name).to_owned(), shares(world, name, &on_land)?)));
    Some(Planet {
        ocean_share: 1.0 - on_land.len() as f64 / all.len() as f64,
        ice_share: ice.map_or(0.0, |ice| ice.iter().filter(|d| **d > 1.0).count() as f64 / all.len() as f64),
        hypsometry_m: [0, 10, 25, 50, 75, 90, 95, 99, 100].iter().map(|p| (format!("{p:03}"), place(*p))).collect(),
        temperature_c: mean(&warmth, &all),
        rain_mm: mean(&rain, &all),
        zonal: zonal.collect(),
        zones: zones.collect(),
    })
}

fn mean(values: &[f32], cells: &[usize]) -> f64 {
    cells.iter().map(|&i| f64::from(values[i])).sum::<f64>() / cells.len().max(1) as f64
}

/// Share of each class among these cells.
fn shares(world: &World, layer: &str, cells: &[usize]) -> Option<BTreeMap<String, f64>> {
    let (classes, numbers) = (classes(layer)?, world.get(layer)?.to_vec());
    let mut found: BTreeMap<String, f64> = BTreeMap::new();
    for &i in cells {
        let class = classes.get(numbers[i].round() as usize)?;
        *found.entry(class.name.to_owned()).or_default() += 1.0 / cells.len() as f64;
    }
    Some(found)
}
