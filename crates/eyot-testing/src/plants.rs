//! Forests and plants in every variant that has rules of its own; shared by the tests of all engines.

use crate::one;
use eyot_climate::Climate;
use eyot_core::process::Scheduled;
use eyot_plants::{ClimateFrom, Forest, Plants};

/// Name and processes of each.
pub fn variants() -> Vec<(&'static str, Vec<Scheduled>)> {
    let few = ["larch", "tropical_raingreen", "mountain_pine", "c4_grass"].map(String::from).into();
    vec![
        ("forest", vec![one(Forest { upper: 30.0, fade: 20.0, ..Forest::default() })]),
        ("plants", vec![one(Plants { temperature: 12.0, fires: 0.9, spread: 2, ..Plants::default() })]),
        (
            "plants of a climate",
            vec![
                one(Climate::default()),
                one(Plants { types: few, climate: ClimateFrom::Layers, hold: 0.0, ..Plants::default() }),
            ],
        ),
    ]
}

/// A plausible value of a layer from a number within 0..1.
pub fn start(layer: &str, u: f32) -> f32 {
    match layer {
        "height" => 40.0 * u - 4.0,
        "plants_ground" => 39.9 * u - 4.0,
        "water" | "lake" => (2.0 * u - 1.4).max(0.0),
        "river" => (2.0 * u - 1.6).max(0.0),
        "drained_area" => 5e6 * u,
        "grove" => (u + 0.5).floor(),
        "temperature" | "temperature_mean" => 40.0 * u - 10.0,
        "temperature_cos" | "temperature_sin" => 20.0 * u - 10.0,
        "precipitation" | "rain_mean" => 3000.0 * u,
        "rain_cos" | "rain_sin" => 2000.0 * u - 1000.0,
        name if name.starts_with("biomass") => (12.0 * u - 2.0).max(0.0),
        name if name.starts_with("stem") => 0.4 * u,
        _ => u,
    }
}
