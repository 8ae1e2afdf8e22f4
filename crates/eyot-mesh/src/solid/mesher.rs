//! From a field to the surface of a body, block by block, and again when the field has changed.

use super::block::{Corner, Raw, Source, extract};
use super::field::ScalarField;
use super::lattice::{BlockId, Lattice};
use super::relax::{Net, Vertex, each_block};
use super::solid_mesh::Solid;
use super::vector::{add, cross, dot, sub, unit};
use crate::error::{Error, Result};
use crate::primitive::Point;
use eyot_core::{Error as CoreError, Limits};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// How to mesh a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshingOptions {
    /// Rounds in which vertices spread out over the surface, at most 7; 0 leaves them on the lattice's edges, where the
    /// field is interpolated linearly. From 1 on, less than one triangle in a hundred has an angle below 10 degrees, and
    /// normals follow the triangles instead of the field where these disagree, as in creases.
    pub rounds: u32,
}

impl Default for MeshingOptions {
    fn default() -> Self {
        Self { rounds: 2 }
    }
}

/// More would carry a change farther than into the next block.
const MAX_ROUNDS: u32 = 7;
/// Cosine of the angle by which a field's gradient may differ from the normal of the triangles around: 32 degrees. A
/// cylinder of a radius of one voxel stays below it, a right-angled edge is above.
const AGREED: f32 = 0.85;
/// Bytes of a vertex with its share of triangles, in all arrays that are alive at once.
const BYTES_PER_VERTEX: u128 = 200;

/// Meshes where a field is 0.
///
/// The surface is closed, and a manifold, for any field: every edge has two triangles, the triangles around every vertex make one
/// fan. What reaches out of the lattice's box ends flat there. Normals are the field's gradient (see [`MeshingOptions`]). The same field gives
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
    let layout = Layout::new(lattice);
    let Found { surface, sources, .. } = Surface::find(field, *lattice, layout, |_, _| None, limits)?;
    let moved = surface.relax(sources, None, options.rounds)?;
    Ok(solid(moved.vertices.iter(), moved.indices, options.rounds > 0))
}

/// Meshes a field that changes, and only those blocks of it that did; the bytes are those of meshing all of it.
pub struct Remesher {
    options: MeshingOptions,
    surface: Surface,
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
    id: BlockId,
    stamp: Option<u64>,
    raw: Arc<Raw>,
    /// Vertices after they have moved.
    vertices: Arc<Vec<Vertex>>,
}

/// No block, or no vertex.
const NOBODY: u32 = u32::MAX;

/// The places of blocks in a lattice, along x first.
#[derive(Clone, Copy)]
struct Layout {
    low: [i32; 3],
    count: [usize; 3],
}

impl Layout {
    fn new(lattice: &Lattice) -> Self {
        let range = lattice.block_range();
        Self { low: range.map(|r| r[0]), count: range.map(|[first, last]| (last - first + 1).max(0) as usize) }
    }

    fn len(&self) -> usize {
        self.count.iter().product()
    }

    fn id(&self, place: usize) -> BlockId {
        let [nx, ny, _] = self.count;
        let at = |axis: usize, i: usize| self.low[axis] + i as i32;
        BlockId { z: at(2, place / (nx * ny)), y: at(1, place / nx % ny), x: at(0, place % nx) }
    }

    fn place(&self, id: BlockId) -> Option<usize> {
        let i = [id.x - self.low[0], id.y - self.low[1], id.z - self.low[2]];
        let is_in = (0..3).all(|axis| i[axis] >= 0 && (i[axis] as usize) < self.count[axis]);
        let [x, y, z] = i.map(|v| v as usize);
        is_in.then(|| (z * self.count[1] + y) * self.count[0] + x)
    }
}

impl Remesher {
    /// A mesher that has seen nothing yet.
    pub fn new(lattice: Lattice, options: MeshingOptions) -> Self {
        Self { options, surface: Surface::new(lattice, Layout::new(&lattice)) }
    }

    /// Meshes what differs from the last time.
    ///
    /// # Errors
    /// As [`mesh_field`]. Then everything is meshed the next time.
    pub fn update(&mut self, field: &dyn ScalarField, limits: &Limits) -> Result<Update> {
        let empty = Surface::new(self.surface.lattice, self.surface.layout);
        let old = std::mem::replace(&mut self.surface, empty);
        let before = |place: usize| old.blocks.get(*old.slots.get(place)? as usize);
        let kept = |place: usize, stamp: u64| before(place).filter(|b| b.stamp == Some(stamp)).cloned();
        let found = Surface::find(field, old.lattice, old.layout, kept, limits)?;
        let (mut surface, is_new) = (found.surface, found.is_new);
        // Changed are those that were meshed, and those that are gone.
        let slots = surface.slots.iter().enumerate();
        let changed: Vec<bool> = slots
            .map(|(place, &slot)| is_new.get(slot as usize).copied().unwrap_or_else(|| before(place).is_some()))
            .collect();
        let meshed = is_new.iter().filter(|n| **n).count();
        let update = Update { meshed, kept: is_new.len() - meshed };
        let moved = surface.relax(found.sources, (update.kept > 0).then_some(&changed), self.options.rounds)?;
        for (b, range) in moved.blocks.iter().filter(|b| b.2).map(|b| (b.0, b.1.clone())) {
            surface.blocks[b].vertices = Arc::new(moved.vertices[range].to_vec());
        }
        self.surface = surface;
        Ok(update)
    }

    /// The surface as the last update left it.
    pub fn solid(&self) -> Solid {
        let blocks = &self.surface.blocks;
        let all: Vec<usize> = (0..blocks.len()).collect();
        let vertices = blocks.iter().flat_map(|b| b.vertices.iter());
        solid(vertices, self.surface.corners(&all).0, self.options.rounds > 0)
    }
}

/// A surface of these vertices, three corners to a triangle.
fn solid<'a>(vertices: impl Iterator<Item = &'a Vertex>, indices: Vec<u32>, is_relaxed: bool) -> Solid {
    let (positions, normals) = vertices.map(|v| (v.position, v.normal)).unzip();
    let mut solid = Solid { positions, normals, indices };
    straighten(&mut solid, is_relaxed);
    solid
}

/// Blocks side by side.
struct Surface {
    lattice: Lattice,
    layout: Layout,
    /// Blocks in which something may be, in the layout's order.
    blocks: Vec<Block>,
    /// For each place of the layout the number of its block, or [`NOBODY`].
    slots: Vec<u32>,
}

/// What a look at a field found.
struct Found<'a> {
    surface: Surface,
    /// What each block asks of the field.
    sources: Vec<Source<'a>>,
    /// Which blocks were meshed.
    is_new: Vec<bool>,
}

/// Vertices where they belong.
struct Moved {
    /// Blocks whose vertices are known, where these are, and whether they are right: those of the others lack neighbours.
    blocks: Vec<(usize, Range<usize>, bool)>,
    vertices: Vec<Vertex>,
    /// Corners of the triangles whose vertices are known.
    indices: Vec<u32>,
}

impl Surface {
    const fn new(lattice: Lattice, layout: Layout) -> Self {
        Self { lattice, layout, blocks: Vec::new(), slots: Vec::new() }
    }

    /// Meshes all blocks in which something may be, except for those that `kept` still knows by their stamp.
    fn find<'a>(
        field: &'a dyn ScalarField,
        lattice: Lattice,
        layout: Layout,
        kept: impl Fn(usize, u64) -> Option<Block> + Sync,
        limits: &Limits,
    ) -> Result<Found<'a>> {
        let look = |place: usize| -> Result<Option<(Block, Source<'a>, bool)>> {
            let id = layout.id(place);
            let source = Source::new(field, lattice, id);
            if source.is_nothing() {
                return Ok(None);
            }
            let stamp = source.stamp();
            if let Some(block) = stamp.and_then(|s| kept(place, s)) {
                return Ok(Some((block, source, false)));
            }
            let raw = Arc::new(extract(&source, &lattice, id)?);
            Ok(Some((Block { id, stamp, raw, vertices: Arc::default() }, source, true)))
        };
        let all: Vec<Option<_>> = (0..layout.len()).into_par_iter().with_min_len(8).map(look).collect::<Result<_>>()?;
        let vertices = all.iter().flatten().map(|b| b.0.raw.positions.len() as u64).sum();
        check_size(vertices, limits)?;
        let mut found = Found { surface: Self::new(lattice, layout), sources: Vec::new(), is_new: Vec::new() };
        for one in all {
            let number = found.is_new.len() as u32;
            found.surface.slots.push(if one.is_some() { number } else { NOBODY });
            if let Some((block, source, is_new)) = one {
                found.surface.blocks.push(block);
                found.sources.push(source);
                found.is_new.push(is_new);
            }
        }
        Ok(found)
    }

    /// Which blocks there are next to these, or are these.
    fn around(&self, are: &[bool]) -> Vec<bool> {
        let mut around = vec![false; are.len()];
        for (place, _) in are.iter().enumerate().filter(|a| *a.1) {
            for id in self.layout.id(place).around() {
                if let Some(next) = self.layout.place(id).filter(|&p| self.slots[p] != NOBODY) {
                    around[next] = true;
                }
            }
        }
        around
    }

    /// Numbers of the blocks at these places.
    fn at(&self, places: &[bool]) -> Vec<usize> {
        places.iter().zip(&self.slots).filter(|(is, s)| **is && **s != NOBODY).map(|(_, s)| *s as usize).collect()
    }

    /// Corners of the triangles of some blocks, whose vertices are numbered one block after the other; [`NOBODY`] for those of
    /// other blocks. With it, where each block's corners are.
    fn corners(&self, some: &[usize]) -> (Vec<u32>, Vec<Range<usize>>) {
        let mut first = vec![NOBODY; self.blocks.len()];
        let (mut vertices, mut corners) = (0, 0);
        let mut ranges = Vec::with_capacity(some.len());
        for &b in some {
            first[b] = vertices;
            vertices += self.blocks[b].raw.positions.len() as u32;
            let n = 3 * self.blocks[b].raw.triangles().len();
            ranges.push(corners..corners + n);
            corners += n;
        }
        let mut indices = vec![0; corners];
        let fill = |(b, _): &(usize, Range<usize>), out: &mut [u32]| {
            let (own, block) = (first[*b], &self.blocks[*b]);
            // The block itself and those beyond its upper faces.
            let near: [Option<(u32, &Raw)>; 8] = std::array::from_fn(|side| {
                let id = block.id.offset([0, 1, 2].map(|axis| (side >> axis & 1) as i32));
                let slot = self.slots[self.layout.place(id)?] as usize;
                let first = first.get(slot).copied().filter(|&f| f != NOBODY)?;
                Some((first, &*self.blocks[slot].raw))
            });
            for (out, &code) in out.iter_mut().zip(block.raw.triangles().as_flattened()) {
                *out = match Raw::corner(code) {
                    Corner::Own(i) => own + i,
                    Corner::Foreign(side, edge) => {
                        near[side].and_then(|(first, raw)| Some(first + raw.vertex_on(edge)?)).unwrap_or(NOBODY)
                    }
                };
            }
        };
        let parts: Vec<(usize, Range<usize>)> = some.iter().copied().zip(ranges.iter().cloned()).collect();
        each_block(&parts, |p| p.1.clone(), &mut indices, fill);
        (indices, ranges)
    }

    /// Moves the vertices of changed blocks and of those around them; of all blocks if nobody says what changed.
    fn relax(&self, sources: Vec<Source<'_>>, changed: Option<&[bool]>, rounds: u32) -> Result<Moved> {
        // What moves differently lies next to what changed; to know how it moves, one must know its neighbours.
        let all = self.blocks.len();
        let (is_moving, known) = match changed {
            None => (vec![true; all], (0..all).collect()),
            Some(changed) => {
                let moving = self.around(changed);
                let mut is_moving = vec![false; all];
                self.at(&moving).into_iter().for_each(|b| is_moving[b] = true);
                (is_moving, self.at(&self.around(&moving)))
            }
        };
        let (mut indices, ranges) = self.corners(&known);
        let mut is_whole = true;
        for (&b, range) in known.iter().zip(ranges) {
            let block = &self.blocks[b];
            let is_there = |axis: usize| {
                let id = block.id.offset([0, 1, 2].map(|i| -i32::from(i == axis)));
                self.layout.place(id).is_some_and(|p| self.slots[p] != NOBODY)
            };
            let lacks = (0..3).any(|axis| block.raw.continues[axis] && !is_there(axis));
            let unknown = indices[range].contains(&NOBODY);
            is_whole &= !unknown;
            if is_moving[b] && (lacks || unknown) {
                return Err(Error::FieldOverlooked { at: self.lattice.box_of(block.id, 0.0)[usize::from(!lacks)] });
            }
        }
        if !is_whole {
            let known = indices.chunks_exact(3).filter(|t| !t.contains(&NOBODY));
            indices = known.flatten().copied().collect();
        }
        let mut home: Vec<Point> = Vec::new();
        let (mut blocks, mut parts) = (Vec::with_capacity(known.len()), Vec::with_capacity(known.len()));
        let mut sources = sources.into_iter().enumerate();
        for &b in &known {
            let begin = home.len();
            home.extend_from_slice(&self.blocks[b].raw.positions);
            // Numbers rise.
            let source = sources.find(|s| s.0 == b);
            parts.extend(source.map(|s| (begin..home.len(), s.1)));
            blocks.push((b, begin..home.len(), is_moving[b]));
        }
        let rounds = rounds.min(MAX_ROUNDS);
        let net = Net::new(parts, home, if rounds > 0 { &indices } else { &[] }, self.lattice.voxel());
        let vertices = if rounds > 0 { net.relaxed(rounds) } else { net.unmoved() };
        Ok(Moved { blocks, vertices, indices })
    }
}

fn check_size(vertices: u64, limits: &Limits) -> Result<()> {
    let most = limits.max_vertices.min(u64::from(u32::MAX >> 1));
    if vertices > most {
        return Err(Error::Core(CoreError::Limit {
            what: "the mesh of a field".into(),
            needed: format!("{vertices} vertices"),
            limit: format!("{most} vertices"),
            remedy: "choose a longer voxel or a smaller box".into(),
        }));
    }
    Ok(limits.check_bytes("the mesh of a field", u128::from(vertices) * BYTES_PER_VERTEX)?)
}

/// Gives vertices the normal of the triangles around them where the field had no gradient, and, if `all` are asked, where its
/// gradient is not what the triangles show: in creases, and where a body is hardly thicker than a voxel.
fn straighten(solid: &mut Solid, all: bool) {
    if !all && solid.normals.iter().all(|n| *n != [0.0; 3]) {
        return;
    }
    let mut sums = vec![[0.0; 3]; solid.positions.len()];
    for (t, [a, b, c]) in solid.indices.chunks_exact(3).zip(solid.corners()) {
        // All count alike: a small triangle turns away as much as a large one.
        let normal = unit(cross(sub(b, a), sub(c, a))).unwrap_or_default();
        for &i in t {
            sums[i as usize] = add(sums[i as usize], normal);
        }
    }
    let up: Point = [0.0, 1.0, 0.0];
    for (normal, sum) in solid.normals.iter_mut().zip(sums) {
        let around = unit(sum);
        let agrees = || around.is_none_or(|a| dot(a, *normal) >= AGREED);
        if *normal == [0.0; 3] || all && !agrees() {
            *normal = around.unwrap_or(up);
        }
    }
}
