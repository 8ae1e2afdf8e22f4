//! Drawing on a GPU, without a window: the same pictures as eyot-render's rays, into any texture.
//!
//! A [`Renderer`] holds the pipelines of a device, a [`Scene`] what they read of one world. Colours, light and optics come from
//! [`eyot_render::Stage`], which the CPU renderer uses, too; the shaders follow its formulas line by line.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let world: eyot_core::World = todo!();
//! use eyot_gpu::{Choice, blocking};
//! use eyot_render::ViewOptions;
//! use eyot_view::{Renderer, Scene};
//!
//! let gpu = blocking::open(&Choice::Best)?;
//! let mut renderer = Renderer::new(&gpu)?;
//! let options = ViewOptions::default();
//! let scene = Scene::from_world(&gpu, &renderer, &world, &options)?;
//! let camera = scene.stage().camera(&options);
//! let picture = renderer.draw(&gpu, &scene, &camera, [1280, 720], 0.0)?.take(&gpu)?;
//! # Ok(())
//! # }
//! ```
//!
//! # Worlds that change
//! [`Scene::update`] takes a world's new layers. A simulation on the same card needs no copy: [`Scene::follow`] reads the engine's layers where
//! they lie, and [`Renderer::paint`] draws into any texture's view, such as a window's. Both can be guests of the window's device
//! ([`Gpu::from_parts`](eyot_gpu::Gpu::from_parts)); nothing waits.
//!
//! # How a picture is made
//! 1. Cells become **maps** (`maps.rs`): a smooth surface on nodes with coarser levels, slopes, colours, and a light map with the
//!    sun's horizon and the open share of the sky. This happens when a world changes.
//! 2. A quadtree selects **patches** of the surface (`detail.rs`), whose vertices morph between levels.
//! 3. One pass draws patches, the walls of a relief model, the sea and what stands behind, with four samples a pixel. Everything is
//!    opaque: the sea's shader looks up the bottom itself.

mod card;
mod detail;
mod flow;
mod frame;
mod levels;
mod maps;
mod renderer;
mod scene;
pub mod shaders;
mod shot;
mod shrink;
mod texture;

pub use renderer::{Canvas, Renderer};
pub use scene::Scene;
pub use shot::Shot;
