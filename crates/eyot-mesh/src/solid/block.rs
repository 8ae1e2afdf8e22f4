//! One block of the lattice: samples of the field, vertices on its edges, and triangles in its cells.

use super::cubes::{EDGES, MIDDLE, Table};
use super::field::{Boxed, Point, ScalarField, Within};
use super::lattice::{BLOCK, BlockId, Lattice};
use crate::error::{Error, Result};

/// Cells along a side.
const CELLS: usize = BLOCK as usize;
/// Points along a side.
const POINTS: usize = CELLS + 1;
/// Vertices stay so far from the ends of their edge, in edges, that triangles around a lattice point on the surface keep an area.
const KEEP_OFF: f32 = 0.01;
/// Marks a corner whose vertex is another block's; bits 14 to 16 say which neighbour, those below its edge there.
const FOREIGN: u32 = 1 << 31;

/// The mesh of a block before vertices have moved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Raw {
    /// Edges that carry the first vertices, in rising order, see [`edge_id`].
    edges: Vec<u16>,
    /// Vertices: those on edges, then those in the middle of cells.
    pub(crate) positions: Vec<Point>,
    /// Corners: numbers of own vertices, or [`FOREIGN`] ones.
    triangles: Vec<[u32; 3]>,
    /// Whether the surface runs through its lower face on each axis, to the block beyond.
    pub(crate) continues: [bool; 3],
}

/// A corner of a triangle.
pub(crate) enum Corner {
    /// A vertex of the block itself.
    Own(u32),
    /// The vertex on this edge of the block that lies so many blocks further along each axis.
    Foreign([i32; 3], u16),
}

impl Raw {
    pub(crate) fn triangles(&self) -> impl ExactSizeIterator<Item = [Corner; 3]> {
        self.triangles.iter().map(|t| {
            t.map(|c| {
                if c & FOREIGN == 0 {
                    return Corner::Own(c);
                }
                let side = |bit: u32| (c >> (14 + bit) & 1) as i32;
                Corner::Foreign([side(0), side(1), side(2)], (c & 0x3fff) as u16)
            })
        })
    }

    /// The vertex on an edge.
    pub(crate) fn vertex_on(&self, edge: u16) -> Option<u32> {
        self.edges.binary_search(&edge).ok().map(|i| i as u32)
    }
}

/// Number of an edge within its block: rows of lattice points, in each row the edges along x, y and z.
fn edge_id(x: usize, y: usize, z: usize, axis: usize) -> usize {
    ((z * CELLS + y) * 3 + axis) * CELLS + x
}

/// What a block asks of the field.
pub(crate) struct Source<'a> {
    part: Within<'a>,
    whole: &'a dyn ScalarField,
    lattice: &'a Lattice,
    is_inner: bool,
}

impl<'a> Source<'a> {
    pub(crate) fn new(whole: &'a dyn ScalarField, lattice: &'a Lattice, block: BlockId) -> Self {
        // Vertices leave their block by at most half a voxel, see `relax`.
        let [low, high] = lattice.box_of(block, 1.0);
        Self { part: whole.within(low, high), whole, lattice, is_inner: lattice.is_inner(block) }
    }

    pub(crate) fn is_nothing(&self) -> bool {
        matches!(self.part, Within::Nothing)
    }

    pub(crate) fn stamp(&self) -> Option<u64> {
        match &self.part {
            Within::Nothing => Some(0),
            Within::Whole => self.whole.stamp(),
            Within::Part(part) => part.stamp(),
        }
    }

    /// Calls `f` with the field, cut off by the lattice's box where that is near.
    pub(crate) fn with<T>(&self, f: impl FnOnce(&dyn ScalarField) -> T) -> T {
        let field: &dyn ScalarField = match &self.part {
            Within::Part(part) => part.as_ref(),
            Within::Nothing | Within::Whole => self.whole,
        };
        if self.is_inner {
            return f(field);
        }
        let [low, high] = self.lattice.bounds();
        // Gentle, so that next to a face its plane and not the field decides where a vertex stands.
        f(&Boxed { field, low, high, steepness: 0.1 / self.lattice.voxel() })
    }
}

/// Values at the lattice points of a block.
struct Samples {
    values: Box<[f32; POINTS * POINTS * POINTS]>,
    /// For each row along x a bit per point that is inside.
    rows: [u32; POINTS * POINTS],
}

impl Samples {
    fn take(field: &dyn ScalarField, lattice: &Lattice, block: BlockId) -> Result<Self> {
        let mut samples = Self { values: Box::new([0.0; POINTS * POINTS * POINTS]), rows: [0; POINTS * POINTS] };
        let first = block.first();
        let line = |axis: usize| -> [f32; POINTS] { std::array::from_fn(|i| lattice.at(first[axis] + i as i32)) };
        let [xs, ys, zs] = [line(0), line(1), line(2)];
        for (row, values) in samples.values.chunks_exact_mut(POINTS).enumerate() {
            let (y, z) = (ys[row % POINTS], zs[row / POINTS]);
            field.row(&xs, y, z, values);
            for (i, v) in values.iter().enumerate() {
                if !v.is_finite() {
                    return Err(Error::FieldNotFinite { value: *v, at: [xs[i], y, z] });
                }
                samples.rows[row] |= u32::from(*v > 0.0) << i;
            }
        }
        Ok(samples)
    }

    /// Whether points of the lower face on each axis lie on both sides of the surface.
    fn lower_faces(&self) -> [bool; 3] {
        let is_mixed = |bits: u32, rows: &mut dyn Iterator<Item = u32>| {
            let (any, all) = rows.fold((0, bits), |(any, all), row| (any | row & bits, all & row));
            any != 0 && all != bits
        };
        let row = |y: usize, z: usize| self.rows[z * POINTS + y];
        let along = (1 << POINTS) - 1;
        [
            is_mixed(1, &mut self.rows.iter().copied()),
            is_mixed(along, &mut (0..POINTS).map(|z| row(0, z))),
            is_mixed(along, &mut (0..POINTS).map(|y| row(y, 0))),
        ]
    }

    fn at(&self, x: usize, y: usize, z: usize) -> f32 {
        self.values[(z * POINTS + y) * POINTS + x]
    }
}

/// Samples a block and meshes it.
///
/// # Errors
/// If the field is no finite number somewhere.
pub(crate) fn extract(source: &Source<'_>, lattice: &Lattice, block: BlockId) -> Result<Raw> {
    let samples = source.with(|field| Samples::take(field, lattice, block))?;
    let (any, all) = samples.rows.iter().fold((0, !0), |(any, all), r| (any | r, all & r));
    let everywhere = (1 << POINTS) - 1;
    if any == 0 || all & everywhere == everywhere {
        return Ok(Raw::default());
    }
    let mut raw = Raw { continues: samples.lower_faces(), ..Raw::default() };
    let mut own = vec![0u16; 3 * CELLS * CELLS * CELLS];
    vertices(&samples, lattice, block, &mut raw, &mut own);
    cells(&samples, lattice, block, &mut raw, &own);
    Ok(raw)
}

/// Place of the vertex on an edge.
fn vertex(samples: &Samples, lattice: &Lattice, first: [i32; 3], p: [usize; 3], axis: usize) -> Point {
    let mut q = p;
    q[axis] += 1;
    let (a, b) = (samples.at(p[0], p[1], p[2]), samples.at(q[0], q[1], q[2]));
    let t = (a / (a - b)).clamp(KEEP_OFF, 1.0 - KEEP_OFF);
    std::array::from_fn(|i| {
        let whole = first[i] + p[i] as i32;
        if i == axis { (whole as f32 + t) * lattice.voxel() } else { lattice.at(whole) }
    })
}

fn vertices(samples: &Samples, lattice: &Lattice, block: BlockId, raw: &mut Raw, own: &mut [u16]) {
    let first = block.first();
    let inner = (1u32 << CELLS) - 1;
    for z in 0..CELLS {
        for y in 0..CELLS {
            let row = |dy: usize, dz: usize| samples.rows[(z + dz) * POINTS + y + dy];
            let here = row(0, 0);
            for (axis, changes) in [here ^ here >> 1, here ^ row(1, 0), here ^ row(0, 1)].into_iter().enumerate() {
                let mut left = changes & inner;
                while left != 0 {
                    let x = left.trailing_zeros() as usize;
                    left &= left - 1;
                    let id = edge_id(x, y, z, axis);
                    own[id] = raw.positions.len() as u16;
                    raw.edges.push(id as u16);
                    raw.positions.push(vertex(samples, lattice, first, [x, y, z], axis));
                }
            }
        }
    }
}

fn cells(samples: &Samples, lattice: &Lattice, block: BlockId, raw: &mut Raw, own: &[u16]) {
    let table = Table::get();
    let inner = (1u32 << CELLS) - 1;
    for z in 0..CELLS {
        for y in 0..CELLS {
            let rows: [u32; 4] = std::array::from_fn(|i| samples.rows[(z + i / 2) * POINTS + y + i % 2]);
            let any = rows[0] | rows[1] | rows[2] | rows[3];
            let all = rows[0] & rows[1] & rows[2] & rows[3];
            let mut left = (any | any >> 1) & !(all & all >> 1) & inner;
            while left != 0 {
                let x = left.trailing_zeros() as usize;
                left &= left - 1;
                let inside = (0..4).fold(0, |set, i| set | (rows[i] >> x & 3) << (2 * i)) as u8;
                cell(samples, lattice, block, raw, own, table, [x, y, z], inside);
            }
        }
    }
}

fn cell(
    samples: &Samples,
    lattice: &Lattice,
    block: BlockId,
    raw: &mut Raw,
    own: &[u16],
    table: &Table,
    [x, y, z]: [usize; 3],
    inside: u8,
) {
    let corner = |c: u8| [x + usize::from(c & 1), y + usize::from(c >> 1 & 1), z + usize::from(c >> 2)];
    let filling = table.filling(inside, |c| {
        let [x, y, z] = corner(c);
        samples.at(x, y, z)
    });
    let first_middle = raw.positions.len() as u32;
    for outline in &filling.middles {
        let sum = outline.iter().fold([0.0; 3], |sum, &edge| {
            let p = vertex(samples, lattice, block.first(), corner(EDGES[usize::from(edge)][0]), usize::from(edge / 4));
            super::vector::add(sum, p)
        });
        raw.positions.push(super::vector::scale(sum, 1.0 / outline.len() as f32));
    }
    let code = |edge: u8| {
        if edge >= MIDDLE {
            return first_middle + u32::from(edge - MIDDLE);
        }
        let p = corner(EDGES[usize::from(edge)][0]);
        let axis = usize::from(edge / 4);
        let [x, y, z] = p.map(|v| v % CELLS);
        let id = edge_id(x, y, z, axis);
        if p.iter().all(|&v| v < CELLS) {
            return u32::from(own[id]);
        }
        let side = (0..3).fold(0, |set, i| set | u32::from(p[i] == CELLS) << i);
        FOREIGN | side << 14 | id as u32
    };
    raw.triangles.extend(filling.corners.iter().map(|t| t.map(code)));
}
