//! Forests and plants in every variant that has rules of its own; shared by the tests of all engines.

use crate::one;
use eyot_core::process::Scheduled;
use eyot_plants::Forest;

/// Name and processes of each.
pub fn variants() -> Vec<(&'static str, Vec<Scheduled>)> {
    vec![("forest", vec![one(Forest { upper: 30.0, fade: 20.0, ..Forest::default() })])]
}

/// A plausible value of a layer from a number within 0..1.
pub fn start(layer: &str, u: f32) -> f32 {
    match layer {
        "height" => 40.0 * u - 4.0,
        "water" | "lake" => (2.0 * u - 1.4).max(0.0),
        "drained_area" => 5e6 * u,
        "grove" => (u + 0.5).floor(),
        _ => u,
    }
}
