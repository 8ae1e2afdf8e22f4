//! What a species is: data, which a recipe may change or add to.

use crate::bodies::{BodyPlan, Shape};
use eyot_core::process::check_ranges;
use eyot_core::{Error, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a colony stands in the fight for space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// Solid: it covers the polygon through the ends of its rays, and branches cannot grow into it.
    #[default]
    Massive,
    /// Branches: it covers the disc of its mean radius, breaks, and spreads by fragments.
    Branching,
}

/// A species of coral.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Species {
    /// Name in tables.
    pub name: String,
    /// How it competes.
    pub form: Form,
    /// Growth of the radius without neighbours, in full light.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "m/yr"))]
    pub growth: f32,
    /// Rays stop here.
    #[schemars(range(min = 0.001, max = 20.0), extend("unit" = "m"))]
    pub max_radius: f32,
    /// Radii at the start are uniform from 0 to this.
    #[schemars(range(min = 0.001, max = 20.0), extend("unit" = "m"))]
    pub max_initial_radius: f32,
    /// Share of the habitable ground that it covers at the start.
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "1"))]
    pub initial_cover: f32,
    /// Colonies from this diameter on have larvae.
    #[schemars(range(min = 0.0, max = 40.0), extend("unit" = "m"))]
    pub mature_diameter: f32,
    /// Living surface over that of a hemisphere with the same radius.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "1"))]
    pub surface_factor: f32,
    /// Larvae of a square centimetre of living surface at each event.
    #[schemars(range(min = 0.0, max = 1000000.0), extend("unit" = "1/cm2"))]
    pub propagules: f32,
    /// Share of the larvae that settle on the same plot.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub retention: f32,
    /// Radius of a colony that has just settled.
    #[schemars(range(min = 0.0001, max = 1.0), extend("unit" = "m"))]
    pub recruit_radius: f32,
    /// Month of the first settling, from 0.
    #[schemars(range(min = 0, max = 1200), extend("unit" = "month"))]
    pub first_recruitment: u32,
    /// Months from one settling to the next.
    #[schemars(range(min = 1, max = 1200), extend("unit" = "month"))]
    pub recruitment_interval: u32,
    /// Larvae from elsewhere that settle at each event, whatever lives here: what lets a reef come back that a storm or heat has
    /// emptied. About a third of what a default plot makes itself. Not used with `compat`.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "1/m2"))]
    pub imported_recruits: f32,
    /// Heat index from which colonies bleach.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "C"))]
    pub bleaching_min: f32,
    /// Heat index at which all of them bleach.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "C"))]
    pub bleaching_max: f32,
    /// Heat index from which bleached colonies die.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "C"))]
    pub death_min: f32,
    /// Heat index at which all bleached ones die.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "C"))]
    pub death_max: f32,
    /// Factor on the probability of bleaching where degree heating weeks decide: 1.5 for arborescent and 1.4 for tabular and
    /// pocilloporid corals, 0.25 for massive ones (ReefMod-GBR).
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    pub heating_week_sensitivity: f32,
    /// Strength in the fight for space: radii times this say who is the larger one. Not used with `compat`.
    #[schemars(range(min = 0.01, max = 100.0), extend("unit" = "1"))]
    pub competition: f32,
    /// Radius of a fragment.
    #[schemars(range(min = 0.0001, max = 5.0), extend("unit" = "m"))]
    pub fragment_radius: f32,
    /// Fragments land within a square that reaches so far to each side.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub fragment_range: f32,
    /// Shallowest water in which it settles. Without rasters of the ground every place is right.
    #[schemars(range(min = -10.0, max = 1000.0), extend("unit" = "m"))]
    pub min_depth: f32,
    /// Deepest water in which it settles.
    #[schemars(range(min = -10.0, max = 1000.0), extend("unit" = "m"))]
    pub max_depth: f32,
    /// Least light with which it settles, as a share of the light at the surface.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub min_light: f32,
    /// Light that saturates growth, as a share of the light at the surface: growth falls as tanh(light / this). 0.125 is 250 of
    /// 2000 uE/m2/s (Bosscher and Schlager 1992).
    #[schemars(range(min = 0.001, max = 10.0), extend("unit" = "1"))]
    pub saturation_light: f32,
    /// Bulk density of its skeleton. Massive Porites 1280 (Lough and Barnes 2000); branch tips of Acropora 860 to 1680.
    #[schemars(range(min = 1.0, max = 2940.0), extend("unit" = "kg/m3"))]
    pub skeletal_density: f32,
    /// Share of the body's outline that is skeleton: 1 for solid ones. Those of branching species are chosen so that a cover of
    /// 100 % makes 20 to 30 kg of limestone a year and square metre.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub solid_share: f32,
    /// Colour in plots and maps, sRGB.
    pub colour: [u8; 3],
    /// What its bodies look like.
    pub body: BodyPlan,
}

impl Default for Species {
    /// *Porites lobata*.
    fn default() -> Self {
        Self {
            name: "Porites lobata".into(),
            form: Form::Massive,
            growth: 0.0116,
            max_radius: 3.0,
            max_initial_radius: 1.5,
            initial_cover: 0.1,
            mature_diameter: 0.08,
            surface_factor: 1.5,
            propagules: 1210.0,
            retention: 4.5e-9,
            recruit_radius: 0.001,
            first_recruitment: 3,
            recruitment_interval: 12,
            imported_recruits: 0.006,
            bleaching_min: 29.9,
            bleaching_max: 31.0,
            death_min: 29.4,
            death_max: 32.0,
            heating_week_sensitivity: 0.25,
            competition: 1.0,
            fragment_radius: 0.05,
            fragment_range: 5.0,
            min_depth: 0.5,
            max_depth: 40.0,
            min_light: 0.05,
            saturation_light: 0.125,
            skeletal_density: 1280.0,
            solid_share: 1.0,
            colour: [58, 96, 190],
            body: BodyPlan::default(),
        }
    }
}

impl Species {
    /// The four species of the source.
    pub fn of_the_source() -> Vec<Self> {
        let lobata = Self::default();
        let lutea = Self {
            name: "Porites lutea".into(),
            growth: 0.0132,
            surface_factor: 1.0,
            propagules: 1375.0,
            competition: 0.9,
            colour: [232, 140, 48],
            body: BodyPlan { roughness: 0.2, colours: [[176, 150, 78], [128, 138, 84]], ..BodyPlan::default() },
            ..lobata.clone()
        };
        let muricata = Self {
            name: "Acropora muricata".into(),
            form: Form::Branching,
            growth: 0.0771,
            max_radius: 0.5,
            max_initial_radius: 0.5,
            mature_diameter: 0.07,
            surface_factor: 5.0,
            propagules: 109.5,
            retention: 3.75e-8,
            recruit_radius: 0.0012,
            imported_recruits: 0.02,
            bleaching_min: 29.4,
            death_min: 28.2,
            heating_week_sensitivity: 1.5,
            skeletal_density: 1300.0,
            solid_share: 0.15,
            colour: [204, 52, 60],
            body: BodyPlan {
                shape: Shape::Branching,
                colours: [[150, 104, 62], [92, 104, 150]],
                ..BodyPlan::default()
            },
            ..lobata.clone()
        };
        let damicornis = Self {
            name: "Pocillopora damicornis".into(),
            growth: 0.0261,
            max_radius: 0.3,
            max_initial_radius: 0.3,
            surface_factor: 3.0,
            propagules: 1.2,
            retention: 1.0e-6,
            recruit_radius: 0.002,
            first_recruitment: 1,
            recruitment_interval: 1,
            imported_recruits: 0.003,
            bleaching_min: 30.0,
            death_min: 21.5,
            death_max: 30.4,
            heating_week_sensitivity: 1.4,
            solid_share: 0.3,
            colour: [64, 190, 196],
            body: BodyPlan {
                shape: Shape::Branching,
                grammar: "cauliflower".into(),
                colours: [[186, 112, 124], [160, 128, 84]],
                ..BodyPlan::default()
            },
            ..muricata.clone()
        };
        vec![lobata, lutea, muricata, damicornis]
    }

    /// # Errors
    /// The first parameter out of its range, or a pair that contradicts itself.
    pub(super) fn check(&self) -> Result<()> {
        let owner = format!("community.species `{}`", self.name);
        check_ranges(&owner, self)?;
        for (field, low, high) in [
            ("bleaching_min", self.bleaching_min, self.bleaching_max),
            ("death_min", self.death_min, self.death_max),
            ("min_depth", self.min_depth, self.max_depth),
        ] {
            if low >= high {
                let reason = format!("{low} must be less than {}, which is {high}", field.replace("min", "max"));
                return Err(Error::BadParameter { owner, field: field.into(), reason });
            }
        }
        for (field, radius) in [
            ("max_initial_radius", self.max_initial_radius),
            ("recruit_radius", self.recruit_radius),
            ("fragment_radius", self.fragment_radius),
        ] {
            if radius > self.max_radius {
                let reason = format!("{radius} m is more than max_radius, which is {} m", self.max_radius);
                return Err(Error::BadParameter { owner, field: field.into(), reason });
            }
        }
        Ok(())
    }
}
