//! Bedrock in beds: which of them comes to light, how fast it wears, and how steep it stands.
//!
//! # Equations
//! `h` height, `r` surface of the rock, `s = h - r` thickness of the loose ground on it, `D` height of the uppermost bed's top,
//! `K` erodibility, `T` years of a step.
//! 1. Where `h < r`, others cut `c = r - h` of rock, which took the time `t = c / K` with the `K` that they found there. In that
//!    time beds wear one after the other, each by at most `K_bed t`: `t` becomes `t - d / K_bed` when `d` of a bed is gone. What
//!    they would have lost less than `c` is given back from `sediment` in the same cell. `r1 = min(r, h)` with the new `h`; what was
//!    taken from loose ground came from the height alone, what was added lies on the rock.
//! 2. `r' = r1 - T soil e^(-s / soil_depth)`: rock becomes soil, slower the deeper it is buried.
//! 3. The bed at depth `b = D - r'` is the first whose bottom lies deeper: the sum of the thicknesses down to it, and what
//!    `surfaces` adds, but no higher than the bottom of the bed above. With `repeat` the sequence begins again below and above itself.
//! 4. `erodibility = K_loose (1 - e^(-s / cover)) + K_bed e^(-s / cover)`; `rock_slope` is the tangent of the bed's angle; `bed_left`
//!    is what is left of the bed and `erodibility_below` the `K` of the next one, or `s` and `K_bed` where `s > cover / 10`.
//! 5. At the start `D = top + bed_shift - tan(dip) d + sum(A cos(2 pi x_f / wavelength)) + sum(throws)`, with `d` the way from the
//!    middle of the grid to where the beds dip, `x_f` that across a fold, and the throw of a fault on the side to the right of its
//!    strike.
//! 6. Uplift lifts `h`, `r` and `D` by `T uplift`.
//!
//! With `new_rock`, up to six kinds of younger rock lie between the beds and the loose ground, `new_rock_1` (softest, on top) to
//! `new_rock_6`, as the process `rock_cycle` makes them. (1) and (2) begin with them, and (4) tells of the uppermost that is there.
//!
//! # Source
//! Soil production after Heimsath and others 1997; the cover of (4) after Shobe, Tucker and Barnhart 2017 (SPACE). The seven usual
//! materials are those of the rock cycle, with densities of Telford, Geldart and Sheriff 1990.
//!
//! # Differences
//! - SPACE wears rock and sediment at two rates at once; here one factor is shared by all processes that wear the land.
//! - Strata are shifted, tilted, folded and broken as a whole: they keep their thickness measured along the vertical, but for those
//!   that have a surface of their own.
//! - A step that cuts into a softer bed wears it at the rate of the harder one; the next step knows better. Where there is no
//!   sediment to give back, as after stream power, which minds `bed_left` itself, what was cut stays cut.
//!
//! # Layers
//! Reads `bed_shift` (m), with `surfaces` `bed_1` to `bed_4` (m); with `soaked` reads and empties `soaked` (m); reads and writes `height`, `sediment`, `bedrock`, `bed_datum` (m),
//! with `new_rock` `new_rock_1` to `new_rock_6` (m); writes `material` (number of a class), `erodibility`, `rock_slope` (1),
//! `bed_left` (m) and `erodibility_below` (1).
//!
//! # Limits
//! Stable for all parameters. Up to 12 beds above the last one, which has no bottom; the wear of each has an account. Of beds that repeat, what a
//! step cuts above the end of a turn counts as of the last bed.
//!
//! # Conserves
//! Height is bedrock, new rock and loose ground; ground and sediment together. What rises is in the ledger, what comes to light of
//! the bedrock is reported, bed by bed and stage by stage (`tests/it/strata.rs`, `tests/it/materials.rs`).

mod beds;
mod expose;
mod lie;
mod new_rock;
mod soaked;

use beds::Profile;
pub(crate) use beds::SURFACES;
pub use beds::{Bed, Fault, Fold, MOST_BEDS};
pub use expose::{BENT, Expose, ExposeParams, FLAT, REPEATING};
pub use lie::{Bury, BuryParams, Lie, LieParams, Lift, LiftParams};
pub use new_rock::{NewRockParams, Overlay, Take};
pub use soaked::{Drain, Soaked};

use crate::materials::{Material, standard};
use crate::sequence::STRATA;
pub use crate::sequence::{SLOTS, Surfaces};
use eyot_core::given::Given;
use eyot_core::layer::known::{HEIGHT, SEDIMENT};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, SECONDS_PER_YEAR};
use eyot_core::{Grid, LayerSpec, Result, World, given};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Folds and faults, of each.
pub const MOST_BENDS: usize = 4;

/// Where the beds lie.
pub const BED_DATUM: LayerSpec =
    LayerSpec::new("bed_datum", "m", "Height of the top of the uppermost bed, worn away or not", (-1e6, 1e6));
/// What a recipe adds to where the beds lie.
pub const BED_SHIFT: LayerSpec = LayerSpec::new(
    "bed_shift",
    "m",
    "How much higher the beds lie here than elsewhere, made by a generator",
    (-1e5, 1e5),
);
const fn surface(name: &'static str) -> LayerSpec {
    LayerSpec::new(name, "m", "Bottom of this bed: how much lower it lies here, or its height", (-1e5, 1e5))
}
/// What a recipe says of the bottoms of the first beds.
pub const BED_SURFACES: [LayerSpec; 4] = [surface("bed_1"), surface("bed_2"), surface("bed_3"), surface("bed_4")];

const fn new_rock(name: &'static str) -> LayerSpec {
    LayerSpec::new(
        name,
        "m",
        "Thickness of rock that hardened on the bedrock, softer kinds above harder ones",
        (0.0, 12000.0),
    )
}
/// Rock younger than the beds.
pub const NEW_ROCK: [LayerSpec; SLOTS] = [
    new_rock("new_rock_1"),
    new_rock("new_rock_2"),
    new_rock("new_rock_3"),
    new_rock("new_rock_4"),
    new_rock("new_rock_5"),
    new_rock("new_rock_6"),
];
const CUT_TIME: LayerSpec = LayerSpec::new("cut_time", "m", "What is left of the time to cut beds", (-1.0, 1e12));
const CUT_TOP: LayerSpec = LayerSpec::new("cut_top", "m", "Top of what is left of new rock", (-12000.0, 12000.0));

/// What standing water has softened since the beds were last asked.
pub const SOAKED: LayerSpec = LayerSpec::new(
    "soaked",
    "m",
    "Bedrock that standing water made loose and no bed has accounted for yet",
    (0.0, 12000.0),
);

/// What lies at the surface.
pub const MATERIAL: LayerSpec =
    LayerSpec::new("material", "1", "Material at the surface, its number in the list of materials", (0.0, 255.0));
pub use eyot_core::layer::known::{BED_LEFT, BEDROCK, ERODIBILITY, ERODIBILITY_BELOW, ROCK_SLOPE};

/// Bedrock in beds: hard ones stand as cliffs and ledges, soft ones as slopes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Strata {
    /// The beds from the top down, at most 13. The last one goes on for ever.
    pub beds: Vec<Bed>,
    /// Materials by name. One of a new name says which it is like, or gives all.
    pub materials: Vec<Material>,
    /// Name of the material of loose ground.
    pub loose: String,
    /// Height of the top of the uppermost bed in the middle of the grid, before it is bent. What is above it is of the same bed.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub top: f32,
    /// Have the bottoms of the first four beds surfaces of their own, the layers `bed_1` to `bed_4`?
    pub surfaces: Surfaces,
    /// Is there rock younger than the beds, as the process `rock_cycle` makes it?
    pub new_rock: bool,
    /// Does the process `soak` soften it? Then new rock loses what was softened of it, and each bed has an account of it.
    pub soaked: bool,
    /// The materials of new rock, softest first: six.
    pub stages: Vec<String>,
    /// Does the sequence begin again below its last bed and above its first?
    pub repeat: bool,
    /// How steeply the beds lie.
    #[schemars(range(min = 0.0, max = 85.0), extend("unit" = "degree"))]
    pub dip: f32,
    /// To where they sink, clockwise from north.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub dip_direction: f32,
    /// Folds, at most 4.
    pub folds: Vec<Fold>,
    /// Faults, at most 4.
    pub faults: Vec<Fault>,
    /// Thickness of the loose ground at the start.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub regolith: f32,
    /// Loose ground of this thickness shelters two thirds of the bedrock. SPACE has 0.1 to 1 m.
    #[schemars(range(min = 0.001, max = 100.0), extend("unit" = "m"))]
    pub cover: f32,
    /// Bare rock that becomes soil in a year: 0.00008 to 0.002 m.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "m/yr"))]
    pub soil: f32,
    /// Soil of this thickness slows that to a third: 0.25 to 0.5 m.
    #[schemars(range(min = 0.01, max = 100.0), extend("unit" = "m"))]
    pub soil_depth: f32,
    /// Uplift of land and beds together.
    #[schemars(range(min = -1.0, max = 1.0), extend("unit" = "m/yr"))]
    pub uplift: f32,
    /// Years of a step, for soil and uplift.
    #[schemars(range(min = 0.001, max = 1000000.0), extend("unit" = "yr"))]
    pub years_per_step: f32,
}

impl Default for Strata {
    fn default() -> Self {
        let bed = |material: &str, thickness: f32| Bed { material: material.into(), thickness };
        Self {
            beds: vec![
                bed("limestone", 60.0),
                bed("schist", 90.0),
                bed("sandstone", 120.0),
                bed("marble", 50.0),
                bed("sandstone", 150.0),
                bed("granite", 1000.0),
            ],
            materials: standard(),
            loose: "regolith".into(),
            top: 800.0,
            surfaces: Surfaces::Flat,
            new_rock: false,
            soaked: false,
            stages: ["sand", "sandstone", "limestone", "schist", "marble", "granite"].map(String::from).into(),
            repeat: false,
            dip: 0.0,
            dip_direction: 90.0,
            folds: Vec::new(),
            faults: Vec::new(),
            regolith: 0.0,
            cover: 0.5,
            soil: 0.0,
            soil_depth: 0.5,
            uplift: 0.0,
            years_per_step: 1000.0,
        }
    }
}

impl Process for Strata {
    fn layers(&self) -> Vec<LayerUse> {
        let mut layers = vec![
            HEIGHT.changed(0.0),
            BED_SHIFT.read(0.0),
            BED_DATUM.changed(0.0),
            BEDROCK.changed(0.0),
            SEDIMENT.changed(0.0),
            MATERIAL.written(0.0),
            ERODIBILITY.changed(1.0),
            ROCK_SLOPE.written(1.0),
            BED_LEFT.written(0.0),
            ERODIBILITY_BELOW.written(1.0),
        ];
        if self.surfaces != Surfaces::Flat {
            layers.extend(BED_SURFACES.map(|s| s.read(0.0)));
        }
        if self.soaked {
            layers.push(SOAKED.changed(0.0));
        }
        if self.new_rock {
            layers.extend(NEW_ROCK.map(|s| s.changed(0.0)));
        }
        layers
    }

    fn start(&self, name: &str, moment: &Moment, plan: &mut Plan) {
        match name {
            "bed_datum" => plan.push::<Lie>(self.lie(&moment.grid)),
            "bedrock" => plan.push::<Bury>(BuryParams { regolith: self.regolith }),
            _ => {}
        }
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        self.fits()?;
        self.profile().map(|_| ())
    }

    fn prepare(&self, world: &mut World) -> Result<()> {
        world.components.insert(STRATA, self.sequence()?);
        Ok(())
    }

    fn seconds_per_step(&self, _grid: &Grid) -> Option<f64> {
        (self.soil > 0.0 || self.uplift != 0.0).then(|| f64::from(self.years_per_step) * SECONDS_PER_YEAR)
    }

    fn plan(&self, _moment: &Moment, plan: &mut Plan) {
        let Ok(profile) = self.profile() else { return };
        if self.uplift != 0.0 {
            plan.push::<Lift>(LiftParams { risen: self.uplift * self.years_per_step });
        }
        let given = |v: f32| Given::from(v);
        // What the rules for beds and for new rock have in common.
        let shared = NewRockParams::<Given> {
            slots: profile.slots.map(|slot| slot.map(given)),
            loose: profile.loose.map(given),
            per_cover: 1.0 / given!(plan, self.cover),
            soil: given!(plan, self.soil) * self.years_per_step,
            per_soil_depth: 1.0 / given!(plan, self.soil_depth),
        };
        if self.soaked {
            if self.new_rock {
                plan.push_given::<Drain>(shared);
            }
            match (self.repeat, self.surfaces != Surfaces::Flat) {
                (true, _) => plan.push_given::<Soaked<REPEATING>>(self.exposed(&profile, &shared)),
                (false, true) => plan.push_given::<Soaked<BENT>>(self.exposed(&profile, &shared)),
                (false, false) => plan.push_given::<Soaked<FLAT>>(self.exposed(&profile, &shared)),
            }
        }
        if self.new_rock {
            [&CUT_TIME, &CUT_TOP].into_iter().for_each(|s| plan.scratch(s));
            plan.push_given::<Take>(shared);
        }
        if self.new_rock {
            self.expose_beds::<true>(&profile, &shared, plan);
        } else {
            self.expose_beds::<false>(&profile, &shared, plan);
        }
        if self.new_rock {
            plan.push_given::<Overlay<false>>(shared);
            plan.push_given::<Overlay<true>>(shared);
        }
    }
}

impl Strata {
    /// Plans the rule for as many beds as there are, the last one among them, which has its account there; of 13 it has one of its own.
    fn expose_beds<const UNDER: bool>(&self, profile: &Profile<f32>, shared: &NewRockParams<Given>, plan: &mut Plan) {
        match (self.beds.len(), self.repeat, self.surfaces != Surfaces::Flat) {
            (..=4, false, false) => self.expose::<4, 6, UNDER, FLAT>(profile, shared, plan),
            (..=8, false, false) => self.expose::<8, 10, UNDER, FLAT>(profile, shared, plan),
            (_, false, false) => self.expose::<12, 15, UNDER, FLAT>(profile, shared, plan),
            (..=8, _, true) => self.expose::<8, 10, UNDER, BENT>(profile, shared, plan),
            (_, _, true) => self.expose::<12, 15, UNDER, BENT>(profile, shared, plan),
            (..=8, true, false) => self.expose::<8, 10, UNDER, REPEATING>(profile, shared, plan),
            (_, true, false) => self.expose::<12, 15, UNDER, REPEATING>(profile, shared, plan),
        }
    }

    /// Plans the rule for up to `BEDS` beds above the last one.
    fn expose<const BEDS: usize, const SUMS: usize, const UNDER: bool, const LIE: u8>(
        &self,
        profile: &Profile<f32>,
        shared: &NewRockParams<Given>,
        plan: &mut Plan,
    ) {
        plan.push_given::<Expose<BEDS, SUMS, UNDER, LIE>>(self.exposed(profile, shared));
    }

    /// The first `BEDS` beds and the last one, as rules take them.
    fn exposed<const BEDS: usize>(
        &self,
        profile: &Profile<f32>,
        shared: &NewRockParams<Given>,
    ) -> ExposeParams<Given, BEDS> {
        let given = |v: f32| Given::from(v);
        let sequence = if self.repeat { self.sequence_m() } else { 0.0 };
        let surface = |i: usize| match self.surfaces {
            _ if i + 1 >= self.beds.len() => 0.0,
            Surfaces::Flat => 0.0,
            Surfaces::Lower => 1.0,
            Surfaces::Height => -1.0,
        };
        let mut beds: [[Given; 5]; BEDS] = std::array::from_fn(|i| profile.beds[i].map(given));
        if self.surfaces == Surfaces::Height {
            // The depth of a height below the datum, which begins at the top.
            beds.iter_mut().take(SURFACES).take(self.beds.len() - 1).for_each(|bed| bed[0] = self.top.into());
        }
        ExposeParams {
            beds,
            last: profile.last.map(given),
            loose: shared.loose,
            sequence: sequence.into(),
            per_sequence: if self.repeat { 1.0 / sequence } else { 0.0 }.into(),
            per_cover: shared.per_cover,
            soil: shared.soil,
            per_soil_depth: shared.per_soil_depth,
            surfaces: std::array::from_fn(|i| surface(i).into()),
        }
    }
}
