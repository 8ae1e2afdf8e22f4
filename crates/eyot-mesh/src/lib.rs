//! Meshes of Eyot: terrains from height fields, bodies from scalar fields, and coarser levels of both.
//!
//! Bodies ([`mesh_field`]) are closed surfaces where a [`ScalarField`] is 0; read the head of `solid/mod.rs` first.
//!
//! A terrain's mesh is made in metres with x to the east, y up and z to the south, its origin in the middle of the grid at
//! height 0. That is the convention of glTF, so exporters write the arrays as they are.
//!
//! ```
//! use eyot_core::{Field, Grid, Limits, Boundary};
//! use eyot_mesh::{MeshOptions, levels_of_detail, terrain};
//!
//! # fn main() -> Result<(), eyot_mesh::Error> {
//! let limits = Limits::default();
//! let grid = Grid::new(65, 65, 10.0, Boundary::CLOSED, &limits)?;
//! let height = Field::from_fn(65, 65, |x, y| 20.0 * (x as f32 * 0.2).sin() + y as f32);
//! let green = vec![[0.1, 0.5, 0.1]; grid.cells()];
//! let full = terrain(&height, &grid, &green, &MeshOptions::default(), &limits)?;
//! assert_eq!((full.stride, full.mesh.triangles()), (1, 2 * 64 * 64));
//! let levels = levels_of_detail(&full, &[0.25, 0.125]);
//! assert!(levels[2].mesh.triangles() < levels[1].mesh.triangles());
//! # Ok(())
//! # }
//! ```
//!
//! [`Tiling`] cuts a grid into tiles whose rims fit, and makes their skirts and the surface of their water.
//!
//! Coarser levels need the feature `simplify`, which is on by default. Without it [`levels_of_detail`] gives the full mesh
//! alone and [`solid_levels`] nothing: [`SIMPLIFIES`] says which build this is.
//!
//! This crate opens no file; `eyot-io` writes meshes.

mod error;
mod lod;
mod primitive;
mod simplifier;
mod solid;
mod terrain;
mod tiles;
mod water;

pub use error::{Error, Result};
pub use lod::{Lod, Rim, levels_of_detail, levels_of_detail_controlled};
/// True if this build can make coarser levels of detail (feature `simplify`).
pub const SIMPLIFIES: bool = cfg!(feature = "simplify");

pub use primitive::{Point, Primitive};
pub use solid::{
    Blend, Blobs, Kernel, Lattice, MeshingOptions, Quality, Remesher, ScalarField, Solid, SolidLod, Topology, Update,
    Volume, Within, mesh_field, solid_levels,
};
pub use terrain::{Attribute, MeshOptions, Terrain, TerrainMesh, terrain, terrain_bytes};
pub use tiles::{Tiling, rim_error};
pub use water::OpenWater;
