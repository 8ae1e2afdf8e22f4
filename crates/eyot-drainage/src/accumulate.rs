//! What flows together: cells, areas and other amounts upstream of each cell, and an order to visit cells in.

use super::Routing;
use super::cascade::{Network, cascade};
use eyot_core::{Grid, Result};
use std::convert::Infallible;

impl Routing {
    /// All cells, each after its receiver: outlets first. Read backwards, each cell comes before its receiver.
    pub fn order(&self) -> Vec<u32> {
        let mut order = vec![0; self.cells()];
        let mut last = order.len();
        self.walk(|i, _| {
            last -= 1;
            order[last] = i as u32;
        });
        order
    }

    /// For each cell the number of cells that drain through it, itself included. Over all outlets they add up to the
    /// number of cells exactly.
    pub fn upstream_cells(&self) -> Vec<u32> {
        let mut cells = vec![1; self.cells()];
        self.gather(&mut cells, |_, n| n, |sum: &mut u32, n| *sum += n);
        cells
    }

    /// For each cell the area that drains through it, itself included, m2: an exact count times the area of a cell.
    pub fn upstream_area_m2(&self, grid: &Grid) -> Vec<f64> {
        let area = grid.cell_area_m2();
        self.upstream_cells().into_iter().map(|n| f64::from(n) * area).collect()
    }

    /// Adds to each cell's amount those of all cells upstream: with rain (m/s) times area (m2) they become discharge (m3/s).
    ///
    /// # Errors
    /// If there is not one amount for each cell.
    pub fn accumulate(&self, amounts: &mut [f64]) -> Result<()> {
        super::check_length("amounts to accumulate", self.cells(), amounts.len())?;
        self.gather(amounts, |_, a| a, |sum: &mut f64, a| *sum += a);
        Ok(())
    }

    /// For each cell the length of the longest way that water takes to it, m.
    pub fn longest_upstream_m(&self) -> Vec<f64> {
        let mut length = vec![0.0_f64; self.cells()];
        self.gather(&mut length, |i, l| l + self.distance_m(i), |longest, l| *longest = longest.max(l));
        length
    }

    /// For each cell the outlet that its water leaves by.
    pub fn basins(&self) -> Vec<u32> {
        let mut basin = self.receivers().to_vec();
        for i in self.order() {
            basin[i as usize] = basin[self.receiver(i as usize)];
        }
        basin
    }

    /// Replaces each value by what comes of it when all donors have handed on `give(donor, value)`, joined by `take`.
    fn gather<V: Copy + Send>(
        &self,
        values: &mut [V],
        give: impl Fn(usize, V) -> V + Sync,
        take: impl Fn(&mut V, V) + Sync,
    ) {
        let single = Single { routing: self, give, take, value: std::marker::PhantomData };
        let Ok(()) = cascade(&single, self.band(), values, || Ok::<(), Infallible>(()));
    }

    /// Calls `f(cell, receiver)` for all cells, for each after all its donors.
    fn walk(&self, mut f: impl FnMut(usize, usize)) {
        let mut waiting = vec![0_u8; self.cells()];
        for (i, &r) in self.receivers().iter().enumerate() {
            waiting[r as usize] += u8::from(r as usize != i);
        }
        for start in 0..self.cells() {
            if waiting[start] > 0 {
                continue;
            }
            let mut i = start;
            loop {
                let r = self.receiver(i);
                f(i, r);
                if r == i {
                    break;
                }
                waiting[r] -= 1;
                if waiting[r] > 0 {
                    break;
                }
                // A later start is a source from the beginning: cells that reach 0 here get a count that no cell has.
                waiting[r] = u8::MAX;
                i = r;
            }
        }
    }
}

/// A network of single receivers.
struct Single<'a, V, G, T> {
    routing: &'a Routing,
    give: G,
    take: T,
    value: std::marker::PhantomData<fn(V)>,
}

impl<V, G, T> Network for Single<'_, V, G, T>
where
    V: Copy + Send,
    G: Fn(usize, V) -> V + Sync,
    T: Fn(&mut V, V) + Sync,
{
    type Value = V;

    #[inline]
    fn receivers(&self, i: usize, mut f: impl FnMut(usize)) {
        let r = self.routing.receiver(i);
        if r != i {
            f(r);
        }
    }

    #[inline]
    fn give(&self, i: usize, value: V, mut f: impl FnMut(usize, V)) {
        let r = self.routing.receiver(i);
        if r != i {
            f(r, (self.give)(i, value));
        }
    }

    #[inline]
    fn take(&self, value: &mut V, arriving: V) {
        (self.take)(value, arriving);
    }
}
