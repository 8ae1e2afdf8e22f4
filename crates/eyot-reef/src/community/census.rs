//! What a plot reports of a month.

use super::forcing::Heat;
use serde::Serialize;

/// A row of the census.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Census {
    /// Months since the beginning; the first one is 0.
    pub month: u64,
    /// Heat stress.
    pub heat: Heat,
    /// One for each species of the community, in its order.
    pub species: Vec<SpeciesCensus>,
    /// Macroalgae.
    pub algae: u64,
    /// Share of the plot's area that discs of macroalgae cover; overlaps count twice.
    pub algae_cover: f64,
    /// Mean cover of turf, 0..=1.
    pub turf_cover: f64,
    /// Living surface over the plot's area, as a length: `sqrt((sum of surfaces + bare area) / area)`.
    pub rugosity: f64,
    /// Probability with which algae were grazed.
    pub grazing: f32,
    /// Small and large disturbances.
    pub disturbances: [u32; 2],
    /// Thickness of the limestone that this month's skeletons make, spread over the plot, m.
    pub limestone_m: f64,
}

/// What a number of a census is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CensusColumn {
    /// Name in tables.
    pub name: String,
    /// Unit; `1` for counts and shares.
    pub unit: &'static str,
    /// True for whole numbers.
    pub is_whole: bool,
}

/// What became of a species in a month.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SpeciesCensus {
    /// Colonies.
    pub colonies: u64,
    /// Of these, bleached ones.
    pub bleached: u64,
    /// Share of the plot's area that discs of the colonies' mean radii cover; overlaps count twice.
    pub cover: f64,
    /// Larvae that settled.
    pub recruits: u64,
    /// Fragments that found hold.
    pub fragments: u64,
    /// Colonies that died.
    pub deaths: Deaths,
    /// Skeleton made, kg of aragonite.
    pub calcified_kg: f64,
}

/// Deaths by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Deaths {
    /// Heat.
    pub heat: u64,
    /// Overgrown or engulfed by neighbours.
    pub overgrowth: u64,
    /// Smothered by turf in the first two months.
    pub turf: u64,
    /// Broken.
    pub breakage: u64,
    /// Small and large disturbances.
    pub disturbance: u64,
}

impl Deaths {
    /// All of them.
    pub const fn all(&self) -> u64 {
        self.heat + self.overgrowth + self.turf + self.breakage + self.disturbance
    }
}

impl Census {
    /// Share of the plot's area that corals cover.
    pub fn coral_cover(&self) -> f64 {
        self.species.iter().map(|s| s.cover).sum()
    }

    /// Colonies of all species.
    pub fn colonies(&self) -> u64 {
        self.species.iter().map(|s| s.colonies).sum()
    }

    /// The row as columns for tables, `names` being the species' names: the same columns for every month of a plot.
    pub fn columns(&self, names: &[&str]) -> Vec<(CensusColumn, f64)> {
        let number = |name: &str, unit, value| (CensusColumn { name: name.into(), unit, is_whole: false }, value);
        let whole = |name: &str, unit, n: u64| (CensusColumn { name: name.into(), unit, is_whole: true }, n as f64);
        let mut row = vec![
            whole("month", "month", self.month),
            number("heat_index_c", "°C", f64::from(self.heat.index)),
            number("degree_heating_weeks", "°C week", f64::from(self.heat.heating_weeks)),
            number("temperature_c", "°C", f64::from(self.heat.mean)),
            number("coral_cover", "1", self.coral_cover()),
            whole("algae", "1", self.algae),
            number("algae_cover", "1", self.algae_cover),
            number("turf_cover", "1", self.turf_cover),
            number("rugosity", "1", self.rugosity),
            number("grazing", "1/month", f64::from(self.grazing)),
            whole("small_disturbances", "1", u64::from(self.disturbances[0])),
            whole("large_disturbances", "1", u64::from(self.disturbances[1])),
            number("limestone_m", "m", self.limestone_m),
        ];
        for (name, s) in names.iter().zip(&self.species) {
            let d = &s.deaths;
            let counts = [
                ("colonies", s.colonies),
                ("bleached", s.bleached),
                ("recruits", s.recruits),
                ("fragments", s.fragments),
                ("deaths_heat", d.heat),
                ("deaths_overgrowth", d.overgrowth),
                ("deaths_turf", d.turf),
                ("deaths_breakage", d.breakage),
                ("deaths_disturbance", d.disturbance),
            ];
            let of = |what: &str| format!("{}.{what}", name.to_lowercase().replace(' ', "_"));
            row.push(number(&of("cover"), "1", s.cover));
            row.extend(counts.map(|(what, n)| whole(&of(what), "1", n)));
            row.push(number(&of("calcified_kg"), "kg", s.calcified_kg));
        }
        row
    }
}
