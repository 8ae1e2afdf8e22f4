//! Values that run down a network of cells: each cell adds up what arrives, and hands it on when nothing more can come.
//!
//! # How
//! Bands of rows work side by side. A band works off the cells that wait for none of its neighbours, and what leaves it goes
//! into a letter. In rounds, bands answer the letters they got, in the order of the bands they came from, until so few are
//! left that one thread follows these rivers to their ends. Bands follow from the grid alone, so that the number of threads
//! does not change the order in which a cell's amounts are added, and no byte.
//!
//! # Source
//! Cells that wait for their donors: Kahn's topological sort (1962). Pieces that exchange what crosses their borders: Barnes
//! (2017), Parallel non-divergent flow accumulation for trillion cell digital elevation models, Environmental Modelling &
//! Software 92, 202-212.
//!
//! # Differences
//! Barnes accumulates each piece twice, before and after it knows what comes in; here each cell is worked off once.

use rayon::prelude::*;

/// Letters of a round that are not worth another one.
const FEW: usize = 1024;
/// Mark of a cell that has handed on its value: no cell has so many donors.
const DONE: u8 = u8::MAX;

/// Who gives what to whom, without loops.
pub(super) trait Network: Sync {
    /// What runs down.
    type Value: Copy + Send;

    /// Calls `f` with each receiver of cell `i`.
    fn receivers(&self, i: usize, f: impl FnMut(usize));
    /// Calls `f` with each receiver of cell `i`, in the order of [`Network::receivers`], and what it gets of `value`.
    fn give(&self, i: usize, value: Self::Value, f: impl FnMut(usize, Self::Value));
    /// Adds what arrives in a cell to its value.
    fn take(&self, value: &mut Self::Value, arriving: Self::Value);
}

/// What a cell of another band gets.
type Letter<V> = (u32, V);

/// Lets `values` run down `network`; bands have `cells` cells. `check` is asked now and then whether to stop.
pub(super) fn cascade<N: Network, E: Send>(
    network: &N,
    cells: usize,
    values: &mut [N::Value],
    check: impl Fn() -> Result<(), E> + Sync,
) -> Result<(), E> {
    let mut waiting = donors(network, cells, values.len());
    let mut inbox: Vec<Vec<Letter<N::Value>>> = values.chunks(cells).map(|_| Vec::new()).collect();
    let mut first_round = true;
    loop {
        let bands = waiting.par_chunks_mut(cells).zip(values.par_chunks_mut(cells)).zip(&mut inbox).enumerate();
        let outbox: Vec<Vec<Letter<N::Value>>> = bands
            .map(|(k, ((waiting, values), inbox))| {
                check()?;
                let mut band = Band { network, first: k * cells, waiting, values, ready: Vec::new(), out: Vec::new() };
                if first_round {
                    band.sources();
                }
                inbox.drain(..).for_each(|letter| band.answer(letter));
                Ok(band.out)
            })
            .collect::<Result<_, E>>()?;
        first_round = false;
        if outbox.iter().map(Vec::len).sum::<usize>() <= FEW {
            let mut whole =
                Band { network, first: 0, waiting: &mut waiting, values, ready: Vec::new(), out: Vec::new() };
            outbox.into_iter().flatten().for_each(|letter| whole.answer(letter));
            return Ok(());
        }
        for letter in outbox.into_iter().flatten() {
            inbox[letter.0 as usize / cells].push(letter);
        }
    }
}

/// For each cell from how many it gets something.
fn donors<N: Network>(network: &N, cells: usize, all: usize) -> Vec<u8> {
    let mut donors = vec![0_u8; all];
    let abroad: Vec<Vec<u32>> = donors
        .par_chunks_mut(cells)
        .enumerate()
        .map(|(k, donors)| {
            let (first, mut out) = (k * cells, Vec::new());
            for i in first..first + donors.len() {
                network.receivers(i, |j| match donors.get_mut(j.wrapping_sub(first)) {
                    Some(n) => *n += 1,
                    None => out.push(j as u32),
                });
            }
            out
        })
        .collect();
    abroad.into_iter().flatten().for_each(|j| donors[j as usize] += 1);
    donors
}

/// The cells from number `first` on.
struct Band<'a, N: Network> {
    network: &'a N,
    first: usize,
    /// Donors of each cell that have not given yet.
    waiting: &'a mut [u8],
    values: &'a mut [N::Value],
    /// Cells of the band that wait for nothing, from 0.
    ready: Vec<u32>,
    /// What leaves the band.
    out: Vec<Letter<N::Value>>,
}

impl<N: Network> Band<'_, N> {
    /// Works off the cells without donors, and what comes to wait for nothing thereby.
    fn sources(&mut self) {
        for i in 0..self.waiting.len() {
            if self.waiting[i] == 0 {
                self.run_down(i);
            }
        }
    }

    fn answer(&mut self, (cell, value): Letter<N::Value>) {
        let i = cell as usize - self.first;
        self.network.take(&mut self.values[i], value);
        self.waiting[i] -= 1;
        if self.waiting[i] == 0 {
            self.run_down(i);
        }
    }

    fn run_down(&mut self, start: usize) {
        let Self { network, first, waiting, values, ready, out } = self;
        let mut next = Some(start);
        while let Some(i) = next {
            waiting[i] = DONE;
            next = None;
            network.give(*first + i, values[i], |j, value| {
                let k = j.wrapping_sub(*first);
                if k >= waiting.len() {
                    return out.push((j as u32, value));
                }
                network.take(&mut values[k], value);
                waiting[k] -= 1;
                if waiting[k] == 0
                    && let Some(other) = next.replace(k)
                {
                    ready.push(other as u32);
                }
            });
            next = next.or_else(|| ready.pop().map(|i| i as usize));
        }
    }
}
