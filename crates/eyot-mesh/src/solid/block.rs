//! One block of the lattice: samples of the field, vertices on its edges, and triangles in its cells.
//!
//! Signs are kept as a bit a point, sixteen to a row, so that rows without a surface cost two comparisons; numbers of
//! vertices stand in a flat table by their edge. What a block keeps of it is a bit an edge and a count a row
//! ([`Raw::vertex_on`]): enough for its neighbours to find the vertices that they share.

use super::cubes::{EDGES, MIDDLE, Table};
use super::field::{Boxed, ScalarField, Within};
use super::lattice::{BLOCK, BlockId, Lattice};
use crate::error::{Error, Result};
use crate::primitive::Point;
use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::LaneBlock;
use std::cell::RefCell;

/// Cells along a side.
const CELLS: usize = BLOCK as usize;
/// Points along a side.
const POINTS: usize = CELLS + 1;
/// A bit for each cell of a row.
const INNER: u32 = (1 << CELLS) - 1;
/// Vertices stay so far from the ends of their edge, in edges, that triangles around a lattice point on the surface keep an area.
const KEEP_OFF: f32 = 0.01;
/// Marks a corner whose vertex is another block's; bits 14 to 16 say which neighbour, those below its edge there.
const FOREIGN: u32 = 1 << 31;
/// Bits of an edge's number within its block.
const EDGE_BITS: u32 = 14;

/// The mesh of a block before vertices have moved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Raw {
    /// For each row of lattice points and each axis: which of its edges carry a vertex, and the number of the first one.
    /// Nothing at all if no edge does.
    ranks: Vec<Rank>,
    /// Vertices: those on edges, then those in the middle of cells.
    pub(crate) positions: Vec<Point>,
    /// Corners: numbers of own vertices, or [`FOREIGN`] ones.
    triangles: Vec<[u32; 3]>,
    /// Whether the surface runs through its lower face on each axis, to the block beyond.
    pub(crate) continues: [bool; 3],
}

#[derive(Clone, Copy, Debug, Default)]
struct Rank {
    edges: u16,
    first: u16,
}

/// A corner of a triangle.
pub(crate) enum Corner {
    /// A vertex of the block itself.
    Own(u32),
    /// The vertex on this edge of the block that lies one block further along the axes whose bits are set.
    Foreign(usize, u32),
}

impl Raw {
    pub(crate) fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// What a number in [`Raw::triangles`] means.
    #[inline(always)]
    pub(crate) fn corner(code: u32) -> Corner {
        if code & FOREIGN == 0 {
            return Corner::Own(code);
        }
        Corner::Foreign((code >> EDGE_BITS & 7) as usize, code & ((1 << EDGE_BITS) - 1))
    }

    /// The vertex on an edge.
    #[inline]
    pub(crate) fn vertex_on(&self, edge: u32) -> Option<u32> {
        let x = edge & 15;
        let rank = self.ranks.get(edge as usize >> 4)?;
        let below = u32::from(rank.edges) & ((1 << x) - 1);
        (rank.edges >> x & 1 == 1).then(|| u32::from(rank.first) + below.count_ones())
    }
}

/// Number of an edge within its block: rows of lattice points, in each row the edges along x, y and z.
fn edge_id(x: usize, y: usize, z: usize, axis: usize) -> usize {
    rank_id(y, z, axis) << 4 | x
}

fn rank_id(y: usize, z: usize, axis: usize) -> usize {
    (z * CELLS + y) * 3 + axis
}

/// What a block asks of the field.
pub(crate) struct Source<'a> {
    part: Within<'a>,
    whole: &'a dyn ScalarField,
    lattice: Lattice,
    is_inner: bool,
}

impl<'a> Source<'a> {
    pub(crate) fn new(whole: &'a dyn ScalarField, lattice: Lattice, block: BlockId) -> Self {
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
    values: [f32; POINTS * POINTS * POINTS],
    /// First row that was sampled, on y and z; those before and after are outside of the lattice.
    first: [usize; 2],
    /// Rows that were sampled of each plane.
    planes: usize,
    /// For each row along x a bit per point that is inside.
    rows: [u32; POINTS * POINTS],
}

impl Samples {
    fn take(field: &dyn ScalarField, lattice: &Lattice, block: BlockId) -> Result<Self> {
        let first = block.first();
        let line = |axis: usize| -> [f32; POINTS] { std::array::from_fn(|i| lattice.at(first[axis] + i as i32)) };
        let [xs, ys, zs] = [line(0), line(1), line(2)];
        let [y, z] = [1, 2].map(|axis| lattice.within(axis, first[axis], POINTS));
        let (ys, zs) = (&ys[y.clone()], &zs[z.clone()]);
        let mut samples = Self {
            values: [0.0; POINTS * POINTS * POINTS],
            first: [y.start, z.start],
            planes: ys.len(),
            rows: [0; POINTS * POINTS],
        };
        let values = &mut samples.values[..POINTS * ys.len() * zs.len()];
        field.fill([&xs, ys, zs], values);
        let mut signs = [0; POINTS * POINTS];
        let rows = ys.len() * zs.len();
        let finite = run_lanes(Isa::best(), Signs { values: values.as_chunks().0, signs: &mut signs[..rows] });
        if !finite {
            let at = values.iter().position(|v| !v.is_finite()).unwrap_or(0);
            let row = at / POINTS;
            let place = [xs[at % POINTS], ys[row % ys.len()], zs[row / ys.len()]];
            return Err(Error::FieldNotFinite { value: values[at], at: place });
        }
        for (k, signs) in signs[..rows].chunks_exact(ys.len()).enumerate() {
            let row = (z.start + k) * POINTS + y.start;
            samples.rows[row..row + ys.len()].copy_from_slice(signs);
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

    /// Value at a point next to which the surface passes: such are within the lattice.
    #[inline(always)]
    fn at(&self, [x, y, z]: [usize; 3]) -> f32 {
        self.values[((z - self.first[1]) * self.planes + y - self.first[0]) * POINTS + x]
    }
}

/// Bits of the points inside, row by row; whether all values are finite.
struct Signs<'a> {
    values: &'a [[f32; POINTS]],
    signs: &'a mut [u32],
}

impl LaneTask for Signs<'_> {
    type Out = bool;

    #[inline(always)]
    fn run<L: LaneBlock>(self) -> bool {
        let mut not_finite = [0; POINTS];
        for (row, sign) in self.values.iter().zip(self.signs) {
            let mut bits = 0;
            for i in 0..POINTS {
                // All bits of the exponent.
                not_finite[i] |= u32::from(row[i].to_bits() & 0x7f80_0000 == 0x7f80_0000);
                bits |= u32::from(row[i] > 0.0) << i;
            }
            *sign = bits;
        }
        not_finite == [0; POINTS]
    }
}

/// Points along x, y and z, for each axis: what the edge that begins there carries, see [`Corner`].
type Numbers = [u32; 3 * POINTS * POINTS * POINTS];

thread_local! {
    /// Only what a block writes into it is read, so it is never cleared.
    static NUMBERS: RefCell<Box<Numbers>> = RefCell::new(Box::new([0; 3 * POINTS * POINTS * POINTS]));
}

fn number_at([x, y, z]: [usize; 3], axis: usize) -> usize {
    ((axis * POINTS + z) * POINTS + y) * POINTS + x
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
    let mut raw = Raw {
        ranks: vec![Rank::default(); 3 * CELLS * CELLS],
        // A plane across the block.
        positions: Vec::with_capacity(3 * CELLS * CELLS),
        triangles: Vec::with_capacity(6 * CELLS * CELLS),
        continues: samples.lower_faces(),
    };
    NUMBERS.with_borrow_mut(|numbers| {
        let place = Place { samples: &samples, voxel: lattice.voxel(), first: block.first() };
        place.vertices(&mut raw, numbers);
        place.cells(&mut raw, numbers);
    });
    Ok(raw)
}

/// A block's samples, and where they lie.
struct Place<'a> {
    samples: &'a Samples,
    voxel: f32,
    first: [i32; 3],
}

impl Place<'_> {
    /// Place of the vertex on an edge.
    #[inline(always)]
    fn vertex(&self, p: [usize; 3], axis: usize) -> Point {
        let mut q = p;
        q[axis] += 1;
        let (a, b) = (self.samples.at(p), self.samples.at(q));
        let t = (a / (a - b)).clamp(KEEP_OFF, 1.0 - KEEP_OFF);
        let on = |i: usize| (self.first[i] + p[i] as i32) as f32;
        let mut place = [on(0), on(1), on(2)];
        place[axis] += t;
        super::vector::scale(place, self.voxel)
    }

    /// Puts a vertex on each edge whose ends differ, and writes down what all edges of its cells carry.
    fn vertices(&self, raw: &mut Raw, numbers: &mut Numbers) {
        let rows = &self.samples.rows;
        for z in 0..POINTS {
            for y in 0..POINTS {
                let here = rows[z * POINTS + y];
                let beyond = |inside: bool, step: usize| if inside { here ^ rows[z * POINTS + y + step] } else { 0 };
                let changes = [(here ^ here >> 1) & INNER, beyond(y < CELLS, 1), beyond(z < CELLS, POINTS)];
                let is_own = y < CELLS && z < CELLS;
                for (axis, mut left) in changes.into_iter().enumerate() {
                    if is_own {
                        let rank = Rank { edges: (left & INNER) as u16, first: raw.positions.len() as u16 };
                        raw.ranks[rank_id(y, z, axis)] = rank;
                    }
                    while left != 0 {
                        let p = [left.trailing_zeros() as usize, y, z];
                        left &= left - 1;
                        numbers[number_at(p, axis)] = if is_own && p[0] < CELLS {
                            raw.positions.push(self.vertex(p, axis));
                            raw.positions.len() as u32 - 1
                        } else {
                            foreign(p, axis)
                        };
                    }
                }
            }
        }
    }

    fn cells(&self, raw: &mut Raw, numbers: &Numbers) {
        let table = Table::get();
        let rows = &self.samples.rows;
        for z in 0..CELLS {
            for y in 0..CELLS {
                let rows: [u32; 4] = std::array::from_fn(|i| rows[(z + i / 2) * POINTS + y + i % 2]);
                let any = rows[0] | rows[1] | rows[2] | rows[3];
                let all = rows[0] & rows[1] & rows[2] & rows[3];
                let mut left = (any | any >> 1) & !(all & all >> 1) & INNER;
                while left != 0 {
                    let x = left.trailing_zeros() as usize;
                    left &= left - 1;
                    let set = |i: usize| (rows[i] >> x & 3) << (2 * i);
                    self.cell(raw, numbers, table, [x, y, z], (set(0) | set(1) | set(2) | set(3)) as u8);
                }
            }
        }
    }

    #[inline(always)]
    fn cell(&self, raw: &mut Raw, numbers: &Numbers, table: &Table, [x, y, z]: [usize; 3], inside: u8) {
        let corner = |c: u8| [x + usize::from(c & 1), y + usize::from(c >> 1 & 1), z + usize::from(c >> 2)];
        let filling = table.filling(inside, |c| self.samples.at(corner(c)));
        let here = &numbers[number_at([x, y, z], 0)..];
        if filling.middles.is_empty() {
            let code = |edge: u8| here[FROM_CELL[usize::from(edge & 15)]];
            raw.triangles.extend(filling.corners.iter().map(|&[a, b, c]| [code(a), code(b), code(c)]));
            return;
        }
        let first_middle = raw.positions.len() as u32;
        for outline in &filling.middles {
            let sum = outline.iter().fold([0.0; 3], |sum, &edge| {
                let p = self.vertex(corner(EDGES[usize::from(edge)][0]), usize::from(edge / 4));
                super::vector::add(sum, p)
            });
            raw.positions.push(super::vector::scale(sum, 1.0 / outline.len() as f32));
        }
        let code = |edge: u8| match edge.checked_sub(MIDDLE) {
            Some(middle) => first_middle + u32::from(middle),
            None => here[FROM_CELL[usize::from(edge)]],
        };
        raw.triangles.extend(filling.corners.iter().map(|&[a, b, c]| [code(a), code(b), code(c)]));
    }
}

/// Where in [`Numbers`] each edge of a cell stands, from its first edge; without meaning from 12 on.
const FROM_CELL: [usize; 16] = {
    let mut from = [0; 16];
    let mut edge = 0;
    while edge < 12 {
        let c = EDGES[edge][0] as usize;
        from[edge] = (edge / 4 * POINTS + (c >> 2)) * POINTS * POINTS + (c >> 1 & 1) * POINTS + (c & 1);
        edge += 1;
    }
    from
};

/// The number of a vertex in the block to which its edge belongs.
fn foreign(p: [usize; 3], axis: usize) -> u32 {
    let side = (0..3).fold(0, |set, i| set | u32::from(p[i] == CELLS) << i);
    let [x, y, z] = p.map(|v| v % CELLS);
    FOREIGN | side << EDGE_BITS | edge_id(x, y, z, axis) as u32
}
