//! Single-receiver routing (D8): every cell hands its water to one of its eight neighbours.
//!
//! # Rule
//! On a surface without depressions, water takes the steepest way down: the neighbour with the largest
//! `(z - z_n) / distance`; of several equally steep ones the first clockwise from north. Flats are crossed towards their
//! lower edge and away from higher ground (`flats.rs`).
//!
//! # Source
//! O'Callaghan & Mark (1984), The extraction of drainage networks from digital elevation data, CVGIP 28, 323-344.

use super::flats::resolve_flats;
use super::neighbours::Neighbours;
use super::steepest::{NOWHERE, steepest};
use super::{Height, check_sizes};
use eyot_core::{Control, Grid, Result};

/// A drainage network: one receiver a cell, no loops.
#[derive(Clone, Debug, PartialEq)]
pub struct Routing {
    /// The cell that receives a cell's water; its own number at outlets.
    pub receiver: Vec<u32>,
    /// Direction of the receiver in [`STEPS`](super::STEPS), 8 at outlets.
    pub direction: Vec<u8>,
    /// Distance to the receiver by direction, m; 0 for outlets.
    pub step_m: [f64; 9],
}

impl Routing {
    /// Routes water over `surface`, which has no depressions (see [`fill`](super::fill()) and [`outlets`](super::outlets()))
    /// and is left at `outlets`. A cell that has neither a lower neighbour nor a flat way to one becomes an outlet.
    ///
    /// # Errors
    /// If `surface` or `outlets` has another size than `grid`, the grid has 2^32 cells or more, or on a request to stop.
    pub fn new<T: Height>(surface: &[T], grid: &Grid, outlets: &[bool], control: &Control<'_>) -> Result<Self> {
        check_sizes(grid, &[("surface", surface.len()), ("outlets", outlets.len())])?;
        let around = Neighbours::new(grid);
        let mut direction = steepest(surface, grid, &around, outlets, control)?;
        resolve_flats(surface, &around, &mut direction, control)?;
        Ok(Self::from_directions(direction, grid))
    }

    /// The network of `direction` (see [`Routing::direction`]); directions that leave the grid make outlets.
    pub(super) fn from_directions(mut direction: Vec<u8>, grid: &Grid) -> Self {
        let around = Neighbours::new(grid);
        let mut receiver = Vec::with_capacity(direction.len());
        for (i, d) in direction.iter_mut().enumerate() {
            let to = if *d < NOWHERE { around.at(i, usize::from(*d)) } else { None };
            if to.is_none() {
                *d = NOWHERE;
            }
            receiver.push(to.unwrap_or(i) as u32);
        }
        let mut step_m = [0.0; 9];
        step_m[..8].copy_from_slice(&around.distance_m);
        Self { receiver, direction, step_m }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.receiver.len()
    }

    /// True if water leaves the grid at cell `i`.
    #[inline]
    pub fn is_outlet(&self, i: usize) -> bool {
        self.direction[i] == NOWHERE
    }

    /// Distance from cell `i` to its receiver, m; 0 at outlets.
    #[inline]
    pub fn distance_m(&self, i: usize) -> f64 {
        self.step_m[usize::from(self.direction[i])]
    }
}
