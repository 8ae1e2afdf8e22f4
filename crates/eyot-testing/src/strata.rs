//! Strata and what comes down from them, in every variant that has rules of its own; shared by the tests of all engines.

use crate::one;
use eyot_core::process::Scheduled;
use eyot_strata::{Fault, Fold, RockCycle, Rockfall, Soak, Strata, Surfaces};

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
    let new = Strata { top: 10.0, new_rock: true, soil: 0.001, years_per_step: 10.0, ..Strata::default() };
    let uneven = Strata { surfaces: Surfaces::Lower, ..new.clone() };
    let new_rock = new.clone();
    let thick = bent.beds.clone();
    let many: Vec<_> = thick.iter().cycle().take(13).cloned().collect();
    vec![
        ("beds", vec![one(Strata { top: 10.0, regolith: 0.5, ..Strata::default() })]),
        ("bent beds", vec![one(bent.clone())]),
        ("few beds", vec![one(Strata { beds: thick[..3].into(), top: 10.0, ..Strata::default() })]),
        ("new rock", vec![one(new.clone())]),
        ("uneven beds", vec![one(Strata { new_rock: false, ..uneven.clone() })]),
        ("uneven beds under new rock", vec![one(uneven.clone())]),
        (
            "few beds of given height under new rock",
            vec![one(Strata { beds: thick[..4].into(), surfaces: Surfaces::Height, ..new.clone() })],
        ),
        ("few beds under new rock", vec![one(Strata { beds: thick[..4].into(), ..new.clone() })]),
        (
            "rock cycle",
            vec![
                one(new_rock),
                one(RockCycle { years_per_turn: 4.0, wait: 1.0, disturbance: 0.3, ..RockCycle::default() }),
            ],
        ),
        ("many beds", vec![one(Strata { beds: many.clone(), top: 10.0, regolith: 0.5, ..Strata::default() })]),
        ("many beds again and again", vec![one(Strata { beds: many.clone(), ..bent.clone() })]),
        ("many uneven beds under new rock", vec![one(Strata { beds: many.clone(), ..uneven.clone() })]),
        ("beds again and again under new rock", vec![one(Strata { new_rock: true, ..bent.clone() })]),
        ("beds under water", vec![one(Strata { soaked: true, top: 10.0, ..Strata::default() })]),
        ("beds again and again under water", vec![one(Strata { soaked: true, ..bent.clone() })]),
        ("uneven beds and new rock under water", vec![one(Strata { soaked: true, ..uneven.clone() })]),
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
        "soak_water" => 10.0 * u,
        "bed_left" => 20.0 * u,
        "bed_1" | "bed_2" | "bed_3" | "bed_4" => 20.0 * u - 10.0,
        // Half of the slots are empty.
        "new_rock_1" | "new_rock_2" | "new_rock_3" | "new_rock_4" | "new_rock_5" | "new_rock_6" => (u - 0.5).max(0.0),
        "rock_slope" => 3.0 * u,
        "rested_height" => 60.0 * u - 40.0,
        "rested_0" | "rested_1" | "rested_2" | "rested_3" | "rested_4" | "rested_5" => 100.0 * u,
        _ => u,
    }
}
