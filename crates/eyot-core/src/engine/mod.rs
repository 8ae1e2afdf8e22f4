//! What carries out plans: the processor's cores, a graphics card, and the reference that both are compared with.
//!
//! Engines run plans and know no processes. Which plans these are, and when something acts between them, is decided in one place for
//! all of them, the [stepper](crate::stepper).

use crate::error::Error;
use crate::grid::Grid;
use crate::limits::Limits;
use crate::plan::Plan;
use crate::process::{Process, Scheduled, Span};
use crate::remedy::Remedy;
use crate::world::World;
use std::borrow::Cow;

mod arena;
mod cpu;
mod estimate;
mod hesitant;
mod saved;
mod sweep;

pub use cpu::{CpuEngine, CpuRunner};
pub use estimate::MemoryEstimate;
pub use hesitant::Hesitant;
pub use saved::Saved;

/// Why an engine did not do what it was asked for.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// The work itself: parameters, limits, values that are not finite, a request to stop.
    #[error(transparent)]
    Core(#[from] Error),
    /// The device that works. The world is what it was when it was last downloaded.
    #[error(transparent)]
    Device(DeviceError),
    /// The device has not done what was asked of it before, and its host must not wait. Nothing has changed: the same call goes on
    /// where this one stopped.
    #[error("the device is not done yet")]
    NotReady,
}

impl EngineError {
    /// True for a request to stop.
    pub const fn is_cancelled(&self) -> bool {
        matches!(self, Self::Core(Error::Cancelled(_)))
    }
}

/// What a device says that cannot go on.
#[derive(Debug, thiserror::Error)]
#[error("{sentence}")]
pub struct DeviceError {
    /// The device is gone, though the world may be continued on another.
    pub lost: bool,
    /// What was asked for cannot be: there is no such device, or not enough of its memory.
    pub refused: bool,
    /// What happened, and what to do.
    pub sentence: Remedy,
    /// The engine's own error.
    pub source: Box<dyn std::error::Error + Send + Sync>,
}

impl From<DeviceError> for Remedy {
    fn from(e: DeviceError) -> Self {
        e.sentence
    }
}

/// What the stepper knows about a plan and what lies behind it.
#[derive(Clone, Copy)]
pub struct Ahead<'a> {
    /// The processes of the simulation.
    pub processes: &'a [Scheduled],
    /// From the step in which the plan begins on.
    pub span: Span,
    /// Steps that are complete with the plan; 0 if it is a part of a step.
    pub completes: u64,
    /// Something acts in the step of which the plan is a part, and nothing is kept to go back to.
    pub within_step: bool,
}

/// Names of the layers that somebody borrows.
#[derive(Clone, Debug, Default)]
pub struct Borrowed {
    /// Those that must be up to date.
    pub reads: Vec<Cow<'static, str>>,
    /// Those that are something else afterwards.
    pub writes: Vec<Cow<'static, str>>,
}

impl Borrowed {
    /// What a process borrows for its action.
    pub fn by(process: &dyn Process) -> Self {
        Self { reads: process.reads(), writes: process.writes() }
    }

    /// What a layer is borrowed for, if it is.
    pub fn is_borrowed(&self, name: &str) -> bool {
        self.is_read(name) || self.is_written(name)
    }

    /// Whether a layer must be up to date.
    pub fn is_read(&self, name: &str) -> bool {
        self.reads.iter().any(|n| n == name)
    }

    /// Whether a layer is something else afterwards.
    pub fn is_written(&self, name: &str) -> bool {
        self.writes.iter().any(|n| n == name)
    }
}

/// Carries out plans on a world.
///
/// Between [`Engine::begin`] and [`Engine::end`] the engine has the world's layers and its ledger. It may keep them beyond that, and
/// then the world's own are out of date until [`Engine::download`]; until [`Engine::release`] nobody else may change them.
///
/// Where nobody may wait for the device, such as in a browser, [`Engine::run`], [`Engine::lend`], [`Engine::save`], [`Engine::wait`],
/// [`Engine::end`] and [`Engine::download`] say [`EngineError::NotReady`] instead, before they have changed anything, until the same
/// call can be answered.
pub trait Engine {
    /// What is at work, for people.
    fn name(&self) -> String;

    /// What the bytes of a result depend on.
    fn kind(&self) -> String {
        self.name()
    }

    /// Bounds on what may be allocated.
    fn limits(&self) -> Limits;

    /// Spans that end at multiples of so many steps give the same bytes wherever they end.
    fn block(&self, _grid: &Grid) -> u64 {
        1
    }

    /// Takes the world's layers. The steps that lie ahead say what there must be room for.
    ///
    /// # Errors
    /// If memory would exceed the limits or the device fails; then the world is as it was.
    fn begin(&mut self, world: &mut World, ahead: &Ahead<'_>) -> Result<(), EngineError>;

    /// The step after the last one that one plan may hold which begins at the step `at`.
    fn plan_end(&self, ahead: &Ahead<'_>, at: u64) -> u64;

    /// Runs a plan, or queues it.
    ///
    /// # Errors
    /// If memory would exceed the limits or a pass names a layer that is not there: then nothing has changed. If the device fails.
    fn run(&mut self, world: &mut World, plan: &Plan, ahead: &Ahead<'_>) -> Result<(), EngineError>;

    /// Lends the world its layers and its ledger while `work` is done on it.
    ///
    /// # Errors
    /// What `work` says, and if the device fails.
    fn lend(
        &mut self,
        world: &mut World,
        borrowed: &Borrowed,
        work: &mut dyn FnMut(&mut World) -> crate::Result<()>,
    ) -> Result<(), EngineError>;

    /// Keeps what a step may change: layers by their names, the ledger and what else the world holds.
    ///
    /// # Errors
    /// If memory would exceed the limits or the device fails.
    fn save(&mut self, world: &mut World, writes: &[Cow<'static, str>]) -> Result<Saved, EngineError>;

    /// Takes back everything since `saved`.
    fn restore(&mut self, world: &mut World, saved: Saved);

    /// Steps that are complete since [`Engine::begin`]; one that queues is behind what it was given.
    fn completed(&self) -> u64;

    /// Waits until what was queued is done.
    ///
    /// # Errors
    /// If the device fails.
    fn wait(&mut self) -> Result<(), EngineError>;

    /// Ends a span of steps, and finds values that are not finite.
    ///
    /// # Errors
    /// If there are such values, or the device fails.
    fn end(&mut self, world: &mut World) -> Result<(), EngineError>;

    /// Brings the world's layers and its ledger up to date.
    ///
    /// # Errors
    /// If values are not finite, or the device fails: the world is then what it was when it was last downloaded.
    fn download(&mut self, world: &mut World) -> Result<(), EngineError>;

    /// Forgets the world, which somebody else will change. What was not downloaded is lost.
    fn release(&mut self);

    /// Makes the world what it was when it was last downloaded, and forgets it. Only after an error that is no request to stop.
    fn fall_back(&mut self, world: &mut World);

    /// Runs the passes of a plan once on a world that it has not begun with, outside of any step: first values of layers.
    ///
    /// # Errors
    /// If memory would exceed the limits or a pass names a layer that is not there; then nothing has changed.
    fn apply(&mut self, world: &mut World, plan: &Plan) -> Result<(), EngineError>;
}
