//! Events that clear a disc of the plot.

use super::parameters::{Community, Disturbances, bad};
use super::plot::Plot;
use super::random::{Draws, Stream};
use super::settling::COMPAT_BIAS_M;
use super::site::Site;
use eyot_core::{Control, Result};

/// Side of the plot for which [`Disturbances::events`] are meant, m.
const REFERENCE_SIDE_M: f64 = 40.0;

/// When the next events of a kind come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Calendar {
    /// Date of the next ones, months, kept as a fraction so that rounding does not change the mean interval.
    pub(super) next: f64,
    /// What the feedback of rugosity has made of the interval.
    pub(super) shrunk: f64,
}

impl Calendar {
    pub(super) fn new(rules: &Disturbances, draws: Draws) -> Self {
        let mut calendar = Self { next: 0.0, shrunk: 1.0 };
        calendar.advance(rules, draws);
        calendar
    }

    /// Puts down the next date.
    fn advance(&mut self, rules: &Disturbances, draws: Draws) {
        let interval = f64::from(rules.interval) * self.shrunk;
        self.next += (interval * (1.0 + f64::from(rules.spread) * draws.normal(0))).max(1.0);
    }

    /// Once a year, while the feedback is on: a flat reef is disturbed more and more often.
    pub(super) fn feed_back(&mut self, rules: &Disturbances, rugosity: f64) {
        self.shrunk = if rugosity <= f64::from(rules.rugosity) { self.shrunk * f64::from(rules.shrink) } else { 1.0 };
    }
}

/// A disc, m.
#[derive(Clone, Copy, Debug)]
struct Disc {
    x: f32,
    y: f32,
    radius: f32,
}

impl Disc {
    fn new(site: &Site, rules: &Disturbances, compat: bool, draws: Draws, event: u64) -> Self {
        let bias = if compat { COMPAT_BIAS_M } else { 0.0 };
        let [low, high] = [0.5 * rules.min_diameter, 0.5 * rules.max_diameter + bias];
        let radius = low + draws.unit(3 * event) * (high - low);
        // Somewhere on the plot, or so near to it that the disc reaches it.
        let at = |u: f32, side: f64| u * (side as f32 + 2.0 * radius) - radius;
        let (x, y) = (at(draws.unit(3 * event + 1), site.width_m), at(draws.unit(3 * event + 2), site.length_m));
        Self { x, y, radius }
    }

    fn covers(&self, x: f32, y: f32) -> bool {
        let (dx, dy) = (x - self.x, y - self.y);
        dx * dx + dy * dy < self.radius * self.radius
    }
}

impl Plot {
    /// The disturbances of this month.
    pub(super) fn disturb(&mut self, control: &Control<'_>) -> Result<[u32; 2]> {
        let mut counts = [0; 2];
        for kind in 0..2 {
            let rules = self.disturbances(kind).clone();
            let mut date = 0;
            while self.calendars[kind].next < (self.month + 1) as f64 {
                let draws = |what: u64| {
                    Draws::new(self.seed, Stream::Disturbance, (self.month * 64 + date) * 4 + 2 * what + kind as u64)
                };
                let (expected, discs) = (events(&self.community, &self.site, &rules), draws(0));
                let count = (expected + f64::from(draws(1).unit(0))) as u64;
                for event in 0..count {
                    control.check()?;
                    let disc = Disc::new(&self.site, &rules, self.community.compat, discs, event);
                    self.clear(disc, rules.fragments)?;
                }
                counts[kind] += count as u32;
                date += 1;
                let interval = Draws::new(self.seed, Stream::Interval, (self.month * 64 + date) * 2 + kind as u64);
                self.calendars[kind].advance(&rules, interval);
            }
        }
        Ok(counts)
    }

    /// Rules of small (0) and large (1) disturbances.
    pub(super) fn disturbances(&self, kind: usize) -> &Disturbances {
        if kind == 0 { &self.community.small_disturbances } else { &self.community.large_disturbances }
    }

    fn clear(&mut self, disc: Disc, fragments: bool) -> Result<()> {
        let hit: Vec<bool> = self.colonies.iter().map(|c| !disc.covers(c.x, c.y)).collect();
        let victims: Vec<_> = self.colonies.iter().filter(|c| disc.covers(c.x, c.y)).copied().collect();
        self.bury(&hit, |d| &mut d.disturbance);
        self.algae.retain(|a| !disc.covers(a.x, a.y));
        if fragments {
            for victim in victims {
                self.fragment(&victim, 2)?;
            }
        }
        Ok(())
    }
}

/// Finds plots on which a date would have more events than can be worked off.
///
/// # Errors
/// The kind of disturbances.
pub(super) fn check(community: &Community, site: &Site) -> Result<()> {
    const MAX: f64 = 100_000.0;
    for (name, rules) in [("small", &community.small_disturbances), ("large", &community.large_disturbances)] {
        let events = events(community, site, rules);
        if events > MAX {
            let owner = format!("community.{name}_disturbances");
            return Err(bad(&owner, "events", format!("makes {events:.0} events a date here; {MAX} are allowed")));
        }
    }
    Ok(())
}

/// Events of a date: as many for each square metre as on the reference plot, by the area in which centres may lie.
fn events(community: &Community, site: &Site, rules: &Disturbances) -> f64 {
    if community.compat {
        return f64::from(rules.events);
    }
    let rim = f64::from(0.5 * (rules.min_diameter + rules.max_diameter));
    let area = (site.width_m + rim) * (site.length_m + rim);
    f64::from(rules.events) * area / (REFERENCE_SIDE_M + rim).powi(2)
}
