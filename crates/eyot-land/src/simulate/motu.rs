//! Motu: waves throw sand and rubble of the reef up on its flat, where islets of it rise over the sea.
//!
//! # Equations
//! `w` level of the sea, `g = w - h` depth, `E` energy of the waves over that of the open sea, `T` years of a step, `d` unit vector to where
//! the wind blows, `D` size of a cell.
//! 1. Waves break where it is shallow: of what arrives at a cell, `F = E e^(-D k)` goes on, with `k = (1 - g / breaking)^2 / flat` for
//!    `0 < g < breaking`, and `k = 4 / flat` on dry land, where the wash soaks away.
//! 2. They go on by a cell a step: `E' = (1 - bend) (|d_x| F_x + |d_y| F_y) / (|d_x| + |d_y|) + bend mean(F of 4 neighbours)`, where `F_x`, `F_y`
//!    are those of the neighbours to windward; the open sea (deeper than `open_sea`, and the rim) has `E = 1`.
//! 3. What they carry falls where their energy does, `b = min(4 E (1 - E), max(0, 3 - 4 E))`: neither at the front, which they sweep clean, nor in the quiet
//!    behind. On reef limestone that lies shallower than `foundation`: `h' = h + supply T b max(0, 1 - (h - w) / (crest b))`, and the same
//!    gain for `sand`. No islet rises above `w + crest`.
//!
//! # Source
//! A sketch of what McLean and Woodroffe 1994 and Kench and others 2005 describe: reef islands of sand and rubble, built by waves and
//! storms on reef flats, some hundred metres behind the edge and mostly to windward, 1 to 4 m high. The formulas are Eyot's, none of
//! them is a measured law.
//!
//! # Differences
//! - Sediment is not followed from the reef's front to the islet: `supply` is what arrives.
//! - Waves have one energy, no length and no direction but the wind's. `bend` stands for refraction and for swell from elsewhere.
//!
//! # Layers
//! Reads `limestone` (m); reads and writes `height`, `sand` (m) and `surf` (1).
//!
//! # Limits
//! Stable for all parameters. Waves need as many steps as the grid has cells from rim to rim; on finer grids they spread less to the
//! sides.
//!
//! # Conserves
//! What arrives is in the ledger (`ground.motu`, `tests/it/motu.rs`).

use eyot_core::given::Given;
use eyot_core::layer::known::{HEIGHT, LIMESTONE, SAND};
use eyot_core::math64::{cos_degrees, sin_degrees};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process, SECONDS_PER_YEAR};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, TallyUnit, read};
use eyot_core::{BoundaryCondition, Grid, LayerSpec, given, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Waves throw sand and rubble up on a reef flat: low islets, mostly to windward.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Motu {
    /// Years of a step.
    #[schemars(range(min = 0.001, max = 10000.0), extend("unit" = "yr"))]
    pub years_per_step: f32,
    /// Where the wind comes from, clockwise from north. The trades blow from the east.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub wind: f32,
    /// Sand and rubble that arrive where most of it falls. An expression that is 0 in places leaves channels between islets.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "m/yr"))]
    pub supply: f32,
    /// Height of the highest islets over the sea: 3 to 4 m where storms throw up rubble, 1 to 2 m of sand elsewhere.
    #[schemars(range(min = 0.01, max = 20.0), extend("unit" = "m"))]
    pub crest: f32,
    /// Way over the shallowest flat on which waves lose two thirds of their energy. Islets stand about as far behind the edge.
    #[schemars(range(min = 1.0, max = 10000.0), extend("unit" = "m"))]
    pub flat: f32,
    /// Depth in which waves begin to break.
    #[schemars(range(min = 0.1, max = 100.0), extend("unit" = "m"))]
    pub breaking: f32,
    /// Islets stand on limestone that lies shallower than this.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m"))]
    pub foundation: f32,
    /// Share of a wave's energy that comes from all sides. With little of it the lee stays bare, at 1 there is no lee.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub bend: f32,
    /// Water deeper than this is open sea and has full waves. Lagoons must not be as deep.
    #[schemars(range(min = 0.1, max = 12000.0), extend("unit" = "m"))]
    pub open_sea: f32,
}

impl Default for Motu {
    fn default() -> Self {
        Self {
            years_per_step: 5.0,
            wind: 80.0,
            supply: 0.006,
            crest: 3.5,
            flat: 150.0,
            breaking: 6.0,
            foundation: 3.0,
            bend: 0.2,
            open_sea: 60.0,
        }
    }
}

/// Layer of the waves' energy.
pub const SURF: LayerSpec = LayerSpec::new("surf", "1", "Energy of the waves over that of the open sea", (0.0, 1.0));

impl Process for Motu {
    fn layers(&self) -> Vec<LayerUse> {
        vec![HEIGHT.changed(0.0), LIMESTONE.read(0.0), SAND.changed(0.0), SURF.changed(0.0)]
    }

    fn seconds_per_step(&self, _grid: &Grid) -> Option<f64> {
        Some(f64::from(self.years_per_step) * SECONDS_PER_YEAR)
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let g = &moment.grid;
        // To where the wind blows: east and south.
        let from = f64::from(self.wind);
        let to = [-sin_degrees(from), cos_degrees(from)];
        let share = |d: f64| Given::of((d.max(0.0) / (to[0].abs() + to[1].abs())) as f32);
        let edge = |e: BoundaryCondition| if e == BoundaryCondition::Wrap { -1e9 } else { 0.5 };
        let sea = Given::of(moment.sea_level_m as f32);
        plan.push_given::<Surf>(SurfParams {
            west: share(to[0]),
            east: share(-to[0]),
            north: share(to[1]),
            south: share(-to[1]),
            bend: given!(plan, self.bend),
            sea,
            per_breaking: 1.0 / given!(plan, self.breaking),
            cells_per_flat: Given::of(g.cell_area_m2().sqrt() as f32) / given!(plan, self.flat),
            open_sea: given!(plan, self.open_sea),
            rim_x: edge(g.rim.x).into(),
            rim_y: edge(g.rim.y).into(),
            last_x: (g.width as f32 - 1.0).into(),
            last_y: (g.height as f32 - 1.0).into(),
        });
        plan.push_given::<Build>(BuildParams {
            sea,
            supply: given!(plan, self.supply) * self.years_per_step,
            crest: given!(plan, self.crest),
            foundation: given!(plan, self.foundation),
        });
    }
}

rule_params! {
    /// Parameters of [`Surf`].
    pub struct SurfParams {
        /// Shares of the waves that come from the neighbours, 1.
        west,
        /// As `west`.
        east,
        /// As `west`.
        north,
        /// As `west`.
        south,
        /// Share that comes from all sides, 1.
        bend,
        /// Level of the sea, m.
        sea,
        /// `1 / breaking`, 1/m.
        per_breaking,
        /// Size of a cell over `flat`, 1.
        cells_per_flat,
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

/// Equations (1) and (2).
pub struct Surf;

impl Rule for Surf {
    const NAME: &'static str = "motu_surf";
    const READS: &'static [Read] = &[read("surf", 1), read("height", 1)];
    const WRITES: &'static [&'static str] = &["surf"];
    type Params = SurfParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &SurfParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let (west, east) = (goes_on(p, c, -1, 0), goes_on(p, c, 1, 0));
        let (north, south) = (goes_on(p, c, 0, -1), goes_on(p, c, 0, 1));
        let ahead = (p.west * west + p.east * east) + (p.north * north + p.south * south);
        let around = R::of(0.25) * ((west + east) + (north + south));
        let coming = ahead + p.bend * (around - ahead);

        let depth = p.sea - c.here(1);
        let arrives = coming.clamp(zero, one).flushed();
        let rim = c.x().min(p.last_x - c.x()).lt(p.rim_x).one() + c.y().min(p.last_y - c.y()).lt(p.rim_y).one();
        let open = (depth.gt(p.open_sea).one() + rim).gt(R::of(0.5));
        ([open.pick(one, arrives)], [])
    }
}

/// Equation (1) for a neighbour.
#[inline(always)]
fn goes_on<R: Real>(p: &SurfParams<R>, c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    let (zero, one) = (R::of(0.0), R::of(1.0));
    let depth = p.sea - c.at(1, dx, dy);
    let shallow = (one - depth * p.per_breaking).clamp(zero, one);
    let lost = depth.gt(zero).pick(shallow * shallow, R::of(4.0)) * p.cells_per_flat;
    c.at(0, dx, dy) * (-lost).exp()
}

rule_params! {
    /// Parameters of [`Build`].
    pub struct BuildParams {
        /// Level of the sea, m.
        sea,
        /// What arrives in a step where most falls, m.
        supply,
        /// Height of the highest islets, m.
        crest,
        /// Greatest depth of limestone that carries them, m.
        foundation,
    }
}

/// Equation (3).
pub struct Build;

impl Rule for Build {
    const NAME: &'static str = "motu_build";
    const READS: &'static [Read] = &[read("height", 0), read("limestone", 0), read("sand", 0), read("surf", 0)];
    const WRITES: &'static [&'static str] = &["height", "sand"];
    const TALLIES: &'static [Tally] = &[Tally {
        account: "ground.motu",
        unit: TallyUnit::Thickness,
        sign: 1,
        meaning: "Sand and rubble that waves brought from the reef",
    }];
    type Params = BuildParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &BuildParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 1]) {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let (h, surf) = (c.here(0), c.here(3));
        let above = h - p.sea;
        let falls = (R::of(4.0) * surf * (one - surf)).min((R::of(3.0) - R::of(4.0) * surf).positive());
        let room = (one - above / (p.crest * falls).max(R::of(0.01))).positive();
        let stands = c.here(1).gt(R::of(0.5)).one() * above.gt(-p.foundation).one();
        // Never past the crest in one step.
        let most = (p.crest * falls - above).positive();
        let arrives = (stands * p.supply * falls * room).min(most);
        let risen = h + arrives.max(zero);
        ([risen, c.here(2) + (risen - h)], [risen - h])
    }
}
