//! What one asks about a planet: its ocean, its heights, its climate by latitude, and the shares of its zones.
//!
//! A world's map is flat: every cell counts the same, also near the poles, where those of a sphere would be smaller. [`Globe`] says what
//! comes out if they do not.

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
    /// The same on a globe.
    pub globe: Globe,
}

/// A planet as a globe, whose cells have the cosine of their latitude as weight: to be compared with numbers of the Earth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Globe {
    /// Share of the globe below the level of the sea.
    pub ocean_share: f64,
    /// Share of the globe under more than a metre of ice.
    pub ice_share: f64,
    /// Mean temperature, degrees Celsius.
    pub temperature_c: f64,
    /// Mean precipitation, mm a year.
    pub rain_mm: f64,
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

/// Layers of classes.
const LAYERS: [&str; 4] = ["zone", "holdridge", "humidity_province", "koeppen"];
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
    let flat = vec![1.0; above.len()];
    let zonal = (0..BELTS).filter_map(|belt| {
        let cells = &all[height.width() * (belt * rows / BELTS)..height.width() * ((belt + 1) * rows / BELTS)];
        let on_land: Vec<usize> = cells.iter().copied().filter(land).collect();
        (!cells.is_empty()).then(|| Zonal {
            latitude: 90.0 - 180.0 * (belt as f64 + 0.5) / BELTS as f64,
            land_share: on_land.len() as f64 / cells.len() as f64,
            temperature_c: mean(&warmth, cells, &flat),
            rain_mm: mean(&rain, cells, &flat),
            land_rain_mm: (!on_land.is_empty()).then(|| mean(&rain, &on_land, &flat)),
        })
    });
    let mut sorted = above.clone();
    sorted.sort_unstable_by(f32::total_cmp);
    let place = |percent: usize| f64::from(sorted[(sorted.len() - 1) * percent / 100]);
    let on_land: Vec<usize> = all.iter().copied().filter(land).collect();
    let iced: Vec<f32> = match ice {
        Some(ice) => ice.iter().map(|d| f32::from(u8::from(*d > 1.0))).collect(),
        None => vec![0.0; above.len()],
    };
    let wet: Vec<f32> = above.iter().map(|h| f32::from(u8::from(*h < 0.0))).collect();
    let globe = |weights: &[f64]| Globe {
        ocean_share: mean(&wet, &all, weights),
        ice_share: mean(&iced, &all, weights),
        temperature_c: mean(&warmth, &all, weights),
        rain_mm: mean(&rain, &all, weights),
        zones: LAYERS
            .iter()
            .filter_map(|name| Some(((*name).to_owned(), shares(world, name, &on_land, weights)?)))
            .collect(),
    };
    let row_weight = |y: usize| (std::f64::consts::PI * ((y as f64 + 0.5) / rows as f64 - 0.5)).cos();
    let round: Vec<f64> = all.iter().map(|i| row_weight(i / height.width())).collect();
    let Globe { ocean_share, ice_share, temperature_c, rain_mm, zones } = globe(&flat);
    Some(Planet {
        ocean_share,
        ice_share,
        hypsometry_m: [0, 10, 25, 50, 75, 90, 95, 99, 100].iter().map(|p| (format!("{p:03}"), place(*p))).collect(),
        temperature_c,
        rain_mm,
        zonal: zonal.collect(),
        zones,
        globe: globe(&round),
    })
}

fn mean(values: &[f32], cells: &[usize], weights: &[f64]) -> f64 {
    cells.iter().map(|&i| weights[i] * f64::from(values[i])).sum::<f64>() / sum(cells, weights)
}

fn sum(cells: &[usize], weights: &[f64]) -> f64 {
    cells.iter().map(|&i| weights[i]).sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Share of each class among these cells.
fn shares(world: &World, layer: &str, cells: &[usize], weights: &[f64]) -> Option<BTreeMap<String, f64>> {
    let (classes, numbers) = (classes(layer)?, world.get(layer)?.to_vec());
    let mut found: BTreeMap<String, f64> = BTreeMap::new();
    let whole = sum(cells, weights);
    for &i in cells {
        let class = classes.get(numbers[i].round() as usize)?;
        *found.entry(class.name.to_owned()).or_default() += weights[i] / whole;
    }
    Some(found)
}
