//! A community of corals.

mod algae;
mod census;
mod colony;
mod competition;
mod disturbance;
mod forcing;
mod geometry;
mod index;
mod parameters;
mod plot;
mod random;
mod settling;
mod site;
mod species;
mod temperature;
mod turf;

pub use census::{Census, Deaths, SpeciesCensus};
pub use colony::{Alga, Colony};
pub use forcing::{CHUMBE, Forcing, Heat, Variability};
pub use geometry::{DIRECTIONS, RAYS, Rays};
pub use parameters::{Algae, Community, Disturbances, Grazing, HeatRules, Stress, Turf};
pub use plot::Plot;
pub use site::{Ground, MAX_SIDE_M, Place, Site};
pub use species::{Form, Species};
pub use temperature::Temperatures;

use eyot_core::math64::pow;

/// Probability that an alga or a cell of turf is grazed in a month: within a range around `middle`, the less the fewer macroalgae
/// there are.
pub fn grazing_probability(rules: &Grazing, middle: f64, algae_cover: f64) -> f32 {
    let half = f64::from(rules.half_range);
    if algae_cover <= 0.0 {
        return 0.0;
    }
    let ratio = f64::from(rules.threshold) / algae_cover;
    let p = 2.0 * half * (1.0 - pow(ratio, f64::from(rules.exponent))) + middle - half;
    p.clamp(0.0, 1.0) as f32
}
