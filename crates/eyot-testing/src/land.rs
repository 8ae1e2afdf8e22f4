//! Every process in every variant that has rules of its own; shared by the tests of all engines.

use crate::one;
use eyot_core::process::Scheduled;
use eyot_land::simulate::hydraulic::{FluxForm, Hydraulic};
use eyot_land::simulate::reef::{Light, Limit, Reef};
use eyot_land::simulate::{Holes, Motu, Seabed, Thermal, Wetness};

/// Name and processes of each.
pub fn variants() -> Vec<(&'static str, Vec<Scheduled>)> {
    // A time step that needs two parts on the suite's cells of 2 x 2.5 m.
    let hydraulic = Hydraulic { time_step: 0.2, rain: 0.01, ..Default::default() };
    let by_rock = Hydraulic { by_rock: true, ..hydraulic.clone() };
    vec![
        ("hydraulic", vec![one(hydraulic.clone())]),
        ("hydraulic signed", vec![one(Hydraulic { flux: FluxForm::Signed, ..hydraulic.clone() })]),
        ("hydraulic classic", vec![one(Hydraulic { flux: FluxForm::Classic, ..hydraulic.clone() })]),
        ("hydraulic by rock", vec![one(by_rock.clone())]),
        ("hydraulic signed by rock", vec![one(Hydraulic { flux: FluxForm::Signed, ..by_rock.clone() })]),
        ("hydraulic classic by rock", vec![one(Hydraulic { flux: FluxForm::Classic, ..by_rock })]),
        ("thermal", vec![one(Thermal::default())]),
        ("thermal inverted", vec![one(Thermal { inverted: true, ..Default::default() })]),
        ("thermal by rock", vec![one(Thermal { by_rock: true, ..Default::default() })]),
        ("thermal inverted by rock", vec![one(Thermal { inverted: true, by_rock: true, ..Default::default() })]),
        ("seabed", vec![one(Seabed::default())]),
        ("seabed by rock", vec![one(Seabed { by_rock: true, ..Default::default() })]),
        ("reef", vec![one(Reef { years_per_step: 1.0, diffusivity: 3.0, sea_level_rise: 0.01, ..Default::default() })]),
        ("reef, plain diffusion", vec![one(Reef { years_per_step: 1.0, diffusivity: 0.5, ..Default::default() })]),
        // So many stages that the engine cuts the step into several chains.
        ("reef, 23 stages", vec![one(Reef { years_per_step: 10.0, diffusivity: 30.0, ..Default::default() })]),
        ("reef in light", vec![one(Reef { limit: Limit::Light, light: Light::Saturating, ..Default::default() })]),
        ("motu", vec![one(Motu { wind: 140.0, open_sea: 3.0, ..Default::default() })]),
        ("wetness", vec![one(Wetness::default())]),
        ("holes", vec![one(hydraulic.clone()), one(Holes::default())]),
        (
            "all",
            vec![
                one(hydraulic),
                one(Thermal::default()),
                Scheduled { name: "wetness", process: Box::new(Wetness::default()), every: 2 },
                Scheduled { name: "seabed", process: Box::new(Seabed::default()), every: 3 },
                one(Reef { years_per_step: 1.0, subsidence: 0.001, ..Default::default() }),
            ],
        ),
    ]
}

/// A plausible value of a layer from a number within 0..1.
pub fn start(layer: &str, u: f32) -> f32 {
    match layer {
        "height" => 12.0 * u - 4.0,
        "water" => (2.0 * u - 0.8).max(0.0),
        "sediment" => 0.1 * u,
        "erodibility" => 3.0 * u - 0.5,
        "limestone" => (2.0 * u - 1.0).max(0.0),
        "reef_floor" => 12.0 * u - 6.0,
        name if name.starts_with("flux") => u - 0.5,
        name if name.starts_with("outflow") => u,
        _ => u,
    }
}
