//! Every process of the living world, alone and together; shared by the tests of all engines.

use crate::one;
use eyot_climate::wind::Cells;
use eyot_climate::*;
use eyot_core::process::Scheduled;

/// Name and processes of each.
pub fn climate_variants() -> Vec<(&'static str, Vec<Scheduled>)> {
    vec![
        ("wind", vec![one(Wind { wind_speed: 1.0, ..Default::default() })]),
        ("wind of the source", vec![one(Wind { cells: Cells::Source, wind_speed: -1.0, ..Default::default() })]),
        ("temperature", vec![one(Temperature::default())]),
        ("humidity", vec![one(Humidity { land_dry: 2.0, ..Default::default() })]),
        ("water", vec![one(Water { rain: 2.0, evaporate: 2.0, ..Default::default() })]),
        ("ice", vec![one(Ice { flow: 0.2, freeze: 10.0, melt: 10.0, ..Default::default() })]),
        ("weathering", vec![one(Weathering { min_difference: 1.0, max_difference: 9.0, strength: 5.0 })]),
        ("sand", vec![one(Sand { erode: 2.0, slump: 2.0 })]),
        ("climate", vec![one(Climate::default())]),
        ("zones", vec![one(Zones { ice: 0.6, lake: 0.8, river: 0.4 })]),
        ("world", world()),
    ]
}

/// All processes as a recipe has them.
pub fn world() -> Vec<Scheduled> {
    let all = PROCESSES.iter().map(|e| Scheduled {
        name: e.name,
        process: (e.make)((e.defaults)()).unwrap_or_else(|err| panic!("{}: {err}", e.name)),
        every: if e.name == "zones" { 2 } else { 1 },
    });
    all.collect()
}

/// A plausible value of a layer from a number within 0..1.
pub fn climate_start(layer: &str, u: f32) -> f32 {
    match layer {
        "height" => 12.0 * u - 4.0,
        "water" => (2.0 * u - 0.8).max(0.0),
        "sand" | "ice" => (2.0 * u - 1.0).max(0.0),
        "temperature" | "temperature_mean" => 60.0 * u - 30.0,
        "temperature_cos" | "temperature_sin" => 30.0 * u - 15.0,
        "precipitation" | "rain_mean" => 3000.0 * u,
        "rain_cos" | "rain_sin" => 2000.0 * u - 1000.0,
        "wind_x" | "wind_y" => 20.0 * u - 10.0,
        "turbulence" => 4.0 * u - 2.0,
        name if name.starts_with("flow") => u - 0.5,
        _ => u,
    }
}
