//! Corals: single colonies that grow, fight for space, bleach, die and settle on the sea floor, a month a step.
//!
//! # Equations
//! `w` level of the sea, `h` height, `g = w - h` depth.
//! 1. Light `I = e^(-attenuation g)`, as a share of the light at the surface; larvae find hold with the chance `substrate` where depth
//!    and light suit their species.
//! 2. A month of the community: `eyot_reef::community` says what happens in it.
//! 3. `sea = "world"`: mean of month `m` over the sea is `T_mean + T_cos cos f + T_sin sin f`, not below freezing, `f = 2 pi (d - 79) / 365`
//!    with `d` the month's middle day: what the process `climate` remembers of a year whose northern spring is `f = 0`. Weather and warm
//!    years around monthly means are two first-order autoregressive series (`variability`).
//! 4. `h' = h + c`, and the same gain for `limestone`: `c` is what the month's skeletons become, `mass / (2930 kg/m3 (1 - porosity))`
//!    spread as a flat heap over `rubble_range` around the colony's centre: a reef is more rubble and sand than skeletons in place.
//!
//! # Source
//! Kubicek, Muhando and Reuter 2012 for the community; Bosscher and Schlager 1992 for light; Liu and others 2003 for degree heating
//! weeks; Lough and Barnes 2000 for the density of skeletons.
//!
//! # Differences
//! The head of `community` lists them. Here: the plot is the whole grid, and grows under its colonies.
//!
//! # Layers
//! Reads and writes `height`, `limestone` (m); writes `coral_cover` (1). Reads `substrate` (1) if it is there, and with
//! `sea = "world"` `temperature_mean`, `temperature_cos`, `temperature_sin` (degrees Celsius).
//! Colonies, algae and turf are the component `corals`, the census of each month the table `corals.census`, the sea's monthly means
//! the numbers `corals.sea`.
//!
//! # Limits
//! Square cells; sides up to 4096 m. A reef of more individuals than memory holds is refused before it is made.
//!
//! # Conserves
//! Limestone is in the ledger (`ground.corals`, `the_ground_gains_what_the_colonies_build`).

use crate::bodies::{Detail, Sculptor};
use crate::community::Population;
use crate::community::{
    CHUMBE, Census, CensusColumn, Community, Forcing, Ground, Plot, Site, Temperatures, Variability,
};
use crate::community::{MONTH_DAYS, YEAR_DAYS};
use eyot_core::component::{Numbers, Shape, Table, Type};
use eyot_core::layer::known::{HEIGHT, LIMESTONE};
use eyot_core::process::{
    Access, Action, ActionInstance, Entry, LayerUse, Locality, Moment, Process, check_ranges, defaults_of,
    parameters_from, schema_of,
};
use eyot_core::{Control, Error, Field, Grid, LayerSpec, Limits, Result, World, about, math64};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Share of a cell that living corals cover.
pub const CORAL_COVER: LayerSpec =
    LayerSpec::new("coral_cover", "1", "Share of the ground under living corals", (0.0, 1.0));
/// The component with the individuals, a [`Population`].
pub const POPULATION: &str = "corals";
/// The component with the census, a [`Table`].
pub const CENSUS: &str = "corals.census";
/// The component with the monthly means of the world's sea, C: [`Numbers`].
pub const SEA: &str = "corals.sea";
/// Layers of the process `climate`.
const CLIMATE: [&str; 3] = ["temperature_mean", "temperature_cos", "temperature_sin"];
/// Day of the year on which its northern spring begins.
const SPRING: f64 = 79.0;
/// The sea is nowhere colder, C.
const FREEZING: f64 = -1.8;
/// Layer that says where larvae find hold, if a step has made it.
const SUBSTRATE: &str = "substrate";
/// Years of weather that a simulated sea has before it begins anew.
const YEARS: usize = 120;

/// Single colonies of corals that grow, fight for space, bleach, die and settle on the sea floor. A step is a month.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Corals {
    /// The community: species, algae, turf, grazing, disturbances, heat.
    #[serde(flatten)]
    pub community: Community,
    /// Extinction of light: 0.04 in the clearest ocean, 0.16 in coastal water (Bosscher and Schlager 1992).
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1/m"))]
    pub attenuation: f32,
    /// Chance of larvae to find hold where depth and light suit them, unless a layer `substrate` says so cell by cell.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub substrate: f32,
    /// Where the temperature of the sea comes from.
    pub sea: Sea,
    /// Years from one severe year to the next (sea = "chumbe").
    #[schemars(range(min = 1, max = 1000), extend("unit" = "yr"))]
    pub severe_interval: u32,
    /// Mean temperatures of the months, January first (sea = "climate"; "world" takes them from its layers).
    #[schemars(inner(range(min = -5.0, max = 50.0)), extend("unit" = "C"))]
    pub monthly_means: [f32; 12],
    /// How the sea varies around its monthly means (sea = "climate" or "world").
    pub variability: Variability,
    /// File with daily or monthly temperatures, a line for each: `2005-08-31, 27.4` or `2005-08, 27.1`, degrees Celsius; relative to the
    /// recipe's folder (sea = "measured"). Gaps are bridged, and the series begins anew when it is through. In a program without
    /// recipes: the text itself.
    #[schemars(extend("file" = "text"))]
    pub temperatures: String,
    /// How far waves spread what a colony builds; under the colony itself if that is wider.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub rubble_range: f32,
    /// Whether the ground grows with what the corals build.
    pub build: bool,
}

/// Where the temperature of the sea comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Sea {
    /// Years as at Chumbe, Zanzibar, 1997 to 2010; one like 1998 at equal intervals.
    #[default]
    Chumbe,
    /// Monthly means, with weather, warm years and a trend around them.
    Climate,
    /// A measured series from a file.
    Measured,
    /// The simulated climate of this world: monthly means from the layers `temperature_mean`, `temperature_cos` and
    /// `temperature_sin`, averaged over the plot's sea when the first month begins, with `variability` around them.
    World,
}

impl Default for Corals {
    fn default() -> Self {
        Self {
            community: Community::default(),
            attenuation: 0.1,
            substrate: 1.0,
            sea: Sea::Chumbe,
            severe_interval: Forcing::SEVERE_INTERVAL,
            monthly_means: CHUMBE,
            variability: Variability::default(),
            temperatures: String::new(),
            rubble_range: 3.0,
            build: true,
        }
    }
}

/// The line of the registry.
pub const CORALS: Entry<dyn Process> = Entry {
    name: "corals",
    schema: schema_of::<Corals>,
    defaults: defaults_of::<Corals>,
    make: |table| Ok(Box::new(Colonies { corals: parameters_from(table)? })),
    about: about!("corals.rs"),
    cites: &["kubicek2012", "bosscher1992", "liu2003", "lough2000"],
};

/// The process.
struct Colonies {
    corals: Corals,
}

impl Process for Colonies {
    fn layers(&self) -> Vec<LayerUse> {
        vec![HEIGHT.changed(0.0), LIMESTONE.changed(0.0), CORAL_COVER.written(0.0)]
    }

    fn needs(&self) -> Vec<&'static str> {
        if self.corals.sea == Sea::World { CLIMATE.to_vec() } else { Vec::new() }
    }

    fn reads(&self) -> Vec<Cow<'static, str>> {
        let own = self.layers().into_iter().filter(|l| l.access != Access::Write).map(|l| l.spec.name);
        own.chain(self.needs().into_iter().chain([SUBSTRATE]).map(Cow::Borrowed)).collect()
    }

    fn views(&self) -> Vec<(&'static str, Shape)> {
        vec![("corals.colonies", Shape::Points), ("corals.algae", Shape::Points), (CENSUS, Shape::Table)]
    }

    fn check(&self, grid: &Grid) -> Result<()> {
        self.corals.check(grid)
    }

    fn action(&self) -> Option<&dyn Action> {
        Some(self)
    }
}

impl Action for Colonies {
    fn instantiate(&self, _world: &World) -> Result<Box<dyn ActionInstance>> {
        Ok(Box::new(Growing { corals: self.corals.clone(), forcing: None }))
    }

    fn locality(&self) -> Locality {
        Locality::Whole
    }

    fn bytes_per_cell(&self) -> usize {
        // Depth, light and substrate, and the sums that first settlers are placed by.
        3 * 4 + 8
    }
}

/// Corals in a simulation.
struct Growing {
    corals: Corals,
    /// The heat of all months, once it is known.
    forcing: Option<Forcing>,
}

impl ActionInstance for Growing {
    fn act(&mut self, moment: &Moment, world: &mut World, control: &Control<'_>) -> Result<()> {
        control.check()?;
        let forcing = match &self.forcing {
            Some(known) => known.clone(),
            None => {
                if self.corals.sea == Sea::World {
                    let means = self.corals.sea_of(world, moment.sea_level_m)?;
                    world.components.insert(SEA, Numbers(means.map(f64::from).to_vec()));
                }
                let made = self.corals.forcing(world)?;
                self.forcing.insert(made).clone()
            }
        };
        let mut plot = self.corals.plot_in(world, moment.sea_level_m, forcing, control)?;
        control.check()?;
        let census = plot.month_under(control)?;
        if self.corals.build {
            build(&plot, world, self.corals.rubble_range, control)?;
        }
        cover(&plot, &mut world.layer_mut(&CORAL_COVER.name)?.field, control)?;
        let names: Vec<&str> = self.corals.community.species.iter().map(|s| s.name.as_str()).collect();
        let row: Vec<f64> = census.columns(&names).into_iter().map(|(_, v)| v).collect();
        self.corals.census_mut(world)?.push(&row)?;
        world.components.insert(POPULATION, plot.into_population());
        Ok(())
    }
}

impl Corals {
    /// Finds parameters that cannot work, or not on this grid.
    ///
    /// # Errors
    /// The first such parameter, by name.
    pub fn check(&self, grid: &Grid) -> Result<()> {
        check_ranges("corals", self)?;
        check_ranges("corals.variability", &self.variability)?;
        self.community.check()?;
        if (grid.cell_x_m - grid.cell_y_m).abs() > 1e-6 * grid.cell_x_m {
            let reason = format!("cells of {} x {} m; corals need square ones", grid.cell_x_m, grid.cell_y_m);
            return Err(wrong("grid.cell", reason));
        }
        if self.sea != Sea::Measured && !self.temperatures.is_empty() {
            return Err(wrong("temperatures", "nothing looks at them; add sea = \"measured\"".into()));
        }
        if self.sea == Sea::Measured && self.temperatures.is_empty() {
            return Err(wrong("temperatures", "sea = \"measured\" needs the name of a file with temperatures".into()));
        }
        // What their bodies need would else be missed after all the months.
        Sculptor::new(&self.community, 0, Detail::default())?;
        let (width, length) = grid.extent_m();
        let site = Site::flat(width, length);
        Plot::check(&self.community, &site, &Limits::default()).map_err(|e| match e {
            Error::BadParameter { owner, reason, .. } if owner == "site" => wrong("grid.size", reason),
            other => other,
        })?;
        // Reads the series and checks it.
        self.heat(0, &CHUMBE).map(drop)
    }

    /// Heat of all months to come.
    ///
    /// # Errors
    /// If the series of temperatures cannot be read, or the world has no climate and should have.
    pub fn forcing(&self, world: &World) -> Result<Forcing> {
        let means = if self.sea == Sea::World { self.sea_of(world, world.sea_level_m)? } else { self.monthly_means };
        self.heat(world.seed, &means)
    }

    fn heat(&self, seed: u64, means: &[f32; 12]) -> Result<Forcing> {
        match self.sea {
            Sea::Chumbe => Forcing::chumbe_every(&self.community, self.severe_interval, seed),
            Sea::Climate | Sea::World => {
                let mut series = Temperatures::of_climate(means, YEARS);
                self.variability.vary(&mut series, seed);
                Forcing::series(&series, &self.community)
            }
            Sea::Measured => {
                let series = Temperatures::parse(&self.temperatures, self.community.compat);
                let series = series.map_err(|e| match e {
                    Error::BadParameter { field, reason, .. } => wrong("temperatures", format!("{field}: {reason}")),
                    other => other,
                })?;
                Forcing::series(&series, &self.community)
            }
        }
    }

    /// Equation (3): what the sea was when the first month began, or is now.
    fn sea_of(&self, world: &World, sea_level_m: f64) -> Result<[f32; 12]> {
        if let Some(Numbers(known)) = world.components.get(SEA)? {
            let sound = known.len() == 12 && known.iter().all(|t| (-5.0..=400.0).contains(t));
            let reason = || wrong("saved state", format!("`{SEA}` does not hold twelve temperatures"));
            return if sound { Ok(std::array::from_fn(|m| known[m] as f32)) } else { Err(reason()) };
        }
        let [mean, cos, sin] = CLIMATE.map(|name| world.layer(name).map(|l| &l.field));
        let (layers, height) = ([mean?, cos?, sin?], &world.layer("height")?.field);
        let (mut sums, mut count) = ([[0.0f64; 3]; 2], [0u64; 2]);
        for (y, row) in (0..height.height()).map(|y| (y, height.row(y))) {
            for (x, &h) in row.iter().enumerate() {
                let is_sea = usize::from(f64::from(h) < sea_level_m);
                count[is_sea] += 1;
                (0..3).for_each(|i| sums[is_sea][i] += f64::from(layers[i].get(x, y)));
            }
        }
        // Where there is no sea, nobody asks how warm it is.
        let of = usize::from(count[1] > 0);
        let [mean, cos, sin] = sums[of].map(|s| s / count[of] as f64);
        let mut first_day = 0.0;
        Ok(MONTH_DAYS.map(|days| {
            let f = 360.0 * (first_day + 0.5 * days as f64 - SPRING) / YEAR_DAYS as f64;
            first_day += days as f64;
            (mean + cos * math64::cos_degrees(f) + sin * math64::sin_degrees(f)).max(FREEZING) as f32
        }))
    }

    /// The reef as it stands in this world, or a new one if none has grown yet.
    ///
    /// # Errors
    /// If the world's numbers are not those of such a reef, or it does not fit into memory.
    pub fn plot(&self, world: &World) -> Result<Plot> {
        self.plot_in(world, world.sea_level_m, self.forcing(world)?, &Control::none())
    }

    fn plot_in(&self, world: &World, sea_level_m: f64, forcing: Forcing, control: &Control<'_>) -> Result<Plot> {
        let (community, site) = (self.community.clone(), self.site(world, sea_level_m)?);
        match world.components.get::<Population>(POPULATION)? {
            // A copy, so that a month that is stopped half-way leaves the world's own as it was.
            Some(known) => Plot::of_population(community, site, forcing, world.seed, *control.limits(), known.clone()),
            None => Plot::under(community, site, forcing, world.seed, control),
        }
    }

    /// Equation (1): the whole grid as a plot.
    fn site(&self, world: &World, sea_level_m: f64) -> Result<Site> {
        let (height, grid) = (&world.layer("height")?.field, &world.grid);
        let (w, h) = (grid.width, grid.height);
        let depth = Field::from_fn(w, h, |x, y| (sea_level_m - f64::from(height.get(x, y))) as f32);
        let mut ground = Ground::of_depth(grid.cell_x_m, depth, self.attenuation, self.substrate);
        if let Some(layer) = world.get(SUBSTRATE) {
            ground.substrate = Field::from_fn(w, h, |x, y| layer.get(x, y).clamp(0.0, 1.0));
        }
        Ok(Site::of_ground(ground))
    }

    /// The columns of the census.
    pub fn census_columns(&self) -> Vec<CensusColumn> {
        let names: Vec<&str> = self.community.species.iter().map(|s| s.name.as_str()).collect();
        let none = Census { species: vec![Default::default(); names.len()], ..Census::default() };
        none.columns(&names).into_iter().map(|(column, _)| column).collect()
    }

    /// A census without a month.
    fn empty_census(&self) -> Table {
        let columns = self.census_columns();
        let of = |c: &CensusColumn| if c.is_whole { Type::U64 } else { Type::F64 };
        Table::new(columns.iter().map(|c| (c.name.as_str(), c.unit, of(c))))
    }

    /// The census of a world, a row for each month; empty before the first. Earlier versions kept its rows as a list of numbers.
    ///
    /// # Errors
    /// If it is something else.
    pub fn census<'w>(&self, world: &'w World) -> Result<Cow<'w, Table>> {
        let Some(component) = world.components.of_any_kind(CENSUS) else { return Ok(Cow::Owned(self.empty_census())) };
        let Some(Numbers(numbers)) = component.as_any().downcast_ref() else {
            let table = world.components.get::<Table>(CENSUS)?;
            return Ok(table.map_or_else(|| Cow::Owned(self.empty_census()), Cow::Borrowed));
        };
        let mut table = self.empty_census();
        let columns = table.columns().len();
        numbers.chunks(columns).try_for_each(|row| table.push(row))?;
        Ok(Cow::Owned(table))
    }

    fn census_mut<'w>(&self, world: &'w mut World) -> Result<&'w mut Table> {
        if let Cow::Owned(table) = self.census(world)? {
            world.components.insert(CENSUS, table);
        }
        world.components.entry(CENSUS, Table::default)
    }
}

fn wrong(field: &str, reason: String) -> Error {
    Error::BadParameter { owner: "corals".into(), field: field.into(), reason }
}

/// Equation (4).
fn build(plot: &Plot, world: &mut World, range_m: f32, control: &Control<'_>) -> Result<()> {
    let grid = world.grid;
    let mut gain = Field::new(grid.width, grid.height, 0.0);
    plot.deposit(grid.cell_x_m, f64::from(range_m), &mut gain, control)?;
    // What rounding leaves of it, so that the ledger closes.
    let built = add(&mut world.layer_mut("height")?.field, &gain);
    add(&mut world.layer_mut("limestone")?.field, &gain);
    let area = grid.cell_x_m * grid.cell_y_m;
    world.ledger.add("ground.corals", built * area, "m3", "Limestone that colonies built", 1);
    Ok(())
}

/// Adds to a layer and returns by how much its sum has grown.
fn add(layer: &mut Field, gain: &Field) -> f64 {
    let mut sum = 0.0;
    for (y, row) in layer.rows_mut().enumerate() {
        for (value, more) in row.iter_mut().zip(gain.row(y)) {
            let before = *value;
            *value += more;
            sum += f64::from(*value) - f64::from(before);
        }
    }
    sum
}

/// Share of each cell under living colonies, as discs of their mean radius: their area counts where it lies, in sixteenths of a cell.
fn cover(plot: &Plot, layer: &mut Field, control: &Control<'_>) -> Result<()> {
    let (w, h) = (layer.width(), layer.height());
    let cell = (plot.site().width_m / w as f64) as f32;
    layer.rows_mut().for_each(|row| row.fill(0.0));
    for c in plot.colonies() {
        control.check()?;
        let reach = |v: f32, n: usize| {
            let at = |v: f32| (v / cell).floor().clamp(0.0, n as f32 - 1.0) as usize;
            at(v - c.radius)..=at(v + c.radius)
        };
        if 2.0 * c.radius < cell {
            // Smaller than a cell: where its centre is.
            let (x, y) = (reach(c.x, w), reach(c.y, h));
            let (x, y) = (*x.start(), *y.start());
            layer.set(x, y, (layer.get(x, y) + c.area_m2() / (cell * cell)).min(1.0));
            continue;
        }
        for y in reach(c.y, h) {
            for x in reach(c.x, w) {
                const PARTS: usize = 4;
                let part = |i: usize, k: usize| (i as f32 + (k as f32 + 0.5) / PARTS as f32) * cell;
                let inside = (0..PARTS * PARTS)
                    .filter(|k| (part(x, k % PARTS) - c.x).hypot(part(y, k / PARTS) - c.y) < c.radius)
                    .count();
                let share = inside as f32 / (PARTS * PARTS) as f32;
                layer.set(x, y, (layer.get(x, y) + share).min(1.0));
            }
        }
    }
    Ok(())
}
