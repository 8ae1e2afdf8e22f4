//! The lattice of points at which a field is sampled, and its blocks.

use crate::error::{Error, Result};
use crate::primitive::Point;
use eyot_core::Limits;

/// Cells along the side of a block: its rows of points fill the lanes of `eyot_core::lanes`.
pub(crate) const BLOCK: i32 = 15;

/// A lattice over a box. Its points are whole multiples of the voxel, so that lattices over different boxes share theirs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    low: Point,
    high: Point,
    voxel: f32,
    /// Points lie from here ...
    first: [i32; 3],
    /// ... to here, both included, in voxels; the outermost ones are outside the box.
    last: [i32; 3],
}

impl Lattice {
    /// A lattice over the box from `low` to `high` with edges of length `voxel`. What of a body reaches out of the box is cut off
    /// flat.
    ///
    /// # Errors
    /// If the box is empty, has no finite size, or if a voxel is not above 0 or too small for the numbers; if it has more cells
    /// than the limits allow.
    pub fn over(low: Point, high: Point, voxel: f32, limits: &Limits) -> Result<Self> {
        let bad = |reason: &str| Error::BadLattice { low, high, voxel, reason: reason.into() };
        let finite = low.iter().chain(&high).all(|v| v.is_finite()) && voxel.is_finite();
        if !finite || voxel <= 0.0 {
            return Err(bad("corners must be finite numbers and the voxel longer than 0"));
        }
        if (0..3).any(|i| low[i] >= high[i]) {
            return Err(bad("the box is empty; its second corner must lie above the first one on all axes"));
        }
        let widest = low.iter().chain(&high).fold(0.0f32, |m, v| m.max(v.abs())) / voxel;
        // Beyond that, single precision cannot tell lattice points apart well enough to place vertices between them.
        if widest > 1_000_000.0 {
            return Err(bad("more than a million voxels from the origin; move the box there or choose a longer voxel"));
        }
        let first = low.map(|v| (v / voxel).floor() as i32 - 1);
        let last = high.map(|v| (v / voxel).ceil() as i32 + 1);
        let cells: u128 = (0..3).map(|i| u128::from((last[i] - first[i]).unsigned_abs())).product();
        if cells > u128::from(limits.max_cells) {
            return Err(Error::Core(eyot_core::Error::Limit {
                what: "a lattice for meshing".into(),
                needed: format!("{cells} cells"),
                limit: format!("{} cells", limits.max_cells),
                remedy: "choose a longer voxel or a smaller box".into(),
            }));
        }
        Ok(Self { low, high, voxel, first, last })
    }

    /// Length of an edge.
    pub const fn voxel(&self) -> f32 {
        self.voxel
    }

    /// The box that it covers.
    pub const fn bounds(&self) -> [Point; 2] {
        [self.low, self.high]
    }

    /// Coordinate of lattice line `i`.
    pub(crate) fn at(&self, i: i32) -> f32 {
        i as f32 * self.voxel
    }

    /// First and last block on each axis.
    pub(crate) fn block_range(&self) -> [[i32; 2]; 3] {
        [0, 1, 2].map(|i| [self.first[i].div_euclid(BLOCK), (self.last[i] - 1).div_euclid(BLOCK)])
    }

    /// Which of `n` lattice lines from `first` on are the lattice's own.
    pub(crate) fn within(&self, axis: usize, first: i32, n: usize) -> std::ops::Range<usize> {
        let own = |i: i32| (i - first).clamp(0, n as i32) as usize;
        own(self.first[axis])..own(self.last[axis] + 1)
    }

    /// The box of a block's cells and `margin` voxels around it.
    pub(crate) fn box_of(&self, block: BlockId, margin: f32) -> [Point; 2] {
        let first = block.first();
        let at = |i: i32, margin: f32| (i as f32 + margin) * self.voxel;
        [first.map(|i| at(i, -margin)), first.map(|i| at(i + BLOCK, margin))]
    }

    /// True if a block's points lie deep enough within the box that its faces do not matter.
    pub(crate) fn is_inner(&self, block: BlockId) -> bool {
        let [low, high] = self.box_of(block, 2.0);
        (0..3).all(|i| low[i] >= self.low[i] && high[i] <= self.high[i])
    }
}

/// Number of a block. The order of blocks is that of these numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct BlockId {
    pub(crate) z: i32,
    pub(crate) y: i32,
    pub(crate) x: i32,
}

impl BlockId {
    /// Its first lattice point.
    pub(crate) fn first(self) -> [i32; 3] {
        [self.x * BLOCK, self.y * BLOCK, self.z * BLOCK]
    }

    pub(crate) fn offset(self, [x, y, z]: [i32; 3]) -> Self {
        Self { z: self.z + z, y: self.y + y, x: self.x + x }
    }

    /// This block and the 26 around it.
    pub(crate) fn around(self) -> impl Iterator<Item = Self> {
        (0..27).map(move |i| self.offset([i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1]))
    }
}
