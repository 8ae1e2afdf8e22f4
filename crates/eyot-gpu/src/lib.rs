//! The GPU engine of Eyot.
//!
//! Nothing here decides what a rule does: rules come from the core as expression graphs, which [`shaders`] prints as WGSL.
//!
//! A device is opened with [`Gpu::open`], or belongs to somebody else, whose guest the engine is: [`Gpu::from_parts`]. Opening and reading
//! back are futures; [`blocking`] has the same for threads that may wait. Of the public signatures only those of the
//! [device as wgpu knows it](Gpu#impl-Gpu-1) name wgpu's types. Drawing is in the crate `eyot-view`.

mod adapter;
mod arena;
mod bandwidth;
#[cfg(not(target_arch = "wasm32"))]
pub mod blocking;
mod cache;
mod clock;
mod device;
mod engine;
mod error;
mod group;
mod guest;
mod health;
mod layer_view;
mod reading;
mod reduce;
mod shader;
pub mod shaders;
mod stepped;

pub use wgpu;

pub use adapter::{AdapterKind, AdapterReport, Choice, adapters};
pub use arena::Pending;
pub use bandwidth::copy_bandwidth;
pub use device::Gpu;
pub use engine::{GpuEngine, Options, Work};
pub use error::{GpuError, Result};
pub use layer_view::{LayerPart, LayerView};
pub use reading::Reading;
pub use reduce::Range;
