//! Bedrock in beds: which of them comes to light, how fast it wears, and how steep it stands.
//!
//! # Equations
//! `h` height, `r` surface of the bedrock, `s = h - r` thickness of the loose ground on it, `D` height of the uppermost bed's top,
//! `T` years of a step.
//! 1. `r1 = min(r, h)`: what was taken from the height came from the loose ground first, what was added lies on the bedrock.
//! 2. `r' = r1 - T soil e^(-s / soil_depth)`: rock becomes soil, slower the deeper it is buried.
//! 3. The bed at depth `b = D - r'` is the first whose bottom lies deeper, `b` less than the sum of the thicknesses down to it;
//!    with `repeat` the sequence begins again below and above itself.
//! 4. `erodibility = K_loose (1 - e^(-s / cover)) + K_bed e^(-s / cover)`; `rock_slope` is the tangent of the bed's angle.
//! 5. At the start `D = top + bed_shift - tan(dip) d + sum(A cos(2 pi x_f / wavelength)) + sum(throws)`, with `d` the way from the middle of the
//!    grid to where the beds dip, `x_f` that across a fold, and the throw of a fault on the side to the right of its strike.
//! 6. Uplift lifts `h`, `r` and `D` by `T uplift`.
//!
//! # Source
//! Soil production after Heimsath and others 1997; the cover of (4) after Shobe, Tucker and Barnhart 2017 (SPACE). The seven usual
//! materials are those of the rock cycle, with densities of Telford, Geldart and Sheriff 1990.
//!
//! # Differences
//! - SPACE wears rock and sediment at two rates at once; here one factor is shared by all processes that wear the land.
//! - Strata are shifted, tilted, folded and broken as a whole: they keep their thickness measured along the vertical.
//! - A step that cuts through a whole bed wears all of it as fast as what lay on top: steps should cut less than half the thinnest
//!   bed.
//!
//! # Layers
//! Reads `bed_shift` (m); reads and writes `height`, `bedrock`, `bed_datum` (m); writes `material` (number of a class), `erodibility`
//! and `rock_slope` (1).
//!
//! # Limits
//! Stable for all parameters. Up to 12 beds above the last one, which has no bottom.
//!
//! # Conserves
//! Height is bedrock and loose ground, to the bit. What rises is in the ledger, what comes to light of the bedrock is reported
//! (`tests/it/strata.rs`).

use crate::materials::{Material, standard};
use crate::sequence::{Layered, STRATA, Sequence};
use eyot_core::given::Given;
use eyot_core::layer::known::HEIGHT;
use eyot_core::math64::{cos_degrees, sin_degrees};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, SECONDS_PER_YEAR};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, ParamSet, Read, Rule, Tally, TallyUnit, read};
use eyot_core::{Error, Grid, LayerSpec, Result, World, given, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Strata above the one without a bottom.
pub const MOST_BEDS: usize = 12;
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
/// What lies at the surface.
pub const MATERIAL: LayerSpec =
    LayerSpec::new("material", "1", "Material at the surface, its number in the list of materials", (0.0, 255.0));
pub use eyot_core::layer::known::{BED_LEFT, BEDROCK, ERODIBILITY, ERODIBILITY_BELOW, ROCK_SLOPE};

/// A bed of one material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Bed {
    /// Name of its material.
    pub material: String,
    /// Thickness, measured along the vertical. That of the last bed has no meaning unless the sequence repeats.
    #[schemars(range(min = 0.01, max = 20000.0), extend("unit" = "m"))]
    pub thickness: f32,
}

impl Default for Bed {
    fn default() -> Self {
        Self { material: "sandstone".into(), thickness: 50.0 }
    }
}

/// A wave of the beds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fold {
    /// From crest to crest.
    #[schemars(range(min = 1.0, max = 1000000.0), extend("unit" = "m"))]
    pub wavelength: f32,
    /// Half the way from crest to trough.
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m"))]
    pub amplitude: f32,
    /// Direction across the crests, clockwise from north.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub direction: f32,
    /// Way from the middle of the grid to a crest.
    #[schemars(range(min = -1000000.0, max = 1000000.0), extend("unit" = "m"))]
    pub crest: f32,
}

impl Default for Fold {
    fn default() -> Self {
        Self { wavelength: 4000.0, amplitude: 150.0, direction: 0.0, crest: 0.0 }
    }
}

/// An upright plane along which the beds are displaced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fault {
    /// Direction in which it runs, clockwise from north.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub strike: f32,
    /// How far it passes the middle of the grid, to the right of its direction.
    #[schemars(range(min = -1000000.0, max = 1000000.0), extend("unit" = "m"))]
    pub distance: f32,
    /// How much higher the beds lie to the right of it.
    #[schemars(range(min = -10000.0, max = 10000.0), extend("unit" = "m"))]
    pub throw: f32,
}

impl Default for Fault {
    fn default() -> Self {
        Self { strike: 0.0, distance: 0.0, throw: 100.0 }
    }
}

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

fn bad(field: &str, reason: String) -> Error {
    Error::BadParameter { owner: "strata".into(), field: field.into(), reason }
}

fn tangent(degrees: f32) -> f64 {
    sin_degrees(f64::from(degrees)) / cos_degrees(f64::from(degrees))
}

impl Strata {
    fn number(&self, field: &str, name: &str) -> Result<usize> {
        self.materials.iter().position(|m| m.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.materials.iter().map(|m| m.name.as_str()).collect();
            bad(field, format!("there is no material `{name}`; there are {}", names.join(", ")))
        })
    }

    /// What a world keeps of its beds.
    ///
    /// # Errors
    /// If there is no material of a name.
    pub fn sequence(&self) -> Result<Sequence> {
        let bed = |bed: &Bed| {
            let material = self.number("beds.material", &bed.material)? as u8;
            Ok(Layered { material, thickness_m: bed.thickness })
        };
        Ok(Sequence {
            materials: self.materials.clone(),
            loose: self.number("loose", &self.loose)? as u8,
            beds: self.beds.iter().map(bed).collect::<Result<_>>()?,
            repeat: self.repeat,
        })
    }

    /// Thickness of the whole sequence, m.
    fn sequence_m(&self) -> f32 {
        self.beds.iter().map(|b| b.thickness).sum()
    }

    /// Finds numbers and counts that cannot be; names are looked up by [`Strata::profile`].
    fn fits(&self) -> Result<()> {
        let fit = |what: &str, value: f32, low: f32, high: f32| {
            let fits = (low..=high).contains(&value);
            if fits { Ok(()) } else { Err(bad(what, format!("{value} is outside {low}..={high}"))) }
        };
        if self.materials.len() > 255 {
            return Err(bad("materials", format!("{} materials; there can be 255", self.materials.len())));
        }
        for m in &self.materials {
            fit(&format!("materials.{}.talus", m.name), m.talus, 1.0, 89.0)?;
            fit(&format!("materials.{}.erodibility", m.name), m.erodibility, 0.0, 1000.0)?;
            fit(&format!("materials.{}.density", m.name), m.density, 100.0, 10000.0)?;
            if self.materials.iter().filter(|o| o.name == m.name).count() > 1 {
                return Err(bad("materials", format!("there are two of the name `{}`", m.name)));
            }
        }
        for (what, count) in [("folds", self.folds.len()), ("faults", self.faults.len())] {
            if count > MOST_BENDS {
                return Err(bad(what, format!("{count} {what}; there can be {MOST_BENDS}")));
            }
        }
        for f in &self.folds {
            fit("folds.wavelength", f.wavelength, 1.0, 1e6)?;
            fit("folds.amplitude", f.amplitude, 0.0, 1e4)?;
            fit("folds.direction", f.direction, -360.0, 360.0)?;
            fit("folds.crest", f.crest, -1e6, 1e6)?;
        }
        for f in &self.faults {
            fit("faults.strike", f.strike, -360.0, 360.0)?;
            fit("faults.distance", f.distance, -1e6, 1e6)?;
            fit("faults.throw", f.throw, -1e4, 1e4)?;
        }
        self.beds.iter().try_for_each(|bed| fit("beds.thickness", bed.thickness, 0.01, 20000.0))
    }

    /// Bottoms of the beds below the datum, m, with their materials: of a sequence that has been checked, since every step asks for it.
    ///
    /// # Errors
    /// If there are too few or too many beds, or no material of a name.
    fn profile(&self) -> Result<Profile<f32>> {
        if self.beds.is_empty() || self.beds.len() > MOST_BEDS + 1 {
            return Err(bad("beds", format!("{} beds; there can be 1 to {}", self.beds.len(), MOST_BEDS + 1)));
        }
        let layer = |bottom: f32, n: usize| {
            let m = &self.materials[n];
            [bottom, n as f32, m.erodibility, tangent(m.talus) as f32]
        };
        let loose = layer(0.0, self.number("loose", &self.loose)?);
        let mut beds = [[-1e30; 4]; MOST_BEDS];
        let (mut bottom, mut last) = (0.0, loose);
        for (i, bed) in self.beds.iter().enumerate() {
            bottom += bed.thickness;
            last = layer(bottom, self.number("beds.material", &bed.material)?);
            if i + 1 < self.beds.len() {
                beds[i] = last;
            }
        }
        Ok(Profile { beds, last, loose })
    }
}

/// Bottom below the datum (m), number, erodibility and tangent of the steepest slope of each bed.
#[derive(Clone, Copy)]
struct Profile<T> {
    beds: [[T; 4]; MOST_BEDS],
    last: [T; 4],
    loose: [T; 4],
}

impl Process for Strata {
    fn layers(&self) -> Vec<LayerUse> {
        vec![
            HEIGHT.changed(0.0),
            BED_SHIFT.read(0.0),
            BED_DATUM.changed(0.0),
            BEDROCK.changed(0.0),
            MATERIAL.written(0.0),
            ERODIBILITY.written(1.0),
            ROCK_SLOPE.written(1.0),
        ]
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
        let beds = profile.beds.map(|bed| bed.map(given));
        let sequence = if self.repeat { self.sequence_m() } else { 0.0 };
        plan.push_given::<Expose>(ExposeParams {
            beds,
            last: profile.last.map(given),
            loose: profile.loose.map(given),
            sequence: sequence.into(),
            per_sequence: if self.repeat { 1.0 / sequence } else { 0.0 }.into(),
            per_cover: 1.0 / given!(plan, self.cover),
            soil: given!(plan, self.soil) * self.years_per_step,
            per_soil_depth: 1.0 / given!(plan, self.soil_depth),
        });
    }
}

impl Strata {
    fn lie(&self, grid: &Grid) -> LieParams<f32> {
        let cell = [grid.cell_x_m, grid.cell_y_m];
        // Columns to the east and rows to the south, in metres.
        let along = |degrees: f32| {
            let d = f64::from(degrees);
            [sin_degrees(d) * cell[0], -cos_degrees(d) * cell[1]]
        };
        let sink = along(self.dip_direction).map(|c| (tangent(self.dip) * c) as f32);
        let mut p = LieParams {
            middle: [0.5 * (grid.width as f32 - 1.0), 0.5 * (grid.height as f32 - 1.0)],
            top: self.top,
            sink,
            folds: [[0.0; 4]; MOST_BENDS],
            faults: [[0.0; 4]; MOST_BENDS],
        };
        for (to, f) in p.folds.iter_mut().zip(&self.folds) {
            let turns = std::f64::consts::TAU / f64::from(f.wavelength);
            let [x, y] = along(f.direction).map(|c| (turns * c) as f32);
            *to = [x, y, (turns * f64::from(f.crest)) as f32, f.amplitude];
        }
        for (to, f) in p.faults.iter_mut().zip(&self.faults) {
            // To the right of its direction.
            let [x, y] = along(f.strike + 90.0).map(|c| c as f32);
            *to = [x, y, f.distance, f.throw];
        }
        p
    }
}

/// Parameters of [`Expose`].
#[derive(Clone, Copy, Debug)]
pub struct ExposeParams<T> {
    /// The beds from the top: bottom below the datum (m), number of the material, erodibility, tangent of the steepest slope. Those
    /// that are missing end above everything.
    pub beds: [[T; 4]; MOST_BEDS],
    /// The bed without a bottom, in the same way.
    pub last: [T; 4],
    /// Loose ground, in the same way.
    pub loose: [T; 4],
    /// Thickness of the sequence if it repeats, else 0, m.
    pub sequence: T,
    /// `1 / sequence`, or 0, 1/m.
    pub per_sequence: T,
    /// `1 / cover`, 1/m.
    pub per_cover: T,
    /// Bare rock that becomes soil in a step, m.
    pub soil: T,
    /// `1 / soil_depth`, 1/m.
    pub per_soil_depth: T,
}

const EXPOSE: &[&str] = &[
    "bottom_0",
    "material_0",
    "erodibility_0",
    "slope_0",
    "bottom_1",
    "material_1",
    "erodibility_1",
    "slope_1",
    "bottom_2",
    "material_2",
    "erodibility_2",
    "slope_2",
    "bottom_3",
    "material_3",
    "erodibility_3",
    "slope_3",
    "bottom_4",
    "material_4",
    "erodibility_4",
    "slope_4",
    "bottom_5",
    "material_5",
    "erodibility_5",
    "slope_5",
    "bottom_6",
    "material_6",
    "erodibility_6",
    "slope_6",
    "bottom_7",
    "material_7",
    "erodibility_7",
    "slope_7",
    "bottom_8",
    "material_8",
    "erodibility_8",
    "slope_8",
    "bottom_9",
    "material_9",
    "erodibility_9",
    "slope_9",
    "bottom_10",
    "material_10",
    "erodibility_10",
    "slope_10",
    "bottom_11",
    "material_11",
    "erodibility_11",
    "slope_11",
    "last_bottom",
    "last_material",
    "last_erodibility",
    "last_slope",
    "loose_bottom",
    "loose_material",
    "loose_erodibility",
    "loose_slope",
    "sequence",
    "per_sequence",
    "per_cover",
    "soil",
    "per_soil_depth",
];

impl ParamSet for ExposeParams<()> {
    type Of<T: Copy + 'static> = ExposeParams<T>;
    const NAMES: &'static [&'static str] = EXPOSE;

    fn build<U: Copy + 'static>(mut f: impl FnMut(&'static str) -> U) -> ExposeParams<U> {
        let mut names = EXPOSE.iter();
        let mut next = || f(names.next().copied().unwrap_or_default());
        ExposeParams {
            beds: std::array::from_fn(|_| std::array::from_fn(|_| next())),
            last: std::array::from_fn(|_| next()),
            loose: std::array::from_fn(|_| next()),
            sequence: next(),
            per_sequence: next(),
            per_cover: next(),
            soil: next(),
            per_soil_depth: next(),
        }
    }

    #[inline(always)]
    fn map<T: Copy + 'static, U: Copy + 'static>(
        p: &ExposeParams<T>,
        mut f: impl FnMut(&'static str, T) -> U,
    ) -> ExposeParams<U> {
        let mut names = EXPOSE.iter();
        let mut next = |v: T| f(names.next().copied().unwrap_or_default(), v);
        ExposeParams {
            beds: p.beds.map(|bed| bed.map(&mut next)),
            last: p.last.map(&mut next),
            loose: p.loose.map(&mut next),
            sequence: next(p.sequence),
            per_sequence: next(p.per_sequence),
            per_cover: next(p.per_cover),
            soil: next(p.soil),
            per_soil_depth: next(p.per_soil_depth),
        }
    }
}

/// Equations (1) to (4).
pub struct Expose;

impl Rule for Expose {
    const NAME: &'static str = "strata_expose";
    const READS: &'static [Read] = &[read("height", 0), read("bedrock", 0), read("bed_datum", 0)];
    const WRITES: &'static [&'static str] = &["bedrock", "material", "erodibility", "rock_slope"];
    const TALLIES: &'static [Tally] = &[
        Tally {
            account: "rock.worn",
            unit: TallyUnit::Thickness,
            sign: 0,
            meaning: "Bedrock that others took from the height",
        },
        Tally { account: "rock.weathered", unit: TallyUnit::Thickness, sign: 0, meaning: "Bedrock that became soil" },
    ];
    type Params = ExposeParams<()>;
    type Out<R: Real> = [R; 4];
    type Sums<R: Real> = [R; 2];

    #[inline(always)]
    fn cell<R: Real>(p: &ExposeParams<R>, c: &impl Cell<R>) -> ([R; 4], [R; 2]) {
        let (height, before, datum) = (c.here(0), c.here(1), c.here(2));
        let worn = before.min(height);
        let buried = height - worn;
        let rock = (worn - p.soil * (-(buried * p.per_soil_depth)).exp()).named("(2) bedrock");
        let depth = datum - rock;
        let depth = depth - p.sequence * (depth * p.per_sequence).floor();
        let mut here = p.last;
        // From below, so that the uppermost bed that reaches down to here is the last to be chosen.
        let mut i = MOST_BEDS;
        while i > 0 {
            i -= 1;
            let bed = p.beds[i];
            let inside = depth.lt(bed[0]);
            here = [here[0], inside.pick(bed[1], here[1]), inside.pick(bed[2], here[2]), inside.pick(bed[3], here[3])];
        }
        let loose = height - rock;
        let bare = (-(loose * p.per_cover)).exp();
        // As in (4), a cover that shelters two thirds is what one sees.
        let material = (loose * p.per_cover).lt(R::of(1.0)).pick(here[1], p.loose[1]);
        let erodibility = p.loose[2] + (here[2] - p.loose[2]) * bare;
        ([rock, material, erodibility, here[3]], [before - worn, worn - rock])
    }
}

rule_params! {
    /// Parameters of [`Lift`].
    pub struct LiftParams {
        /// What land and beds rise by in a step, m.
        risen,
    }
}

/// Equation (6).
pub struct Lift;

impl Rule for Lift {
    const NAME: &'static str = "strata_lift";
    const READS: &'static [Read] = &[read("height", 0), read("bedrock", 0), read("bed_datum", 0)];
    const WRITES: &'static [&'static str] = &["height", "bedrock", "bed_datum"];
    const TALLIES: &'static [Tally] =
        &[Tally { account: "ground.uplifted", unit: TallyUnit::Thickness, sign: 1, meaning: "Ground that rose" }];
    type Params = LiftParams<()>;
    type Out<R: Real> = [R; 3];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &LiftParams<R>, c: &impl Cell<R>) -> ([R; 3], [R; 1]) {
        // All by what the height really rose by, so that nothing loose comes or goes by rounding; no compiler may see that it is
        // `p.risen` but for that.
        let height = (c.here(0) + p.risen).no_contract();
        let risen = height - c.here(0);
        ([height, c.here(1) + risen, c.here(2) + risen], [risen])
    }
}

rule_params! {
    /// Parameters of [`Bury`].
    pub struct BuryParams {
        /// Thickness of the loose ground, m.
        regolith,
    }
}

/// The bedrock at the start: below the loose ground.
pub struct Bury;

impl Rule for Bury {
    const NAME: &'static str = "strata_bury";
    const READS: &'static [Read] = &[read("height", 0)];
    const WRITES: &'static [&'static str] = &["bedrock"];
    type Params = BuryParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &BuryParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        ([c.here(0) - p.regolith], [])
    }
}

/// Parameters of [`Lie`].
#[derive(Clone, Copy, Debug)]
pub struct LieParams<T> {
    /// The middle of the grid, column and row.
    pub middle: [T; 2],
    /// Height of the top there, m.
    pub top: T,
    /// What beds sink by to the next column and row, m.
    pub sink: [T; 2],
    /// Folds: radians to the next column and row, radians at the middle, amplitude (m).
    pub folds: [[T; 4]; MOST_BENDS],
    /// Faults: metres away from it to the next column and row, metres at the middle, throw (m).
    pub faults: [[T; 4]; MOST_BENDS],
}

const LIE: &[&str] = &[
    "middle_x",
    "middle_y",
    "top",
    "sink_x",
    "sink_y",
    "fold_x_0",
    "fold_y_0",
    "fold_phase_0",
    "fold_amplitude_0",
    "fold_x_1",
    "fold_y_1",
    "fold_phase_1",
    "fold_amplitude_1",
    "fold_x_2",
    "fold_y_2",
    "fold_phase_2",
    "fold_amplitude_2",
    "fold_x_3",
    "fold_y_3",
    "fold_phase_3",
    "fold_amplitude_3",
    "fault_x_0",
    "fault_y_0",
    "fault_distance_0",
    "fault_throw_0",
    "fault_x_1",
    "fault_y_1",
    "fault_distance_1",
    "fault_throw_1",
    "fault_x_2",
    "fault_y_2",
    "fault_distance_2",
    "fault_throw_2",
    "fault_x_3",
    "fault_y_3",
    "fault_distance_3",
    "fault_throw_3",
];

impl ParamSet for LieParams<()> {
    type Of<T: Copy + 'static> = LieParams<T>;
    const NAMES: &'static [&'static str] = LIE;

    fn build<U: Copy + 'static>(mut f: impl FnMut(&'static str) -> U) -> LieParams<U> {
        let mut names = LIE.iter();
        let mut next = || f(names.next().copied().unwrap_or_default());
        LieParams {
            middle: std::array::from_fn(|_| next()),
            top: next(),
            sink: std::array::from_fn(|_| next()),
            folds: std::array::from_fn(|_| std::array::from_fn(|_| next())),
            faults: std::array::from_fn(|_| std::array::from_fn(|_| next())),
        }
    }

    #[inline(always)]
    fn map<T: Copy + 'static, U: Copy + 'static>(
        p: &LieParams<T>,
        mut f: impl FnMut(&'static str, T) -> U,
    ) -> LieParams<U> {
        let mut names = LIE.iter();
        let mut next = |v: T| f(names.next().copied().unwrap_or_default(), v);
        LieParams {
            middle: p.middle.map(&mut next),
            top: next(p.top),
            sink: p.sink.map(&mut next),
            folds: p.folds.map(|fold| fold.map(&mut next)),
            faults: p.faults.map(|fault| fault.map(&mut next)),
        }
    }
}

/// Equation (5).
pub struct Lie;

impl Rule for Lie {
    const NAME: &'static str = "strata_lie";
    const READS: &'static [Read] = &[read("bed_shift", 0)];
    const WRITES: &'static [&'static str] = &["bed_datum"];
    type Params = LieParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &LieParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let (x, y) = (c.x() - p.middle[0], c.y() - p.middle[1]);
        let mut datum = p.top + c.here(0) - (p.sink[0] * x + p.sink[1] * y);
        let mut i = 0;
        while i < MOST_BENDS {
            let [fold, fault] = [p.folds[i], p.faults[i]];
            datum = datum + fold[3] * (fold[0] * x + fold[1] * y - fold[2]).cos();
            let right = (fault[0] * x + fault[1] * y - fault[2]).gt(R::of(0.0));
            datum = datum + right.pick(fault[3], R::of(0.0));
            i += 1;
        }
        ([datum], [])
    }
}
