//! Runs a rule over one row of cells: in lanes, compiled for several instruction sets, or cell by cell.

// Reason for the exception: this is the hot loop. Rows are read through raw pointers because several rows of several
// layers, old and new, are in use at once and padded so that no index needs a check.
#![allow(unsafe_code)]

use crate::domain::{Domain, cell_number};
use crate::isa::{Isa, LaneTask, run_lanes};
use crate::lanes::{LaneBlock, WIDTH};
use crate::rng::{self, Key};
use crate::rule::{Cell, MAX_REACH, MAX_READS, MAX_TALLIES, MAX_WRITES, ParamSet, Rule, Side, Slot};
use std::ops::Range;

/// Rows around a cell.
pub(crate) const ROWS: usize = 2 * MAX_REACH + 1;

/// One row to compute.
pub(crate) struct RowJob {
    /// Column 0 of rows y - 2 ..= y + 2 of each layer read; unused entries are null.
    pub(crate) rows: [[*const f32; ROWS]; MAX_READS],
    /// Column 0 of row y of each layer written.
    pub(crate) out: [*mut f32; MAX_WRITES],
    /// For each layer written: does it want column -1 as well (a face on an open rim)?
    pub(crate) west_face: [bool; MAX_WRITES],
    /// Columns.
    pub(crate) width: usize,
    /// Where the row lies in the whole grid.
    pub(crate) place: Place,
    /// Columns of which sums are kept: those of the window, in its rows.
    pub(crate) counted: Range<usize>,
    /// Seed of the world and step, for random numbers.
    pub(crate) seed: u64,
    pub(crate) step: u64,
    /// Open sides to look at: west and east of every row, north and south of the first and last.
    pub(crate) open: [bool; 4],
    /// Sums of this row, added to.
    pub(crate) sums: [f64; MAX_TALLIES],
}

/// Where a row lies in the whole grid.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    /// Column of the grid that is column 0 here; may be negative if the row crosses the seam of a ring.
    column: isize,
    /// Row of the grid; -1 for the northern faces of an open rim.
    row: isize,
    /// Columns of the grid.
    width: usize,
    crosses_seam: bool,
}

impl Place {
    /// Of the row that is held as row `y`.
    pub(crate) fn new(domain: &Domain, y: isize) -> Self {
        let (crosses_seam, width) = (domain.crosses_seam(), domain.global().width);
        let first = domain.columns().start as isize - domain.inside_columns().start as isize;
        Self { column: first, row: domain.row(y), width, crosses_seam }
    }

    /// Row of the grid.
    #[inline(always)]
    pub(crate) fn row(&self) -> f32 {
        self.row as f32
    }

    /// Column of the grid that is column `x` here.
    #[inline(always)]
    fn column(&self, x: isize) -> isize {
        let column = self.column + x;
        if self.crosses_seam { column.rem_euclid(self.width as isize) } else { column }
    }

    /// Columns of a block of lanes from `x` on. Not of rows that cross a seam.
    #[inline(always)]
    pub(crate) fn columns<L: LaneBlock>(&self, x: usize) -> L {
        L::of((self.column + x as isize) as f32) + L::index()
    }

    /// Number in the whole grid of the first cell of a block of lanes. Not of rows that cross a seam.
    #[inline(always)]
    pub(crate) fn first_number(&self, x: usize) -> u32 {
        cell_number(self.column + x as isize, self.row, self.width)
    }

    /// The instruction set for this row. A row whose columns do not all follow on each other is computed cell by cell: only halos
    /// have such.
    pub(crate) fn isa(&self, isa: Isa) -> Isa {
        if self.crosses_seam { Isa::Scalar } else { isa }
    }
}

/// Runs `U` over the row.
pub(crate) fn row<U: Rule>(isa: Isa, params: &<U::Params as ParamSet>::Of<f32>, job: &mut RowJob) {
    // What leaves is computed from the old state, so it comes before the row, which may overwrite it.
    if job.open.iter().any(|&o| o) {
        leave::<U>(params, job);
    }
    if job.west_face.iter().any(|&f| f) {
        west_faces::<U>(params, job);
    }
    match job.place.isa(isa) {
        Isa::Scalar => scalar_row::<U>(params, job),
        _ => run_lanes(isa, LaneRow::<U> { params, job }),
    }
}

struct LaneRow<'a, U: Rule> {
    params: &'a <U::Params as ParamSet>::Of<f32>,
    job: &'a mut RowJob,
}

impl<U: Rule> LaneTask for LaneRow<'_, U> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        lanes_body::<L, U>(self.params, self.job);
    }
}

struct LaneCell<'a> {
    rows: &'a [[*const f32; ROWS]; MAX_READS],
    x: usize,
    place: &'a Place,
    seed: u64,
    step: u64,
}

impl<L: LaneBlock> Cell<L> for LaneCell<'_> {
    #[inline(always)]
    fn at(&self, slot: Slot, dx: isize, dy: isize) -> L {
        let row = self.rows[slot][(dy + MAX_REACH as isize) as usize];
        // SAFETY: rows are padded by at least a block of lanes on both sides (`Field`), and dx is at most MAX_REACH.
        L::from_array(unsafe { row.add(self.x).offset(dx).cast::<[f32; WIDTH]>().read_unaligned() })
    }
    #[inline(always)]
    fn x(&self) -> L {
        self.place.columns(self.x)
    }
    #[inline(always)]
    fn y(&self) -> L {
        L::of(self.place.row())
    }
    #[inline(always)]
    fn uniform(&self, stream: u32) -> L {
        let first = self.place.first_number(self.x);
        let mut cells = [0; WIDTH];
        let mut i = 0;
        while i < WIDTH {
            cells[i] = first.wrapping_add(i as u32);
            i += 1;
        }
        rng::unit(rng::hash(Key::new(self.seed, stream, self.step), L::bits_from_array(cells)))
    }
}

#[inline(always)]
fn lanes_body<L: LaneBlock, U: Rule>(params: &<U::Params as ParamSet>::Of<f32>, job: &mut RowJob) {
    let p = U::Params::map(params, |_, v| L::of(v));
    let (rows, out, width, place) = (job.rows, job.out, job.width, job.place);
    let (first, end) = (job.counted.start, job.counted.end as isize);
    let mut sums = [L::of(0.0); MAX_TALLIES];
    let mut x = 0;
    while x < width {
        let c = LaneCell { rows: &rows, x, place: &place, seed: job.seed, step: job.step };
        let (values, summands) = U::cell::<L>(&p, &c);
        for (i, v) in values.as_ref().iter().enumerate() {
            // SAFETY: as for reading; the schedule gives this row of the written layer to this job alone.
            unsafe { out[i].add(x).cast::<[f32; WIDTH]>().write_unaligned(v.to_array()) };
        }
        // Lanes beyond the last column hold nothing of this world.
        let live = L::of((end - x as isize) as f32);
        for (sum, v) in sums.iter_mut().zip(summands.as_ref()) {
            *sum = *sum + L::index().lt(live).pick(*v, L::of(0.0));
        }
        if !U::TALLIES.is_empty() && x < first {
            forget(&mut sums[..U::TALLIES.len()], first - x);
        }
        x += WIDTH;
    }
    for (total, sum) in job.sums.iter_mut().zip(&sums).take(U::TALLIES.len()) {
        *total += sum.to_array().iter().map(|&v| f64::from(v)).sum::<f64>();
    }
}

/// Makes the sums of all lanes before `first` zero: those of cells west of the window.
#[inline(always)]
pub(crate) fn forget<L: LaneBlock>(sums: &mut [L], first: usize) {
    for sum in sums {
        *sum = L::index().lt(L::of(first as f32)).pick(L::of(0.0), *sum);
    }
}

/// One cell of a row.
pub(crate) struct ScalarCell<'a> {
    rows: &'a [[*const f32; ROWS]; MAX_READS],
    x: isize,
    place: Place,
    seed: u64,
    step: u64,
}

impl Cell<f32> for ScalarCell<'_> {
    #[inline(always)]
    fn at(&self, slot: Slot, dx: isize, dy: isize) -> f32 {
        let row = self.rows[slot][(dy + MAX_REACH as isize) as usize];
        // SAFETY: as for lanes; x is at least -1.
        unsafe { *row.offset(self.x + dx) }
    }
    #[inline(always)]
    fn x(&self) -> f32 {
        self.place.column(self.x) as f32
    }
    #[inline(always)]
    fn y(&self) -> f32 {
        self.place.row()
    }
    #[inline(always)]
    fn uniform(&self, stream: u32) -> f32 {
        let cell = cell_number(self.place.column(self.x), self.place.row, self.place.width);
        rng::unit::<f32>(rng::hash(Key::new(self.seed, stream, self.step), cell))
    }
}

impl RowJob {
    pub(crate) fn cell(&self, x: isize) -> ScalarCell<'_> {
        ScalarCell { rows: &self.rows, x, place: self.place, seed: self.seed, step: self.step }
    }
}

fn scalar_row<U: Rule>(params: &<U::Params as ParamSet>::Of<f32>, job: &mut RowJob) {
    // Sums are kept in sixteen parts as in lanes, so that the bits agree.
    let mut sums = [[0.0f32; WIDTH]; MAX_TALLIES];
    for x in 0..job.width {
        let (values, summands) = U::cell::<f32>(params, &job.cell(x as isize));
        for (i, v) in values.as_ref().iter().enumerate() {
            // SAFETY: as in `lanes_body`.
            unsafe { *job.out[i].add(x) = *v };
        }
        for (sum, v) in sums.iter_mut().zip(summands.as_ref()).filter(|_| job.counted.contains(&x)) {
            sum[x % WIDTH] += v;
        }
    }
    for (total, sum) in job.sums.iter_mut().zip(&sums).take(U::TALLIES.len()) {
        *total += sum.iter().map(|&v| f64::from(v)).sum::<f64>();
    }
}

#[inline(never)]
fn west_faces<U: Rule>(params: &<U::Params as ParamSet>::Of<f32>, job: &RowJob) {
    let (values, _) = U::cell::<f32>(params, &job.cell(-1));
    for (i, v) in values.as_ref().iter().enumerate().filter(|(i, _)| job.west_face[*i]) {
        // SAFETY: column -1 is padding of the row that belongs to this job.
        unsafe { *job.out[i].offset(-1) = *v };
    }
}

#[inline(never)]
fn leave<U: Rule>(params: &<U::Params as ParamSet>::Of<f32>, job: &mut RowJob) {
    leave_by(job, |cell, side| U::boundary_outflow::<f32>(params, cell, side));
}

/// Adds what leaves through the open sides to the sums of the row.
pub(crate) fn leave_by<S: AsRef<[f32]>>(
    job: &mut RowJob,
    boundary_outflow: impl Fn(&ScalarCell<'_>, Side) -> Option<S>,
) {
    for (side, open) in Side::ALL.into_iter().zip(job.open) {
        let columns = match side {
            Side::West => 0..1,
            Side::East => job.width - 1..job.width,
            Side::North | Side::South => job.counted.clone(),
        };
        let counted = job.counted.clone();
        for x in columns.filter(|x| open && counted.contains(x)) {
            let Some(summands) = boundary_outflow(&job.cell(x as isize), side) else { return };
            for (total, v) in job.sums.iter_mut().zip(summands.as_ref()) {
                *total += f64::from(*v);
            }
        }
    }
}
