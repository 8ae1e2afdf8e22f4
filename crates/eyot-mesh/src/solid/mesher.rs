//! From a field to the surface of a body, block by block, and again when the field has changed.

use super::block::{Corner, Raw, Source, extract};
use super::field::{Point, ScalarField};
use super::lattice::{BlockId, Lattice};
use super::relax::{Net, Vertex};
use super::solid_mesh::Solid;
use super::vector::unit;
use crate::error::{Error, Result};
use eyot_core::{Error as CoreError, Limits};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// How to mesh a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshingOptions {
    /// Rounds in which vertices spread out over the surface, at most 7; 0 leaves them on the lattice's edges, where the
    /// field is interpolated linearly. From 1 on, less than one triangle in a hundred has an angle below 10 degrees.
    pub rounds: u32,
}

impl Default for MeshingOptions {
    fn default() -> Self {
        Self { rounds: 2 }
    }
}

/// More would carry a change farther than into the next block.
const MOST_ROUNDS: u32 = 7;
/// Bytes of a vertex with its share of triangles, in all arrays that are alive at once.
const BYTES_PER_VERTEX: u128 = 200;

/// Meshes where a field is 0.
///
/// The surface is closed, and a manifold, for any field: every edge has two triangles, the triangles around every vertex make one
/// fan. What reaches out of the lattice's box ends flat there. Normals are the field's gradient. The same field gives
/// the same bytes on any number of threads.
///
/// # Errors
/// If the field is no finite number somewhere, if its [`ScalarField::within`] overlooks a part of it, or if the mesh exceeds the
/// limits.
pub fn mesh_field(
    field: &dyn ScalarField,
    lattice: &Lattice,
    options: &MeshingOptions,
    limits: &Limits,
) -> Result<Solid> {
    let mut remesher = Remesher::new(*lattice, *options);
    remesher.update(field, limits)?;
    Ok(remesher.solid())
}

/// Meshes a field that changes, and only those blocks of it that did; the bytes are those of meshing all of it.
pub struct Remesher {
    lattice: Lattice,
    options: MeshingOptions,
    blocks: BTreeMap<BlockId, Arc<Block>>,
}

/// What [`Remesher::update`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Update {
    /// Blocks that were sampled and meshed.
    pub meshed: usize,
    /// Blocks that stayed as they were.
    pub kept: usize,
}

/// A block of the surface.
#[derive(Clone)]
struct Block {
    stamp: Option<u64>,
    raw: Arc<Raw>,
    vertices: Vec<Vertex>,
}

impl Remesher {
    /// A mesher that has seen nothing yet.
    pub fn new(lattice: Lattice, options: MeshingOptions) -> Self {
        let options = MeshingOptions { rounds: options.rounds.min(MOST_ROUNDS) };
        Self { lattice, options, blocks: BTreeMap::new() }
    }

    /// Meshes what differs from the last time.
    ///
    /// # Errors
    /// As [`mesh_field`]. Then everything is meshed the next time.
    pub fn update(&mut self, field: &dyn ScalarField, limits: &Limits) -> Result<Update> {
        let old = std::mem::take(&mut self.blocks);
        let lattice = self.lattice;
        let remesh = |id: BlockId| -> Option<Result<(BlockId, Arc<Block>, bool)>> {
            let source = Source::new(field, &lattice, id);
            if source.is_nothing() {
                return None;
            }
            let stamp = source.stamp();
            if let Some(block) = old.get(&id).filter(|b| stamp.is_some() && b.stamp == stamp) {
                return Some(Ok((id, block.clone(), false)));
            }
            let block = |raw| Arc::new(Block { stamp, raw: Arc::new(raw), vertices: Vec::new() });
            Some(extract(&source, &lattice, id).map(|raw| (id, block(raw), true)))
        };
        let found: Vec<(BlockId, Arc<Block>, bool)> =
            lattice.blocks().par_bridge().filter_map(remesh).collect::<Result<_>>()?;
        let vertices: u64 = found.iter().map(|b| b.1.raw.positions.len() as u64).sum();
        check_size(vertices, limits)?;

        let mut changed: BTreeSet<BlockId> = found.iter().filter(|b| b.2).map(|b| b.0).collect();
        let blocks: BTreeMap<BlockId, Arc<Block>> = found.into_iter().map(|(id, block, _)| (id, block)).collect();
        changed.extend(old.keys().filter(|id| !blocks.contains_key(id)));
        let meshed = changed.iter().filter(|id| blocks.contains_key(id)).count();
        let update = Update { meshed, kept: blocks.len() - meshed };
        self.blocks = self.relaxed(field, blocks, &changed)?;
        Ok(update)
    }

    /// The surface as the last update left it.
    pub fn solid(&self) -> Solid {
        let mut solid = Solid::default();
        let mut first = BTreeMap::new();
        for (id, block) in &self.blocks {
            first.insert(*id, solid.positions.len() as u32);
            solid.positions.extend(block.vertices.iter().map(|v| v.position));
            solid.normals.extend(block.vertices.iter().map(|v| v.normal));
        }
        for (id, block) in &self.blocks {
            let own = (*id, first[id]);
            // All neighbours were there when the vertices were relaxed.
            let corner = |c: Corner| find(&self.blocks, &first, own, &c).unwrap_or(0);
            solid.indices.extend(block.raw.triangles().flatten().map(corner));
        }
        straighten(&mut solid);
        solid
    }

    /// Moves the vertices of changed blocks and of those around them.
    fn relaxed(
        &self,
        field: &dyn ScalarField,
        mut blocks: BTreeMap<BlockId, Arc<Block>>,
        changed: &BTreeSet<BlockId>,
    ) -> Result<BTreeMap<BlockId, Arc<Block>>> {
        let present = |ids: &BTreeSet<BlockId>| -> BTreeSet<BlockId> {
            ids.iter().flat_map(|id| id.around()).filter(|id| blocks.contains_key(id)).collect()
        };
        // What moves differently lies next to what changed; to know how it moves, one must know its neighbours.
        let moving = present(changed);
        let known = present(&moving);
        let (mut home, mut ranges, mut first) = (Vec::new(), Vec::new(), BTreeMap::new());
        for id in &known {
            let positions = &blocks[id].raw.positions;
            first.insert(*id, home.len() as u32);
            ranges.push((home.len()..home.len() + positions.len(), Source::new(field, &self.lattice, *id)));
            home.extend_from_slice(positions);
        }
        let mut indices = Vec::new();
        for id in &known {
            let beyond = (0..3).filter(|&axis| blocks[id].raw.continues[axis]);
            let is_there = |axis: usize| blocks.contains_key(&id.offset([0, 1, 2].map(|i| -i32::from(i == axis))));
            if moving.contains(id) && !beyond.into_iter().all(is_there) {
                return Err(Error::FieldOverlooked { at: self.lattice.box_of(*id, 0.0)[0] });
            }
            let own = (*id, first[id]);
            for corners in blocks[id].raw.triangles() {
                let corners = corners.map(|c| find(&blocks, &first, own, &c));
                if let [Some(a), Some(b), Some(c)] = corners {
                    indices.extend([a, b, c]);
                } else if moving.contains(id) {
                    return Err(Error::FieldOverlooked { at: self.lattice.box_of(*id, 0.0)[1] });
                }
            }
        }
        let is_relaxed = self.options.rounds > 0;
        let net = Net::new(ranges, home, if is_relaxed { &indices } else { &[] }, self.lattice.voxel());
        let vertices = if is_relaxed { net.relaxed(self.options.rounds) } else { net.unmoved() };
        for (id, (range, _)) in known.iter().zip(&net.blocks) {
            if let Some(block) = blocks.get_mut(id).filter(|_| moving.contains(id)) {
                Arc::make_mut(block).vertices = vertices[range.clone()].to_vec();
            }
        }
        Ok(blocks)
    }
}

/// Number of a corner's vertex, given where the vertices of its own block and of all blocks begin.
fn find(
    blocks: &BTreeMap<BlockId, Arc<Block>>,
    first: &BTreeMap<BlockId, u32>,
    (id, own): (BlockId, u32),
    corner: &Corner,
) -> Option<u32> {
    match corner {
        Corner::Own(i) => Some(own + i),
        Corner::Foreign(side, edge) => {
            let other = id.offset(*side);
            Some(first.get(&other)? + blocks.get(&other)?.raw.vertex_on(*edge)?)
        }
    }
}

fn check_size(vertices: u64, limits: &Limits) -> Result<()> {
    let most = limits.max_vertices.min(u64::from(u32::MAX >> 1));
    if vertices > most {
        return Err(Error::Core(CoreError::Limit {
            what: "the mesh of a field".into(),
            needed: format!("{vertices} vertices"),
            limit: format!("{most} vertices"),
            remedy: "choose a longer voxel or a smaller box",
        }));
    }
    Ok(limits.check_bytes("the mesh of a field", u128::from(vertices) * BYTES_PER_VERTEX)?)
}

/// Gives vertices at which the field had no gradient the normal of the triangles around them.
fn straighten(solid: &mut Solid) {
    if solid.normals.iter().all(|n| *n != [0.0; 3]) {
        return;
    }
    let mut sums = vec![[0.0; 3]; solid.positions.len()];
    for (t, [a, b, c]) in solid.indices.chunks_exact(3).zip(solid.corners()) {
        let normal = super::vector::cross(super::vector::sub(b, a), super::vector::sub(c, a));
        for &i in t {
            sums[i as usize] = super::vector::add(sums[i as usize], normal);
        }
    }
    let up: Point = [0.0, 1.0, 0.0];
    for (normal, sum) in solid.normals.iter_mut().zip(sums).filter(|(n, _)| **n == [0.0; 3]) {
        *normal = unit(sum).unwrap_or(up);
    }
}
