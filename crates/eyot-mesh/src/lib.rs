//! Terrain meshes of Eyot: triangles from a height field, and coarser levels of the same terrain.
//!
//! The mesh is made in metres with x to the east, y up and z to the south, its origin in the middle of the grid at
//! height 0. That is the convention of glTF, so exporters write the arrays as they are.
//!
//! This crate opens no file; `eyot-io` writes meshes.

mod error;
mod lod;
mod terrain;

pub use error::{Error, Result};
pub use lod::{Lod, levels_of_detail};
pub use terrain::{MeshOptions, Terrain, TerrainMesh, terrain};
