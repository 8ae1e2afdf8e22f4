//! Routing to several receivers: shares of a cell's water for its neighbours, and what flows together.
//!
//! # Rule
//! Shares follow Freeman 1991 (`multiple.rs`) or Tarboton 1997 (`dinf.rs`). Cells without a lower neighbour, on flats, hand
//! everything to their single receiver.
//!
//! # Conserves
//! Whatever a cell hands on adds up to what it has: the largest share gets what the others leave. Areas are counted in
//! millionths of a cell (2^-20), which double precision adds without rounding: over all outlets they add up to the area of
//! the grid exactly.

use super::cascade::{Network, cascade};
use super::dinf::Dinf;
use super::multiple::Multiple;
use super::{Height, Neighbours, Routing, check_length, check_sizes};
use eyot_core::{Control, Error, Grid, Result};

/// How water spreads over several neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// Over all lower neighbours, more to the steeper ones, by a power of the slope.
    Multiple {
        /// The power, 0..=100. 1 spreads most, 1.1 is right on cones, more gathers it in valleys.
        exponent: f64,
    },
    /// Straight down the slope, to the one or two neighbours beside the way.
    Dinf,
}

/// A part of a cell's area that counts: sums of them are exact below 2^53, on every grid that can be routed.
const PARTS_OF_A_CELL: f64 = (1_u32 << 20) as f64;

impl Routing {
    /// For each cell the area that drains through it, itself included, m2. `surface`: the heights that this routing was made
    /// from.
    ///
    /// # Errors
    /// As [`Routing::accumulate_spread`].
    pub fn spread_area_m2<T: Height>(
        &self,
        surface: &[T],
        grid: &Grid,
        spread: Spread,
        control: &Control<'_>,
    ) -> Result<Vec<f64>> {
        let mut parts = vec![PARTS_OF_A_CELL; self.cells()];
        self.run_down(surface, grid, spread, &mut parts, f64::floor, control)?;
        let area = grid.cell_area_m2();
        parts.iter_mut().for_each(|a| *a = *a / PARTS_OF_A_CELL * area);
        Ok(parts)
    }

    /// Adds to each cell's amount its share of what lies upstream. `surface`: the heights that this routing was made from.
    /// See [`Routing::accumulate`] for amounts.
    ///
    /// # Errors
    /// If `surface` or `amounts` has another size than the network, the exponent is not within 0..=100, or on a request to
    /// stop; amounts are then unfinished.
    pub fn accumulate_spread<T: Height>(
        &self,
        surface: &[T],
        grid: &Grid,
        spread: Spread,
        amounts: &mut [f64],
        control: &Control<'_>,
    ) -> Result<()> {
        self.run_down(surface, grid, spread, amounts, |amount| amount, control)
    }

    fn run_down<T: Height>(
        &self,
        z: &[T],
        grid: &Grid,
        spread: Spread,
        amounts: &mut [f64],
        round: fn(f64) -> f64,
        control: &Control<'_>,
    ) -> Result<()> {
        check_sizes(grid, &[("surface", z.len()), ("amounts", amounts.len())])?;
        check_length("cells of the network", grid.cells(), self.cells())?;
        let (near, routing) = (Neighbours::new(grid), self);
        match spread {
            Spread::Multiple { exponent: p } if (0.0..=100.0).contains(&p) => {
                let shares = Multiple { z, near, p };
                cascade(&Spreading { routing, shares, round }, self.band(), amounts, || control.check())
            }
            Spread::Multiple { exponent } => {
                let reason = format!("is {exponent}, it must lie within 0..=100");
                Err(Error::BadParameter { owner: "multiple flow".into(), field: "exponent".into(), reason })
            }
            Spread::Dinf => {
                let shares = Dinf { z, near };
                cascade(&Spreading { routing, shares, round }, self.band(), amounts, || control.check())
            }
        }
    }
}

/// Who gets how much of a cell's water, as long as a neighbour is lower.
pub(super) trait Shares: Sync {
    /// Calls `f` with each receiver of cell `i`.
    fn receivers(&self, i: usize, f: impl FnMut(usize));
    /// Calls `f` with each receiver, in the same order, and its share above 0; shares need not sum to 1.
    fn shares(&self, i: usize, f: impl FnMut(usize, f64));
}

struct Spreading<'a, S> {
    routing: &'a Routing,
    shares: S,
    /// What a share is rounded down to.
    round: fn(f64) -> f64,
}

impl<S: Shares> Network for Spreading<'_, S> {
    type Value = f64;

    #[inline]
    fn receivers(&self, i: usize, mut f: impl FnMut(usize)) {
        let single = self.routing.receiver(i);
        if single == i {
            return;
        }
        let mut none = true;
        self.shares.receivers(i, |j| {
            none = false;
            f(j);
        });
        if none {
            f(single);
        }
    }

    #[inline]
    fn give(&self, i: usize, amount: f64, mut f: impl FnMut(usize, f64)) {
        let single = self.routing.receiver(i);
        if single == i {
            return;
        }
        let (mut to, mut n, mut sum) = ([(single, 1.0); 8], 0, 0.0);
        self.shares.shares(i, |j, share| {
            to[n] = (j, share);
            sum += share;
            n += 1;
        });
        let to = &to[..n.max(1)];
        let largest = (1..n).fold(0, |best, k| if to[k].1 > to[best].1 { k } else { best });
        // Falls beneath the smallest numbers have no shares: then the first neighbour gets everything.
        let part = |share: f64| if sum > 0.0 { (self.round)(amount * (share / sum)) } else { 0.0 };
        let others: f64 = (0..n).filter(|&k| k != largest).map(|k| part(to[k].1)).sum();
        for (k, &(j, share)) in to.iter().enumerate() {
            f(j, if k == largest { amount - others } else { part(share) });
        }
    }

    #[inline]
    fn take(&self, value: &mut f64, arriving: f64) {
        *value += arriving;
    }
}
