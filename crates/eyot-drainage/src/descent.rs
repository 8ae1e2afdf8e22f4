//! Basins of a rough surface: which pit or outlet a marble reaches from each cell.
//!
//! From each cell the marble goes to the lowest cell among itself and its neighbours, of equally low ones to that with the
//! smallest number, so that it also crosses flats and comes to rest somewhere. Each band of rows is labelled on its own,
//! ways that leave a band count as basins for the moment; a table of these joins the bands.

use super::bands::{band_cells, three_rows};
use super::{Height, Neighbours, STEPS};
use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::LaneBlock;
use eyot_core::{Control, Grid, Result};
use rayon::prelude::*;

/// Label of the cells that reach an outlet.
pub(super) const OUTSIDE: u32 = 0;
/// A cell that has no label yet, and a basin that ends in a pit.
const NONE: u32 = u32::MAX;
/// The cell itself among the nine around it, which are numbered row by row.
const HERE: u8 = 4;
/// Added where the way leads across a wrapping rim.
const ACROSS: u8 = 9;
const OUTLET: u8 = u8::MAX;
/// Directions of [`STEPS`] by number among the nine; the middle is no direction.
const DIRECTION: [usize; 9] = [7, 0, 1, 6, 8, 2, 5, 4, 3];
/// Numbers among the nine by direction.
const NINE: [u8; 8] = [1, 2, 5, 8, 7, 6, 3, 0];

/// The label of each cell, and how many labels there are.
pub(super) struct Basins {
    pub(super) label: Vec<u32>,
    pub(super) labels: usize,
}

/// Labels the basins of `z`; cells that reach one of `outlets` get [`OUTSIDE`].
pub(super) fn basins<T: Height>(z: &[T], grid: &Grid, outlets: &[bool], control: &Control<'_>) -> Result<Basins> {
    let (around, isa) = (Neighbours::new(grid), Isa::best());
    let cells = band_cells(grid);
    let mut label = vec![NONE; z.len()];
    let ends: Vec<Vec<u32>> = label
        .par_chunks_mut(cells)
        .enumerate()
        .map(|(band, label)| {
            control.check()?;
            let first = band * cells;
            let mut lowest = vec![HERE; label.len()];
            for (k, row) in lowest.chunks_exact_mut(grid.width).enumerate() {
                let y = first / grid.width + k;
                lowest_in_row(z, grid, &around, y, isa, row);
                let outlets = &outlets[y * grid.width..];
                row.iter_mut().zip(outlets).for_each(|(d, &o)| *d = if o { OUTLET } else { *d });
            }
            Ok(follow(&lowest, first, grid.width, &around, label))
        })
        .collect::<Result<_>>()?;

    // Number the labels of all bands in one row; 0 stays what it is.
    let offset: Vec<u32> = ends.iter().scan(0, |sum, e| Some(std::mem::replace(sum, *sum + e.len() as u32))).collect();
    let number = |cell: u32| match label[cell as usize] {
        OUTSIDE => OUTSIDE,
        l => offset[cell as usize / cells] + l,
    };
    let mut joined = vec![OUTSIDE];
    for end in ends.iter().flatten() {
        joined.push(if *end == NONE { joined.len() as u32 } else { number(*end) });
    }
    for l in 0..joined.len() {
        let mut root = l;
        while joined[root] as usize != root {
            root = joined[root] as usize;
        }
        let mut at = l;
        while at != root {
            at = std::mem::replace(&mut joined[at], root as u32) as usize;
        }
    }
    label.par_chunks_mut(cells).zip(&offset).for_each(|(label, offset)| {
        label.iter_mut().filter(|l| **l != OUTSIDE).for_each(|l| *l = joined[(offset + *l) as usize]);
    });
    Ok(Basins { label, labels: joined.len() })
}

/// For each cell of row `y` the lowest of the nine.
fn lowest_in_row<T: Height>(z: &[T], grid: &Grid, around: &Neighbours, y: usize, isa: Isa, out: &mut [u8]) {
    let w = grid.width;
    let slowly = |x: usize| {
        let i = y * w + x;
        let (mut best, mut number) = ((z[i].key(), i), HERE);
        around.each(i, |d, j| {
            if (z[j].key(), j) < best {
                best = (z[j].key(), j);
                let (dx, dy) = STEPS[d];
                let within = x.checked_add_signed(dx).is_some_and(|x| x < w)
                    && y.checked_add_signed(dy).is_some_and(|y| y < grid.height);
                number = NINE[d] + if within { 0 } else { ACROSS };
            }
        });
        number
    };
    match three_rows(z, grid, y) {
        Some(rows) => {
            run_lanes(isa, Lowest { rows, out: &mut out[1..w - 1] });
            (out[0], out[w - 1]) = (slowly(0), slowly(w - 1));
        }
        _ => out.iter_mut().enumerate().for_each(|(x, o)| *o = slowly(x)),
    }
}

/// The lowest of the nine for the inner cells of a row.
struct Lowest<'a, T> {
    rows: [&'a [T]; 3],
    out: &'a mut [u8],
}

impl<T: Height> LaneTask for Lowest<'_, T> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let n = self.out.len();
        let [north, here, south] = self.rows.map(|r| &r[..n + 2]);
        for x in 0..n {
            let (mut best, mut number) = (north[x], 0_u32);
            let others =
                [north[x + 1], north[x + 2], here[x], here[x + 1], here[x + 2], south[x], south[x + 1], south[x + 2]];
            for k in 0..8 {
                let lower = others[k] < best;
                best = if lower { others[k] } else { best };
                number = if lower { k as u32 + 1 } else { number };
            }
            self.out[x] = number as u8;
        }
    }
}

/// Labels the cells of a band, from 1 on, and returns where each label ends: in a cell of another band or in a pit.
fn follow(lowest: &[u8], first: usize, width: usize, around: &Neighbours, label: &mut [u32]) -> Vec<u32> {
    let step: [isize; 9] = std::array::from_fn(|k| (k as isize / 3 - 1) * width as isize + k as isize % 3 - 1);
    let (mut ends, mut way) = (Vec::new(), Vec::new());
    for start in 0..label.len() {
        if label[start] != NONE {
            continue;
        }
        let mut i = start;
        let found = loop {
            way.push(i as u32);
            let end = match lowest[i] {
                OUTLET => break OUTSIDE,
                HERE => NONE,
                k => {
                    let to = if k < ACROSS {
                        (first + i).wrapping_add_signed(step[usize::from(k)])
                    } else {
                        // A step across the rim was taken to an existing neighbour.
                        around.at(first + i, DIRECTION[usize::from(k - ACROSS)]).unwrap_or(first + i)
                    };
                    match to.checked_sub(first).filter(|&i| i < label.len()) {
                        Some(next) if label[next] != NONE => break label[next],
                        Some(next) => {
                            i = next;
                            continue;
                        }
                        None => to as u32,
                    }
                }
            };
            ends.push(end);
            break ends.len() as u32;
        };
        way.drain(..).for_each(|i| label[i as usize] = found);
    }
    ends
}
