//! Bodies: closed surfaces of scalar fields.
//!
//! A [`ScalarField`] is sampled on a [`Lattice`], block by block where it may have a surface (`block.rs`); cells are filled with
//! triangles from a table that fits together on all faces (`cubes.rs`); vertices spread out over the surface (`relax.rs`).
//! [`Blobs`] are fields of balls, rounded cylinders and cones, [`Volume`] is one of given numbers.

mod blobs;
mod block;
mod cubes;
mod field;
mod kernel;
mod lattice;
mod mesher;
mod relax;
mod simplify;
mod solid_mesh;
mod topology;
mod vector;
mod volume;

pub use blobs::{Blend, Blobs};
pub use field::{ScalarField, Within};
pub use kernel::Kernel;
pub use lattice::Lattice;
pub use mesher::{MeshingOptions, Remesher, Update, mesh_field};
pub use simplify::{SolidLod, solid_levels};
pub use solid_mesh::Solid;
pub use topology::{Quality, Topology};
pub use volume::Volume;
