//! The GPU engine of Eyot and its drawing.
//!
//! Nothing here decides what a rule does: rules come from the core as expression graphs, which [`shaders`] prints as WGSL. This
//! crate is the only one that names `wgpu`.

mod arena;
mod bandwidth;
mod cache;
pub mod device;
pub mod draw;
mod engine;
mod error;
mod group;
mod reduce;
mod shader;
pub mod shaders;
mod stepped;

pub use wgpu;

pub use arena::Pending;
pub use bandwidth::copy_bandwidth;
pub use device::{AdapterReport, Choice, Gpu, adapters};
pub use engine::{GpuEngine, Options, Work};
pub use error::{GpuError, Result};
pub use reduce::Range;
