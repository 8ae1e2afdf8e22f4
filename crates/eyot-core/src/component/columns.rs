//! Columns: what lies over what in each cell, such as strata of rock and soil.
//!
//! Runs of a cell are kept bottom first in slots, and slot `s` of all cells is one plane: what is done to all cells alike goes along
//! planes, in lanes. Unused slots hold zeros.

use super::{Attribute, Component, ComponentKind, Decoder, Encoder, Shape, Table, Values, View};
use crate::error::{Error, Result};
use crate::fingerprint::Fingerprint;
use crate::limits::Limits;
use std::borrow::Cow;
use std::sync::Arc;

/// A stretch of one material in a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Number of the material; what it means is said elsewhere.
    pub material: u8,
    /// How thick it is, m; finite and above 0.
    pub thickness_m: f32,
}

/// For each cell an ordered list of runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    cells: usize,
    slots: usize,
    /// Runs of each cell.
    counts: Vec<u8>,
    /// Plane by plane.
    materials: Vec<u8>,
    thicknesses: Vec<f32>,
}

pub(super) static KIND: ComponentKind = ComponentKind {
    name: "columns",
    version: 1,
    formerly: &[],
    decode: |_, from| Ok(Arc::new(Columns::decode(from)?)),
};

impl Columns {
    /// Runs that a cell can have at most.
    pub const MAX_SLOTS: usize = 64;

    /// Empty columns of `slots` runs at most (1 to [`Columns::MAX_SLOTS`]).
    ///
    /// # Errors
    /// If there can be no such columns, or they exceed the limits.
    pub fn new(cells: usize, slots: usize, limits: &Limits) -> Result<Self> {
        if !(1..=Self::MAX_SLOTS).contains(&slots) {
            let reason = format!("{slots} runs in a column; there can be 1 to {}", Self::MAX_SLOTS);
            return Err(Error::BadParameter { owner: "columns".into(), field: "slots".into(), reason });
        }
        limits.check_bytes("columns of runs", cells as u128 * (1 + 5 * slots as u128))?;
        let all = cells * slots;
        Ok(Self { cells, slots, counts: vec![0; cells], materials: vec![0; all], thicknesses: vec![0.0; all] })
    }

    /// Cells, row by row from the north.
    pub const fn cells(&self) -> usize {
        self.cells
    }

    /// Runs that a cell has room for.
    pub const fn slots(&self) -> usize {
        self.slots
    }

    /// Runs of each cell.
    pub fn counts(&self) -> &[u8] {
        &self.counts
    }

    /// Materials and thicknesses (m) of all cells in a slot; 0 where a cell has fewer runs.
    pub fn plane(&self, slot: usize) -> (&[u8], &[f32]) {
        let cells = slot * self.cells..(slot + 1) * self.cells;
        (&self.materials[cells.clone()], &self.thicknesses[cells])
    }

    /// The runs of a cell, bottom first.
    pub fn runs(&self, cell: usize) -> impl DoubleEndedIterator<Item = Run> + ExactSizeIterator + '_ {
        (0..usize::from(self.counts[cell])).map(move |slot| self.run(cell, slot))
    }

    /// What lies on top of a cell.
    pub fn top(&self, cell: usize) -> Option<Run> {
        self.runs(cell).next_back()
    }

    /// Thickness of all runs of a cell, m.
    pub fn thickness_m(&self, cell: usize) -> f64 {
        self.runs(cell).map(|r| f64::from(r.thickness_m)).sum()
    }

    /// The runs as rows, cell by cell and bottom first: number of the cell, of the run from the bottom, and of the material, height of the
    /// run's bottom over that of the column (m), and thickness (m).
    fn table(&self) -> Result<Table> {
        let rows = self.counts.iter().map(|c| usize::from(*c)).sum();
        let (mut cells, mut numbers) = (Vec::with_capacity(rows), Vec::with_capacity(rows));
        let (mut materials, mut bottoms) = (Vec::with_capacity(rows), Vec::with_capacity(rows));
        let mut thicknesses = Vec::with_capacity(rows);
        for cell in 0..self.cells {
            let mut bottom = 0.0f64;
            for (number, run) in self.runs(cell).enumerate() {
                cells.push(cell as u64);
                numbers.push(number as u8);
                materials.push(run.material);
                bottoms.push(bottom as f32);
                thicknesses.push(run.thickness_m);
                bottom += f64::from(run.thickness_m);
            }
        }
        let column = |name: &str, unit: &str, values| Attribute { name: name.into(), unit: unit.into(), values };
        Table::of(vec![
            column("cell", "1", Values::U64(cells)),
            column("run", "1", Values::U8(numbers)),
            column("material", "1", Values::U8(materials)),
            column("bottom_m", "m", Values::F32(bottoms)),
            column("thickness_m", "m", Values::F32(thicknesses)),
        ])
    }

    /// Thickness of all runs of each cell, m.
    pub fn thicknesses_m(&self) -> Vec<f32> {
        let mut sums = vec![0.0; self.cells];
        for slot in 0..self.slots {
            sums.iter_mut().zip(self.plane(slot).1).for_each(|(sum, t)| *sum += t);
        }
        sums
    }

    /// Lays a run on a cell. Upon the same material it makes the top thicker; where no slot is left, those two neighbours become one
    /// that are thinnest together, of the thicker one's material.
    ///
    /// # Errors
    /// If its thickness is not finite or below 0; nothing is laid for 0.
    pub fn deposit(&mut self, cell: usize, run: Run) -> Result<()> {
        if !(run.thickness_m.is_finite() && run.thickness_m >= 0.0) {
            let reason = format!("a run of {} m", run.thickness_m);
            return Err(Error::BadParameter { owner: "columns".into(), field: "thickness_m".into(), reason });
        }
        if run.thickness_m == 0.0 {
            return Ok(());
        }
        if self.top(cell).is_some_and(|top| top.material == run.material) {
            let top = self.at(cell, usize::from(self.counts[cell]) - 1);
            self.thicknesses[top] = sum(self.thicknesses[top], run.thickness_m);
            return Ok(());
        }
        if self.slots == 1 && self.counts[cell] == 1 {
            // There is nothing but the top to join it with.
            let old = self.run(cell, 0);
            self.set(cell, 0, joined(old, run));
            return Ok(());
        }
        if usize::from(self.counts[cell]) == self.slots {
            self.join_thinnest(cell);
            // The top may be of another material now.
            return self.deposit(cell, run);
        }
        self.set(cell, usize::from(self.counts[cell]), run);
        self.counts[cell] += 1;
        Ok(())
    }

    /// Takes up to `thickness_m` off the top of a cell, hands each piece to `taken`, top first, and returns how much it was.
    pub fn erode(&mut self, cell: usize, thickness_m: f32, mut taken: impl FnMut(Run)) -> f32 {
        let mut left = thickness_m;
        // Summed, and not what was asked less what is left: that would be off by the rounding of the larger number.
        let mut sum = 0.0;
        while left > 0.0
            && let Some(top) = self.top(cell)
        {
            let slot = usize::from(self.counts[cell]) - 1;
            let piece = Run { thickness_m: top.thickness_m.min(left), ..top };
            if left >= top.thickness_m {
                self.set(cell, slot, Run { material: 0, thickness_m: 0.0 });
                self.counts[cell] -= 1;
            } else {
                self.set(cell, slot, Run { thickness_m: top.thickness_m - left, ..top });
            }
            left -= piece.thickness_m;
            sum += f64::from(piece.thickness_m);
            taken(piece);
        }
        (sum as f32).min(thickness_m)
    }

    /// Gives the runs of a material another one, everywhere, and joins what has become the same.
    pub fn replace(&mut self, material: u8, by: u8) {
        for cell in 0..self.cells {
            let changed = self.runs(cell).any(|r| r.material == material);
            if changed {
                for slot in 0..usize::from(self.counts[cell]) {
                    let run = self.run(cell, slot);
                    self.set(
                        cell,
                        slot,
                        Run { material: if run.material == material { by } else { run.material }, ..run },
                    );
                }
                self.join_equal(cell);
            }
        }
    }

    /// Makes one run of neighbours of the same material.
    fn join_equal(&mut self, cell: usize) {
        let mut slot = 1;
        while slot < usize::from(self.counts[cell]) {
            if self.run(cell, slot - 1).material == self.run(cell, slot).material {
                self.join(cell, slot - 1);
            } else {
                slot += 1;
            }
        }
    }

    fn join_thinnest(&mut self, cell: usize) {
        let pair = |slot: usize| self.run(cell, slot).thickness_m + self.run(cell, slot + 1).thickness_m;
        let thinnest = (0..usize::from(self.counts[cell]) - 1).min_by(|a, b| pair(*a).total_cmp(&pair(*b)));
        if let Some(slot) = thinnest {
            self.join(cell, slot);
            // It may now lie between runs of its own material.
            self.join_equal(cell);
        }
    }

    /// Makes one run of those in `slot` and above it.
    fn join(&mut self, cell: usize, slot: usize) {
        let count = usize::from(self.counts[cell]);
        self.set(cell, slot, joined(self.run(cell, slot), self.run(cell, slot + 1)));
        for above in slot + 1..count - 1 {
            self.set(cell, above, self.run(cell, above + 1));
        }
        self.set(cell, count - 1, Run { material: 0, thickness_m: 0.0 });
        self.counts[cell] -= 1;
    }

    fn at(&self, cell: usize, slot: usize) -> usize {
        slot * self.cells + cell
    }

    fn run(&self, cell: usize, slot: usize) -> Run {
        let at = self.at(cell, slot);
        Run { material: self.materials[at], thickness_m: self.thicknesses[at] }
    }

    fn set(&mut self, cell: usize, slot: usize, run: Run) {
        let at = self.at(cell, slot);
        (self.materials[at], self.thicknesses[at]) = (run.material, run.thickness_m);
    }

    fn decode(from: &mut Decoder<'_>) -> Result<Self> {
        let (cells, slots) = (from.count(1)?, usize::from(from.u8()?));
        if cells != from.grid().cells() {
            return Err(from.wrong(format!("columns of {cells} cells on a grid of {}", from.grid().cells())));
        }
        let mut columns = Self::new(cells, slots, from.limits()).map_err(|e| from.wrong(e.to_string()))?;
        columns.counts = from.u8s(cells)?;
        if let Some(cell) = columns.counts.iter().position(|n| usize::from(*n) > slots) {
            return Err(from.wrong(format!("{} runs in cell {cell}, at most {slots} can be", columns.counts[cell])));
        }
        let all: usize = columns.counts.iter().map(|n| usize::from(*n)).sum();
        let (materials, thicknesses) = (from.u8s(all)?, from.f32s(all)?);
        if let Some(t) = thicknesses.iter().find(|t| !(t.is_finite() && **t > 0.0)) {
            return Err(from.wrong(format!("a run of {t} m")));
        }
        let mut runs = materials.into_iter().zip(thicknesses);
        for cell in 0..cells {
            for (slot, (material, thickness_m)) in runs.by_ref().take(usize::from(columns.counts[cell])).enumerate() {
                columns.set(cell, slot, Run { material, thickness_m });
            }
        }
        Ok(columns)
    }
}

/// Both, of the thicker one's material.
fn joined(below: Run, above: Run) -> Run {
    let material = if above.thickness_m > below.thickness_m { above.material } else { below.material };
    Run { material, thickness_m: sum(below.thickness_m, above.thickness_m) }
}

/// Stays finite, as decoding asks of it.
fn sum(a: f32, b: f32) -> f32 {
    (a + b).min(f32::MAX)
}

impl Component for Columns {
    fn kind(&self) -> &'static ComponentKind {
        &KIND
    }

    /// Runs only, cell by cell: most slots of most cells are empty.
    fn encode(&self, out: &mut Encoder<'_>) {
        out.count(self.cells);
        out.u8(self.slots as u8);
        out.bytes(&self.counts);
        (0..self.cells).for_each(|cell| self.runs(cell).for_each(|r| out.u8(r.material)));
        (0..self.cells).for_each(|cell| self.runs(cell).for_each(|r| out.f32(r.thickness_m)));
    }

    fn fingerprint(&self, print: &mut Fingerprint) {
        for cell in 0..self.cells {
            print.word(u64::from(self.counts[cell]));
            for run in self.runs(cell) {
                print.word(u64::from(run.material));
                print.values(&[run.thickness_m]);
            }
        }
    }

    fn bytes(&self) -> usize {
        self.counts.len() + self.materials.len() + size_of_val(&*self.thicknesses)
    }

    fn views(&self) -> &'static [(&'static str, Shape)] {
        &[("", Shape::Table)]
    }

    fn view(&self, name: &str) -> Option<View<'_>> {
        name.is_empty().then(|| self.table().map(|t| View::Table(Cow::Owned(t))).ok()).flatten()
    }
}
