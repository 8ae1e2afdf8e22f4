//! Sweeps a chain of passes over the grid.
//!
//! The grid is cut into bands of rows. First every band runs the whole chain over the rows that need nothing from its neighbours: pass
//! p stops `lag(p)` rows short of the cut. Then the wedges around the cuts are filled in, pass p over the `2 lag(p)` rows that are
//! missing. Bands, and then wedges, touch disjoint rows, so each set runs in parallel without copies and without computing anything
//! twice; inside each, rows are swept as a skewed wave, so that a row stays in cache through all passes of all steps of the chain.

// Reason for the exception: rows of one field are handed to several threads at once, as the schedule allows.
#![allow(unsafe_code)]

use crate::domain::{Domain, End};
use crate::field::RawField;
use crate::grid::{BoundaryCondition, Grid};
use crate::isa::Isa;
use crate::kernel::{Place, ROWS, RowJob};
use crate::lanes::WIDTH;
use crate::layer::{Centering, GhostFill, LayerSpec};
use crate::plan::Pass;
use crate::rule::{MAX_REACH, MAX_READS, MAX_TALLIES, MAX_WRITES};
use crate::schedule::Schedule;
use rayon::prelude::*;
use std::ops::Range;

/// Columns kept valid beyond each end of a row: rules may be evaluated at column -1 and look [`MAX_REACH`] further.
const HALO: usize = MAX_REACH + 1;

/// Where the sums per row lie; a row's sums belong to whoever computes the row.
#[derive(Clone, Copy)]
pub(super) struct SumsPointer(pub(super) *mut f64);
// SAFETY: only an address; the schedule gives each row to one thread at a time.
unsafe impl Send for SumsPointer {}
// SAFETY: as above.
unsafe impl Sync for SumsPointer {}

/// One chain of passes over the grid.
pub(super) struct Sweep<'a> {
    pub(super) isa: Isa,
    pub(super) domain: Domain,
    /// The cells that are held.
    pub(super) grid: Grid,
    pub(super) seed: u64,
    pub(super) passes: &'a [Pass],
    pub(super) schedule: &'a Schedule,
    pub(super) specs: &'a [LayerSpec],
    pub(super) raw: &'a [[Option<RawField>; 2]],
    pub(super) zeros: RawField,
    pub(super) dummy: RawField,
    /// Where the sums of each pass begin, in numbers of sums.
    pub(super) first_sums: Vec<usize>,
    pub(super) sums: SumsPointer,
}

impl Sweep<'_> {
    pub(super) fn run(&self, band: usize) {
        let height = self.grid.height;
        let lag = self.schedule.longest_lag;
        let least = 2 * lag + 2 * MAX_REACH + 1;
        let wraps = self.closes();
        let threads = rayon::current_num_threads();
        // Enough bands that threads finish together, tall enough that wedges stay a small part.
        let wanted = if band > 0 { band } else { (height / (4 * threads)).max(4 * lag) };
        let bands = (height / wanted.max(least)).max(1);
        if wraps && height < least {
            // Too low for wedges on a ring: pass by pass.
            for p in 0..self.schedule.passes.len() {
                self.wave(p..p + 1, 0, |_| (0, height as isize));
            }
            return;
        }
        let cut = |i: usize| (i * height / bands) as isize;
        (0..bands).into_par_iter().for_each(|i| {
            let (a, b) = (cut(i), cut(i + 1));
            self.wave(0..self.schedule.passes.len(), a, |p| {
                let lag = self.schedule.passes[p].lag as isize;
                let low = if i == 0 && !wraps { self.first_row(p) } else { a + lag };
                let high = if i + 1 == bands && !wraps { b } else { b - lag };
                (low, high)
            });
        });
        let wedges = if wraps { 0..bands } else { 1..bands };
        wedges.into_par_iter().for_each(|i| {
            let b = cut(i);
            self.wave(0..self.schedule.passes.len(), b - lag as isize, |p| {
                let lag = self.schedule.passes[p].lag as isize;
                (b - lag, b + lag)
            });
        });
    }

    /// True if the first row follows on the last one.
    fn closes(&self) -> bool {
        self.domain.ends_y()[0] == End::Boundary(BoundaryCondition::Wrap)
    }

    /// Passes that write southern faces also compute the northern rim's faces when that rim is open.
    fn first_row(&self, pass: usize) -> isize {
        let writes = &self.schedule.passes[pass].writes;
        let faces = writes.iter().any(|b| self.specs[b.layer].centering == Centering::FaceY);
        if faces && self.domain.ends_y()[0] == End::Boundary(BoundaryCondition::Open) { -1 } else { 0 }
    }

    /// Sweeps the rows `range(p)` of the passes as a wave that starts at row `start`.
    fn wave(&self, passes: Range<usize>, start: isize, range: impl Fn(usize) -> (isize, isize)) {
        let rows: Vec<(usize, isize, isize, isize)> = passes
            .map(|p| {
                let (low, high) = range(p);
                (p, self.schedule.passes[p].lag as isize, low, high)
            })
            .collect();
        let first = rows.iter().map(|(_, lag, low, _)| low + lag).min().unwrap_or(start);
        let last = rows.iter().map(|(_, lag, _, high)| high + lag).max().unwrap_or(start);
        let closes = self.closes();
        for tick in first..last {
            for &(p, lag, low, high) in &rows {
                let y = tick - lag;
                if low <= y && y < high {
                    self.row(p, if closes { y.rem_euclid(self.grid.height as isize) } else { y });
                }
            }
        }
    }

    fn row(&self, p: usize, y: isize) {
        let (pass, scheduled) = (&self.passes[p], &self.schedule.passes[p]);
        let (g, last) = (&self.grid, self.grid.height as isize - 1);
        let (ends_x, ends_y) = (self.domain.ends_x(), self.domain.ends_y());
        let counted = usize::try_from(y).is_ok_and(|y| self.domain.inside_rows().contains(&y));
        let mut job = RowJob {
            rows: [[std::ptr::null(); ROWS]; MAX_READS],
            out: [std::ptr::null_mut(); MAX_WRITES],
            west_face: [false; MAX_WRITES],
            width: g.width,
            place: Place::new(&self.domain, y),
            counted: if counted { self.domain.inside_columns() } else { 0..0 },
            seed: self.seed,
            step: pass.step,
            open: [false; 4],
            sums: [0.0; MAX_TALLIES],
        };
        for (slot, (buffer, reach)) in scheduled.reads.iter().enumerate() {
            let (spec, raw) = (&self.specs[buffer.layer], self.buffer(buffer.layer, buffer.copy));
            for d in MAX_REACH - reach..=MAX_REACH + reach {
                job.rows[slot][d] = self.row_pointer(raw, spec, y + d as isize - MAX_REACH as isize);
            }
        }
        for (i, buffer) in scheduled.writes.iter().enumerate() {
            let centering = self.specs[buffer.layer].centering;
            job.out[i] = if y < 0 && centering != Centering::FaceY {
                self.dummy.row(i as isize)
            } else {
                self.buffer(buffer.layer, buffer.copy).row(y)
            };
            job.west_face[i] =
                y >= 0 && ends_x[0] == End::Boundary(BoundaryCondition::Open) && centering == Centering::FaceX;
        }
        if counted {
            let open = |end| end == End::Boundary(BoundaryCondition::Open);
            job.open = [open(ends_x[0]), open(ends_x[1]), open(ends_y[0]) && y == 0, open(ends_y[1]) && y == last];
        }
        pass.rule.row(self.isa, &mut job);
        for buffer in &scheduled.writes {
            let spec = &self.specs[buffer.layer];
            if y >= 0 || spec.centering == Centering::FaceY {
                // SAFETY: this row of the written buffers belongs to this call.
                unsafe { finish_row(self.buffer(buffer.layer, buffer.copy).row(y), &self.domain, spec, y) };
            }
        }
        if y >= 0 {
            for i in 0..pass.rule.tallies().len() {
                let place = (self.first_sums[p] + i) * g.height + y as usize;
                // SAFETY: `Arena::provide` made a number for each row of each sum, and this row belongs to this call.
                unsafe { *self.sums.0.add(place) = job.sums[i] };
            }
        }
    }

    fn buffer(&self, layer: usize, copy: usize) -> RawField {
        // `Arena::provide` made what the schedule names.
        self.raw[layer][copy].unwrap_or_else(|| unreachable!("layer {layer} has no copy {copy}"))
    }

    fn row_pointer(&self, raw: RawField, spec: &LayerSpec, y: isize) -> *const f32 {
        let (height, ends) = (self.grid.height as isize, self.domain.ends_y());
        if (0..height).contains(&y)
            || (y == -1 && ends[0] == End::Boundary(BoundaryCondition::Open) && spec.centering == Centering::FaceY)
        {
            return raw.row(y);
        }
        let end = ends[usize::from(y > 0)];
        match (end, beyond(spec, end)) {
            (End::Boundary(BoundaryCondition::Wrap), _) => raw.row(y.rem_euclid(height)),
            (_, GhostFill::Nearest) => raw.row(y.clamp(0, height - 1)),
            (_, GhostFill::Zero) => self.zeros.row(0),
        }
    }
}

/// What rules read beyond an end. Whatever it is where the grid is cut, the halo is for that.
fn beyond(spec: &LayerSpec, end: End) -> GhostFill {
    match end {
        End::Boundary(BoundaryCondition::Open) => spec.beyond_open,
        End::Boundary(_) => spec.beyond_closed,
        End::Cut => GhostFill::Nearest,
    }
}

/// Makes the columns beyond both ends of a row what the rim says, and shuts faces on closed rims.
///
/// # Safety
/// `row` must be column 0 of a row of a `Field` as wide as what the domain holds, and nobody else may be using it.
pub(super) unsafe fn finish_row(row: *mut f32, domain: &Domain, spec: &LayerSpec, y: isize) {
    let (width, height) = domain.held_size();
    let ([west, east], [_, south]) = (domain.ends_x(), domain.ends_y());
    // SAFETY: rows are padded by two blocks of lanes on the left and one block on the right after rounding up.
    let cells = unsafe { std::slice::from_raw_parts_mut(row.sub(WIDTH), WIDTH + width.next_multiple_of(WIDTH) + HALO) };
    let at = |x: isize| (x + WIDTH as isize) as usize;
    if spec.centering == Centering::FaceY
        && south == End::Boundary(BoundaryCondition::Closed)
        && y == height as isize - 1
    {
        cells[at(0)..at(width as isize)].fill(0.0);
    }
    if spec.centering == Centering::FaceX && east == End::Boundary(BoundaryCondition::Closed) {
        cells[at(width as isize - 1)] = 0.0;
    }
    let end = cells.len() - WIDTH;
    if west == End::Boundary(BoundaryCondition::Wrap) {
        for i in 1..=HALO {
            cells[at(-(i as isize))] = cells[at((-(i as isize)).rem_euclid(width as isize))];
        }
        for x in width..end {
            cells[at(x as isize)] = cells[at((x % width) as isize)];
        }
        return;
    }
    let value = |end, nearest: f32| if beyond(spec, end) == GhostFill::Nearest { nearest } else { 0.0 };
    let (before, behind) = (value(west, cells[at(0)]), value(east, cells[at(width as isize - 1)]));
    // Column -1 of an open rim's faces has been computed.
    let computed = usize::from(west == End::Boundary(BoundaryCondition::Open) && spec.centering == Centering::FaceX);
    for i in 1 + computed..=HALO {
        cells[at(-(i as isize))] = before;
    }
    cells[at(width as isize)..].fill(behind);
}
