//! Parameters of the community. Values are those of the source's model unless something else is said.

use super::species::Species;
use eyot_core::process::{Parameters, check_ranges};
use eyot_core::{Error, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A community of corals, macroalgae and turf.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Community {
    /// Behave like the original program, oddities included: for comparisons with it.
    pub compat: bool,
    /// The species of corals; at most 256.
    pub species: Vec<Species>,
    /// Factor on the growth of a ray for each neighbour that covers its tip.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub shade: f32,
    /// Further factor if that neighbour is larger.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub shade_of_larger: f32,
    /// A colony dies when its neighbours overlap this share of its disc.
    #[schemars(range(min = 0.01, max = 100.0), extend("unit" = "1"))]
    pub overgrowth: f32,
    /// Probability a month that a branching colony without support breaks, for a surface factor of 1. A neighbour of at least
    /// half its radius supports it.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1/month"))]
    pub breakage: f32,
    /// Probability that a full-grown branching colony (each month), or one that breaks, leaves fragments, for a surface factor
    /// of 1.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub fragmentation: f32,
    /// Fragments of a colony that fragments.
    #[schemars(range(min = 0, max = 100), extend("unit" = "1"))]
    pub fragments: u32,
    /// Larvae that come from elsewhere, for each one of the plot's own.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "1"))]
    pub import_factor: f32,
    /// Macroalgae.
    pub algae: Algae,
    /// Turf.
    pub turf: Turf,
    /// Grazing fish and urchins.
    pub grazing: Grazing,
    /// Heat.
    pub heat: HeatRules,
    /// Small disturbances: anchors, divers, small waves.
    pub small_disturbances: Disturbances,
    /// Large disturbances: storms.
    pub large_disturbances: Disturbances,
    /// Month from which the rugosity of the reef feeds back on grazing and on the interval of disturbances. The original program
    /// does so from month 600 to 1200; with its numbers a reef of a rugosity below 1.75 then dies within decades, so that it is
    /// off unless asked for.
    #[schemars(range(min = 0, max = 1000000), extend("unit" = "month"))]
    pub feedback_from: u32,
    /// Month at which that ends; 0 for never having it.
    #[schemars(range(min = 0, max = 1000000), extend("unit" = "month"))]
    pub feedback_until: u32,
    /// Pore space of the limestone that skeletons become, for the thickness that the terrain gains. 0.5 lies between
    /// framework and sand.
    #[schemars(range(min = 0.0, max = 0.95), extend("unit" = "1"))]
    pub porosity: f32,
}

impl Default for Community {
    fn default() -> Self {
        Self {
            compat: false,
            species: Species::of_the_source(),
            shade: 0.7,
            shade_of_larger: 0.3,
            overgrowth: 0.75,
            breakage: 0.001,
            fragmentation: 0.002,
            fragments: 2,
            import_factor: 1.0,
            algae: Algae::default(),
            turf: Turf::default(),
            grazing: Grazing::default(),
            heat: HeatRules::default(),
            small_disturbances: Disturbances::small(),
            large_disturbances: Disturbances::large(),
            feedback_from: 0,
            feedback_until: 0,
            porosity: 0.5,
        }
    }
}

/// Macroalgae: Sargassum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Algae {
    /// Growth, first of the radius and then of the height.
    #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "m/month"))]
    pub growth: f32,
    /// Largest radius.
    #[schemars(range(min = 0.001, max = 5.0), extend("unit" = "m"))]
    pub max_radius: f32,
    /// Largest height.
    #[schemars(range(min = 0.001, max = 20.0), extend("unit" = "m"))]
    pub max_height: f32,
    /// Age beyond which it dies.
    #[schemars(range(min = 1, max = 1200), extend("unit" = "month"))]
    pub max_age: u32,
    /// Share of the ground that it covers at the start.
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "1"))]
    pub initial_cover: f32,
    /// It fragments above this height.
    #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "m"))]
    pub fragmentation_height: f32,
    /// Most fragments a month.
    #[schemars(range(min = 0, max = 100), extend("unit" = "1"))]
    pub max_fragments: u32,
    /// Radius of a fragment, and the height that the alga loses.
    #[schemars(range(min = 0.0001, max = 5.0), extend("unit" = "m"))]
    pub fragment_radius: f32,
    /// Fragments land within a square that reaches so far to each side.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub fragment_range: f32,
    /// Radius of a recruit.
    #[schemars(range(min = 0.0001, max = 5.0), extend("unit" = "m"))]
    pub recruit_radius: f32,
    /// Recruits of an event.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "1/m2"))]
    pub recruits: f32,
    /// Month of the first event, from 0.
    #[schemars(range(min = 0, max = 1200), extend("unit" = "month"))]
    pub first_recruitment: u32,
    /// Months from one event to the next.
    #[schemars(range(min = 1, max = 1200), extend("unit" = "month"))]
    pub recruitment_interval: u32,
    /// Deepest water in which it settles, where there are rasters of the ground.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub max_depth: f32,
}

impl Default for Algae {
    fn default() -> Self {
        Self {
            growth: 0.03,
            max_radius: 0.175,
            max_height: 0.6,
            max_age: 12,
            initial_cover: 0.2,
            fragmentation_height: 0.3,
            max_fragments: 2,
            fragment_radius: 0.05,
            fragment_range: 5.0,
            recruit_radius: 0.005,
            recruits: 0.5,
            first_recruitment: 2,
            recruitment_interval: 12,
            max_depth: 30.0,
        }
    }
}

/// Turf on cells of the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Turf {
    /// Edge of a cell.
    #[schemars(range(min = 0.05, max = 100.0), extend("unit" = "m"))]
    pub cell: f32,
    /// Growth of its cover.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1/month"))]
    pub growth: f32,
    /// Factor on that for each coral wider than a cell that overlaps it.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub shade: f32,
    /// Probability a month that full turf kills a coral in the first two months after it has settled.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1/month"))]
    pub kills_settlers: f32,
    /// Cover that grazers take from a cell which they visit.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub grazed: f32,
}

impl Default for Turf {
    fn default() -> Self {
        Self { cell: 1.0, growth: 0.05, shade: 0.9, kills_settlers: 0.5, grazed: 0.5 }
    }
}

/// Grazing: every alga and every cell of turf is grazed with the same probability a month.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Grazing {
    /// Middle of the range of that probability.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1/month"))]
    pub probability: f32,
    /// Half of the range.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1/month"))]
    pub half_range: f32,
    /// Cover of macroalgae at which the probability is at the low end of the range.
    #[schemars(range(min = 0.0001, max = 1.0), extend("unit" = "1"))]
    pub threshold: f32,
    /// How steeply it falls below that.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    pub exponent: f32,
    /// Rugosity at which grazing that depends on rugosity reaches `probability`.
    #[schemars(range(min = 1.01, max = 100.0), extend("unit" = "1"))]
    pub max_rugosity: f32,
}

impl Default for Grazing {
    fn default() -> Self {
        Self { probability: 0.18, half_range: 0.04, threshold: 0.075, exponent: 2.0, max_rugosity: 3.5 }
    }
}

/// Events that kill everything whose centre lies in a disc.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Disturbances {
    /// Events of each date on a plot of 40 x 40 m. Other plots get as many for their area, and with `compat` as many for
    /// themselves.
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "1"))]
    pub events: f32,
    /// Mean time from one date to the next.
    #[schemars(range(min = 1.0, max = 100000.0), extend("unit" = "month"))]
    pub interval: f32,
    /// Standard deviation of the interval, as a share of it.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub spread: f32,
    /// Smallest diameter.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub min_diameter: f32,
    /// Largest diameter.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub max_diameter: f32,
    /// Branching corals may leave fragments before they die.
    pub fragments: bool,
    /// At or below this rugosity the interval shrinks while the feedback of rugosity is on.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "1"))]
    pub rugosity: f32,
    /// Factor on the interval for each year of that.
    #[schemars(range(min = 0.01, max = 1.0), extend("unit" = "1"))]
    pub shrink: f32,
}

impl Default for Disturbances {
    fn default() -> Self {
        Self::small()
    }
}

impl Disturbances {
    /// 2 to 4 m every year.
    pub fn small() -> Self {
        Self {
            events: 1.0,
            interval: 12.0,
            spread: 0.1,
            min_diameter: 2.0,
            max_diameter: 4.0,
            fragments: false,
            rugosity: 1.75,
            shrink: 0.9,
        }
    }

    /// 5 to 10 m every third year.
    pub fn large() -> Self {
        Self { interval: 36.0, min_diameter: 5.0, max_diameter: 10.0, fragments: true, ..Self::small() }
    }
}

/// How heat is measured and what it does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct HeatRules {
    /// What decides over bleaching.
    pub stress: Stress,
    /// Temperature from which days count.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "C"))]
    pub threshold: f32,
    /// Days over which the excess is averaged. With `compat` one more day counts, but the sum is divided by this.
    #[schemars(range(min = 1, max = 365), extend("unit" = "d"))]
    pub window: u32,
    /// Probability of bleaching at a species' `bleaching_min`.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub least_bleaching: f32,
    /// Bleaching that a colony recovers from in a month; 1 is fully bleached.
    #[schemars(range(min = 0.001, max = 1.0), extend("unit" = "1/month"))]
    pub recovery: f32,
    /// Mean temperature of the warmest month, from which degree heating weeks count; from the series itself if it is 0.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "C"))]
    pub warmest_month: f32,
    /// Degree heating weeks at which bleaching begins, and at which a species of sensitivity 1 bleaches wholly. 4: "bleaching
    /// likely" (NOAA Coral Reef Watch).
    #[schemars(inner(range(min = 0.0, max = 1000.0)), extend("unit" = "C week"))]
    pub bleaching_weeks: [f32; 2],
    /// Degree heating weeks at which bleached colonies begin to die, and at which all of them do. 8: "mortality likely".
    #[schemars(inner(range(min = 0.0, max = 1000.0)), extend("unit" = "C week"))]
    pub death_weeks: [f32; 2],
}

/// What decides over bleaching.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Stress {
    /// The mean excess over a threshold, with the limits of each species.
    #[default]
    Excess,
    /// Degree heating weeks, with one pair of limits and a sensitivity of each species.
    HeatingWeeks,
}

impl Default for HeatRules {
    fn default() -> Self {
        Self {
            stress: Stress::Excess,
            threshold: 29.0,
            window: 20,
            least_bleaching: 0.3,
            recovery: 0.17,
            warmest_month: 0.0,
            bleaching_weeks: [4.0, 16.0],
            death_weeks: [8.0, 20.0],
        }
    }
}

impl HeatRules {
    /// # Errors
    /// The first parameter that cannot work.
    pub fn check(&self) -> Result<()> {
        let owner = "community.heat";
        check_ranges(owner, self)?;
        for (field, [low, high]) in [("bleaching_weeks", self.bleaching_weeks), ("death_weeks", self.death_weeks)] {
            if low >= high {
                return Err(bad(owner, field, format!("{low} must be less than {high}")));
            }
        }
        Ok(())
    }
}

impl Community {
    /// Finds parameters that cannot work, before anything is allocated.
    ///
    /// # Errors
    /// The first such parameter, by name.
    pub fn check(&self) -> Result<()> {
        let owner = "community";
        check_ranges(owner, self)?;
        if self.species.len() > 256 {
            return Err(bad(owner, "species", format!("{} are too many; there may be 256", self.species.len())));
        }
        if let Some(s) = self.species.iter().find(|s| s.name.trim().is_empty() || s.name.chars().any(char::is_control))
        {
            return Err(bad(owner, "species", format!("{:?} is no name of a species", s.name)));
        }
        self.species.iter().try_for_each(Species::check)?;
        if let Some(s) =
            self.species.iter().enumerate().find(|(i, s)| self.species[..*i].iter().any(|o| o.name == s.name))
        {
            return Err(bad(owner, "species", format!("`{}` is there twice", s.1.name)));
        }
        part("algae", &self.algae)?;
        part("turf", &self.turf)?;
        part("grazing", &self.grazing)?;
        self.heat.check()?;
        for (name, d) in [("small", &self.small_disturbances), ("large", &self.large_disturbances)] {
            part(&format!("{name}_disturbances"), d)?;
            if d.min_diameter > d.max_diameter {
                let reason = format!("{} m is more than max_diameter, {} m", d.min_diameter, d.max_diameter);
                return Err(bad(&format!("community.{name}_disturbances"), "min_diameter", reason));
            }
        }
        let a = &self.algae;
        if a.recruit_radius.max(a.fragment_radius) > a.max_radius {
            let reason = format!("{} m is less than the radius of recruits or fragments", a.max_radius);
            return Err(bad("community.algae", "max_radius", reason));
        }
        Ok(())
    }

    /// Largest radius that anything can reach, m.
    pub(super) fn max_radius(&self) -> f32 {
        self.species.iter().map(|s| s.max_radius).fold(self.algae.max_radius, f32::max)
    }
}

fn part<P: Parameters>(name: &str, parameters: &P) -> Result<()> {
    check_ranges(&format!("community.{name}"), parameters)
}

pub(super) fn bad(owner: &str, field: &str, reason: String) -> Error {
    Error::BadParameter { owner: owner.into(), field: field.into(), reason }
}
