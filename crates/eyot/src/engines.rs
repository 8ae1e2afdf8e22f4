//! Engines of this program: the processor, and with the feature `gpu` graphics cards.

use eyot_core::engine::CpuEngine;

#[cfg(feature = "gpu")]
pub use crate::card::{Engines, adapter, card, keep_pipelines, on_card, polled};
pub use eyot_core::isa::Isa;
#[cfg(feature = "gpu")]
pub use eyot_gpu::{Choice, Gpu, GpuEngine, GpuError, Options, blocking, wgpu};
#[cfg(not(feature = "gpu"))]
pub use eyot_session::Processor as Engines;

/// Instruction set of the CPU engine.
pub fn isa() -> Isa {
    CpuEngine::default().isa
}
