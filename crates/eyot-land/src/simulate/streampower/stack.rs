//! The order in which an implicit step visits cells: upstream from the outlets, each subtree in one piece.
//!
//! # Source
//! The stack of Braun and Willett 2013. Here positions follow from the sizes of subtrees, without recursion, and what
//! lies between the large rivers falls apart into pieces that are worked on in parallel.

use crate::drainage::Routing;
use rayon::prelude::*;
use std::ops::Range;

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

impl Stack {
    pub(super) fn new(routing: &Routing) -> Self {
        let n = routing.cells();
        let receiver = routing.receivers();
        let (mut upstream, mut order) = (vec![1_u32; n], vec![0_u32; n]);
        let mut last = n;
        routing.walk(|i, r| {
            last -= 1;
            order[last] = i as u32;
            if i != r {
                upstream[r] += upstream[i];
            }
        });
        // Of each cell its position, and the position where its next donor goes.
        let mut places = vec![(0_u32, 0_u32); n];
        let mut cell = vec![0_u32; n];
        let (mut rivers, mut roots, mut free) = (Vec::new(), Vec::new(), 0);
        for &i in &order {
            let (c, size) = (i as usize, upstream[i as usize]);
            let r = receiver[c] as usize;
            let place = if r == c { &mut free } else { &mut places[r].1 };
            let p = *place;
            *place += size;
            places[c] = (p, p + 1);
            cell[p as usize] = i;
            if size > PIECE {
                rivers.push(p);
            } else if r == c || upstream[r] > PIECE {
                roots.push(p);
            }
        }
        // The order is not needed any more.
        let mut below = order;
        below.par_iter_mut().zip(&cell).for_each(|(b, &i)| {
            let r = receiver[i as usize];
            *b = if r == i { OUTLET } else { places[r as usize].0 };
        });
        let position = places.into_par_iter().map(|p| p.0).collect();
        roots.sort_unstable();
        let pieces = pieces(&rivers, &roots, n);
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
        let (mut rest, mut at) = (values, 0);
        let mut work = Vec::with_capacity(self.pieces.len());
        for piece in &self.pieces {
            let (_, from) = std::mem::take(&mut rest).split_at_mut(piece.positions.start - at);
            let (own, after) = from.split_at_mut(piece.positions.len());
            work.push((piece, own));
            (rest, at) = (after, piece.positions.end);
        }
        work.into_par_iter().for_each(|(piece, values)| {
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
