//! Plots on which nothing happens but what a test wants.

use eyot_core::Limits;
use eyot_reef::community::{Community, Forcing, Heat, Plot, Site};

/// No larvae, no fragments, no breakage, no disturbances, no turf, no grazing, no feedback.
pub(crate) fn quiet() -> Community {
    let mut c = Community { breakage: 0.0, fragmentation: 0.0, feedback_until: 0, ..Community::default() };
    c.species.iter_mut().for_each(|s| (s.propagules, s.imported_recruits) = (0.0, 0.0));
    c.algae.recruits = 0.0;
    c.turf.growth = 0.0;
    (c.grazing.probability, c.grazing.half_range) = (0.0, 0.0);
    (c.small_disturbances.events, c.large_disturbances.events) = (0.0, 0.0);
    c
}

/// A sea that is never too warm.
pub(crate) fn cool() -> Forcing {
    Forcing::constant(Heat::default())
}

/// A bare plot.
pub(crate) fn bare(community: Community, forcing: Forcing, side: f64, seed: u64) -> Plot {
    Plot::empty(community, Site::flat(side, side), forcing, seed, Limits::default()).unwrap()
}
