//! Strata and what comes down from them, in every variant that has rules of its own; shared by the tests of all engines.

use crate::one;
use eyot_core::process::Scheduled;
use eyot_strata::{Fault, Fold, Rockfall, Soak, Strata};

/// Name and processes of each.
pub fn variants() -> Vec<(&'static str, Vec<Scheduled>)> {
    let bent = Strata {
        top: 20.0,
        repeat: true,
        dip: 7.0,
        folds: vec![Fold { wavelength: 11.0, amplitude: 3.0, direction: 30.0, crest: 2.0 }],
        faults: vec![Fault { strike: 20.0, distance: 3.0, throw: -9.0 }],
        soil: 0.001,
        uplift: 0.002,
        years_per_step: 10.0,
        ..Strata::default()
    };
    vec![
        ("beds", vec![one(Strata { top: 10.0, regolith: 0.5, ..Strata::default() })]),
        ("bent beds", vec![one(bent.clone())]),
        ("rockfall", vec![one(Rockfall::default())]),
        ("beds and rockfall", vec![one(bent), one(Rockfall { talus: 20.0, rate: 1.0, ..Rockfall::default() })]),
        ("soak", vec![one(Soak { change: 20.0, slope: 5.0, rate: 0.1, ..Soak::default() })]),
    ]
}

/// A plausible value of a layer from a number within 0..1.
pub fn start(layer: &str, u: f32) -> f32 {
    match layer {
        "height" => 40.0 * u - 10.0,
        "bedrock" => 40.0 * u - 11.0,
        "bed_datum" => 60.0 * u,
        "water" => (20.0 * u - 8.0).max(0.0),
        "soak_depth" => 10.0 * u,
        "bed_left" => 20.0 * u,
        "erodibility" | "erodibility_below" => 2.0 * u,
        "rock_slope" => 3.0 * u,
        _ => u,
    }
}
