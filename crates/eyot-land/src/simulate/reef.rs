//! Reef growth: corals in light, reached by the carbon of the open sea, build limestone.
//!
//! # Equations
//! `w` level of the sea, `g = w - h` depth, `O` carbon relative to the open sea, `T` years of a step.
//! 1. Calcification `c = growth O^2 e^(-g / light_depth)` in m/yr, or after Bosscher and Schlager
//!    `c = growth tanh(surface_light e^(-g attenuation) / saturation_light)`; zero outside `shallow < g < deep`.
//!    With `limit = "light"` the factor `O^2` is left out.
//! 2. `O' = max(0, O - c T uptake / g)`.
//! 3. `O` diffuses between wet neighbours with `diffusivity`; land has none, and the open sea (deeper than `open_sea`, and
//!    the rim) holds it at 1.
//! 4. `h' = h + min(c T, g - shallow) - subsidence T`, and the same gain for `limestone`.
//! 5. `w' = w + rise T + curve(t + T) - curve(t)`.
//! 6. Where sea or ground move, fresh water on ground below `w'` joins the sea, and nothing is wet there.
//!
//! # Source
//! Light and growth after Bosscher and Schlager 1992; subsidence and the sequence fringing reef, barrier reef, atoll after
//! Darwin 1842. Carbon that is used up and diffuses in from the open sea stands for the exchange of water; it is a model, not a
//! measured law.
//!
//! # Differences
//! - Limestone is a layer of its own, as a part of the height; what erosion takes from the height it takes from the
//!   limestone first.
//! - Growth ends exactly at the shallow limit instead of overshooting it by up to a step.
//! - Diffusion is in m2 per year instead of a share per step, so that it means the same on every grid.
//!
//! # Layers
//! Reads and writes `height`, `limestone` (m), `carbon`, `growth` (1), `reef_floor` (m); where sea or ground move, also
//! `water` (m) and `wetness` (1).
//!
//! # Limits
//! Diffusion by plain steps is stable for `diffusivity T (1 / dx^2 + 1 / dy^2) <= 1/2`; longer steps take several stages of the
//! scheme RKL1, whose number grows with the root of that sum (Meyer, Balsara and Aslam 2014).
//!
//! # Conserves
//! Growth and subsidence are in the ledger (`ground.reef`, `ground.subsided`), and so is the carbon that (2) makes where
//! growth wants more than there is (`carbon.clamped`). Fresh water that joins the sea is in `water.drained`.

mod drown;

pub use drown::{Drown, DrownParams};
use eyot_core::given::Given;
use eyot_core::layer::known::{CARBON, GROWTH, HEIGHT, LIMESTONE, WATER, WETNESS};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, SECONDS_PER_YEAR};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, TallyUnit, read};
use eyot_core::{BoundaryCondition, Error, Grid, LayerSpec, Result, World, given, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Corals build limestone in the light, where carbon from the open sea reaches them: fringing reefs, barriers, atolls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Reef {
    /// Years of a step.
    #[schemars(range(min = 0.001, max = 100000.0), extend("unit" = "yr"))]
    pub years_per_step: f32,
    /// Fastest growth: 10 to 15 mm a year for branching corals in the best light (Bosscher and Schlager 1992).
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "m/yr"))]
    pub growth: f32,
    /// What limits growth.
    pub limit: Limit,
    /// How light falls off with depth.
    pub light: Light,
    /// Depth at which the light has fallen to 37 % (light = "exponential").
    #[schemars(range(min = 0.1, max = 1000.0), extend("unit" = "m"))]
    pub light_depth: f32,
    /// Extinction of light (light = "saturating"): 0.04 in the clearest ocean, 0.16 in coastal water.
    #[schemars(range(min = 0.001, max = 10.0), extend("unit" = "1/m"))]
    pub attenuation: f32,
    /// Light at the surface (light = "saturating").
    #[schemars(range(min = 1.0, max = 10000.0), extend("unit" = "uE/m2/s"))]
    pub surface_light: f32,
    /// Light that saturates growth (light = "saturating"): 50 to 450.
    #[schemars(range(min = 1.0, max = 10000.0), extend("unit" = "uE/m2/s"))]
    pub saturation_light: f32,
    /// Corals grow only deeper than this: low tide.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m"))]
    pub shallow: f32,
    /// Corals grow only shallower than this.
    #[schemars(range(min = 0.1, max = 1000.0), extend("unit" = "m"))]
    pub deep: f32,
    /// Carbon that a metre of growth takes from a metre of water. More of it starves lagoons and makes narrow rims.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "1"))]
    pub uptake: f32,
    /// How fast carbon spreads on the time scale of reef building. The reef's width grows with its square root.
    #[schemars(range(min = 0.0, max = 1000000.0), extend("unit" = "m2/yr"))]
    pub diffusivity: f32,
    /// Water deeper than this is open sea and always holds its carbon.
    #[schemars(range(min = 0.1, max = 12000.0), extend("unit" = "m"))]
    pub open_sea: f32,
    /// Rise of the sea, negative if it falls. Reefs drown where it outruns their growth.
    #[schemars(range(min = -10.0, max = 10.0), extend("unit" = "m/yr"))]
    pub sea_level_rise: f32,
    /// Further change of the sea's level: years since the reef began and metres, straight lines in between.
    #[schemars(extend("unit" = "[yr, m]"))]
    pub sea_level_curve: Vec<[f64; 2]>,
    /// Sinking of the ground.
    #[schemars(range(min = -1.0, max = 1.0), extend("unit" = "m/yr"))]
    pub subsidence: f32,
}

/// What limits the growth of corals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Limit {
    /// Light, and the carbon that reaches them.
    #[default]
    Carbon,
    /// Light alone.
    Light,
}

/// How light becomes growth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Light {
    /// Growth falls exponentially with depth.
    #[default]
    Exponential,
    /// Growth is saturated near the surface and falls with the light further down (Bosscher and Schlager 1992).
    Saturating,
}

impl Default for Reef {
    fn default() -> Self {
        Self {
            years_per_step: 10.0,
            growth: 0.012,
            limit: Limit::Carbon,
            light: Light::Exponential,
            light_depth: 20.0,
            attenuation: 0.1,
            surface_light: 2000.0,
            saturation_light: 250.0,
            shallow: 0.5,
            deep: 40.0,
            uptake: 0.4,
            diffusivity: 20.0,
            open_sea: 60.0,
            sea_level_rise: 0.0,
            sea_level_curve: Vec::new(),
            subsidence: 0.0,
        }
    }
}

/// Start value of the layer below: the floor is not known yet, it lies as deep as the limestone is thick.
const UNKNOWN: f32 = 12_000.0;
/// Layer of the ground below the limestone.
pub const REEF_FLOOR: LayerSpec =
    LayerSpec::new("reef_floor", "m", "Height of the ground below the reef limestone", (-12000.0, 12000.0));

const CARBON_BEFORE: LayerSpec =
    LayerSpec::new("carbon_before", "1", "Carbon one stage of diffusion before", (0.0, 1.0));

impl Reef {
    /// Change of the sea's level over turn number `turn`, m.
    pub fn sea_level_change(&self, turn: u64) -> f64 {
        let years = f64::from(self.years_per_step);
        let (t0, t1) = (turn as f64 * years, (turn + 1) as f64 * years);
        f64::from(self.sea_level_rise) * years + curve(&self.sea_level_curve, t1) - curve(&self.sea_level_curve, t0)
    }

    /// True if land can come to lie under the sea.
    fn drowns(&self) -> bool {
        self.sea_level_rise != 0.0 || !self.sea_level_curve.is_empty() || self.subsidence > 0.0
    }

    /// Stages of a step's diffusion, and the diffusion numbers of the whole step to the east and to the south.
    ///
    /// `s` stages of the scheme RKL1 are monotone up to `(s^2 + s) / 2` times the longest plain step, whose numbers sum to
    /// 1/2. Odd numbers damp checkerboards best.
    fn diffusion(&self, grid: &Grid) -> (u32, f32, f32) {
        let dt = f64::from(self.diffusivity) * f64::from(self.years_per_step);
        let (x, y) = (dt / grid.cell_x_m.powi(2), dt / grid.cell_y_m.powi(2));
        let plain_steps = (x + y) / 0.48;
        let stages = (((1.0 + 8.0 * plain_steps).sqrt() - 1.0) / 2.0 - 1e-6).ceil().max(1.0) as u32;
        (stages | 1, x as f32, y as f32)
    }
}

fn curve(points: &[[f64; 2]], t: f64) -> f64 {
    match points.iter().position(|p| p[0] > t) {
        Some(0) => points[0][1],
        Some(i) => {
            let ([t0, v0], [t1, v1]) = (points[i - 1], points[i]);
            v0 + (v1 - v0) * (t - t0) / (t1 - t0)
        }
        None => points.last().map_or(0.0, |p| p[1]),
    }
}

impl Process for Reef {
    fn layers(&self) -> Vec<LayerUse> {
        let mut layers = vec![
            HEIGHT.changed(0.0),
            LIMESTONE.changed(0.0),
            GROWTH.changed(0.0),
            CARBON.changed(1.0),
            REEF_FLOOR.changed(UNKNOWN),
        ];
        if self.drowns() {
            layers.extend([WATER.changed(0.0), WETNESS.changed(0.0)]);
        }
        layers
    }

    fn check(&self, grid: &Grid) -> Result<()> {
        let bad =
            |field: &str, reason: String| Error::BadParameter { owner: "reef".into(), field: field.into(), reason };
        if self.shallow >= self.deep {
            return Err(bad("shallow", format!("{} m must be less than deep, which is {} m", self.shallow, self.deep)));
        }
        if self.sea_level_curve.windows(2).any(|w| w[1][0] <= w[0][0])
            || self.sea_level_curve.iter().flatten().any(|v| !v.is_finite())
        {
            return Err(bad("sea_level_curve", "needs finite numbers with years in rising order".into()));
        }
        let (x, y) = (grid.cell_x_m, grid.cell_y_m);
        let (stages, ..) = self.diffusion(grid);
        if stages > 301 {
            return Err(bad(
                "diffusivity",
                format!(
                    "{} m2/yr over {} yr needs {stages} stages on cells of {x} x {y} m; lower it or years_per_step",
                    self.diffusivity, self.years_per_step
                ),
            ));
        }
        Ok(())
    }

    fn prepare(&self, world: &mut World) -> Result<()> {
        // Limestone that came from a file or a generator rests on something too.
        for row in 0..world.grid.height {
            let height = world.layer("height")?.field.row(row).to_vec();
            let stone = world.layer("limestone")?.field.row(row).to_vec();
            let floor = world.layer_mut("reef_floor")?.field.row_mut(row);
            for ((f, h), s) in floor.iter_mut().zip(height).zip(stone).filter(|((f, ..), _)| **f >= UNKNOWN) {
                *f = h - s;
            }
        }
        Ok(())
    }

    fn seconds_per_step(&self, _grid: &Grid) -> Option<f64> {
        Some(f64::from(self.years_per_step) * SECONDS_PER_YEAR)
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let sea = moment.sea_level_m as f32;
        let years = self.years_per_step;
        if self.limit == Limit::Carbon && self.diffusivity > 0.0 {
            let (stages, x, y) = self.diffusion(&moment.grid);
            let edge = |e: BoundaryCondition| if e == BoundaryCondition::Wrap { -1e9 } else { 0.5 };
            let g = &moment.grid;
            let w = 2.0 / (stages * (stages + 1)) as f32;
            for j in 1..=stages {
                let j = j as f32;
                let ahead = (2.0 * j - 1.0) / j;
                let params = SpreadParams::<Given> {
                    x: (ahead * w * x).into(),
                    y: (ahead * w * y).into(),
                    ahead: ahead.into(),
                    sea: sea.into(),
                    open_sea: given!(plan, self.open_sea),
                    rim_x: edge(g.rim.x).into(),
                    rim_y: edge(g.rim.y).into(),
                    last_x: (g.width as f32 - 1.0).into(),
                    last_y: (g.height as f32 - 1.0).into(),
                };
                if stages == 1 {
                    plan.push_given::<Spread>(params);
                } else {
                    plan.scratch(&CARBON_BEFORE);
                    plan.push_given::<SpreadStage>(params);
                }
            }
        }
        let growth = given!(plan, self.growth);
        let params = GrowParams {
            years: years.into(),
            sea: sea.into(),
            growth,
            by_carbon: Given::of(if self.limit == Limit::Carbon { 1.0 } else { 0.0 }),
            per_growth: 1.0 / growth.max(Given::of(1e-9)),
            extinction: match self.light {
                Light::Exponential => 1.0 / given!(plan, self.light_depth),
                Light::Saturating => given!(plan, self.attenuation),
            },
            relative_light: given!(plan, self.surface_light) / given!(plan, self.saturation_light),
            shallow: given!(plan, self.shallow),
            deep: given!(plan, self.deep),
            uptake: given!(plan, self.uptake),
            sink: given!(plan, self.subsidence) * years,
        };
        match self.light {
            Light::Exponential => plan.push_given::<Grow<false>>(params),
            Light::Saturating => plan.push_given::<Grow<true>>(params),
        }
        if self.drowns() {
            let risen = moment.sea_level_m + self.sea_level_change(moment.turn);
            plan.push::<Drown>(DrownParams { sea: risen as f32 });
        }
    }

    fn advance(&self, moment: &mut Moment) {
        moment.sea_level_m += self.sea_level_change(moment.turn);
    }
}

rule_params! {
    /// Parameters of [`Spread`].
    pub struct SpreadParams {
        /// Diffusion number to the east and west, 1.
        x,
        /// Diffusion number to the north and south, 1.
        y,
        /// Weight of the last stage, `(2 j - 1) / j`; the one before has 1 minus this.
        ahead,
        /// Level of the sea, m.
        sea,
        /// Depth of the open sea, m.
        open_sea,
        /// Columns nearer than this to the west or east rim are open sea.
        rim_x,
        /// Rows nearer than this to the north or south rim are open sea.
        rim_y,
        /// Last column.
        last_x,
        /// Last row.
        last_y,
    }
}

/// Carbon that was not there. Diffusion leaves 0..1 by rounding only; growth may want more than the water holds.
const CARBON_CLAMPED: Tally = Tally {
    account: "carbon.clamped",
    unit: TallyUnit::Thickness,
    sign: 1,
    meaning: "Carbon made where growth or rounding had left 0 to 1, as the depth of fresh sea water that holds it",
};

/// Equation (3).
pub struct Spread;

impl Rule for Spread {
    const NAME: &'static str = "reef_spread";
    const READS: &'static [Read] = &[read("carbon", 1), read("height", 1)];
    const WRITES: &'static [&'static str] = &["carbon"];
    const TALLIES: &'static [Tally] = &[CARBON_CLAMPED];
    type Params = SpreadParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &SpreadParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 1]) {
        let (new, made) = hold(p, c, c.here(0) + spread(p, c));
        ([new], [made])
    }
}

/// Equation (3) in stages: `O_j = a_j O_(j-1) + (1 - a_j) O_(j-2) + a_j w D lap O_(j-1)` with `a_j = (2 j - 1) / j` and
/// `w = 2 / (s^2 + s)`, the scheme RKL1 of Meyer, Balsara and Aslam 2014.
pub struct SpreadStage;

impl Rule for SpreadStage {
    const NAME: &'static str = "reef_spread_stage";
    const READS: &'static [Read] = &[read("carbon", 1), read("height", 1), read("carbon_before", 0)];
    const WRITES: &'static [&'static str] = &["carbon", "carbon_before"];
    const TALLIES: &'static [Tally] = &[CARBON_CLAMPED];
    type Params = SpreadParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &SpreadParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 1]) {
        let (o, before) = (c.here(0), c.here(2));
        // The stages amplify rounding with the square of their number.
        let mixed = (p.ahead * o).no_contract() + ((R::of(1.0) - p.ahead) * before).no_contract();
        let (new, made) = hold(p, c, mixed + spread(p, c));
        ([new, o], [made])
    }
}

/// What diffusion adds to a cell.
#[inline(always)]
fn spread<R: Real>(p: &SpreadParams<R>, c: &impl Cell<R>) -> R {
    let x = gain(p, c, 1, 0) + gain(p, c, -1, 0);
    let y = gain(p, c, 0, 1) + gain(p, c, 0, -1);
    (p.x * x).no_contract() + (p.y * y).no_contract()
}

/// The new value, where neither land nor the open sea decide, and what the clamp made of nothing.
#[inline(always)]
fn hold<R: Real>(p: &SpreadParams<R>, c: &impl Cell<R>, new: R) -> (R, R) {
    let (zero, one) = (R::of(0.0), R::of(1.0));
    let depth = p.sea - c.here(1);
    let inland = c.x().min(p.last_x - c.x()).lt(p.rim_x).pick(zero, one)
        * c.y().min(p.last_y - c.y()).lt(p.rim_y).pick(zero, one);
    let open = inland.lt(R::of(0.5)).pick(one, depth.gt(p.open_sea).one());
    let clamped = new.clamp(zero, one);
    let is_open = open.gt(R::of(0.5));
    let under_sea = depth.gt(zero);
    let made = is_open.pick(zero, (clamped - new) * depth);
    (under_sea.pick(is_open.pick(one, clamped).flushed(), zero), under_sea.pick(made, zero))
}

/// Difference to a neighbour that is under the sea, else 0.
#[inline(always)]
fn gain<R: Real>(p: &SpreadParams<R>, c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    c.at(1, dx, dy).lt(p.sea).pick(c.at(0, dx, dy) - c.here(0), R::of(0.0))
}

rule_params! {
    /// Parameters of [`Grow`].
    pub struct GrowParams {
        /// Years of a step.
        years,
        /// Level of the sea, m.
        sea,
        /// Fastest growth, m/yr.
        growth,
        /// 1 if carbon limits growth, 0 if not.
        by_carbon,
        /// `1 / growth`, yr/m.
        per_growth,
        /// Extinction of light, or of growth, with depth, 1/m.
        extinction,
        /// Light at the surface over the light that saturates, 1.
        relative_light,
        /// Shallow limit, m.
        shallow,
        /// Deep limit, m.
        deep,
        /// Carbon taken by a metre of growth from a metre of water, 1.
        uptake,
        /// Sinking of the ground during a step, m.
        sink,
    }
}

/// Equations (1), (2) and (4), for exponential or for saturating light.
pub struct Grow<const SATURATING: bool>;

impl<const SATURATING: bool> Rule for Grow<SATURATING> {
    const NAME: &'static str = if SATURATING { "reef_grow_saturating" } else { "reef_grow" };
    const READS: &'static [Read] =
        &[read("height", 0), read("limestone", 0), read("growth", 0), read("carbon", 0), read("reef_floor", 0)];
    const WRITES: &'static [&'static str] = &["height", "limestone", "growth", "carbon", "reef_floor"];
    const TALLIES: &'static [Tally] = &[
        Tally { account: "ground.reef", unit: TallyUnit::Thickness, sign: 1, meaning: "Limestone that corals built" },
        Tally { account: "ground.subsided", unit: TallyUnit::Thickness, sign: -1, meaning: "Ground that sank" },
        Tally {
            account: "limestone.worn",
            unit: TallyUnit::Thickness,
            sign: -1,
            meaning: "Limestone that erosion took away",
        },
        Tally {
            account: "limestone.grown",
            unit: TallyUnit::Thickness,
            sign: 1,
            meaning: "Limestone that corals built",
        },
        CARBON_CLAMPED,
    ];
    type Params = GrowParams<()>;
    type Out<R: Real> = [R; 5];
    type Sums<R: Real> = [R; 5];

    #[inline(always)]
    fn cell<R: Real>(p: &GrowParams<R>, c: &impl Cell<R>) -> ([R; 5], [R; 5]) {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let (h, old, memory, carbon) = (c.here(0), c.here(1), c.here(2), c.here(3));
        // Erosion since the last turn took limestone before it took the ground below.
        let floor = old.gt(zero).pick(c.here(4).min(h), h);
        let stone = old.min(h - floor);

        let depth = p.sea - h;
        let g = depth.max(R::of(0.01));
        let fall = (-(g * p.extinction)).exp();
        let lit = if SATURATING {
            // tanh a = 1 - 2 / (e^(2 a) + 1)
            let a = p.relative_light * fall;
            one - R::of(2.0) / ((a + a).exp() + one)
        } else {
            fall
        };
        let fed = p.by_carbon.gt(R::of(0.5)).pick(carbon * carbon, one);
        let inside = depth.gt(p.shallow).one() * depth.lt(p.deep).one();
        let rate = inside * p.growth * fed * lit;
        let grown = (rate * p.years).min((depth - p.shallow).positive());

        let wanted = carbon - p.by_carbon * grown * p.uptake / g;
        let left = wanted.positive();
        // The counter forgets in about fifty turns.
        let now = (rate * p.per_growth).min(one);
        let counter = (memory + R::of(0.02) * (now - memory)).flushed();
        // What height and limestone really gain and lose after rounding is what the ledger says.
        let risen = h + grown;
        let sunk = risen - p.sink;
        let taller = stone + (risen - h);
        (
            [sunk, taller, counter, left.flushed(), floor - p.sink],
            [risen - h, risen - sunk, old - stone, taller - stone, (left - wanted) * g],
        )
    }
}
