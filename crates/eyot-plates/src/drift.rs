//! Plates shift by whole cells; where two of them come to lie on a cell, one goes under.
//!
//! Crust is copied and never interpolated, so coasts do not blur however far they drift. Every row of the result is put together
//! from the rows that move into it, without a look at other rows of the result, so threads change nothing.

use crate::geometry::{Geometry, rows_at_once};
use crate::growth::NOBODY;
use crate::meeting::{Contact, Holder, Polarity};
use crate::runs::{Run, equal};
use rayon::prelude::*;

/// The maps that move.
pub(crate) struct Maps {
    pub(crate) owner: Vec<u8>,
    /// Thickness, units.
    pub(crate) crust: Vec<i32>,
    /// Age, Myr.
    pub(crate) age: Vec<f32>,
}

impl Maps {
    pub(crate) fn empty(cells: usize) -> Self {
        Self { owner: vec![NOBODY; cells], crust: vec![0; cells], age: vec![0.0; cells] }
    }
}

/// What happened where plates moved apart and together.
#[derive(Default)]
pub(crate) struct Borders {
    /// Cells that were left, which have no crust yet and belong to the plate that left them.
    pub(crate) gaps: Vec<u32>,
    /// Crust that went under.
    pub(crate) contacts: Vec<Contact>,
}

/// Moves every plate by its shift (columns, rows), each -1, 0 or 1, from `old` to `new`.
pub(crate) fn drift(
    g: &Geometry,
    rows: &[Vec<Run>],
    old: &Maps,
    new: &mut Maps,
    shifts: &[(i8, i8)],
    polarity: &Polarity<'_>,
) -> Borders {
    let width = g.width;
    let lines = new.owner.par_chunks_mut(width).zip(new.crust.par_chunks_mut(width)).zip(new.age.par_chunks_mut(width));
    let borders: Vec<Borders> = lines
        .enumerate()
        .with_min_len(rows_at_once(width))
        .map(|(y, ((owner, crust), age))| {
            owner.fill(NOBODY);
            let mut line = Line { g, y, owner, crust, age, borders: Borders::default(), polarity };
            for dy in [-1i8, 0, 1] {
                let Some(from) = g.row(y as isize - isize::from(dy)) else { continue };
                for run in rows[from].iter().filter(|r| shifts[usize::from(r.owner)].1 == dy) {
                    line.place(old, from * width, run, isize::from(shifts[usize::from(run.owner)].0));
                }
            }
            line.leave(&old.owner[y * width..][..width]);
            line.borders
        })
        .collect();
    let mut all = Borders::default();
    for b in borders {
        all.gaps.extend(b.gaps);
        all.contacts.extend(b.contacts);
    }
    beyond_north_and_south(g, rows, old, shifts, &mut all);
    all
}

/// One row of the result.
struct Line<'a> {
    g: &'a Geometry,
    y: usize,
    owner: &'a mut [u8],
    crust: &'a mut [i32],
    age: &'a mut [f32],
    borders: Borders,
    polarity: &'a Polarity<'a>,
}

impl Line<'_> {
    /// Puts the cells of a run down, `dx` columns further east.
    fn place(&mut self, old: &Maps, row: usize, run: &Run, dx: isize) {
        let (mut from, mut end) = (run.start as usize, run.end as usize);
        // At most one cell at either end leaves the row.
        for (x, edge) in [(from, true), (end - 1, false)] {
            let to = x as isize + dx;
            if (0..self.g.width as isize).contains(&to) || from >= end {
                continue;
            }
            match self.g.column(to) {
                Some(column) => self.put(old, row + x, column, run.owner),
                None => self.lose(old, row + x, x, run.owner, (dx as i8, 0)),
            }
            if edge { from += 1 } else { end -= 1 }
        }
        if from >= end {
            return;
        }
        let to = (from as isize + dx) as usize;
        let length = end - from;
        let mut done = 0;
        while done < length {
            let (source, target) = (row + from + done, to + done);
            let free = equal(&self.owner[target..to + length], NOBODY);
            self.owner[target..target + free].fill(run.owner);
            self.crust[target..target + free].copy_from_slice(&old.crust[source..source + free]);
            self.age[target..target + free].copy_from_slice(&old.age[source..source + free]);
            if done + free < length {
                self.put(old, source + free, target + free, run.owner);
            }
            done += free + 1;
        }
    }

    fn put(&mut self, old: &Maps, from: usize, to: usize, owner: u8) {
        let comes = Holder { owner, crust: old.crust[from], age: old.age[from] };
        let stays = if self.owner[to] == NOBODY {
            comes
        } else {
            let holds = Holder { owner: self.owner[to], crust: self.crust[to], age: self.age[to] };
            let (top, contact) = self.polarity.meet((self.y * self.g.width + to) as u32, holds, comes);
            self.borders.contacts.push(contact);
            top
        };
        (self.owner[to], self.crust[to], self.age[to]) = (stays.owner, stays.crust, stays.age);
    }

    /// The crust of a cell goes over the rim of the grid.
    fn lose(&mut self, old: &Maps, from: usize, x: usize, owner: u8, out: (i8, i8)) {
        let cell = (self.y * self.g.width + x) as u32;
        self.borders.contacts.push(Contact::at_rim(cell, owner, old.crust[from], out));
    }

    /// Cells where nobody is now belong to those who left them.
    fn leave(&mut self, before: &[u8]) {
        for start in (0..self.owner.len()).step_by(64) {
            let part = &self.owner[start..(start + 64).min(self.owner.len())];
            if part.iter().fold(false, |any, &o| any | (o == NOBODY)) {
                for x in start..start + part.len() {
                    if self.owner[x] == NOBODY {
                        (self.owner[x], self.crust[x], self.age[x]) = (before[x], 0, 0.0);
                        self.borders.gaps.push((self.y * self.g.width + x) as u32);
                    }
                }
            }
        }
    }
}

/// Crust that moves over the northern or southern rim.
fn beyond_north_and_south(g: &Geometry, rows: &[Vec<Run>], old: &Maps, shifts: &[(i8, i8)], borders: &mut Borders) {
    for (y, dy) in [(0, -1i8), (g.height - 1, 1)] {
        if g.row(y as isize + isize::from(dy)).is_some() {
            continue;
        }
        for run in rows[y].iter().filter(|r| shifts[usize::from(r.owner)].1 == dy) {
            for x in run.range() {
                let dx = isize::from(shifts[usize::from(run.owner)].0);
                let to = g.column(x as isize + dx).unwrap_or(x);
                let from = y * g.width + x;
                let cell = (y * g.width + to) as u32;
                borders.contacts.push(Contact::at_rim(cell, run.owner, old.crust[from], (0, dy)));
            }
        }
    }
}
