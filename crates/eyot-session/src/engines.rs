//! What carries out the plans of a session: which engine is wanted, and how the host opens it.

use eyot_core::Limits;
use eyot_core::engine::{CpuEngine, CpuRunner, DeviceError, Engine};
use eyot_core::remedy::Remedy;
use serde::{Deserialize, Serialize};
use std::any::Any;

/// Which engine a run wants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
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

/// An engine that a host has opened, with what a session asks of it beside the steps.
pub trait OpenEngine: Send {
    /// The engine.
    fn engine(&self) -> &dyn Engine;

    /// The engine, to be worked with.
    fn engine_mut(&mut self) -> &mut dyn Engine;

    /// A device's own time so far, s; 0 for the processor.
    fn device_seconds(&self) -> f64 {
        0.0
    }

    /// The session has come to an end, or waits for one: what was compiled may be kept for the next.
    fn keep(&self) {}

    /// Itself, for hosts that know of which type it is, such as a window that draws what lies on the card.
    fn as_any(&self) -> Option<&dyn Any> {
        None
    }

    /// For tests: takes the device away.
    #[doc(hidden)]
    fn lose_device(&mut self) {}
}

/// An engine, and what to say if it is not the one that was wanted first.
pub struct Opened {
    /// The engine.
    pub engine: Box<dyn OpenEngine>,
    /// One sentence.
    pub warning: Option<Remedy>,
}

impl Opened {
    /// The processor.
    pub fn processor(limits: Limits, warning: Option<Remedy>) -> Self {
        Self { engine: processor(limits), warning }
    }
}

/// Opens engines; a closure can do so, too.
pub trait Engines: Send + Sync {
    /// The engine that the options ask for.
    ///
    /// # Errors
    /// If there is none such, or it cannot be used.
    fn open(&self, options: &EngineOptions, limits: Limits) -> Result<Opened, DeviceError>;
}

impl<F> Engines for F
where
    F: Fn(&EngineOptions, Limits) -> Result<Opened, DeviceError> + Send + Sync,
{
    fn open(&self, options: &EngineOptions, limits: Limits) -> Result<Opened, DeviceError> {
        self(options, limits)
    }
}

/// The processor alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct Processor;

impl Engines for Processor {
    fn open(&self, options: &EngineOptions, limits: Limits) -> Result<Opened, DeviceError> {
        if options.choice == EngineChoice::Gpu {
            let reason = "this program works with the processor alone";
            return Err(DeviceError { lost: false, refused: true, sentence: reason.into(), source: reason.into() });
        }
        Ok(Opened::processor(limits, None))
    }
}

struct Cpu(CpuRunner);

impl OpenEngine for Cpu {
    fn engine(&self) -> &dyn Engine {
        &self.0
    }

    fn engine_mut(&mut self) -> &mut dyn Engine {
        &mut self.0
    }
}

/// The processor as an engine.
pub(crate) fn processor(limits: Limits) -> Box<dyn OpenEngine> {
    Box::new(Cpu(CpuEngine { limits, ..CpuEngine::default() }.runner()))
}
