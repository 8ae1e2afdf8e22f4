//! Pictures of Eyot worlds, made on the CPU: perspective views, reliefs from above and maps of layers.
//!
//! - [`perspective`] looks at the world from a camera: islands in an open sea, everything else as a relief model.
//! - [`relief`] draws it from above as a map maker would.
//! - [`layer_map`] maps one layer with a legend.
//! - [`mesh_view`] draws triangle meshes, such as corals.
//! - [`Cover`] says what the ground is, for colours, masks and materials; [`terrain_colours`] gives the colours that all pictures use, for
//!   meshes too.
//!
//! ```
//! use eyot_core::{Field, Grid, Limits, Boundary, World, layer::known};
//! use eyot_render::{MapOptions, ReliefOptions, ViewOptions, layer_map, perspective, relief};
//!
//! let mut world = World::new(Grid::new(48, 48, 20.0, Boundary::CLOSED, &Limits::default())?, 7);
//! let cone = |x: usize, y: usize| 200.0 - 12.0 * (x as f32 - 24.0).hypot(y as f32 - 24.0);
//! world.put(&known::HEIGHT, Field::from_fn(48, 48, cone))?;
//!
//! let view = perspective(&world, &ViewOptions { width: 160, height: 90, azimuth_deg: 220.0, ..Default::default() })?;
//! assert_eq!(view.bytes().len(), 3 * 160 * 90);
//! let map = relief(&world, &ReliefOptions { min_size: 48, ..Default::default() })?;
//! assert_eq!((map.width, map.height), (48, 48));
//! layer_map(&world, "height", &MapOptions::default())?;
//! # Ok::<(), eyot_core::Error>(())
//! ```
//!
//! # How a view is made
//! The cells are refined by a cubic kernel until a node is about a pixel wide (`surface.rs`). Light that
//! does not depend on the camera is computed once per node: the sun's disc over the horizon and the open share of the
//! sky (`light.rs`). A ray then finds the surface through a pyramid of maxima and reads colour, slope and light between
//! nodes. Pixels with edges take more rays. Every pixel is a pure function of world, options and its place, so the bytes
//! do not depend on the number of threads.

mod arrows;
mod block;
mod camera;
mod climate;
mod colour_map;
pub mod cover;
mod cut;
mod drawing;
mod framing;
mod ground;
mod hillshade;
mod legend;
mod light;
mod map;
mod math;
mod memory;
mod mesh_view;
mod path;
mod perspective;
mod picture;
mod raster;
mod relief;
mod resample;
mod scene;
mod sea;
mod sheet;
mod sky;
mod stage;
mod streams;
mod surface;
mod text;
mod view;
mod water;

pub use block::{BLOCK_COLOURS, BlockColours};
pub use camera::Camera;
pub use colour_map::ColourMap;
pub use cover::{Class, Cover, Looks, Palette, Season, terrain_colours};
pub use drawing::{Anchor, Drawing, Ink, Place, Shape, Stroke};
pub use ground::water_cover;
pub use light::PENUMBRA_DEG;
pub use map::{ColourTable, LayerColours, MapOptions, layer_map};
pub use memory::{layer_map_bytes, mesh_view_bytes, perspective_bytes, relief_bytes, terrain_colours_bytes};
pub use mesh_view::{Haze, MeshPart, MeshViewOptions, mesh_view};
pub use path::{CameraPath, Key, Pose};
pub use perspective::{perspective, perspective_controlled};
pub use picture::{Picture, linear};
pub use relief::{ReliefOptions, relief, relief_controlled};
pub use scene::Scene;
pub use sheet::{SheetCell, contact_sheet};
pub use sky::Sky;
pub use stage::{Stage, colour_bytes};
pub use view::{Setting, ViewOptions};
pub use water::Water;
