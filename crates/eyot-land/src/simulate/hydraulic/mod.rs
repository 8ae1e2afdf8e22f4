//! Hydraulic erosion: rain runs down, digs where it is fast and settles where it is slow.
//!
//! # Equations
//! `h` ground, `d` depth of water, `s` suspended sediment (thickness), `f` flux through an edge (m/s: discharge over the
//! cell's area), `l` cell size, `t` time step, `c = sqrt(g H)` wave speed with `H` the wave depth.
//! 1. `f' = e^(-r t) f + w t c^2 / l^2 (h + d - h_n - d_n)` for each edge, positive east and south, `r` friction. To eight
//!    neighbours `w = 2/3`, to diagonal ones `1/6`; with four `w = 1`. On cells of `dx` by `dy`:
//!    `1 / (3 (dx^2 + dy^2))` instead of `w / l^2` diagonally, `1 / dx^2 - 2 / (3 (dx^2 + dy^2))` eastward.
//! 2. `K = min(1, d / (t sum of outflows))`; every flux is scaled by the `K` of the cell that it leaves.
//! 3. `d1 = d + t (sum of inflows - sum of outflows)`.
//! 4. `v = 1/2 sum(f (x_n - x)) / max(d_mean, dry)` over all edges, from where `f` comes to where it goes; `|v| <= max_speed`;
//!    0 where `d_mean <= dry`.
//! 5. `sin a = |grad h| / sqrt(1 + |grad h|^2)`, kept within its limits; central differences over `2 l`, of three rows and
//!    columns with weights 1/6, 2/3, 1/6.
//! 6. `C = capacity |v| sin a min(1, d_mean / ramp_depth)`.
//! 7. sediment leaves in proportion to water: `s1 = s + t sum(f K s / d)` over inflows minus outflows; then where
//!    `C > s1`: `h -= e, s1 += e` with `e = min((1 - e^(-dig t)) (C - s1), dig_limit (h - lowest neighbour))`,
//!    else `h += e, s1 -= e` with `e = (1 - e^(-settle t)) (s1 - C)`. By rock, `E` times as much is dug, with `E` the layer
//!    `erodibility`: `1 - e^(-dig t)` becomes `min(1, E (1 - e^(-dig t)))`, and `dig_limit` becomes `min(1, E) dig_limit`.
//! 8. `d' = e^(-evaporation t) d1 + t rain`. Under the sea water joins the sea and all sediment settles.
//!
//! # Source
//! Mei, Decaudin and Hu 2007; pipes after O'Brien and Hodgins 1995.
//!
//! # Differences
//! - Water, sediment and slopes see eight neighbours. With four, channels along rows and columns win over those between them:
//!   of the steps of small channels 0.26 to 0.35 are diagonal where isotropic ones would have 0.41. `flux = "signed"` keeps
//!   four (`tests/it/directions.rs`).
//! - One signed flux an edge instead of four one-way fluxes a cell: those run waves sqrt 2 too fast after the first
//!   reversal and need half the time step (`tests/it/hydraulic_waves.rs`). `flux = "classic"` keeps the published form.
//! - The capacity has a ramp with depth; without it films erode everywhere and no rivers form.
//! - Sediment moves with the flux and is conserved; tracing it back along the velocity loses nearly all of it.
//! - The load changes by what the ground really changed by after rounding, not by the computed amount. At a height of 40 m
//!   a float has steps of 4e-6 m; ten thousand roundings of that size made 4e-5 of the ground out of nothing, now 9e-10.
//! - Digging is limited by the drop to the lowest neighbour, so that pits do not run away.
//! - Pipes do not know the friction of a bed. A pipe on a slope `S` carries `g H S / r` at last, with the defaults 98 m2/s on
//!   a slope of 0.1, far more than a film of water has: the `K` of (2) is then below 1, all water leaves its cell in a step, and
//!   `l / t` (20 m/s) is its speed. `max_speed` stands for the bed: it is in force in most steps of wet cells
//!   (`hydraulic.speed_capped`), as it is meant to be, and the ramp of (6) lets films carry little. On fBm with the defaults it
//!   acts in 86 of 100 steps of wet cells and in all films below 0.1 m; where `l / t <= max_speed`, in nearly none.
//! - The pipe model is not shallow water: its wave speed does not depend on the depth.
//!
//! # Layers
//! Reads and writes `height` (m), `water` (m), `sediment` (m), `flux_x`, `flux_y`, `flux_se` and `flux_sw` (m/s);
//! reads `springs` (1) if they flow, and `erodibility` (1) by rock.
//!
//! # Limits
//! Stable for `t <= l / (sqrt 2 c)` (half that for the classic form); longer steps are cut into equal parts of at most 0.9
//! of it; steps that would need more than a thousand parts are refused.
//!
//! # Conserves
//! Ground + sediment, and water with rain, evaporation and drainage in the ledger, to rounding
//! (`tests/it/hydraulic_conservation.rs`).

mod classic;
mod eight;
mod signed;

use super::{ends, face};
use eyot_core::given::Given;
use eyot_core::layer::known::{ERODIBILITY, HEIGHT, SEDIMENT, WATER};
use eyot_core::math;
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process};
use eyot_core::real::Real;
use eyot_core::{Centering, Error, Grid, LayerSpec, Result, given};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use classic::{ClassicAdvect, ClassicErode, ClassicFlux};
pub use eight::{EightErode, EightFlux, EightParams};
pub use signed::{Erode, ErodeParams, Flux, FluxParams, Spring, SpringParams};

/// Rain runs down, digs where it is fast and settles where it is slow: valleys, rivers, fans.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Hydraulic {
    /// Duration of a step. Longer steps do more at once; beyond the stability bound they are cut into parts.
    #[schemars(range(min = 0.0001, max = 1000.0), extend("unit" = "s", "between_cells" = true))]
    pub time_step: f32,
    /// Rain. More of it makes wider and deeper channels; far too much floods the land and nothing but mud remains.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "m/s"))]
    pub rain: f32,
    /// Strength of the springs in the layer `springs` (0 to 1), which a generator step must have made; 0 needs none.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m/s"))]
    pub springs: f32,
    /// Share of the water that evaporates in a second. Too little fills every hollow, too much leaves rivers dry.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1/s"))]
    pub evaporation: f32,
    /// Gravity.
    #[schemars(range(min = 0.01, max = 100.0), extend("unit" = "m/s2"))]
    pub gravity: f32,
    /// Depth whose long waves are as fast as the model's: the pipe's cross-section over the cell size. Larger values move
    /// water faster and need shorter steps.
    #[schemars(range(min = 0.001, max = 10000.0), extend("unit" = "m"))]
    pub wave_depth: f32,
    /// Rate at which flow loses its momentum. Too little lets lakes slosh, too much makes water creep.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "1/s"))]
    pub friction: f32,
    /// Speed that the sediment feels at most. Films on cliffs would otherwise count as the fastest rivers.
    #[schemars(range(min = 0.01, max = 1000.0), extend("unit" = "m/s"))]
    pub max_speed: f32,
    /// Sediment that a metre per second of water on a vertical slope carries. More digs deeper and builds larger fans.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "s"))]
    pub capacity: f32,
    /// Sine of the slope that the sediment feels at least, so that rivers on plains still carry some.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub min_slope: f32,
    /// Sine of the slope that the sediment feels at most.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub max_slope: f32,
    /// Depth from which on the full capacity counts. This is what makes rivers: without it films erode everywhere.
    #[schemars(range(min = 0.0001, max = 1000.0), extend("unit" = "m"))]
    pub ramp_depth: f32,
    /// Depth below which water carries nothing.
    #[schemars(range(min = 0.000001, max = 10.0), extend("unit" = "m"))]
    pub dry_depth: f32,
    /// Rate at which missing load is dug from the ground.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "1/s"))]
    pub dig: f32,
    /// Rate at which surplus load settles.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "1/s"))]
    pub settle: f32,
    /// Share of the drop to the lowest neighbour that may be dug in one step. Above 0.5 cells undercut each other.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub dig_limit: f32,
    /// Does water that reaches the sea join it? Off, the ground below sea level fills with fresh water.
    pub sea: bool,
    /// Is rock dug by its kind, as the layer `erodibility` has it, which `strata` writes? Off, all ground is dug as if it were
    /// loose.
    pub by_rock: bool,
    /// The form of the flux.
    pub flux: FluxForm,
}

/// How flux is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum FluxForm {
    /// One signed flux to each of eight neighbours; sediment moves with it. Gullies run as the land falls.
    #[default]
    Eight,
    /// One signed flux to each of four neighbours: less work, but gullies follow the grid.
    Signed,
    /// Four one-way fluxes a cell and sediment traced back along the velocity, as published in 2007; for comparison.
    Classic,
}

impl Default for Hydraulic {
    /// The measured recipe that makes rivers, for cells of about ten metres.
    fn default() -> Self {
        Self {
            time_step: 0.5,
            rain: 0.004,
            springs: 0.0,
            evaporation: 0.01,
            gravity: 9.81,
            wave_depth: 10.0,
            friction: 0.1,
            max_speed: 10.0,
            capacity: 1.0,
            min_slope: 0.05,
            max_slope: 0.5,
            ramp_depth: 0.5,
            dry_depth: 0.005,
            dig: 0.1,
            settle: 0.1,
            dig_limit: 0.25,
            sea: true,
            by_rock: false,
            flux: FluxForm::Eight,
        }
    }
}

const FLUX: (f32, f32) = (-1e9, 1e9);
/// Layer of the flux through eastern edges.
pub const FLUX_X: LayerSpec =
    face("flux_x", "Flux of water through the eastern edge, over the cell's area", Centering::FaceX);
/// Layer of the flux through southern edges.
pub const FLUX_Y: LayerSpec =
    face("flux_y", "Flux of water through the southern edge, over the cell's area", Centering::FaceY);
/// Layer of springs.
pub const SPRINGS: LayerSpec =
    LayerSpec::new("springs", "1", "Where springs rise, and how strong they are", (0.0, 1.0));
/// Layer of the flux to the south-eastern neighbour.
pub const FLUX_SE: LayerSpec =
    diagonal("flux_se", "Flux of water to the south-eastern neighbour, over the cell's area");
/// Layer of the flux to the south-western neighbour.
pub const FLUX_SW: LayerSpec =
    diagonal("flux_sw", "Flux of water to the south-western neighbour, over the cell's area");
const RAW_SE: LayerSpec = diagonal("raw_se", "Flux before it is limited to what is there");
const RAW_SW: LayerSpec = diagonal("raw_sw", "Flux before it is limited to what is there");
const RAW_X: LayerSpec = face("raw_x", "Flux before it is limited to what is there", Centering::FaceX);
const RAW_Y: LayerSpec = face("raw_y", "Flux before it is limited to what is there", Centering::FaceY);
const AFFORD: LayerSpec =
    LayerSpec::new("afford", "1", "Share of its raw outflow that a cell has", (0.0, 1.0)).empty_outside();
const AFFORD_SEDIMENT: LayerSpec =
    LayerSpec::new("afford_sediment", "1", "Sediment that leaves with a unit of raw outflow", (0.0, 1e9))
        .empty_outside();
const OUTFLOW: [LayerSpec; 4] = [
    outflow("outflow_west", "Flux out to the west"),
    outflow("outflow_east", "Flux out to the east"),
    outflow("outflow_north", "Flux out to the north"),
    outflow("outflow_south", "Flux out to the south"),
];
const SPEED_X: LayerSpec = LayerSpec::new("speed_x", "m/s", "Velocity to the east", FLUX);
const SPEED_Y: LayerSpec = LayerSpec::new("speed_y", "m/s", "Velocity to the south", FLUX);

/// A flux that no rim lets through.
const fn diagonal(name: &'static str, meaning: &'static str) -> LayerSpec {
    let mut spec = LayerSpec::new(name, "m/s", meaning, FLUX).empty_outside();
    spec.beyond_closed = eyot_core::GhostFill::Zero;
    spec
}

const fn outflow(name: &'static str, meaning: &'static str) -> LayerSpec {
    // A one-way flux of a cell that does not exist is zero: nothing flows in over the rim.
    let mut spec = LayerSpec::new(name, "m/s", meaning, (0.0, 1e9)).empty_outside();
    spec.beyond_closed = eyot_core::GhostFill::Zero;
    spec
}

/// Parts of a step that are worth planning; more of them mean a mistake in the units.
const MAX_PARTS: u32 = 1000;
/// Height of the sea where there is none.
const NO_SEA: f32 = -1e30;

impl Hydraulic {
    /// Equal parts into which a step is cut, and their duration in s.
    pub fn substeps(&self, dx_m: f64, dy_m: f64) -> (u32, f32) {
        let speed = (f64::from(self.gravity) * f64::from(self.wave_depth)).sqrt();
        let bound = 1.0 / (speed * (1.0 / (dx_m * dx_m) + 1.0 / (dy_m * dy_m)).sqrt());
        let bound = match self.flux {
            FluxForm::Eight | FluxForm::Signed => bound,
            FluxForm::Classic => bound / std::f64::consts::SQRT_2,
        };
        let parts = (f64::from(self.time_step) / (0.9 * bound)).ceil().max(1.0);
        (parts as u32, (f64::from(self.time_step) / parts) as f32)
    }
}

impl Process for Hydraulic {
    fn layers(&self) -> Vec<LayerUse> {
        let mut layers = vec![HEIGHT.changed(0.0), WATER.changed(0.0), SEDIMENT.changed(0.0)];
        match self.flux {
            FluxForm::Eight => layers.extend([FLUX_X, FLUX_Y, FLUX_SE, FLUX_SW].map(|f| f.changed(0.0))),
            FluxForm::Signed => layers.extend([FLUX_X, FLUX_Y].map(|f| f.changed(0.0))),
            FluxForm::Classic => layers.extend(OUTFLOW.map(|o| o.changed(0.0))),
        }
        if self.by_rock {
            layers.push(ERODIBILITY.read(1.0));
        }
        layers
    }

    fn check(&self, grid: &Grid) -> Result<()> {
        let (x, y) = (grid.cell_x_m, grid.cell_y_m);
        let (parts, _) = self.substeps(x, y);
        if parts > MAX_PARTS {
            return Err(Error::BadParameter {
                owner: "hydraulic".into(),
                field: "time_step".into(),
                reason: format!(
                    "{} s needs {parts} sub-steps on cells of {x} x {y} m, at most {MAX_PARTS} are allowed; lower it, gravity or \
                     wave_depth, or choose larger cells",
                    self.time_step
                ),
            });
        }
        Ok(())
    }

    fn needs(&self) -> Vec<&'static str> {
        if self.springs > 0.0 { vec!["springs"] } else { Vec::new() }
    }

    fn seconds_per_step(&self, _grid: &Grid) -> Option<f64> {
        Some(f64::from(self.time_step))
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let (dx, dy) = (moment.grid.cell_x_m as f32, moment.grid.cell_y_m as f32);
        let (parts, dt) = self.substeps(moment.grid.cell_x_m, moment.grid.cell_y_m);
        let c2 = self.gravity * self.wave_depth;
        let sea = if self.sea { moment.sea_level_m as f32 } else { NO_SEA };
        let flux = FluxParams::<Given> {
            push_x: (dt * c2 / (dx * dx)).into(),
            push_y: (dt * c2 / (dy * dy)).into(),
            keep: math::exp(-given!(plan, self.friction) * dt),
            dt: dt.into(),
            sea: sea.into(),
        };
        let [first_x, last_x] = ends(moment.grid.width, moment.grid.rim.x);
        let [first_y, last_y] = ends(moment.grid.height, moment.grid.rim.y);
        let eight = EightParams::<Given> {
            push_x: flux.push_x,
            push_y: flux.push_y,
            push_d: (dt * c2 / (3.0 * (dx * dx + dy * dy))).into(),
            keep: flux.keep,
            dt: flux.dt,
            sea: flux.sea,
            first_x: first_x.into(),
            last_x: last_x.into(),
            first_y: first_y.into(),
            last_y: last_y.into(),
        };
        let (max_speed, min_slope) = (given!(plan, self.max_speed), given!(plan, self.min_slope));
        let max_slope = given!(plan, self.max_slope).max(min_slope);
        let erode = ErodeParams::<Given> {
            dt: dt.into(),
            dx: dx.into(),
            dy: dy.into(),
            slope_x: (0.5 / dx).into(),
            slope_y: (0.5 / dy).into(),
            rain: given!(plan, self.rain),
            keep: math::exp(-given!(plan, self.evaporation) * dt),
            dry: given!(plan, self.dry_depth),
            speed2_max: max_speed * max_speed,
            sine2_min: min_slope * min_slope,
            sine2_max: max_slope * max_slope,
            capacity: given!(plan, self.capacity),
            ramp: 1.0 / given!(plan, self.ramp_depth),
            dig: 1.0 - math::exp(-given!(plan, self.dig) * dt),
            settle: 1.0 - math::exp(-given!(plan, self.settle) * dt),
            dig_limit: given!(plan, self.dig_limit),
            sea: sea.into(),
        };
        for _ in 0..parts {
            if self.springs > 0.0 {
                plan.push::<Spring>(SpringParams { gain: self.springs * dt });
            }
            match self.flux {
                FluxForm::Eight => {
                    let scratch = [&RAW_X, &RAW_Y, &RAW_SE, &RAW_SW, &AFFORD, &AFFORD_SEDIMENT];
                    scratch.into_iter().for_each(|s| plan.scratch(s));
                    plan.push_given::<EightFlux>(eight);
                    if self.by_rock {
                        plan.push_given::<EightErode<true>>(erode);
                    } else {
                        plan.push_given::<EightErode>(erode);
                    }
                }
                FluxForm::Signed => {
                    [&RAW_X, &RAW_Y, &AFFORD, &AFFORD_SEDIMENT].into_iter().for_each(|s| plan.scratch(s));
                    plan.push_given::<Flux>(flux);
                    if self.by_rock {
                        plan.push_given::<Erode<true>>(erode);
                    } else {
                        plan.push_given::<Erode>(erode);
                    }
                }
                FluxForm::Classic => {
                    [&SPEED_X, &SPEED_Y].into_iter().for_each(|s| plan.scratch(s));
                    plan.push_given::<ClassicFlux>(flux);
                    if self.by_rock {
                        plan.push_given::<ClassicErode<true>>(erode);
                    } else {
                        plan.push_given::<ClassicErode>(erode);
                    }
                    plan.push_given::<ClassicAdvect>(erode);
                }
            }
        }
    }
}
