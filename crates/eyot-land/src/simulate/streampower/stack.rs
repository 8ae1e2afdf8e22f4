//! The order in which an implicit step visits cells: upstream from the outlets, each subtree in one piece.
//!
//! # Source
//! The stack of Braun and Willett 2013. Here positions follow from the sizes of subtrees, without recursion, and what
//! lies between the large rivers falls apart into pieces that are worked on in parallel.

use eyot_core::Grid;
use eyot_drainage::{Neighbours, Routing};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// Cells with more cells upstream than this belong to large rivers, which are visited one after the other; pieces have
/// about as many cells. Decides no byte.
const PIECE: u32 = 4096;
/// Marks a cell that drains to no other.
const OUTLET: u32 = u32::MAX;

/// Cells in stack order: each after its receiver, and each followed by everything upstream of it.
pub(super) struct Stack {
    /// Of each position, the cell.
    pub(super) cell: Vec<u32>,
    /// Of each cell, the position.
    pub(super) position: Vec<u32>,
    /// Of each cell, the number of cells that drain through it, itself included.
    pub(super) upstream: Vec<u32>,
    /// Of each position, the position of the receiver; [`OUTLET`] if there is none.
    below: Vec<u32>,
    /// Positions of large rivers, each after its receiver.
    rivers: Vec<u32>,
    /// Positions of cells that are no large rivers and drain to one, or to nothing; from first to last.
    roots: Vec<u32>,
    pieces: Vec<Piece>,
}

/// Whole subtrees side by side.
struct Piece {
    positions: Range<usize>,
    /// Their roots, as indices of [`Stack::roots`].
    roots: Range<usize>,
}

/// A cell that has found its place.
#[derive(Clone, Copy)]
struct Placed {
    cell: u32,
    position: u32,
    /// Position of the receiver.
    below: u32,
}

impl Stack {
    pub(super) fn new(routing: &Routing, grid: &Grid) -> Self {
        let n = routing.cells();
        let upstream = routing.upstream_cells();
        let donors = Donors { near: Neighbours::new(grid), directions: routing.directions(), upstream: &upstream };
        let (rivers, mut placed_roots) = donors.rivers();
        placed_roots.sort_unstable_by_key(|r| r.position);
        let roots: Vec<u32> = placed_roots.iter().map(|r| r.position).collect();
        let pieces = pieces(&rivers.iter().map(|r| r.position).collect::<Vec<_>>(), &roots, n);

        let (mut cell, mut below) = (vec![0; n], vec![OUTLET; n]);
        // Each cell is written once, by the piece that it is in.
        let position: Vec<AtomicU32> = (0..n).into_par_iter().map(|_| AtomicU32::new(0)).collect();
        for r in &rivers {
            (cell[r.position as usize], below[r.position as usize]) = (r.cell, r.below);
            position[r.cell as usize].store(r.position, Ordering::Relaxed);
        }
        let slices = split(&mut cell, &pieces).into_par_iter().zip(split(&mut below, &pieces)).zip(&pieces);
        slices.for_each(|((cell, below), piece)| {
            let start = piece.positions.start;
            let mut left = Vec::new();
            for &root in &placed_roots[piece.roots.clone()] {
                left.push(root);
                while let Some(at) = left.pop() {
                    let p = at.position as usize - start;
                    (cell[p], below[p]) = (at.cell, at.below);
                    position[at.cell as usize].store(at.position, Ordering::Relaxed);
                    donors.place(at, |donor| left.push(donor));
                }
            }
        });
        let position = position.into_iter().map(AtomicU32::into_inner).collect();
        let rivers = rivers.into_iter().map(|r| r.position).collect();
        Self { cell, position, upstream, below, rivers, roots, pieces }
    }

    /// Replaces the value at each position, receivers first, by `visit(position, value, the receiver's new value)`; outlets get
    /// `None`.
    pub(super) fn climb(&self, values: &mut [f64], visit: impl Fn(usize, f64, Option<f64>) -> f64 + Sync) {
        for &p in &self.rivers {
            let base = self.base(p, values);
            values[p as usize] = visit(p as usize, values[p as usize], base);
        }
        let bases: Vec<Option<f64>> = self.roots.iter().map(|&p| self.base(p, values)).collect();
        let slices = split(values, &self.pieces).into_par_iter().zip(&self.pieces);
        slices.for_each(|(values, piece)| {
            let start = piece.positions.start;
            let mut bases = bases[piece.roots.clone()].iter();
            for p in piece.positions.clone() {
                // Roots alone drain out of their piece.
                let base = match (self.below[p] as usize).checked_sub(start).and_then(|k| values.get(k)) {
                    Some(&b) => Some(b),
                    None => bases.next().copied().flatten(),
                };
                values[p - start] = visit(p, values[p - start], base);
            }
        });
    }

    /// Adds to each position's value those of all positions upstream.
    pub(super) fn descend(&self, values: &mut [f64]) {
        for (p, &below) in self.below.iter().enumerate().rev() {
            if below != OUTLET {
                values[below as usize] += values[p];
            }
        }
    }

    fn base(&self, p: u32, values: &[f64]) -> Option<f64> {
        let b = self.below[p as usize];
        (b != OUTLET).then(|| values[b as usize])
    }
}

/// Finds who drains to a cell.
struct Donors<'a> {
    near: Neighbours,
    directions: &'a [u8],
    upstream: &'a [u32],
}

impl Donors<'_> {
    /// Calls `f` with each donor of a cell, which has its place behind it, one subtree after the other.
    #[inline]
    fn place(&self, at: Placed, mut f: impl FnMut(Placed)) {
        if self.upstream[at.cell as usize] == 1 {
            return;
        }
        let mut position = at.position + 1;
        self.near.each(at.cell as usize, |d, j| {
            if usize::from(self.directions[j]) == (d + 4) % 8 {
                f(Placed { cell: j as u32, position, below: at.position });
                position += self.upstream[j];
            }
        });
    }

    /// The cells of large rivers, each after its receiver, and the roots of what drains to them.
    fn rivers(&self) -> (Vec<Placed>, Vec<Placed>) {
        let (mut rivers, mut roots, mut left, mut free) = (Vec::new(), Vec::new(), Vec::new(), 0);
        // No direction leads from an outlet.
        for outlet in (0..self.directions.len()).filter(|&i| self.directions[i] >= 8) {
            left.push(Placed { cell: outlet as u32, position: free, below: OUTLET });
            free += self.upstream[outlet];
            while let Some(at) = left.pop() {
                if self.upstream[at.cell as usize] > PIECE {
                    rivers.push(at);
                    self.place(at, |donor| left.push(donor));
                } else {
                    roots.push(at);
                }
            }
        }
        (rivers, roots)
    }
}

/// The values of each piece.
fn split<'a, T>(values: &'a mut [T], pieces: &[Piece]) -> Vec<&'a mut [T]> {
    let (mut rest, mut at) = (values, 0);
    let cut = |piece: &Piece| {
        let (_, from) = std::mem::take(&mut rest).split_at_mut(piece.positions.start - at);
        let (own, after) = from.split_at_mut(piece.positions.len());
        (rest, at) = (after, piece.positions.end);
        own
    };
    pieces.iter().map(cut).collect()
}

/// Cuts what lies between large rivers at roots, into runs of about [`PIECE`] cells.
fn pieces(rivers: &[u32], roots: &[u32], n: usize) -> Vec<Piece> {
    let mut rivers = rivers.to_vec();
    rivers.sort_unstable();
    let mut ends = rivers.iter().map(|&p| p as usize).chain([n]);
    let mut end = ends.next().unwrap_or(n);
    let mut pieces: Vec<Piece> = Vec::new();
    let mut open: Option<(usize, usize)> = None;
    for (k, &p) in roots.iter().enumerate() {
        let p = p as usize;
        if let Some((start, first)) = open.filter(|&(start, _)| end < p || p - start >= PIECE as usize) {
            pieces.push(Piece { positions: start..p.min(end), roots: first..k });
            open = None;
        }
        while end < p {
            end = ends.next().unwrap_or(n);
        }
        open = open.or(Some((p, k)));
    }
    if let Some((start, first)) = open {
        pieces.push(Piece { positions: start..end, roots: first..roots.len() });
    }
    pieces
}
