//! Grazing, and what the shape of the reef does to it.

use super::census::Census;
use super::parameters::Grazing;
use super::plot::Plot;
use super::random::{Draws, Stream};
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

impl Plot {
    /// True while rugosity feeds back.
    fn feeds_back(&self) -> bool {
        (u64::from(self.community.feedback_from)..u64::from(self.community.feedback_until)).contains(&self.month)
    }

    pub(super) fn feed_back(&mut self, rugosity: f64) {
        if !self.feeds_back() {
            self.calendars.iter_mut().for_each(|c| c.shrunk = 1.0);
        } else if self.month % 12 == 11 {
            for kind in 0..2 {
                let rules = self.disturbances(kind).clone();
                self.calendars[kind].feed_back(&rules, rugosity);
            }
        }
    }

    /// Grazers take algae and turf; returns the probability for each.
    pub(super) fn graze(&mut self, census: &Census) -> f32 {
        let rules = &self.community.grazing;
        let middle = if self.feeds_back() {
            let share = (census.rugosity - 1.0) / (f64::from(rules.max_rugosity) - 1.0);
            f64::from(rules.probability) * share.clamp(0.0, 1.0)
        } else {
            f64::from(rules.probability)
        };
        let probability = grazing_probability(rules, middle, census.algae_cover);
        let draws = Draws::new(self.seed, Stream::Grazing, self.month);
        self.algae.retain(|a| !draws.chance(a.id, probability));
        let draws = Draws::new(self.seed, Stream::TurfGrazing, self.month);
        self.turf.graze(&self.community.turf, probability, draws);
        probability
    }
}
