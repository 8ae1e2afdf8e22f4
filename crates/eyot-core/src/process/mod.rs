//! What generators and processes are to the rest of the program: parameters with a schema, and something to run.

use crate::component::Shape;
use crate::control::Control;
use crate::domain::Domain;
use crate::error::Result;
use crate::grid::Grid;
use crate::layer::LayerSpec;
use crate::plan::Plan;
use crate::world::{World, check_clock};
use std::borrow::Cow;

mod entry;
mod generator;
mod partial;

pub use entry::{Entry, Parameters, check_ranges, defaults_of, parameters_from, schema_of};
pub use generator::{Around, Generator, Reach, Site};
pub use partial::{LIKE, are_named, over};

/// Seconds of a year, the Julian one.
pub const SECONDS_PER_YEAR: f64 = 365.25 * 86_400.0;

/// The moment for which a process plans a step.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// The whole grid, also where the world is a window of it.
    pub grid: Grid,
    /// The part of it that the world holds.
    pub domain: Domain,
    /// Steps that the world has done; keys the random numbers.
    pub step: u64,
    /// How often this process has run before in this simulation.
    pub turn: u64,
    /// Level of the sea, m.
    pub sea_level_m: f64,
}

impl Moment {
    /// That of a world, which begins a simulation.
    pub fn of(world: &World) -> Self {
        let domain = world.domain();
        Self { grid: *domain.global(), domain, step: world.step, turn: 0, sea_level_m: world.sea_level_m }
    }

    /// The step `step` on the whole of a grid.
    pub fn whole(grid: Grid, step: u64, sea_level_m: f64) -> Self {
        Self { grid, domain: Domain::whole(grid), step, turn: 0, sea_level_m }
    }
}

/// What a process does with a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Access {
    /// Looks at it and leaves it as it is.
    Read,
    /// Gives each cell a new value without a look at the old ones.
    Write,
    /// Looks at it and changes it.
    Change,
}

/// A layer that a process works with.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerUse {
    /// What it is.
    pub spec: LayerSpec,
    /// The value that a missing one starts from.
    pub start: f32,
    /// What the process does with it.
    pub access: Access,
}

impl LayerSpec {
    /// A process looks at the layer, which starts from `start` if it is missing.
    pub const fn read(self, start: f32) -> LayerUse {
        LayerUse { spec: self, start, access: Access::Read }
    }

    /// As [`LayerSpec::read`] of a process that gives each cell a new value without a look at the old ones.
    pub const fn written(self, start: f32) -> LayerUse {
        LayerUse { spec: self, start, access: Access::Write }
    }

    /// As [`LayerSpec::read`] of a process that looks at the layer and changes it.
    pub const fn changed(self, start: f32) -> LayerUse {
        LayerUse { spec: self, start, access: Access::Change }
    }
}

/// A named set of rules, or an action, with one parameter struct and a stability bound.
///
/// A process is parameters and never changes; what it keeps between its steps is in the world, or, where that can be made anew from
/// the world, in an [`ActionInstance`].
pub trait Process: Send + Sync {
    /// Layers that the process reads or writes and makes if they are missing.
    fn layers(&self) -> Vec<LayerUse>;

    /// Adds passes that give the layer `name` of [`Process::layers`] its first values, where a constant will not do. They may
    /// read what is there before this process and the layers that it lists before this one.
    fn start(&self, _name: &str, _moment: &Moment, _plan: &mut Plan) {}

    /// Whether it makes land where there is none, so that nothing before it needs to.
    fn makes_ground(&self) -> bool {
        false
    }

    /// Layers that it reads and cannot make itself: something before it has to.
    fn needs(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// Names of all layers whose values its steps depend on. Those that it looks at only if they are there are among them.
    fn reads(&self) -> Vec<Cow<'static, str>> {
        let own = self.layers().into_iter().filter(|l| l.access != Access::Write).map(|l| l.spec.name);
        own.chain(self.needs().into_iter().map(Cow::Borrowed)).collect()
    }

    /// Names of all layers that its steps change.
    fn writes(&self) -> Vec<Cow<'static, str>> {
        self.layers().into_iter().filter(|l| l.access != Access::Read).map(|l| l.spec.name).collect()
    }

    /// What can be shown of the components that it keeps, by its full name in [`Components::views`](crate::Components::views).
    fn views(&self) -> Vec<(&'static str, Shape)> {
        Vec::new()
    }

    /// Finds parameters that cannot work together or on this grid, before anything runs.
    ///
    /// # Errors
    /// The first such parameter, by name.
    fn check(&self, _grid: &Grid) -> Result<()> {
        Ok(())
    }

    /// Makes layers that need more than a constant start value; called before the first step of each span, after the layers of
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

/// How far work that is not rules of cells looks, and so on which part of a grid it can be done.
///
/// On a window of a grid it is given the halo's cells too. It changes those like the others, if it can, and the ledger by what
/// happened inside the window alone ([`Domain::inside_columns`], [`Domain::inside_rows`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Locality {
    /// A cell depends on nothing but its place and what was there.
    Cell,
    /// Also on this many rows and columns to all sides, by which the halo of a window is spent.
    Rows(usize),
    /// On everything, or on what the world keeps beside its layers: only the whole grid will do.
    Whole,
}

/// Work that rules of cells cannot do: drainage, rivers, plates. Says what is to be known before it begins.
pub trait Action: Send + Sync {
    /// Makes what acts in the steps of a simulation of this world, which has been prepared. It must act the same whenever it is made:
    /// after a resume and when a step was taken back it is made anew.
    ///
    /// # Errors
    /// If a parameter cannot work on this world, or what the world keeps for it is damaged.
    fn instantiate(&self, world: &World) -> Result<Box<dyn ActionInstance>>;

    /// True if this neither fails nor looks for requests to stop on a world that [`Process::prepare`] accepted. Engines then keep
    /// no copy of the world to go back to, which takes longer than quick actions do.
    fn cannot_fail(&self) -> bool {
        false
    }

    /// How far it looks.
    fn locality(&self) -> Locality;

    /// The most that it holds for each cell while it acts, beside the world's layers, bytes. Runs are refused by this number
    /// before they begin, so it is measured and not guessed (`eyot-land/tests/memory.rs`).
    fn bytes_per_cell(&self) -> usize;
}

/// An action in a simulation, which lives as long as that does.
pub trait ActionInstance: Send {
    /// Changes the layers that [`Process::writes`] names, and writes what entered, left or was clamped to the ledger. Of the other
    /// layers those are up to date that [`Process::reads`] names. The result must not depend on the number of threads.
    ///
    /// # Errors
    /// If a parameter cannot work on this world, or on a request to stop, which long work must look for. The stepper then
    /// takes the whole step back.
    fn act(&mut self, moment: &Moment, world: &mut World, control: &Control<'_>) -> Result<()>;
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

/// What a moment becomes in a span of steps, without doing any of them.
///
/// # Errors
/// As [`check_clock`], for the first step after which it is beyond its bounds.
pub fn clock_after(processes: &[Scheduled], mut moment: Moment, span: Span) -> Result<Moment> {
    for step in span.from..span.from + span.steps {
        for s in processes.iter().filter(|s| s.is_due(step)) {
            moment.turn = step / s.every.max(1);
            s.process.advance(&mut moment);
        }
        moment.step += 1;
        check_clock(moment.step, moment.sea_level_m)?;
    }
    Ok(moment)
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

/// Layers that may have been changed in a step when something fails in it: those of the last process that can, and of all before it.
/// Whoever takes the step back needs no more of them.
pub(crate) fn changed_by_failure<'a>(processes: impl Iterator<Item = &'a Scheduled>) -> Vec<Cow<'static, str>> {
    let processes: Vec<_> = processes.collect();
    let fails = |s: &&Scheduled| s.process.action().is_some_and(|a| !a.cannot_fail());
    let count = processes.iter().rposition(fails).map_or(0, |last| last + 1);
    let mut names: Vec<_> = processes[..count].iter().flat_map(|s| s.process.writes()).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Span of steps to run.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Steps of this simulation that are done already (after a resume); the schedule counts from 0.
    pub from: u64,
    /// Steps to do now.
    pub steps: u64,
}
