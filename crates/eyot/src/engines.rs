//! Which engine carries out a run's plans: the processor, or a graphics card.

use crate::backend::io;
use crate::error::RunError;
use eyot_core::engine::{CpuEngine, CpuRunner, Engine as _};
use eyot_core::isa::Isa;
use eyot_core::process::Span;
use eyot_core::remedy;
use eyot_core::remedy::Remedy;
use eyot_core::stepper::Simulation;
use eyot_core::{Control, Error, Grid, Limits, World};
use eyot_gpu::{Choice, Gpu, GpuEngine, GpuError, Options, blocking};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::PathBuf;

/// Which engine a run wants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EngineChoice {
    /// A graphics card if there is one that can do it, else the processor.
    Auto,
    /// The processor: the same bytes on every machine.
    #[default]
    Cpu,
    /// A graphics card or its software stand-in: the same within rounding.
    Gpu,
}

/// How to find an engine.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EngineOptions {
    /// Which one.
    pub choice: EngineChoice,
    /// A part of the graphics adapter's name; the best one if not given.
    pub adapter: Option<String>,
    /// For tests: after so many steps the graphics device is taken away.
    #[doc(hidden)]
    #[serde(skip)]
    pub lose_device_after: Option<u64>,
}

impl EngineOptions {
    /// The adapter that these options mean.
    pub fn adapter(&self) -> Choice {
        match (&self.adapter, self.choice) {
            (Some(name), _) => Choice::Named(name.clone()),
            (None, EngineChoice::Auto) => Choice::Hardware,
            (None, _) => Choice::Best,
        }
    }
}

/// Carries out plans.
pub(crate) enum Engine {
    Cpu(CpuRunner),
    Gpu(Box<GpuEngine>),
}

/// Why steps were not done.
pub(crate) enum Failure {
    /// The work itself; or a request to stop.
    Work(Error),
    /// The device. The world is what it was when it was last brought back.
    Device(GpuError),
}

impl From<GpuError> for Failure {
    fn from(e: GpuError) -> Self {
        match e {
            GpuError::Core(e) => Self::Work(e),
            e => Self::Device(e),
        }
    }
}

impl Engine {
    /// The processor.
    pub(crate) fn cpu(limits: Limits) -> Self {
        Self::Cpu(CpuEngine { limits, ..CpuEngine::default() }.runner())
    }

    /// The engine that the options ask for, and what to say if it is not the one that was wanted first.
    pub(crate) fn open(options: &EngineOptions, limits: Limits) -> Result<(Self, Option<Remedy>), RunError> {
        if options.choice == EngineChoice::Cpu {
            return Ok((Self::cpu(limits), None));
        }
        // The card's own time stands in the run's report.
        match card(options, Options::default().limits(limits).timed(true)) {
            Ok(engine) => Ok((Self::Gpu(Box::new(engine)), None)),
            Err(e) if options.choice == EngineChoice::Auto => {
                Ok((Self::cpu(limits), Some(remedy![e, "; the processor works instead"])))
            }
            Err(e) => Err(RunError::Gpu(e)),
        }
    }

    /// What is at work, for people.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Cpu(e) => e.name(),
            Self::Gpu(e) => e.name(),
        }
    }

    /// What the bytes of a result depend on: the processor gives the same with all its instruction sets.
    pub(crate) fn kind(&self) -> String {
        match self {
            Self::Cpu(e) => e.kind(),
            Self::Gpu(e) => e.kind(),
        }
    }

    /// Spans that end at multiples of so many steps give the same bytes wherever they end.
    pub(crate) fn block(&self, grid: &Grid) -> u64 {
        match self {
            Self::Cpu(_) => 1,
            Self::Gpu(e) => e.block(grid),
        }
    }

    /// See [`Simulation::advance`]. On a graphics card layers and ledger of the world are out of date afterwards.
    pub(crate) fn simulate(
        &mut self,
        world: &mut World,
        simulation: &mut Simulation,
        span: Span,
        control: &Control<'_>,
    ) -> Result<(), Failure> {
        match self {
            Self::Cpu(e) => simulation.advance(e, world, span, control),
            Self::Gpu(e) => simulation.advance(&mut **e, world, span, control),
        }
        .map_err(|e| Failure::from(GpuError::from(e)))
    }

    /// Brings the world's layers and its ledger up to date.
    pub(crate) fn download(&mut self, world: &mut World) -> Result<(), Failure> {
        match self {
            Self::Cpu(_) => Ok(()),
            Self::Gpu(e) => e.download(world).map_err(Failure::from),
        }
    }

    /// Forgets the world, which somebody else will change.
    pub(crate) fn release(&mut self) {
        if let Self::Gpu(e) = self {
            e.release();
        }
    }

    /// For tests: takes the device away.
    pub(crate) fn lose_device(&mut self) {
        if let Self::Gpu(e) = self {
            e.gpu().destroy();
        }
    }

    /// Keeps compiled pipelines for the next run.
    pub(crate) fn keep_pipelines(&self) {
        if let Self::Gpu(e) = self {
            keep_pipelines(e);
        }
    }

    /// The graphics card's own time so far, s.
    pub(crate) fn card_seconds(&self) -> f64 {
        match self {
            Self::Cpu(_) => 0.0,
            Self::Gpu(e) => e.work().card_s,
        }
    }
}

/// A graphics card, with the pipelines that earlier processes compiled.
///
/// # Errors
/// If there is no such adapter, or it cannot run the engine.
pub fn card(options: &EngineOptions, how: Options) -> Result<GpuEngine, GpuError> {
    let gpu = blocking::open(&options.adapter())?;
    let cache = cache_file(&gpu).and_then(|path| std::fs::read(path).ok());
    GpuEngine::new(gpu, how, cache.as_deref())
}

/// Keeps compiled pipelines for the next process. Only a convenience: what cannot be kept is compiled again.
pub fn keep_pipelines(e: &GpuEngine) {
    let (Some(path), Some(data)) = (cache_file(e.gpu()), e.cache_data()) else { return };
    if std::fs::metadata(&path).is_ok_and(|m| m.len() == data.len() as u64) {
        return;
    }
    let Some(folder) = path.parent() else { return };
    if std::fs::create_dir_all(folder).is_ok() {
        let fail = |source| io::Error::Io { path: path.clone(), action: "write", source };
        // Nobody misses it but the next run's first second.
        let _ = io::write_atomically(&path, |w| w.write_all(&data).map_err(fail));
    }
}

/// Instruction set of the CPU engine.
pub fn isa() -> Isa {
    CpuEngine::default().isa
}

/// Where compiled pipelines of an adapter lie; a driver's cache is of no use to another one.
fn cache_file(gpu: &Gpu) -> Option<PathBuf> {
    let from = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let folder = from("XDG_CACHE_HOME")
        .or_else(|| from("LOCALAPPDATA"))
        .or_else(|| from("HOME").map(|home| home.join(".cache")))?;
    let info = &gpu.report;
    let name: String = format!("{}-{}-{:x}-{:x}", info.driver, info.driver_info, info.vendor, info.device)
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' })
        .collect();
    Some(folder.join("eyot").join(format!("pipelines-{name}.bin")))
}
