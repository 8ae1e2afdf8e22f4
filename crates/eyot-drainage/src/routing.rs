//! Single-receiver routing (D8): every cell hands its water to one of its eight neighbours.
//!
//! # Rule
//! On a surface without depressions, water takes the steepest way down: the neighbour with the largest
//! `(z - z_n) / distance`; of several equally steep ones `place.rs` chooses one, so that the drainage of a turned land is the turned
//! drainage. Flats are crossed towards their lower edge and away from higher ground (`flats.rs`).
//!
//! Single steps follow the nearest of eight directions, so that on a slope between two of them all water runs in one, and land that is
//! cut along those ways learns the grid's directions. [`Descent::Rho8`] counts a diagonal way as one whose length lies between one and
//! two steps, by lot: on a plane the share of diagonal steps is then that of a straight line.
//!
//! # Source
//! O'Callaghan & Mark (1984), The extraction of drainage networks from digital elevation data, CVGIP 28, 323-344. Fairfield & Leymarie
//! (1991), Drainage networks from grid digital elevation models, Water Resources Research 27, 709-717: rho8. Ours: cells that are not
//! square, and the same lot for a cell in every step, so that channels stay where they are.

use super::bands::{band_cells, broad_band_cells};
use super::flats::resolve_flats;
use super::neighbours::{Neighbours, STEPS};
use super::steepest::{NOWHERE, descent};
use super::{Height, check_sizes};
use eyot_core::{Control, Grid, Result};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A drainage network: one receiver a cell, no loops.
#[derive(Clone, Debug, PartialEq)]
pub struct Routing {
    receiver: Vec<u32>,
    direction: Vec<u8>,
    step_m: [f64; 9],
    /// Cells of the bands that accumulation works on.
    band: usize,
}

/// Which way water takes on a slope.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Descent {
    /// The steepest of eight.
    #[default]
    D8,
    /// The steepest of eight with lots for diagonal ways, so that on the whole water runs as the land falls.
    Rho8,
}

/// How water crosses flats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum FlatRule {
    /// Away from higher ground and towards the lower edge, so that it gathers in the middle.
    #[default]
    Gathering,
    /// By a shortest way to the lower edge: along that on which a breadth-first search from the edge came first, edge cells
    /// by number.
    Shortest,
}

impl Routing {
    /// Routes water over `surface`, which has no depressions (see [`fill`](super::fill()) and [`outlets`](super::outlets()))
    /// and is left at `outlets`. A cell that has neither a lower neighbour nor a flat way to one becomes an outlet.
    ///
    /// # Errors
    /// If `surface` or `outlets` has another size than `grid`, the grid has 2^32 cells or more, or on a request to stop.
    pub fn new<T: Height>(surface: &[T], grid: &Grid, outlets: &[bool], control: &Control<'_>) -> Result<Self> {
        Self::with(surface, grid, outlets, Descent::D8, FlatRule::default(), control)
    }

    /// As [`Routing::new`], with another rule for slopes.
    ///
    /// # Errors
    /// As [`Routing::new`].
    pub fn with_descent<T: Height>(
        surface: &[T],
        grid: &Grid,
        outlets: &[bool],
        rule: Descent,
        control: &Control<'_>,
    ) -> Result<Self> {
        Self::with(surface, grid, outlets, rule, FlatRule::default(), control)
    }

    /// As [`Routing::new`], with another rule for flats.
    ///
    /// # Errors
    /// As [`Routing::new`].
    pub fn with_flats<T: Height>(
        surface: &[T],
        grid: &Grid,
        outlets: &[bool],
        rule: FlatRule,
        control: &Control<'_>,
    ) -> Result<Self> {
        Self::with(surface, grid, outlets, Descent::D8, rule, control)
    }

    fn with<T: Height>(
        surface: &[T],
        grid: &Grid,
        outlets: &[bool],
        slopes: Descent,
        flats: FlatRule,
        control: &Control<'_>,
    ) -> Result<Self> {
        check_sizes(grid, &[("surface", surface.len()), ("outlets", outlets.len())])?;
        let mut direction = descent(surface, grid, outlets, slopes, control)?;
        resolve_flats(surface, grid, flats, &mut direction, control)?;

        let near = Neighbours::new(grid);
        let (w, cells) = (grid.width, band_cells(grid));
        let mut step = [0; 9];
        step[..8].copy_from_slice(&STEPS.map(|(dx, dy)| dy * w as isize + dx));
        let mut receiver = vec![0; direction.len()];
        receiver.par_chunks_mut(cells).enumerate().for_each(|(band, receiver)| {
            let first = band * cells;
            for (k, (r, d)) in receiver.iter_mut().zip(&direction[first..]).enumerate() {
                *r = (first + k).wrapping_add_signed(step[usize::from(*d)]) as u32;
            }
            // At the rim a step may wrap.
            for (row, r) in receiver.chunks_exact_mut(w).enumerate() {
                let from = first + row * w;
                let mut exactly = |x: usize| {
                    let d = usize::from(direction[from + x]);
                    r[x] = if d < 8 { near.at(from + x, d).unwrap_or(from + x) } else { from + x } as u32;
                };
                if near.wraps() && (from == 0 || from + w == direction.len()) {
                    (0..w).for_each(&mut exactly);
                }
                exactly(0);
                exactly(w - 1);
            }
        });
        let mut step_m = [0.0; 9];
        step_m[..8].copy_from_slice(&near.distance_m);
        Ok(Self { receiver, direction, step_m, band: broad_band_cells(grid) })
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.receiver.len()
    }

    /// The cell that receives the water of cell `i`; `i` itself at outlets.
    #[inline]
    pub fn receiver(&self, i: usize) -> usize {
        self.receiver[i] as usize
    }

    /// Of each cell, the cell that receives its water; its own number at outlets.
    pub fn receivers(&self) -> &[u32] {
        &self.receiver
    }

    /// Of each cell, the direction of its receiver in [`STEPS`](super::STEPS), 8 at outlets.
    pub fn directions(&self) -> &[u8] {
        &self.direction
    }

    /// By direction, the distance to the receiver, m; 0 at outlets.
    pub fn steps_m(&self) -> [f64; 9] {
        self.step_m
    }

    /// Cells of the bands that accumulation works on.
    pub(super) fn band(&self) -> usize {
        self.band
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

    /// The network of these receivers, with steps of these lengths: 0 to all but outlets, 8 to those. For tests of measures: on no grid.
    #[doc(hidden)]
    pub fn by_hand(receiver: Vec<u32>, step_m: [f64; 9]) -> Self {
        let outlet = |(i, &r): (usize, &u32)| if i == r as usize { NOWHERE } else { 0 };
        let band = receiver.len();
        Self { direction: receiver.iter().enumerate().map(outlet).collect(), receiver, step_m, band }
    }
}
