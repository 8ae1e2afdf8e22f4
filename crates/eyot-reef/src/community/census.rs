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

    /// The row as named columns for tables, `names` being the species' names: the same columns for every month of a plot.
    pub fn columns(&self, names: &[&str]) -> Vec<(String, f64)> {
        let mut row = vec![
            ("month".to_owned(), self.month as f64),
            ("heat_index_c".into(), f64::from(self.heat.index)),
            ("degree_heating_weeks".into(), f64::from(self.heat.heating_weeks)),
            ("temperature_c".into(), f64::from(self.heat.mean)),
            ("coral_cover".into(), self.coral_cover()),
            ("algae".into(), self.algae as f64),
            ("algae_cover".into(), self.algae_cover),
            ("turf_cover".into(), self.turf_cover),
            ("rugosity".into(), self.rugosity),
            ("grazing".into(), f64::from(self.grazing)),
            ("small_disturbances".into(), f64::from(self.disturbances[0])),
            ("large_disturbances".into(), f64::from(self.disturbances[1])),
            ("limestone_m".into(), self.limestone_m),
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
            row.push((of("cover"), s.cover));
            row.extend(counts.map(|(what, n)| (of(what), n as f64)));
            row.push((of("calcified_kg"), s.calcified_kg));
        }
        row
    }
}
