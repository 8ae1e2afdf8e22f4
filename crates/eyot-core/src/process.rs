//! What generators and processes are to the rest of the program: parameters with a schema, and something to run.

use crate::control::Control;
use crate::engine::CpuEngine;
use crate::error::{Error, Result};
use crate::field::Field;
use crate::grid::{Edge, Grid};
use crate::layer::LayerSpec;
use crate::limits::Limits;
use crate::plan::Plan;
use crate::world::World;
use schemars::{JsonSchema, Schema};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::ops::Range;

/// Seconds of a year, the Julian one.
pub const SECONDS_PER_YEAR: f64 = 365.25 * 86_400.0;

/// The moment for which a process plans a step.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// The grid.
    pub grid: Grid,
    /// Steps that the world has done; keys the random numbers.
    pub step: u64,
    /// How often this process has run before in this simulation.
    pub turn: u64,
    /// Level of the sea, m.
    pub sea_level_m: f64,
}

/// A named set of rules, or an action, with one parameter struct and a stability bound.
pub trait Process: Send + Sync {
    /// Layers that the process reads or writes, with the value that a missing one starts from.
    fn layers(&self) -> Vec<(LayerSpec, f32)>;

    /// Adds passes that give the layer `name` of [`Process::layers`] its first values, where a constant will not do. They may
    /// read what is there before this process and the layers that it lists before this one.
    fn start(&self, _name: &str, _moment: &Moment, _plan: &mut Plan) {}

    /// Layers that it reads and cannot make itself: something before it has to.
    fn needs(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// Finds parameters that cannot work together or on this grid, before anything runs.
    ///
    /// # Errors
    /// The first such parameter, by name.
    fn check(&self, _grid: &Grid) -> Result<()> {
        Ok(())
    }

    /// Makes layers that need more than a constant start value; called once before the first step, after the layers of
    /// [`Process::layers`] exist. Must change nothing on a world that has been prepared before.
    ///
    /// # Errors
    /// If a parameter cannot work on this world; the error names it.
    fn prepare(&self, _world: &mut World) -> Result<()> {
        Ok(())
    }

    /// Adds the passes of one step to the plan, sub-stepped to the process's stability bound.
    fn plan(&self, _moment: &Moment, _plan: &mut Plan) {}

    /// Work of a step that is not rules of cells; done after the passes that [`Process::plan`] adds.
    fn action(&self) -> Option<&dyn Action> {
        None
    }

    /// Time that passes in a step, s; `None` if the process has no clock of its own. What is faster than nature for the sake of
    /// whoever watches, beside others that are not, has none either.
    fn seconds_per_step(&self, _grid: &Grid) -> Option<f64> {
        None
    }

    /// Moves what is not a layer (the sea level) on by one step.
    fn advance(&self, _moment: &mut Moment) {}
}

/// Work on the whole world at once, which rules of cells cannot do: drainage, rivers, plates.
pub trait Action: Send + Sync {
    /// Changes the layers that [`Process::layers`] names, and writes what entered, left or was clamped to the ledger. The
    /// result must not depend on the number of threads.
    ///
    /// # Errors
    /// If a parameter cannot work on this world, or on a request to stop, which long work must look for. The engine then
    /// takes the whole step back.
    fn act(&self, moment: &Moment, world: &mut World, control: &Control<'_>) -> Result<()>;

    /// True if this neither fails nor looks for requests to stop on a world that [`Process::prepare`] accepted. Engines then keep
    /// no copy of the world to go back to, which takes longer than quick actions do.
    fn cannot_fail(&self) -> bool {
        false
    }

    /// The most that it holds for each cell while it acts, beside the world's layers, bytes. Runs are refused by this number
    /// before they begin, so it is measured and not guessed (`eyot-land/tests/memory.rs`).
    fn bytes_per_cell(&self) -> usize;
}

/// What a generator may look at, and which rows it is to make.
///
/// A grid may be made in windows, so that it need never be in memory as a whole. Then `rows` are the rows to make, and the
/// base and the layers of `world` hold the rows [`Reach::around`] these; the world's own grid is as high as they are.
pub struct Site<'a> {
    /// The whole grid.
    pub grid: Grid,
    /// The rows of it to make.
    pub rows: Range<usize>,
    /// Seed of this step: the recipe's seed mixed with the step's position in it.
    pub seed: u64,
    /// The world so far.
    pub world: &'a World,
    /// Cancellation and progress.
    pub control: &'a Control<'a>,
}

impl<'a> Site<'a> {
    /// All rows of the grid.
    pub const fn whole(grid: Grid, seed: u64, world: &'a World, control: &'a Control<'a>) -> Self {
        Self { grid, rows: 0..grid.height, seed, world, control }
    }
}

/// How far a generator looks, and so how a grid can be cut for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// A cell depends on nothing but its place and the cell that was there.
    Cell,
    /// Also on this many rows to the north and to the south.
    Rows(usize),
    /// On everything: the grid can only be made in one piece.
    Whole,
}

impl Reach {
    /// The rows of base and world that are needed to make `rows`. Beyond closed and open rims there are none; on a wrapping
    /// rim numbers below 0 and from the height on stand for the far side, unless all rows are needed.
    pub fn around(self, grid: &Grid, rows: &Range<usize>) -> Range<isize> {
        self.around_any(grid, &(rows.start as isize..rows.end as isize))
    }

    /// As [`Reach::around`] of rows that may themselves lie beyond a wrapping rim.
    pub fn around_any(self, grid: &Grid, rows: &Range<isize>) -> Range<isize> {
        let height = grid.height as isize;
        let n = match self {
            Self::Cell => 0,
            Self::Rows(n) => n.min(grid.height) as isize,
            Self::Whole => height,
        };
        let (from, to) = (rows.start - n, rows.end + n);
        match grid.rim.y {
            Edge::Wrap if to - from < height => from..to,
            Edge::Wrap => 0..height,
            Edge::Closed | Edge::Open => from.max(0)..to.min(height),
        }
    }
}

/// The rows of a field around a window, by their numbers in the whole grid.
#[derive(Clone, Copy)]
pub struct Around<'a> {
    field: &'a Field,
    /// Row of the grid that is row 0 of the field; may be negative on a wrapping rim.
    first: isize,
    height: usize,
}

impl<'a> Around<'a> {
    /// `field` holds the rows that a generator with this `reach` needs at this `site`.
    ///
    /// # Errors
    /// If it holds another number of rows or columns.
    pub fn new(site: &Site<'_>, reach: Reach, field: &'a Field) -> Result<Self> {
        let rows = reach.around(&site.grid, &site.rows);
        if (field.width(), field.height()) != (site.grid.width, rows.len()) {
            return Err(Error::Shape {
                what: format!("rows {rows:?} of {} cells", site.grid.width),
                expected: site.grid.width * rows.len(),
                found: field.width() * field.height(),
            });
        }
        Ok(Self { field, first: rows.start, height: site.grid.height })
    }

    /// Row `y` of the grid.
    ///
    /// # Panics
    /// If it is not one of the rows around the window.
    pub fn row(&self, y: usize) -> &'a [f32] {
        self.field.row((y as isize - self.first).rem_euclid(self.height as isize) as usize)
    }
}

/// Makes a layer from parameters and a seed, or from the layer that is there.
pub trait Generator: Send + Sync {
    /// Computes the rows `site.rows` of a new field: as many rows as that. `base` is the layer that they will be merged into;
    /// a source ignores it, a filter transforms it.
    ///
    /// # Errors
    /// If a parameter cannot work here, or on a request to stop.
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field>;

    /// Finds parameters that cannot work together or on this grid, before anything runs.
    ///
    /// # Errors
    /// The first such parameter, by name.
    fn check(&self, _grid: &Grid) -> Result<()> {
        Ok(())
    }

    /// How a grid can be cut for this generator. If not at all, it is only ever asked for all rows.
    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Whole
    }

    /// The most that it holds for each cell while it generates, the result included, bytes. Measured as
    /// [`Action::bytes_per_cell`]. Most make their result row by row and hold nothing else.
    fn bytes_per_cell(&self, _grid: &Grid) -> usize {
        size_of::<f32>()
    }

    /// Layers that it looks at beside its base.
    fn reads(&self) -> Vec<&str> {
        Vec::new()
    }

    /// True if the result replaces the base instead of being merged with it.
    fn is_filter(&self) -> bool {
        false
    }
}

/// A parameter struct that is everything there is to say about a process or generator.
///
/// Field attributes carry the schema: the doc comment is the meaning, `range(min, max)` the range,
/// `extend("unit" = "m")` the unit.
pub trait Parameters: Default + Serialize + DeserializeOwned + JsonSchema {}
impl<T: Default + Serialize + DeserializeOwned + JsonSchema> Parameters for T {}

/// One line of a registry: a name, a schema, and how to make the thing from a table of parameters.
pub struct Entry<T: ?Sized> {
    /// Name in recipes.
    pub name: &'static str,
    /// JSON Schema of the parameters, made by `schemars` from the struct.
    pub schema: fn() -> Schema,
    /// Default parameters as a table.
    pub defaults: fn() -> Value,
    /// Makes it; missing parameters take their defaults.
    pub make: fn(Value) -> Result<Box<T>, serde_json::Error>,
    /// What it does, its equations and its source, as Markdown: the head of its source file, see [`about!`](crate::about!).
    pub about: &'static str,
    /// Keys in `references.bib`.
    pub cites: &'static [&'static str],
}

/// Default values of `P` as JSON.
pub fn defaults_of<P: Parameters>() -> Value {
    serde_json::to_value(P::default()).unwrap_or_default()
}

/// JSON Schema of `P`.
pub fn schema_of<P: Parameters>() -> Schema {
    let mut schema = schemars::generate::SchemaSettings::draft2020_12()
        .with(|s| s.inline_subschemas = true)
        .into_generator()
        .into_root_schema_for::<P>();
    // Parameters that several structs share stand in a struct of their own, whose defaults need not be those of `P`.
    let defaults = defaults_of::<P>();
    for (name, property) in schema.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten() {
        if !defaults[name].is_null() {
            property["default"] = defaults[name].clone();
        }
    }
    schema
}

/// `P` from a table; what the table leaves out has the default of `P`.
///
/// Unknown keys are found here and not by `serde`, which cannot tell them where structs share parameters by `flatten`.
///
/// # Errors
/// If the table holds something else than the parameters of `P`.
pub fn parameters_from<P: Parameters>(table: Value) -> Result<P, serde_json::Error> {
    let (mut all, Value::Object(table)) = (defaults_of::<P>(), table) else {
        return P::deserialize(Value::Null);
    };
    if let Some(all) = all.as_object_mut() {
        if let Some(key) = table.keys().find(|k| !all.contains_key(*k)) {
            let known: Vec<&str> = all.keys().map(String::as_str).collect();
            return Err(serde::de::Error::custom(format!("unknown key `{key}`; there are {}", known.join(", "))));
        }
        all.extend(table);
    }
    serde_json::from_value(all)
}

/// Fails if a parameter is outside the range that its schema gives, or not a number.
///
/// Recipes are checked before they get here; this is for structs that a program filled.
///
/// # Errors
/// The first such parameter, with its range and its default.
pub fn check_ranges<P: Parameters>(owner: &str, parameters: &P) -> Result<()> {
    let schema = schema_of::<P>();
    let (values, defaults) = (serde_json::to_value(parameters).unwrap_or_default(), defaults_of::<P>());
    let Some(properties) = schema.get("properties").and_then(Value::as_object) else { return Ok(()) };
    for (field, rule) in properties {
        let (value, default) = (&values[field], &defaults[field]);
        let pairs = match (value.as_array(), default.as_array()) {
            (Some(v), Some(d)) => v.iter().zip(d).map(|(v, d)| (v, d, &rule["items"])).collect(),
            _ => vec![(value, default, rule)],
        };
        for (value, default, rule) in pairs.into_iter().filter(|(_, default, _)| default.is_number()) {
            let low = rule["minimum"].as_f64().unwrap_or(f64::MIN);
            let high = rule["maximum"].as_f64().unwrap_or(f64::MAX);
            // Not-a-numbers become null on the way. A range is written in f64, a parameter may have been rounded to f32.
            let slack = 1e-6 * low.abs().max(high.abs()).min(1.0);
            let fits = value.as_f64().is_some_and(|v| (low - slack..=high + slack).contains(&v));
            if !fits {
                return Err(Error::BadParameter {
                    owner: owner.to_owned(),
                    field: field.clone(),
                    reason: format!("{value} is outside {low}..={high}; the default is {default}"),
                });
            }
        }
    }
    Ok(())
}

impl Entry<dyn Process> {
    /// The entry of a parameter struct that is a process.
    pub const fn process<P: Parameters + Process + 'static>(
        name: &'static str,
        about: &'static str,
        cites: &'static [&'static str],
    ) -> Self {
        Self {
            name,
            schema: schema_of::<P>,
            defaults: defaults_of::<P>,
            make: |v| Ok(Box::new(parameters_from::<P>(v)?)),
            about,
            cites,
        }
    }
}

impl Entry<dyn Generator> {
    /// The entry of a parameter struct that is a generator.
    pub const fn generator<P: Parameters + Generator + 'static>(
        name: &'static str,
        about: &'static str,
        cites: &'static [&'static str],
    ) -> Self {
        Self {
            name,
            schema: schema_of::<P>,
            defaults: defaults_of::<P>,
            make: |v| Ok(Box::new(parameters_from::<P>(v)?)),
            about,
            cites,
        }
    }
}

/// A process together with how often it runs.
pub struct Scheduled {
    /// Name in recipes, for messages and the ledger.
    pub name: &'static str,
    /// The process.
    pub process: Box<dyn Process>,
    /// It runs in every `every`-th step; at least 1.
    pub every: u64,
}

impl Scheduled {
    /// True if the process runs in the `local_step`-th step of a simulation.
    pub fn is_due(&self, local_step: u64) -> bool {
        local_step.is_multiple_of(self.every.max(1))
    }

    /// Adds the passes of one step to the plan.
    pub fn plan(&self, local_step: u64, moment: &mut Moment, plan: &mut Plan) {
        plan.step = moment.step;
        moment.turn = local_step / self.every.max(1);
        self.process.plan(moment, plan);
    }
}

/// Adds one step of all processes that are due to the plan, and moves the moment on.
pub fn plan_step(processes: &[Scheduled], local_step: u64, moment: &mut Moment, plan: &mut Plan) {
    for s in processes.iter().filter(|s| s.is_due(local_step)) {
        s.plan(local_step, moment, plan);
        s.process.advance(moment);
    }
    moment.step += 1;
}

/// True if a process that is due in this step has an action.
pub fn acts(processes: &[Scheduled], local_step: u64) -> bool {
    processes.iter().any(|s| s.is_due(local_step) && s.process.action().is_some())
}

/// True if a step may have to be taken back, because something that acts in it can fail.
pub fn may_fail(processes: &[Scheduled], local_step: u64) -> bool {
    let mut due = processes.iter().filter(|s| s.is_due(local_step));
    due.any(|s| s.process.action().is_some_and(|a| !a.cannot_fail()))
}

/// What every engine does before the first step: finds what cannot work, and makes the layers that the processes need.
///
/// # Errors
/// If the world does not fit its grid or the limits, or a parameter does not fit the world.
pub fn prepare(world: &mut World, processes: &[Scheduled], limits: &Limits) -> Result<()> {
    // Engines reach rows by address, so a world that does not fit its grid must not get further than this.
    world.grid.checked(limits)?;
    for l in world.layers() {
        let (expected, found) = (world.grid.cells(), l.field.width() * l.field.height());
        if (l.field.width(), l.field.height()) != (world.grid.width, world.grid.height) {
            return Err(Error::Shape { what: format!("layer `{}`", l.spec.name), expected, found });
        }
    }
    processes.iter().try_for_each(|s| s.process.check(&world.grid))?;
    for s in processes {
        s.process.needs().into_iter().try_for_each(|name| world.layer(name).map(|_| ()))?;
        for (spec, value) in s.process.layers() {
            let missing = world.get(&spec.name).is_none();
            world.ensure(&spec, value);
            if missing {
                start(world, &*s.process, &spec.name, limits)?;
            }
        }
        s.process.prepare(world)?;
    }
    Ok(())
}

/// Gives a layer that was made just now its first values.
fn start(world: &mut World, process: &dyn Process, name: &str, limits: &Limits) -> Result<()> {
    let moment = Moment { grid: world.grid, step: world.step, turn: 0, sea_level_m: world.sea_level_m };
    let mut plan = Plan { step: world.step, ..Plan::default() };
    process.start(name, &moment, &mut plan);
    if plan.passes().is_empty() {
        return Ok(());
    }
    CpuEngine { limits: *limits, ..CpuEngine::default() }.apply(world, &plan)
}

/// Span of steps to run.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Steps of this simulation that are done already (after a resume); the schedule counts from 0.
    pub from: u64,
    /// Steps to do now.
    pub steps: u64,
}
