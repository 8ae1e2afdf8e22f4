//! Benchmarks that everyone can repeat: what `eyot bench` runs and what `benches/peers` compares with.
//!
//! A simulation is timed as users run it, in one call of the engine: every chain of steps leaves a time stamp, the first
//! stretch warms up, and the following ones are samples. Start fields and parameters are those of
//! `benches/peers/common.py`; `benches/peers/check.py` shows that start fields are equal to the bit and results agree.

use crate::rule;
use eyot_core::engine::{CpuEngine, MemoryEstimate};
use eyot_core::isa::Isa;
use eyot_core::plan::Plan;
use eyot_core::process::{Action, Generator, Moment, Process, Scheduled, Site, Span};
use eyot_core::remedy;
use eyot_core::remedy::Setting;
use eyot_core::{Boundary, BoundaryCondition, Cancel, Control, Error, Field, Grid, LayerSpec, Limits, Result, World};
use eyot_drainage::{BYTES_PER_CELL, Base, Routing, fill, outlets};
use eyot_ice::Glaciers;
use eyot_land::generate::GENERATORS;
use eyot_land::simulate::hydraulic::FluxForm;
use eyot_land::simulate::{Hydraulic, Reef, Streampower, Thermal};
use eyot_plants::Plants;
use eyot_plates::{Drift, Tectonics};
use eyot_reef::bodies::{Bodies, Detail};
use eyot_reef::community::{self, Community, Forcing, Ground, Plot, Site as SeaFloor};
use eyot_strata::{Bed, RockCycle, Rockfall, Strata};
use eyot_water::Rivers;
use serde::Serialize;
use std::collections::BTreeMap;
use std::str::FromStr;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// What to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum BenchSubject {
    /// Hydraulic erosion: one step of all its rules.
    Hydraulic,
    /// The same with pipes to four neighbours, which is what the peers do.
    Signed,
    /// Thermal erosion.
    Thermal,
    /// Thermal erosion again, as a rule that a recipe could have; it gives the same bytes.
    Rule,
    /// The generator `fbm`; a step is one field of eight octaves.
    Noise,
    /// Reef growth: carbon spreads once, then corals grow.
    Reef,
    /// Filling depressions, D8 routing and counting the cells upstream, once each.
    Drainage,
    /// Lakes and rivers of the land of `drainage`, once: levels, graph, lines and beds.
    Rivers,
    /// A year of ice on mountains, in time steps of half a year, once the glaciers have grown.
    Glaciers,
    /// Stream power with routing and creep, on open rims.
    Streampower,
    /// A month of the default community of corals on a square plot; the size is in metres.
    Community,
    /// The same on a reef slope from 1 to 25 m of water with sand between the rock, of 400 x 400 m: 100,000 colonies.
    Slope,
    /// The bodies of all corals of a square plot at the voxels of their source, and of those that changed in a month; the
    /// size is in metres.
    Bodies,
    /// A step of all processes of the living world, zones in every tenth, on a ring with closed poles.
    World,
    /// Ten plates on a torus as large as the Earth; a step is a million years of all that they do, less on fine grids.
    Plates,
    /// Ageing rock: water on eight beds, rockfall in every 20th step and the rock cycle in every second, as its source had it.
    Strata,
    /// A year of all thirteen types of plants, in a temperate country where fires are rare.
    Plants,
    /// The living world on drifting plates, which take a turn in every 25th step: how long the world stops for them.
    Drift,
}

impl BenchSubject {
    /// All of them.
    pub const ALL: [Self; 18] = [
        Self::Hydraulic,
        Self::Signed,
        Self::Thermal,
        Self::Rule,
        Self::Noise,
        Self::Reef,
        Self::Drainage,
        Self::Rivers,
        Self::Glaciers,
        Self::Streampower,
        Self::Strata,
        Self::Plants,
        Self::Community,
        Self::Slope,
        Self::Bodies,
        Self::World,
        Self::Plates,
        Self::Drift,
    ];

    /// Cells along a side unless somebody says something else: metres for the community and bodies.
    pub const fn usual_size(self) -> usize {
        match self {
            Self::Community => 40,
            Self::Slope => 400,
            Self::Bodies => 10,
            _ => 512,
        }
    }

    /// Name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hydraulic => "hydraulic",
            Self::Signed => "signed",
            Self::Thermal => "thermal",
            Self::Rule => "rule",
            Self::Noise => "noise",
            Self::Reef => "reef",
            Self::Drainage => "drainage",
            Self::Rivers => "rivers",
            Self::Glaciers => "glaciers",
            Self::Streampower => "streampower",
            Self::Strata => "strata",
            Self::Plants => "plants",
            Self::Community => "community",
            Self::Slope => "slope",
            Self::Bodies => "bodies",
            Self::World => "world",
            Self::Plates => "plates",
            Self::Drift => "drift",
        }
    }
}

impl FromStr for BenchSubject {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let known = Self::ALL.map(Self::name).join(", ");
        let found = Self::ALL.into_iter().find(|s| s.name() == name);
        found.ok_or_else(|| bad("what", format!("there is no benchmark `{name}`; there are: {known}")))
    }
}

/// What to measure, and how.
#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// What to measure.
    pub what: BenchSubject,
    /// Cells along a side of the square grid; metres along a side of the plot of corals.
    pub size: usize,
    /// Threads; at least 1.
    pub threads: usize,
    /// Instruction set; the best one if `None`.
    pub isa: Option<Isa>,
    /// Hydraulic erosion as published in 2007.
    pub classic: bool,
    /// Time to spend on samples, s; warming up comes on top.
    pub seconds: f64,
}

impl Default for BenchOptions {
    fn default() -> Self {
        Self { what: BenchSubject::Hydraulic, size: 512, threads: 1, isa: None, classic: false, seconds: 5.0 }
    }
}

/// What was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BenchReport {
    /// What was measured: `hydraulic`, `hydraulic classic`, `signed`, `thermal`, `rule`, `noise`, `reef`, `drainage`, `rivers`, `glaciers`, `streampower`,
    /// `strata`, `plants`, `community`, `slope`, `bodies`, `world`, `plates` or `drift`.
    pub what: &'static str,
    /// Cells along a side, or metres.
    pub size: usize,
    /// Threads.
    pub threads: usize,
    /// Instruction set.
    pub isa: &'static str,
    /// Steps that were timed.
    pub steps: u64,
    /// Samples that they were split into.
    pub samples: usize,
    /// Seconds a step in the best sample.
    pub seconds_per_step: f64,
    /// Seconds a step in the median sample.
    pub seconds_per_step_median: f64,
    /// Cells times steps a second in the best sample.
    pub cell_steps_per_second: f64,
    /// Cells times steps a second in the median sample.
    pub cell_steps_per_second_median: f64,
    /// The most memory that is held for a cell while it runs: layers, scratch layers and second copies, padding included,
    /// and what actions, drainage and generators hold beside them.
    pub bytes_per_cell: f64,
    /// What the passes of a step must read and write for a cell if each is on its own: one read or write per layer and
    /// pass. What reaches memory is less, because a row stays in cache through several passes and steps. `None` where the work
    /// is no rules, which alone say what they read.
    pub bytes_moved_per_cell_step: Option<f64>,
    /// Arithmetic operations of the rules' graphs for a cell and step, equal subexpressions counted once; `None` as above.
    pub operations_per_cell_step: Option<usize>,
    /// What the community adds.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub community: Option<CommunityReport>,
    /// What bodies add.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<BodiesReport>,
    /// What drift adds.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub drift: Option<DriftReport>,
    /// Ledger of the whole run, warm-up included, in the accounts' units.
    pub ledger: BTreeMap<String, f64>,
}

/// Years that the life of a plot is counted for, as in the recipe `reef`.
const YEARS: f64 = 50.0;

/// Speed and size of a community of corals.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CommunityReport {
    /// Seconds a month in the best sample.
    pub seconds_per_month: f64,
    /// Months a second in the best sample.
    pub months_per_second: f64,
    /// Seconds of fifty years on such a plot, from bare ground, at the speed of the median sample.
    pub seconds_per_plot: f64,
    /// Colonies at the end.
    pub colonies: usize,
    /// Macroalgae at the end.
    pub algae: usize,
}

/// Speed and size of the bodies of corals.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodiesReport {
    /// Seconds for all bodies of the plot in the best sample.
    pub seconds_per_plot: f64,
    /// Seconds for the bodies that changed in a month, the median of two years after the first.
    pub seconds_per_month: f64,
    /// Triangles of all bodies of the plot, over the seconds that they took in the best sample.
    pub triangles_per_second: f64,
    /// Colonies of the plot.
    pub colonies: usize,
    /// Their triangles.
    pub triangles: usize,
}

/// How long a world stops for its plates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriftReport {
    /// The median step where plates take no turn, s.
    pub seconds_between_turns: f64,
    /// What a turn of theirs adds to the steps among which it is, s (median): so long the world stops.
    pub seconds_of_turn: f64,
    /// For comparison, the median step of plates with no world around them, s.
    pub seconds_of_plates: f64,
    /// Turns that were timed.
    pub turns: usize,
}

/// Runs a benchmark.
///
/// # Errors
/// If an option is out of range, the processor lacks the instruction set, the grid exceeds the limits, or the generator
/// is not there.
pub fn run(options: &BenchOptions) -> Result<BenchReport> {
    if options.threads == 0 {
        return Err(bad("threads", "needs at least 1".into()));
    }
    if !(options.seconds > 0.0 && options.seconds <= 86_400.0) {
        return Err(bad("seconds", format!("{} is not above 0 and at most 86400", options.seconds)));
    }
    if let Some(isa) = options.isa.filter(|isa| !isa.is_available()) {
        return Err(bad("isa", format!("this processor has no {}", isa.name())));
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build()
        .map_err(|e| bad("threads", e.to_string()))?;
    let result = pool.install(|| match options.what {
        BenchSubject::Noise => noise(options),
        BenchSubject::Drainage => drainage(options),
        BenchSubject::Rivers => rivers(options),
        BenchSubject::Glaciers => glaciers(options),
        BenchSubject::Community | BenchSubject::Slope => community(options),
        BenchSubject::Bodies => bodies(options),
        BenchSubject::Plates => plates(options),
        BenchSubject::Drift => drift(options),
        _ => simulation(options),
    });
    result.map_err(|e| match e {
        Error::Limit { what, needed, limit, .. } => {
            Error::Limit { what, needed, limit, remedy: remedy!["choose fewer cells with ", Setting::Size] }
        }
        other => other,
    })
}

/// Start fields and processes of a simulation benchmark; the same as the peers'.
///
/// # Errors
/// If the grid is not sound or the run would exceed the limits, or if asked for noise, drainage,
/// the community, bodies or plates, which are no simulations of cells.
pub fn case(what: BenchSubject, classic: bool, size: usize) -> Result<(World, Vec<Scheduled>)> {
    if matches!(what, BenchSubject::World | BenchSubject::Drift) {
        let grid = Grid::new(
            size,
            size,
            4e7 / size as f64,
            Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Closed },
            &Limits::default(),
        )?;
        let mut processes = living_world()?;
        if what == BenchSubject::Drift {
            let plates = Tectonics { years_per_step: plates_years(size), ..Tectonics::default() };
            // First, as in the recipe `world`: then the steps around a turn are one chain.
            processes.insert(0, Scheduled { name: "plates", process: Box::new(Drift::new(plates)), every: TURN });
        }
        return start(grid, what, processes, -5000.0, 5000.0);
    }
    if what == BenchSubject::Strata {
        let grid = Grid::new(size, size, 10.0, Boundary::CLOSED, &Limits::default())?;
        return start(grid, what, ageing(), -350.0, 650.0);
    }
    // Cell size, lowest and highest ground (m), process.
    let (cell_m, low, high, process): (f64, f64, f64, Box<dyn Process>) = match (what, classic) {
        (BenchSubject::Hydraulic, false) => (10.0, -350.0, 650.0, Box::new(Hydraulic::default())),
        (BenchSubject::Signed, _) => {
            (10.0, -350.0, 650.0, Box::new(Hydraulic { flux: FluxForm::Signed, ..Default::default() }))
        }
        (BenchSubject::Hydraulic, true) => (1.0, 0.0, 80.0, Box::new(mei_2007())),
        (BenchSubject::Thermal, _) => (10.0, 0.0, 1000.0, Box::new(Thermal::default())),
        (BenchSubject::Rule, _) => (10.0, 0.0, 1000.0, Box::new(rule::thermal(10.0)?)),
        // A year a step makes one spreading a growth; the default of ten years takes nine.
        (BenchSubject::Reef, _) => (10.0, -140.0, 60.0, Box::new(Reef { years_per_step: 1.0, ..Default::default() })),
        (
            BenchSubject::Noise
            | BenchSubject::Drainage
            | BenchSubject::Rivers
            | BenchSubject::Glaciers
            | BenchSubject::Community
            | BenchSubject::Slope
            | BenchSubject::Bodies
            | BenchSubject::World
            | BenchSubject::Strata
            | BenchSubject::Drift
            | BenchSubject::Plates,
            _,
        ) => {
            return Err(bad("what", format!("{} is no simulation", what.name())));
        }
        (BenchSubject::Plants, _) => (20.0, 0.0, 1500.0, Box::<Plants>::default()),
        (BenchSubject::Streampower, _) => (30.0, 0.0, 200.0, Box::new(streampower())),
    };
    let rim = if what == BenchSubject::Streampower { Boundary::OPEN } else { Boundary::CLOSED };
    let grid = Grid::new(size, size, cell_m, rim, &Limits::default())?;
    start(grid, what, vec![Scheduled { name: what.name(), process, every: 1 }], low, high)
}

/// Water, beds, what falls from them and what becomes rock again.
fn ageing() -> Vec<Scheduled> {
    let bed = |material: &str, thickness: f32| Bed { material: material.into(), thickness };
    let beds = vec![
        bed("sandstone", 60.0),
        bed("schist", 90.0),
        bed("limestone", 40.0),
        bed("sand", 80.0),
        bed("marble", 70.0),
        bed("sandstone", 120.0),
        bed("limestone", 60.0),
        bed("granite", 1000.0),
    ];
    let strata = Strata { beds, top: 600.0, regolith: 0.5, new_rock: true, ..Strata::default() };
    let scheduled = |name, process, every| Scheduled { name, process, every };
    vec![
        scheduled("hydraulic", Box::new(Hydraulic::default()) as Box<dyn Process>, 1),
        scheduled("strata", Box::new(strata), 1),
        scheduled("rockfall", Box::<Rockfall>::default(), 20),
        scheduled("rock_cycle", Box::<RockCycle>::default(), 2),
    ]
}

/// Steps of the world for which zones stay what they are.
const ZONES: u64 = 10;

/// The processes of the living world as recipes have them.
fn living_world() -> Result<Vec<Scheduled>> {
    let each = eyot_climate::PROCESSES.iter().map(|e| {
        let process = (e.make)((e.defaults)()).map_err(|err| bad(e.name, err.to_string()))?;
        Ok(Scheduled { name: e.name, process, every: if e.name == "zones" { ZONES } else { 1 } })
    });
    each.collect()
}

/// A world with ground between `low` and `high`, m, and a little water.
fn start(
    grid: Grid,
    what: BenchSubject,
    scheduled: Vec<Scheduled>,
    low: f64,
    high: f64,
) -> Result<(World, Vec<Scheduled>)> {
    let mut layers: Vec<(LayerSpec, f32)> = Vec::new();
    for layer in scheduled.iter().flat_map(|s| s.process.layers()) {
        if layers.iter().all(|(l, _)| l.name != layer.spec.name) {
            layers.push((layer.spec, layer.start));
        }
    }
    // The engine would find it out after the fields are filled, which takes long.
    Limits::default()
        .check_bytes("this benchmark", MemoryEstimate::of(&grid, layers.len(), &scheduled).bytes(&grid))?;
    let mut world = World::new(grid, 1);
    if what == BenchSubject::Streampower {
        world.sea_level_m = -1000.0;
    }
    for (spec, value) in layers {
        let field = &mut world.ensure(&spec, value).field;
        for y in 0..grid.height {
            for x in 0..grid.width {
                match &*spec.name {
                    "height" => field.set(x, y, (low + (high - low) * terrain(x as u32, y as u32)) as f32),
                    "water" => field.set(x, y, (0.2 * hashed(x as u32, y as u32, 99)) as f32),
                    _ => {}
                }
            }
        }
    }
    for s in &scheduled {
        s.process.prepare(&mut world)?;
    }
    Ok((world, scheduled))
}

/// The parameters under which the published form is usually measured: cells of 1 m, no friction, no sea, and neither a
/// ramp of the capacity with depth nor a limit to digging but the lowest neighbour.
fn mei_2007() -> Hydraulic {
    Hydraulic {
        flux: FluxForm::Classic,
        time_step: 0.02,
        rain: 0.01,
        evaporation: 0.015,
        wave_depth: 1.0,
        friction: 0.0,
        max_speed: 50.0,
        capacity: 0.1,
        min_slope: 0.05,
        max_slope: 1.0,
        ramp_depth: 1e-4,
        dry_depth: 1e-3,
        dig: 0.5,
        settle: 0.5,
        dig_limit: 1.0,
        sea: false,
        ..Default::default()
    }
}

/// Without creep, as the peer.
fn streampower() -> Streampower {
    Streampower { years_per_step: 10_000.0, diffusivity: 0.0, ..Default::default() }
}

/// Value noise within 0..1: seven octaves with periods of 128 to 2 cells.
fn terrain(x: u32, y: u32) -> f64 {
    let mut total = 0.0;
    for octave in 0..7 {
        let period = 128u32 >> octave;
        let smooth = |t: u32| {
            let t = f64::from(t % period) / f64::from(period);
            t * t * (3.0 - 2.0 * t)
        };
        let (u, v, i, j) = (smooth(x), smooth(y), x / period, y / period);
        let (a, b) = (hashed(i, j, octave), hashed(i + 1, j, octave));
        let (c, d) = (hashed(i, j + 1, octave), hashed(i + 1, j + 1, octave));
        let (north, south) = (a + (b - a) * u, c + (d - c) * u);
        total += (north + (south - north) * v) * 0.5f64.powi(octave as i32);
    }
    total / (2.0 - 0.5f64.powi(6))
}

/// A number in [0, 1) from two integers (the hash `lowbias32`, as in `common.py`).
fn hashed(x: u32, y: u32, salt: u32) -> f64 {
    let h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ (salt + 1).wrapping_mul(0xc2b2_ae3d);
    let h = (h ^ (h >> 16)).wrapping_mul(0x21f0_aaad);
    let h = (h ^ (h >> 15)).wrapping_mul(0x735a_2d97);
    f64::from(h ^ (h >> 15)) / 4_294_967_296.0
}

/// Samples that the time is split into.
const SAMPLES: u32 = 8;

fn simulation(options: &BenchOptions) -> Result<BenchReport> {
    let (mut world, processes) = case(options.what, options.classic, options.size)?;
    let held = MemoryEstimate::of(&world.grid, world.layers().len(), &processes);
    let rules = rules(&world, &processes);
    let engine = CpuEngine { isa: options.isa.unwrap_or_else(Isa::best), ..CpuEngine::default() };

    // Stamps at the ends of chains, thinned to one a sample, until there are enough; then the engine is asked to stop.
    let sample = Duration::from_secs_f64(options.seconds) / SAMPLES;
    let stamps: Mutex<Vec<(u64, Instant)>> = Mutex::default();
    let cancel = Cancel::default();
    let stamp = |done: u64, _: u64| {
        let now = Instant::now();
        let mut stamps = stamps.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        // The first chain touches all memory, so the warm-up begins after it.
        if stamps.last().is_none_or(|(_, last)| now - *last >= sample) {
            stamps.push((done, now));
        }
        // One stretch to warm up and one for each sample.
        if stamps.len() > SAMPLES as usize + 1 {
            cancel.raise();
        }
    };
    let span = Span { from: 0, steps: Limits::default().max_steps };
    match engine.simulate(&mut world, &processes, span, &Control::new(cancel.clone(), &stamp)) {
        Ok(()) | Err(Error::Cancelled(_)) => {}
        Err(e) => return Err(e),
    }
    let stamps = stamps.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let timed: Vec<(u64, f64)> =
        stamps.windows(2).skip(1).map(|w| (w[1].0 - w[0].0, (w[1].1 - w[0].1).as_secs_f64())).collect();
    let what = if options.what == BenchSubject::Hydraulic && options.classic {
        "hydraulic classic"
    } else {
        options.what.name()
    };
    let mut report = report(what, options, engine.isa, &timed);
    report.bytes_per_cell = held.bytes(&world.grid) as f64 / world.grid.cells() as f64;
    report.bytes_moved_per_cell_step = rules.map(|r| r.0);
    report.operations_per_cell_step = rules.map(|r| r.1);
    report.ledger = world.ledger.iter().map(|(name, a)| (name.to_owned(), a.amount)).collect();
    Ok(report)
}

/// Bytes that the passes of a step read and write for a cell, and arithmetic operations; `None` if actions do some of the work,
/// of which the plan knows nothing.
fn rules(world: &World, processes: &[Scheduled]) -> Option<(f64, usize)> {
    if processes.iter().any(|s| s.process.action().is_some()) {
        return None;
    }
    let (mut moved, mut operations) = (0.0, 0.0);
    for s in processes {
        let mut plan = Plan::default();
        s.process.plan(&Moment::whole(world.grid, 1, world.sea_level_m), &mut plan);
        for p in plan.passes() {
            moved += (p.reads().len() + p.writes().len()) as f64 / s.every as f64;
            operations += p.graph().operations() as f64 / s.every as f64;
        }
    }
    Some((moved * size_of::<f32>() as f64, operations.round() as usize))
}

fn noise(options: &BenchOptions) -> Result<BenchReport> {
    let isa = best_isa(options)?;
    let generator = fbm(8)?;
    let grid = Grid::new(options.size, options.size, 10.0, Boundary::CLOSED, &Limits::default())?;
    // The base and the result.
    let bytes = 2 * Field::bytes_of(options.size, options.size);
    Limits::default().check_bytes("this benchmark", bytes)?;
    let (world, base) = (World::new(grid, 1), Field::new(options.size, options.size, 0.0));
    let control = Control::none();
    let field = |seed: u64| {
        let start = Instant::now();
        let made = generator.generate(&Site::whole(grid, seed, &world, &control), &base)?;
        std::hint::black_box(made.get(0, 0));
        Ok::<_, Error>(start.elapsed().as_secs_f64())
    };
    let once = field(0)?;
    let timed = samples(options, once, |i| field(1 + i))?;
    let mut report = report(options.what.name(), options, isa, &timed);
    report.bytes_per_cell = bytes as f64 / grid.cells() as f64;
    report.bytes_moved_per_cell_step = Some(size_of::<f32>() as f64);
    Ok(report)
}

/// Grid and heights of the drainage benchmark: ten octaves of fBm, on which water leaves on all sides. 32 in 100 cells lie in
/// depressions.
///
/// # Errors
/// If the grid is not sound.
pub fn drainage_case(size: usize) -> Result<(Grid, Vec<f32>)> {
    let grid = Grid::new(size, size, 30.0, Boundary::OPEN, &Limits::default())?;
    let (world, control) = (World::new(grid, 1), Control::none());
    let site = Site::whole(grid, 3, &world, &control);
    Ok((grid, fbm(10)?.generate(&site, &Field::new(size, size, 0.0))?.to_vec()))
}

fn drainage(options: &BenchOptions) -> Result<BenchReport> {
    let isa = best_isa(options)?;
    // The land, the copy that is filled, and what the work itself holds.
    let each = 2 * size_of::<f32>() + BYTES_PER_CELL;
    Limits::default().check_bytes("this benchmark", (options.size as u128).pow(2) * each as u128)?;
    let (grid, height) = drainage_case(options.size)?;
    let control = Control::none();
    let run = || {
        let start = Instant::now();
        let mut filled = height.clone();
        let outlets = outlets(&filled, &grid, &Base::default())?;
        fill(&mut filled, &grid, &outlets, &control)?;
        let cells = Routing::new(&filled, &grid, &outlets, &control)?.upstream_cells();
        std::hint::black_box(cells[0]);
        Ok::<_, Error>(start.elapsed().as_secs_f64())
    };
    let once = run()?;
    let timed = samples(options, once, |_| run())?;
    let mut report = report(options.what.name(), options, isa, &timed);
    report.bytes_per_cell = each as f64;
    Ok(report)
}

fn rivers(options: &BenchOptions) -> Result<BenchReport> {
    let isa = best_isa(options)?;
    let process = Rivers::default();
    let layers = process.layers();
    let each = layers.len() * size_of::<f32>() + Action::bytes_per_cell(&process);
    // The world that is begun with and the one that is worked on.
    let bytes = (options.size as u128).pow(2) * (each + layers.len() * size_of::<f32>()) as u128;
    Limits::default().check_bytes("this benchmark", bytes)?;
    let (grid, height) = drainage_case(options.size)?;
    let mut land = World::new(grid, 1);
    land.put(&eyot_core::layer::known::HEIGHT, Field::from_slice(grid.width, grid.height, &height)?)?;
    for used in &layers {
        land.ensure(&used.spec, used.start);
    }
    let run = || {
        let mut world = land.clone();
        let mut action = process.instantiate(&world)?;
        let start = Instant::now();
        action.act(&Moment::of(&land), &mut world, &Control::none())?;
        Ok::<_, Error>(start.elapsed().as_secs_f64())
    };
    let once = run()?;
    let timed = samples(options, once, |_| run())?;
    let mut report = report(options.what.name(), options, isa, &timed);
    report.bytes_per_cell = each as f64;
    Ok(report)
}

/// Years of ice before the ones that are timed, and in each sample.
const ICE_YEARS: [f32; 2] = [100.0, 4.0];

fn glaciers(options: &BenchOptions) -> Result<BenchReport> {
    let isa = best_isa(options)?;
    let process = Glaciers { years: 0.0, ela: 1200.0, climate: false, ..Glaciers::default() };
    let layers = process.layers();
    let each = layers.len() * size_of::<f32>() + Action::bytes_per_cell(&process);
    // The world that is begun with and the one that is worked on.
    let bytes = (options.size as u128).pow(2) * (each + layers.len() * size_of::<f32>()) as u128;
    Limits::default().check_bytes("this benchmark", bytes)?;
    let grid = Grid::new(options.size, options.size, 60.0, Boundary::OPEN, &Limits::default())?;
    let mut land = World::new(grid, 1);
    land.sea_level_m = -1000.0;
    let height = |x: usize, y: usize| (2500.0 * terrain(x as u32, y as u32)) as f32;
    land.put(&eyot_core::layer::known::HEIGHT, Field::from_fn(grid.width, grid.height, height))?;
    for used in &layers {
        land.ensure(&used.spec, used.start);
    }
    let act = |world: &mut World, years: f32| {
        let mut action = Glaciers { ice_years: years, ..process.clone() }.instantiate(world)?;
        let start = Instant::now();
        action.act(&Moment::of(&land), world, &Control::none())?;
        Ok::<_, Error>(start.elapsed().as_secs_f64() / f64::from(years))
    };
    let mut grown = land.clone();
    act(&mut grown, ICE_YEARS[0])?;
    let once = act(&mut grown.clone(), ICE_YEARS[1])?;
    let timed = samples(options, once * f64::from(ICE_YEARS[1]), |_| act(&mut grown.clone(), ICE_YEARS[1]))?;
    let mut report = report(options.what.name(), options, isa, &timed);
    report.bytes_per_cell = each as f64;
    Ok(report)
}

fn community(options: &BenchOptions) -> Result<BenchReport> {
    let isa = best_isa(options)?;
    let parameters = Community::default();
    let (side, forcing) = (options.size as f64, Forcing::chumbe(&parameters, 1)?);
    let site = if options.what == BenchSubject::Slope { slope(options.size)? } else { SeaFloor::flat(side, side) };
    let start = Instant::now();
    let mut plot = Plot::new(parameters, site, forcing, 1)?;
    let made = start.elapsed().as_secs_f64();
    // The first year sorts out what was put down at random.
    for _ in 0..12 {
        plot.month()?;
    }
    let month = |plot: &mut Plot| {
        let start = Instant::now();
        std::hint::black_box(plot.month()?);
        Ok::<_, Error>(start.elapsed().as_secs_f64())
    };
    let once = month(&mut plot)?;
    let plot = std::cell::RefCell::new(plot);
    let timed = samples(options, once, |_| month(&mut plot.borrow_mut()))?;
    let mut report = report(options.what.name(), options, isa, &timed);
    let plot = plot.into_inner();
    let (colonies, algae) = (plot.colonies().len(), plot.algae().len());
    report.community = Some(CommunityReport {
        seconds_per_month: report.seconds_per_step,
        months_per_second: 1.0 / report.seconds_per_step,
        seconds_per_plot: made + 12.0 * YEARS * report.seconds_per_step_median,
        colonies,
        algae,
    });
    Ok(report)
}

fn bodies(options: &BenchOptions) -> Result<BenchReport> {
    let isa = best_isa(options)?;
    let parameters = Community::default();
    let (side, forcing) = (options.size as f64, Forcing::chumbe(&parameters, 1)?);
    let mut plot = Plot::new(parameters, SeaFloor::flat(side, side), forcing, 1)?;
    plot.month()?;
    let bytes = Bodies::bytes(&plot, Detail::default());
    Limits::default().check_bytes("this benchmark", bytes)?;
    let update = |bodies: &mut Bodies, plot: &Plot| {
        let start = Instant::now();
        std::hint::black_box(bodies.update(plot)?);
        Ok::<_, Error>(start.elapsed().as_secs_f64())
    };
    let all = || update(&mut Bodies::new(plot.community(), 1, Detail::default())?, &plot);
    let once = all()?;
    let timed = samples(options, once, |_| all())?;
    let mut report = report(options.what.name(), options, isa, &timed);
    let mut followed = Bodies::new(plot.community(), 1, Detail::default())?;
    followed.update(&plot)?;
    let of = |colony: &community::Colony| followed.of(colony.id).map_or(0, |b| b.solid.triangles());
    let (colonies, triangles) = (plot.colonies().len(), plot.colonies().iter().map(of).sum::<usize>());
    // The first year sorts out what was put down at random.
    let months: Result<Vec<f64>> = (0..36).map(|_| plot.month().and_then(|_| update(&mut followed, &plot))).collect();
    let mut months = months?.split_off(12);
    months.sort_unstable_by(f64::total_cmp);
    report.bytes_per_cell = bytes as f64 / (options.size * options.size).max(1) as f64;
    report.bodies = Some(BodiesReport {
        seconds_per_plot: report.seconds_per_step,
        seconds_per_month: months[months.len() / 2],
        triangles_per_second: triangles as f64 / report.seconds_per_step,
        colonies,
        triangles,
    });
    Ok(report)
}

/// A slope of this length in metres, in cells of a metre: from 1 to 25 m of water, a fifth of it sand.
fn slope(side: usize) -> Result<SeaFloor> {
    Limits::default().check_cells(side, side)?;
    let depth = Field::from_fn(side, side, |x, _| 1.0 + 24.0 * (x as f32 + 0.5) / side as f32);
    let mut ground = Ground::of_depth(1.0, depth, 0.05, 1.0);
    // Channels of sand that run down the slope.
    ground.substrate = Field::from_fn(side, side, |x, y| if (y + x / 8) % 20 < 4 { 0.0 } else { 1.0 });
    Ok(SeaFloor::of_ground(ground))
}

/// A world of ten plates as `PyPlatec` has it: a torus with 35 in 100 cells of land, cycles of 550 steps at most.
///
/// # Errors
/// If the grid is not sound.
pub fn plates_case(size: usize) -> Result<eyot_plates::Plates> {
    let grid = Grid::new(size, size, 4e7 / size.max(1) as f64, Boundary::WRAP, &Limits::default())?;
    let years_per_step = plates_years(size);
    let parameters = Tectonics { count: 10, land: 0.35, cycle: 550.0, years_per_step, ..Tectonics::default() };
    eyot_plates::Plates::new(&grid, 3, parameters, eyot_plates::Start::Noise)
}

/// Years of a step of plates: on finer grids they cross as many cells in one.
fn plates_years(size: usize) -> f32 {
    1e6 * (512.0 / size as f32).min(1.0)
}

/// Steps of the world for each of the plates.
const TURN: u64 = 25;

fn drift(options: &BenchOptions) -> Result<BenchReport> {
    let (mut world, processes) = case(options.what, options.classic, options.size)?;
    let held = MemoryEstimate::of(&world.grid, world.layers().len(), &processes);
    let engine = CpuEngine { isa: options.isa.unwrap_or_else(Isa::best), ..CpuEngine::default() };
    let stamps: Mutex<Vec<(u64, Instant)>> = Mutex::default();
    let (cancel, begun) = (Cancel::default(), Instant::now());
    let stamp = |done: u64, _: u64| {
        stamps.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push((done, Instant::now()));
        // Two turns to warm up.
        if done > 5 * TURN && begun.elapsed().as_secs_f64() > options.seconds {
            cancel.raise();
        }
    };
    let span = Span { from: 0, steps: Limits::default().max_steps };
    match engine.simulate(&mut world, &processes, span, &Control::new(cancel.clone(), &stamp)) {
        Ok(()) | Err(Error::Cancelled(_)) => {}
        Err(e) => return Err(e),
    }
    let stamps = stamps.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let spans = stamps.windows(2).map(|w| (w[0].0, w[1].0 - w[0].0, (w[1].1 - w[0].1).as_secs_f64()));
    let mut timed: Vec<(u64, u64, f64)> = spans.filter(|(at, ..)| *at > 2 * TURN).collect();
    // Steps in which zones are found take longer.
    let has = |at: u64, steps: u64, every: u64| (at..at + steps).any(|step| step.is_multiple_of(every));
    timed.retain(|&(at, steps, _)| !has(at, steps, ZONES));
    let takes_turn = |at: u64, steps: u64| has(at, steps, TURN);
    let between = timed.iter().filter(|(at, steps, _)| !takes_turn(*at, *steps)).map(|t| t.2 / t.1 as f64);
    let between = median(between.collect());
    let turns = timed.iter().filter(|(at, steps, _)| takes_turn(*at, *steps)).map(|t| t.2 - between * t.1 as f64);
    let turns: Vec<f64> = turns.collect();
    let mut plates = plates_case(options.size)?;
    let alone = (0..turns.len() + 8).map(|_| {
        let start = Instant::now();
        plates.step();
        start.elapsed().as_secs_f64()
    });
    let alone: Vec<f64> = alone.skip(8).collect();
    let samples: Vec<(u64, f64)> = timed.iter().map(|&(_, steps, seconds)| (steps, seconds)).collect();
    let mut report = report(options.what.name(), options, engine.isa, &samples);
    report.bytes_per_cell = held.bytes(&world.grid) as f64 / world.grid.cells() as f64;
    report.ledger = world.ledger.iter().map(|(name, a)| (name.to_owned(), a.amount)).collect();
    report.drift = Some(DriftReport {
        turns: turns.len(),
        seconds_between_turns: between,
        seconds_of_turn: median(turns),
        seconds_of_plates: median(alone),
    });
    Ok(report)
}

/// The upper one of two middles.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn plates(options: &BenchOptions) -> Result<BenchReport> {
    let isa = best_isa(options)?;
    let each = Drift::new(Tectonics::default()).bytes_per_cell();
    Limits::default().check_bytes("this benchmark", (options.size as u128).pow(2) * each as u128)?;
    let plates = std::cell::RefCell::new(plates_case(options.size)?);
    let step = || {
        let start = Instant::now();
        plates.borrow_mut().step();
        start.elapsed().as_secs_f64()
    };
    // Borders are still smooth at the beginning, which is faster.
    let once = (0..40).map(|_| step()).sum::<f64>() / 40.0;
    let timed = samples(options, once, |_| Ok(step()))?;
    let mut report = report(options.what.name(), options, isa, &timed);
    report.bytes_per_cell = each as f64;
    Ok(report)
}

/// Repeats and seconds of each sample of work that takes about `once` seconds; `work` gets its number.
fn samples(options: &BenchOptions, once: f64, work: impl Fn(u64) -> Result<f64>) -> Result<Vec<(u64, f64)>> {
    // Repeats of a sample: a single one may be too short for the clock.
    let repeats = (options.seconds / f64::from(SAMPLES) / once.max(1e-9)).clamp(1.0, 1e6) as u64;
    (0..u64::from(SAMPLES))
        .map(|sample| {
            let seconds: Result<f64> = (0..repeats).map(|i| work(sample * repeats + i)).sum();
            Ok((repeats, seconds?))
        })
        .collect()
}

fn best_isa(options: &BenchOptions) -> Result<Isa> {
    let isa = Isa::best();
    match options.isa.filter(|i| *i != isa) {
        Some(asked) => {
            let reason = format!("this benchmark's is chosen when the program starts; set EYOT_ISA={}", asked.name());
            Err(bad("isa", reason))
        }
        None => Ok(isa),
    }
}

/// The generator `fbm` with so many octaves.
fn fbm(octaves: u32) -> Result<Box<dyn Generator>> {
    let entry = GENERATORS.iter().find(|e| e.name == "fbm").ok_or_else(|| {
        let known: Vec<&str> = GENERATORS.iter().map(|e| e.name).collect();
        let reason =
            format!("this needs the generator `fbm`, which is not registered; there are: {}", known.join(", "));
        bad("what", reason)
    })?;
    let mut parameters = (entry.defaults)();
    if let Some(value) = parameters.get_mut("octaves") {
        *value = serde_json::json!(octaves);
    }
    (entry.make)(parameters).map_err(|e| bad("what", format!("the generator `fbm` refuses: {e}")))
}

/// `timed`: steps and seconds of each sample.
fn report(what: &'static str, options: &BenchOptions, isa: Isa, timed: &[(u64, f64)]) -> BenchReport {
    let mut each: Vec<f64> = timed.iter().map(|&(steps, s)| s / steps.max(1) as f64).collect();
    each.sort_unstable_by(f64::total_cmp);
    let best = each.first().copied().unwrap_or(f64::NAN);
    // The upper one of two middles: never better than it was.
    let median = each.get(each.len() / 2).copied().unwrap_or(f64::NAN);
    let cells = (options.size * options.size) as f64;
    BenchReport {
        what,
        size: options.size,
        threads: options.threads,
        isa: isa.name(),
        steps: timed.iter().map(|t| t.0).sum(),
        samples: timed.len(),
        seconds_per_step: best,
        seconds_per_step_median: median,
        cell_steps_per_second: cells / best,
        cell_steps_per_second_median: cells / median,
        bytes_per_cell: 0.0,
        bytes_moved_per_cell_step: None,
        operations_per_cell_step: None,
        community: None,
        bodies: None,
        drift: None,
        ledger: BTreeMap::new(),
    }
}

fn bad(field: &str, reason: String) -> Error {
    Error::BadParameter { owner: "bench".into(), field: field.into(), reason }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::process::Action;

    #[test]
    fn every_simulation_reports_sound_numbers() {
        for (what, classic, held, moved) in [
            (BenchSubject::Hydraulic, false, 14, Some(29.0)),
            (BenchSubject::Signed, false, 10, Some(21.0)),
            (BenchSubject::Hydraulic, true, 11, Some(26.0)),
            (BenchSubject::Thermal, false, 2, Some(2.0)),
            (BenchSubject::Reef, false, 6, Some(13.0)),
            // Two layers and the copies to go back to; its action, of which the plan knows nothing, comes on top.
            (BenchSubject::Streampower, false, 4, None),
            // Water 29, beds and new rock 60, the rock cycle 50 in every second step and rockfall 7 in every 20th.
            (BenchSubject::Strata, false, 39, Some(114.35)),
        ] {
            let options = BenchOptions { what, classic, size: 64, seconds: 0.05, ..Default::default() };
            let r = run(&options).unwrap();
            assert_eq!(r.samples, SAMPLES as usize, "{what:?}");
            assert!(r.seconds_per_step > 0.0 && r.seconds_per_step <= r.seconds_per_step_median);
            let action = if what == BenchSubject::Streampower { streampower().bytes_per_cell() as f64 } else { 0.0 };
            let layers = f64::from(held) * Field::bytes_of(64, 64) as f64 / (64.0 * 64.0);
            assert!((r.bytes_per_cell - layers - action).abs() < 1e-9, "{what:?}: {}", r.bytes_per_cell);
            match (r.bytes_moved_per_cell_step, moved) {
                (Some(got), Some(want)) => assert!((got - 4.0 * want).abs() < 1e-9, "{what:?}: {got}"),
                (got, want) => assert_eq!(got, want, "{what:?}"),
            }
            assert_eq!(r.operations_per_cell_step.is_some(), moved.is_some(), "{what:?}");
            let json = serde_json::to_value(&r).unwrap();
            assert!(json["cell_steps_per_second"].as_f64().unwrap() > 0.0);
        }
    }

    #[test]
    fn noise_and_drainage_report_sound_numbers() {
        for what in [BenchSubject::Noise, BenchSubject::Drainage, BenchSubject::Rivers] {
            let r = run(&BenchOptions { what, size: 64, seconds: 0.05, ..Default::default() }).unwrap();
            assert_eq!((r.samples, r.what), (SAMPLES as usize, what.name()));
            assert!(r.seconds_per_step > 0.0 && r.seconds_per_step <= r.seconds_per_step_median);
            assert!(r.bytes_per_cell > 8.0);
            assert_eq!(r.bytes_moved_per_cell_step.is_some(), what == BenchSubject::Noise);
            assert!(case(what, false, 64).is_err());
            let e = run(&BenchOptions { what: BenchSubject::Streampower, size: 20_000, ..Default::default() });
            assert!(matches!(e, Err(Error::Limit { .. })));
        }
    }

    #[test]
    fn the_world_reports_a_step_of_all_processes() {
        let what = BenchSubject::World;
        let r = run(&BenchOptions { what, size: 48, seconds: 0.05, ..Default::default() }).unwrap();
        assert_eq!((r.samples, r.what), (SAMPLES as usize, "world"));
        assert!(r.seconds_per_step > 0.0 && r.cell_steps_per_second > 0.0);
        assert!(r.operations_per_cell_step.unwrap() > 300 && r.bytes_moved_per_cell_step.unwrap() > 200.0);
        assert!(r.ledger["water.rain"] > 0.0 && r.ledger["humidity.taken_up"] > 0.0);
    }

    #[test]
    fn plates_report_their_steps() {
        let r =
            run(&BenchOptions { what: BenchSubject::Plates, size: 64, seconds: 0.05, ..Default::default() }).unwrap();
        assert_eq!((r.samples, r.what), (SAMPLES as usize, "plates"));
        assert!(r.seconds_per_step > 0.0 && r.cell_steps_per_second > 0.0 && r.bytes_per_cell > 8.0);
    }

    #[test]
    fn drift_reports_how_long_a_world_stops_for_its_plates() {
        let r =
            run(&BenchOptions { what: BenchSubject::Drift, size: 64, seconds: 0.05, ..Default::default() }).unwrap();
        let d = r.drift.unwrap();
        assert!(d.turns >= 2 && d.seconds_between_turns > 0.0 && d.seconds_of_plates > 0.0);
        assert!(d.seconds_of_turn.is_finite() && r.ledger["crust.deposited"] > 0.0);
    }

    #[test]
    fn the_community_reports_its_months() {
        for what in [BenchSubject::Community, BenchSubject::Slope] {
            let r = run(&BenchOptions { what, size: 40, seconds: 0.05, ..Default::default() }).unwrap();
            let json = serde_json::to_value(&r).unwrap();
            let number = |key: &str| json[key].as_f64().unwrap();
            assert!(number("seconds_per_month") > 0.0 && json["colonies"].as_u64().unwrap() > 0);
            // Fifty years of months, none of which is faster than the best.
            assert!(number("seconds_per_plot") >= 600.0 * number("seconds_per_month"));
            assert!((number("months_per_second") * number("seconds_per_month") - 1.0).abs() < 1e-9);
            assert_eq!((r.samples, r.what, r.size), (SAMPLES as usize, what.name(), 40));
        }
    }

    #[test]
    fn bodies_report_their_plot_and_months() {
        let what = BenchSubject::Bodies;
        let r = run(&BenchOptions { what, size: 3, seconds: 0.05, ..Default::default() }).unwrap();
        let json = serde_json::to_value(&r).unwrap();
        for name in ["seconds_per_plot", "seconds_per_month", "triangles_per_second"] {
            assert!(json[name].as_f64().unwrap() > 0.0, "{name}");
        }
        assert!(json["triangles"].as_u64().unwrap() > 100 * json["colonies"].as_u64().unwrap());
        assert_eq!((r.samples, r.what), (SAMPLES as usize, "bodies"));
    }

    #[test]
    fn options_out_of_range_are_refused_by_name() {
        let refused = |options: BenchOptions| run(&options).unwrap_err().to_string();
        assert!(refused(BenchOptions { threads: 0, ..Default::default() }).contains("threads"));
        assert!(refused(BenchOptions { seconds: f64::NAN, ..Default::default() }).contains("seconds"));
        assert!(refused(BenchOptions { size: 0, ..Default::default() }).contains("grid"));
        assert!("water".parse::<BenchSubject>().unwrap_err().to_string().contains("hydraulic"));
    }
}
