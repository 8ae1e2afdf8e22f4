//! Plants: cohorts of thirteen types that grow, shade each other, seed, burn and hold the ground, year by year.
//!
//! # Equations
//! Each type has a cohort in each cell: dry matter `b` (kg/m2) and the diameter `D` (m) of its stems, `n = b / m(D)` of them on a m2. `t`
//! temperature, a mean and a swing over the year; `A(z)` leaf area above `z`; `s` the type's tolerance of shade.
//! 1. `warmth`: degrees above 5 °C, summed over the days of the year; winter and summer are the mean less and plus the swing.
//! 2. Trees grow where at least 94 days are above 0.9 °C and have a mean of at least 6.4 °C; their growth falls to three tenths at that line.
//! 3. `moisture = rain soil' (1 + hollows ln(1 + area / 1 ha) / 10) / E`, at most doubled, with the potential evaporation `E = 58.93 B` of the
//!    biotemperature `B`, and `soil' = 1.25 d / (d + 0.25 m)` of soil `d`, which thins out to nothing at `slope`. Trees and bushes cover
//!    at most `C = max(2.03 w - 0.142, 0.6 w)`, `w = moisture (E / 1450 mm)^(3/4)`, which is a leaf area of `-2 ln(1 - C)`.
//! 4. `H = H0 + (Hm - H0) x (2 - x)` with `x = D / Dm`; `m = 0.46 wood D^2 H`; `A = 1350 D^(7/4) n`, evenly between `H` and `0.4 H`.
//! 5. `suits`: the product of how well winter, summer, warmth, moisture and the driest month suit a type, each from 0 to 1.
//! 6. `vigour = f(e^(-A(0.7 H) / 2)) suits`, `f` between JABOWA's two curves of light, by `s`.
//! 7. `crowd = max(A(0.4 H) / A_s, A(0) / A_max)`, `A_s` the leaves in whose shade the type can live. In a year `0.4 (crowd - 1)` of the
//!    plants die where it is above 1, a quarter where nothing grows, and 4.6 over the greatest age of all, half of these together, as a gap.
//! 8. `D' = D + G D (1 - D H / (Dm Hm)) / (2 H0 + 3 b2 D - 4 b3 D^2) vigour`, JABOWA, slower where water is short or among grass.
//! 9. `0.08 (1 - crowd) f suits seeds` young plants take root on a m2, with seeds of the cells around, fewer the farther away these are, and
//!    with the chance `far` of distant plants. They count as much for the cohort's diameter as their basal area.
//! 10. Fire goes into a cell with the chance `dry max(grass o, 0.15 cover)`, `o` falling from 1 at a cover of `open` to 0 at `closed`, `dry`
//!     from 0 to 1 by the driest month.
//! 11. It begins in few of these cells, and goes on to those around them so many times as `spread` says.
//! 12. `b' = b + 0.6 (b_max - b)` of grass, by climate and by the light that trees and bushes leave.
//! 13. `forest = 1 - e^(-A / 2)` of trees, `shrubs` likewise; `grass` by 10 m2 of blades a kg.
//! 14. `erodibility = K (1 - hold (1 - (1 - forest) (1 - shrubs) (1 - 0.7 grass)))`, `K` what others wrote there.
//!
//! # Source
//! Types of LPJmL (Schaphoff and others 2018). Growth and light: JABOWA (Botkin, Janak and Wallis 1972). (2) TREELIM (Paulsen and Körner
//! 2014). (3) the upper bound of woody cover of Sankaran and others 2005, with Holdridge's evaporation. (7) the rule of self-thinning
//! (Yoda and others 1963), which follows from leaves that bear no more shade. (10) Staver, Archibald and Levin 2011: grass carries fire where
//! trees cover up to 40 %. Sheltered ground: Cordonnier and others 2017.
//!
//! # Differences
//! - Gap models have single trees, dynamic vegetation models means over wide areas. Here a cohort of a cell of some ten metres is a patch
//!   of trees of one age, and gaps, fires and far seeds fall by chance; on cells of kilometres a cohort is a mean.
//! - A cohort has one size. Young plants among old ones make the mean smaller, not the stand older.
//!
//! # Layers
//! Reads `height`, `water`, `lake` (m), `drained_area` (m2), `river` (1), with `climate = "layers"` those of the process `climate`. Keeps for
//! each type `biomass_TYPE` (kg/m2) and `stem_TYPE` (m). Writes `forest`, `shrubs`, `grass`, `burnt_area`, `leaf_area` (1), `canopy_height` (m),
//! `plant_mass` (kg/m2) and `plant_type` (number of a class). Reads and writes `erodibility` (1), if plants hold the ground.
//!
//! # Limits
//! Stable for all parameters. Seeds and fires go some cells a year, so that both are slower, in metres, on finer grids. Fires
//! come from the grid alone: its rim burns less than its middle.
//!
//! # Conserves
//! Dry matter: what there is is what grew less what died and what burnt (`tests/it/plants.rs`).

pub(crate) mod canopy;
mod fire;
mod grow;
mod show;
mod site;

pub use canopy::{NoParams, Shade, Suit};
pub use fire::{Grass, GrassParams, Kindle, KindleParams, Spread};
pub use grow::{Grow, GrowParams};
pub use show::{Begin, Cover, Disturb, DisturbParams, Ground, Hold, HoldParams, Show};
pub use site::{Site, SiteParams};

use crate::FOREST;
use crate::layers::{
    BURNT, CANOPY_HEIGHT, CLIMATE, ERODIBILITY_BARE, ERODIBILITY_HELD, GRASS, LEAF_AREA, PLANT_MASS, PLANT_TYPE,
    PLANTS_GROUND, RIVER, SCRATCH, SHRUBS,
};
use crate::types::{C3, C4, TYPES, WOODY, biomass, by_name, stem};
use canopy::least;
use eyot_core::layer::known::{DRAINED_AREA, ERODIBILITY, HEIGHT, LAKE, WATER};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, SECONDS_PER_YEAR, check_ranges};
use eyot_core::{Error, Grid, Result, given, math};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the climate comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ClimateFrom {
    /// From the parameters `temperature`, `swing`, `lapse`, `rain` and `dry_season`.
    #[default]
    Given,
    /// From the layers that the process `climate` keeps: means and swings of temperature and rain.
    Layers,
}

/// Cohorts of trees, bushes and grass: they grow, shade each other, seed, burn and hold the ground. A step is a year.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Plants {
    /// Types that grow here, by name.
    pub types: Vec<String>,
    /// Is the climate that of the parameters below, or that of a world's layers?
    pub climate: ClimateFrom,
    /// Mean temperature of the year at the level of the sea.
    #[schemars(range(min = -60.0, max = 50.0), extend("unit" = "°C"))]
    pub temperature: f32,
    /// Half of what the warmest month is warmer than the coldest: 1 K in the tropics, 8 K in western Europe, 20 K in Siberia.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "K"))]
    pub swing: f32,
    /// How much colder a km higher up is.
    #[schemars(range(min = 0.0, max = 15.0), extend("unit" = "K/km"))]
    pub lapse: f32,
    /// Rain of a year.
    #[schemars(range(min = 0.0, max = 20000.0), extend("unit" = "mm/a"))]
    pub rain: f32,
    /// By which share the driest month has less than the mean one: 1 is a month without rain.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub dry_season: f32,
    /// Thickness of the soil where it is level.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m"))]
    pub soil: f32,
    /// Slope that keeps no soil.
    #[schemars(range(min = 1.0, max = 89.0), extend("unit" = "degree"))]
    pub slope: f32,
    /// How much moister valleys are, where `drained_area` is known; 0 leaves it out.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    pub hollows: f32,
    /// Water of this depth drowns plants.
    #[schemars(range(min = 0.001, max = 1000.0), extend("unit" = "m"))]
    pub wet: f32,
    /// Ground that rises or sinks so much in a year leaves no plant.
    #[schemars(range(min = 0.001, max = 1000.0), extend("unit" = "m"))]
    pub slide: f32,
    /// Share of dry grassland that burns in a year; 0 is a world without fires.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1/a"))]
    pub fires: f32,
    /// How often a fire goes on to the cells around it, at most 32.
    #[schemars(range(min = 0, max = 32), extend("unit" = "1"))]
    pub spread: u32,
    /// Cover of trees and bushes up to which grass carries fire.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub open: f32,
    /// Cover from which it does not.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub closed: f32,
    /// Chance that seeds of a type come from far away, cell by cell and year by year.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1/a"))]
    pub far: f32,
    /// Share of the wear that a full cover prevents; 0 leaves `erodibility` alone.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub hold: f32,
}

impl Default for Plants {
    fn default() -> Self {
        Self {
            types: TYPES.map(|t| t.name.to_owned()).into(),
            climate: ClimateFrom::Given,
            temperature: 9.0,
            swing: 9.0,
            lapse: 6.0,
            rain: 900.0,
            dry_season: 0.3,
            soil: 1.0,
            slope: 45.0,
            hollows: 1.0,
            wet: 0.3,
            slide: 0.5,
            fires: 0.6,
            spread: 4,
            open: 0.4,
            closed: 0.6,
            far: 0.01,
            hold: 0.9,
        }
    }
}

/// Trees whose fall opens so much ground, m2.
const GAP_M2: f64 = 900.0;
/// Fires in closed forests of dry countries over those of grassland.
const CROWNS: f32 = 0.02;

/// Calls a function that is generic over the number of a type of trees or bushes.
macro_rules! of_type {
    ($n:expr, $f:ident($($arg:expr),*)) => {
        match $n {
            0 => $f::<0>($($arg),*),
            1 => $f::<1>($($arg),*),
            2 => $f::<2>($($arg),*),
            3 => $f::<3>($($arg),*),
            4 => $f::<4>($($arg),*),
            5 => $f::<5>($($arg),*),
            6 => $f::<6>($($arg),*),
            7 => $f::<7>($($arg),*),
            8 => $f::<8>($($arg),*),
            9 => $f::<9>($($arg),*),
            _ => $f::<10>($($arg),*),
        }
    };
}

fn shade<const T: usize>(plan: &mut Plan) {
    plan.push::<Shade<T>>(NoParams);
}

fn grow<const T: usize>(plan: &mut Plan, params: GrowParams<eyot_core::given::Given>) {
    plan.push::<Suit<T>>(NoParams);
    plan.push_given::<Grow<T>>(params);
}

fn show<const T: usize>(plan: &mut Plan) {
    plan.push::<Show<T>>(NoParams);
}

fn bad(field: &str, reason: String) -> Error {
    Error::BadParameter { owner: "plants".into(), field: field.into(), reason }
}

impl Plants {
    /// Numbers of the types that grow, in the order of the table.
    ///
    /// # Errors
    /// If there is no type of a name, or one twice.
    pub fn numbers(&self) -> Result<Vec<usize>> {
        let mut numbers = Vec::new();
        for name in &self.types {
            let number = by_name(name).ok_or_else(|| {
                let names = TYPES.map(|t| t.name).join(", ");
                bad("types", format!("there is no type `{name}`; there are {names}"))
            })?;
            if numbers.contains(&number) {
                return Err(bad("types", format!("`{name}` stands there twice")));
            }
            numbers.push(number);
        }
        numbers.sort_unstable();
        Ok(numbers)
    }

    fn site(&self, moment: &Moment, plan: &mut Plan) {
        let angle = self.slope.to_radians();
        let steepest = math::sin(angle) / math::cos(angle);
        let sea = moment.sea_level_m as f32;
        let params = SiteParams {
            temperature: given!(plan, self.temperature),
            swing: given!(plan, self.swing),
            lapse: 0.001 * given!(plan, self.lapse),
            rain: given!(plan, self.rain),
            dry_season: given!(plan, self.dry_season),
            soil: given!(plan, self.soil),
            hollows: given!(plan, self.hollows),
            per_2dx: (0.5 / moment.grid.cell_x_m as f32).into(),
            per_2dy: (0.5 / moment.grid.cell_y_m as f32).into(),
            per_steepest: (1.0 / (steepest * steepest)).into(),
            wet: given!(plan, self.wet),
            sea: sea.into(),
            datum: (if sea <= HEIGHT.range.0 { 0.0 } else { sea }).into(),
        };
        match self.climate {
            ClimateFrom::Given => plan.push_given::<Site<false>>(params),
            ClimateFrom::Layers => plan.push_given::<Site<true>>(params),
        }
    }

    /// What a cell's size makes of a type's seeds and gaps.
    fn growth(&self, n: usize, grid: &Grid, plan: &Plan) -> GrowParams<eyot_core::given::Given> {
        let share = |m: f64| math::exp(-(m / f64::from(TYPES[n].seed)) as f32);
        GrowParams {
            east: share(grid.cell_x_m).into(),
            south: share(grid.cell_y_m).into(),
            corner: share(grid.cell_x_m.hypot(grid.cell_y_m)).into(),
            far: given!(plan, self.far),
            gap: (0.9 * (GAP_M2 / grid.cell_area_m2()).min(1.0) as f32).into(),
        }
    }
}

impl Process for Plants {
    fn layers(&self) -> Vec<LayerUse> {
        let read = [HEIGHT, DRAINED_AREA, WATER, LAKE, RIVER].map(|l| l.read(0.0));
        let mut layers = Vec::from(read);
        layers.push(PLANTS_GROUND.changed(0.0));
        for n in self.numbers().unwrap_or_default().into_iter().filter(|n| *n < WOODY) {
            layers.extend([biomass(n).changed(0.0), stem(n).changed(least(&TYPES[n]))]);
        }
        layers.extend([biomass(C3), biomass(C4)].map(|l| l.changed(0.0)));
        layers.extend(
            [FOREST, SHRUBS, GRASS, LEAF_AREA, CANOPY_HEIGHT, PLANT_TYPE, PLANT_MASS, BURNT].map(|l| l.written(0.0)),
        );
        if self.hold > 0.0 {
            layers.push(ERODIBILITY.changed(1.0));
            layers.extend([ERODIBILITY_BARE.changed(1.0), ERODIBILITY_HELD.changed(-1.0)]);
        }
        layers
    }

    fn needs(&self) -> Vec<&'static str> {
        match self.climate {
            ClimateFrom::Given => Vec::new(),
            ClimateFrom::Layers => CLIMATE.into(),
        }
    }

    fn start(&self, name: &str, _moment: &Moment, plan: &mut Plan) {
        if name == PLANTS_GROUND.name {
            plan.push::<Ground>(NoParams);
        }
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("plants", self)?;
        if self.types.is_empty() {
            return Err(bad("types", "no type, so that nothing could grow; name at least one".into()));
        }
        self.numbers()?;
        if self.open >= self.closed {
            return Err(bad(
                "open",
                format!(
                    "grass carries fire up to a cover of {}, which is not below {}, `closed`, from which it does not",
                    self.open, self.closed
                ),
            ));
        }
        Ok(())
    }

    fn seconds_per_step(&self, _grid: &Grid) -> Option<f64> {
        Some(SECONDS_PER_YEAR)
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let Ok(numbers) = self.numbers() else { return };
        SCRATCH.iter().for_each(|spec| plan.scratch(spec));
        let woody = || numbers.iter().copied().filter(|n| *n < WOODY);
        self.site(moment, plan);
        plan.push_given::<Disturb>(DisturbParams { per_slide: 1.0 / given!(plan, self.slide) });
        woody().for_each(|n| of_type!(n, shade(plan)));
        // So many fires that all dry grass of a place burns as often as `fires` says if nothing is in the way of any.
        let cells = (2 * self.spread + 1).pow(2) as f32;
        let lit = 1.0 - math::pow(1.0 - self.fires.min(0.999), 1.0 / cells);
        plan.push_given::<Kindle>(KindleParams {
            lit: lit.into(),
            open: given!(plan, self.open),
            closed: given!(plan, self.closed),
            crowns: CROWNS.into(),
        });
        (0..if self.fires > 0.0 { self.spread } else { 0 }).for_each(|_| plan.push::<Spread>(NoParams));
        for n in woody() {
            let params = self.growth(n, &moment.grid, plan);
            of_type!(n, grow(plan, params));
        }
        let grows = |n: usize| if numbers.contains(&n) { 1.0 } else { 0.0 };
        plan.push::<Grass>(GrassParams { cool: grows(C3), warm: grows(C4) });
        plan.push::<Begin>(NoParams);
        woody().for_each(|n| of_type!(n, show(plan)));
        plan.push::<Cover>(NoParams);
        if self.hold > 0.0 {
            plan.push_given::<Hold>(HoldParams { hold: given!(plan, self.hold) });
        }
    }
}
