//! The CPU engine: runs plans on all cores.
//!
//! Several steps make one chain of passes. The grid is cut into bands of rows. First every band runs the whole chain
//! over the rows that need nothing from its neighbours: pass p stops `lag(p)` rows short of the cut. Then the wedges
//! around the cuts are filled in, pass p over the `2 lag(p)` rows that are missing. Bands, and then wedges, touch
//! disjoint rows, so each set runs in parallel without copies and without computing anything twice; inside each, rows
//! are swept as a skewed wave, so that a row stays in cache through all passes of all steps of the chain.
//!
//! Every cell's value is a pure function of the plan, so bands, chains and threads never change a bit. Nor do they change
//! a sum: each pass keeps its own per row, which are folded in a fixed order and added to the ledger's accounts in the
//! order of the plan, so that it does not matter either where a simulation is cut into spans.

// Reason for the exception: rows of one field are handed to several threads at once, as the schedule allows.
#![allow(unsafe_code)]

use crate::component::Components;
use crate::control::Control;
use crate::error::Result;
use crate::field::{Field, RawField, STAGGERS};
use crate::grid::{Edge, Grid};
use crate::isa::Isa;
use crate::kernel::{ROWS, RowJob};
use crate::lanes::WIDTH;
use crate::layer::{Beyond, LayerSpec, Stagger};
use crate::ledger::Ledger;
use crate::limits::Limits;
use crate::plan::{Pass, Plan};
use crate::process::{self, Moment, Scheduled, Span, may_fail, plan_step};
use crate::rule::{MAX_REACH, MAX_READS, MAX_TALLIES, MAX_WRITES, Tally, TallyUnit};
use crate::schedule::{Buffer, Schedule};
use crate::world::World;
use rayon::prelude::*;
use std::ops::Range;

/// Columns kept valid beyond each end of a row: rules may be evaluated at column -1 and look [`MAX_REACH`] further.
const HALO: usize = MAX_REACH + 1;

/// Executes plans on the cores of the current rayon pool.
#[derive(Clone, Copy, Debug)]
pub struct CpuEngine {
    /// Instruction set.
    pub isa: Isa,
    /// Steps run as one chain; 0 chooses.
    pub chain: usize,
    /// Rows of a band; 0 chooses. Raised to what the chain's lag needs.
    pub band: usize,
    /// Bounds on what may be allocated.
    pub limits: Limits,
}

impl Default for CpuEngine {
    fn default() -> Self {
        Self { isa: Isa::best(), chain: 0, band: 0, limits: Limits::default() }
    }
}

/// Memory of a simulation at its peak.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// Fields of the grid's size: layers, scratch layers, second copies, and copies to go back to where something acts that
    /// can fail.
    pub fields: usize,
    /// What actions hold beside them, some of it between their turns, too; bytes per cell.
    pub action_bytes_per_cell: usize,
}

impl Need {
    /// What simulating these processes needs on a world that has `layers` layers, those of the processes included.
    pub fn of(grid: &Grid, layers: usize, processes: &[Scheduled]) -> Self {
        let mut plan = Plan::default();
        let mut moment = Moment { grid: *grid, step: 0, turn: 0, sea_level_m: 0.0 };
        plan_step(processes, 0, &mut moment, &mut plan);
        let actions: Vec<_> = processes.iter().filter_map(|s| s.process.action()).collect();
        let copies = if actions.iter().any(|a| !a.cannot_fail()) { layers } else { 0 };
        let fields = layers + plan.scratch_layers().len() + plan.doubled_layers().len() + copies;
        Self { fields, action_bytes_per_cell: actions.iter().map(|a| a.bytes_per_cell()).sum() }
    }

    /// All of it on a grid, bytes.
    pub fn bytes(&self, grid: &Grid) -> u128 {
        let action = self.action_bytes_per_cell as u128 * grid.cells() as u128;
        Field::bytes_of(grid.width, grid.height) * self.fields as u128 + action
    }
}

impl CpuEngine {
    /// Runs a span of steps of the given processes on the world.
    ///
    /// # Errors
    /// If a parameter does not fit the world or memory would exceed the limits (before the first step), on a request to
    /// stop (the world is then in the state after the last whole step; `world.step` tells which), and if a value that is
    /// not finite turns up.
    pub fn simulate(
        &self,
        world: &mut World,
        processes: &[Scheduled],
        span: Span,
        control: &Control<'_>,
    ) -> Result<()> {
        process::prepare(world, processes, &self.limits)?;
        let need = Need::of(&world.grid, world.layers().len(), processes);
        self.limits.check_bytes("this simulation", need.bytes(&world.grid))?;
        let mut arena = Arena::new(world);
        let mut first = Plan::default();
        let mut moment = Moment { grid: world.grid, step: world.step, turn: 0, sea_level_m: world.sea_level_m };
        plan_step(processes, 0, &mut moment, &mut first);
        let chain = self.chain_length(&world.grid, first.passes.len());
        let mut done = 0;
        let mut outcome = control.check();
        while done < span.steps && outcome.is_ok() {
            let at = span.from + done;
            let most = chain.min(span.steps - done);
            // A step that may have to be taken back is no link of a chain.
            let before = may_fail(processes, at).then(|| arena.save(world));
            let most = if before.is_some() { 1 } else { most };
            let steps = (1..most).find(|i| may_fail(processes, at + i)).unwrap_or(most);
            outcome = self.steps(&mut arena, world, processes, at..at + steps, control);
            match (&outcome, before) {
                (Ok(()), _) => {
                    done += steps;
                    outcome = control.tick(done, span.steps);
                }
                (Err(_), Some(saved)) => arena.restore(world, saved),
                (Err(_), None) => {}
            }
        }
        arena.give_back(world);
        world.check_finite(&format!("step {}", world.step))?;
        outcome
    }

    /// Runs the passes of a plan once, outside of any step.
    ///
    /// # Errors
    /// If memory would exceed the limits or a pass names a layer that is not there; then nothing has changed.
    pub fn apply(&self, world: &mut World, plan: &Plan) -> Result<()> {
        let fields = world.layers().len() + plan.scratch_layers().len() + plan.doubled_layers().len();
        let need = Need { fields, action_bytes_per_cell: 0 };
        self.limits.check_bytes("the start values of a layer", need.bytes(&world.grid))?;
        let mut arena = Arena::new(world);
        let outcome = arena.run(self, plan, &world.ledger);
        arena.give_back(world);
        outcome
    }

    /// Some steps as one chain, which only actions interrupt. On an error the passes before it have been done and the clock has not
    /// moved; who acts and may fail therefore needs a copy to go back to.
    fn steps(
        &self,
        arena: &mut Arena,
        world: &mut World,
        processes: &[Scheduled],
        steps: Range<u64>,
        control: &Control<'_>,
    ) -> Result<()> {
        let mut moment = Moment { grid: world.grid, step: world.step, turn: 0, sea_level_m: world.sea_level_m };
        let control = &control.within(self.limits);
        let mut plan = Plan::default();
        for step in steps {
            for s in processes.iter().filter(|s| s.is_due(step)) {
                s.plan(step, &mut moment, &mut plan);
                if let Some(action) = s.process.action() {
                    arena.run(self, &std::mem::take(&mut plan), &world.ledger)?;
                    arena.lend(world, &s.process.layers(), |world| action.act(&moment, world, control))?;
                }
                s.process.advance(&mut moment);
            }
            moment.step += 1;
        }
        // Nothing can stop the passes after the last action.
        arena.run(self, &plan, &world.ledger)?;
        (world.step, world.sea_level_m) = (moment.step, moment.sea_level_m);
        Ok(())
    }

    /// Steps of a chain for plans of so many passes a step.
    fn chain_length(&self, grid: &Grid, passes: usize) -> u64 {
        let passes = passes.max(1) as u64;
        match self.chain {
            // Measured (docs/performance.md): for two passes a step, two steps when all layers fit the last cache and four
            // when they do not; a single pass needs twice as many to keep its rows in cache as long.
            0 if grid.cells() <= 1 << 19 => (4 / passes).max(2),
            0 => (8 / passes).max(4),
            n => n as u64,
        }
    }
}

/// A world before a step: layers and ledger.
struct Saved {
    fields: Vec<Field>,
    ledger: Ledger,
    components: Components,
}

/// Buffers of a simulation: two copies of each layer as needed, scratch layers, sums.
struct Arena {
    grid: Grid,
    seed: u64,
    specs: Vec<LayerSpec>,
    /// Layers of the world come first, scratch layers after them.
    world_layers: usize,
    fields: Vec<[Option<Field>; 2]>,
    current: Vec<usize>,
    zeros: Field,
    dummy: Field,
    /// The accounts of all sums so far and what is in them.
    accounts: Vec<(Tally, f64)>,
    /// Sums per row: for each pass of a chain, for each of its sums, all rows.
    sums: Vec<f64>,
}

impl Arena {
    /// Takes the world's fields, which [`Arena::give_back`] puts back.
    fn new(world: &mut World) -> Self {
        let g = world.grid;
        let specs: Vec<LayerSpec> = world.layers().iter().map(|l| l.spec.clone()).collect();
        let mut arena = Self {
            grid: g,
            seed: world.seed,
            current: vec![0; specs.len()],
            world_layers: specs.len(),
            fields: vec![[const { None }; 2]; specs.len()],
            zeros: Field::new(g.width, 1, 0.0),
            dummy: Field::new(g.width, MAX_WRITES, 0.0),
            accounts: Vec::new(),
            sums: Vec::new(),
            specs,
        };
        arena.take(world);
        arena
    }

    /// Takes the world's fields and makes their padding what the rim says.
    fn take(&mut self, world: &mut World) {
        let mut taken = Staggers::default();
        for (l, layer) in world.layers_mut().iter_mut().enumerate().take(self.world_layers) {
            let mut field = std::mem::replace(&mut layer.field, Field::new(0, 0, 0.0));
            // Fields that were put into the world may all have the same one.
            let stagger = taken.this_or_free(field.stagger());
            if stagger != field.stagger() {
                field = field.restaggered(stagger);
            }
            self.finish(&self.specs[l], &mut field);
            self.fields[l][self.current[l]] = Some(field);
        }
    }

    /// Makes the padding of a layer what the rim says.
    fn finish(&self, spec: &LayerSpec, field: &mut Field) {
        // Faces north of an open rim are a row of their own.
        let first = if spec.stagger == Stagger::FaceY && self.grid.rim.y == Edge::Open { -1 } else { 0 };
        for y in first..self.grid.height as isize {
            // SAFETY: this thread owns the field.
            unsafe { finish_row(field.raw().row(y), &self.grid, spec, y) };
        }
    }

    /// Runs a plan: as one chain, or as several if its lag would leave the bands too low. If it fails, nothing has changed.
    fn run(&mut self, engine: &CpuEngine, plan: &Plan, ledger: &Ledger) -> Result<()> {
        for spec in plan.scratch_layers() {
            debug_assert!(
                self.specs.iter().skip(self.world_layers).all(|s| s.name != spec.name || s == spec),
                "two kinds of scratch layer `{}`",
                spec.name
            );
            if !self.specs.iter().any(|s| s.name == spec.name) {
                self.specs.push(spec.clone());
                self.fields.push([None, None]);
                self.current.push(0);
            }
        }
        let most_lag = (self.grid.height / (8 * rayon::current_num_threads())).clamp(4, 64);
        let mut chains = Vec::new();
        let (mut passes, mut current) = (&plan.passes[..], self.current.clone());
        while !passes.is_empty() {
            let schedule = Schedule::new(passes, &self.specs, &current, most_lag)?;
            let (now, later) = passes.split_at(schedule.passes.len());
            current.clone_from(&schedule.current);
            chains.push((now, schedule));
            passes = later;
        }
        // All of it before the first pass: a world must not be left in the middle of a step.
        self.provide(&chains);
        for (passes, schedule) in chains {
            self.sweep(engine, passes, &schedule);
            self.post(passes, ledger);
            self.current = schedule.current;
        }
        Ok(())
    }

    /// Makes what the schedules need and is not there yet: scratch layers, second copies, sums.
    fn provide(&mut self, chains: &[(&[Pass], Schedule)]) {
        let mut missing: Vec<Buffer> = Vec::new();
        for p in chains.iter().flat_map(|(_, s)| &s.passes) {
            for b in p.writes.iter().chain(p.reads.iter().map(|r| &r.0)) {
                if self.fields[b.layer][b.copy].is_none() && !missing.contains(b) {
                    missing.push(*b);
                }
            }
        }
        let sums = chains.iter().map(|(passes, _)| count_sums(passes)).max().unwrap_or(0) * self.grid.height;
        let mut taken = Staggers::default();
        self.fields.iter().flatten().flatten().for_each(|f| taken.0[f.stagger()] += 1);
        for b in missing {
            let field = Field::staggered(self.grid.width, self.grid.height, 0.0, taken.free());
            self.fields[b.layer][b.copy] = Some(field);
        }
        self.sums.resize(self.sums.len().max(sums), 0.0);
    }

    fn sweep(&mut self, engine: &CpuEngine, passes: &[Pass], schedule: &Schedule) {
        let raw: Vec<[Option<RawField>; 2]> = self
            .fields
            .iter_mut()
            .map(|pair| [pair[0].as_mut().map(Field::raw), pair[1].as_mut().map(Field::raw)])
            .collect();
        let mut first = 0;
        let starts = passes.iter().map(|p| {
            first += p.rule.tallies().len();
            first - p.rule.tallies().len()
        });
        let first_sums = starts.collect();
        let sweep = Sweep {
            isa: engine.isa,
            grid: self.grid,
            seed: self.seed,
            passes,
            schedule,
            specs: &self.specs,
            raw: &raw,
            zeros: self.zeros.raw(),
            dummy: self.dummy.raw(),
            first_sums,
            sums: SumsPointer(self.sums.as_mut_ptr()),
        };
        sweep.run(engine.band);
    }

    /// Adds the sums of a chain that has run to the accounts.
    fn post(&mut self, passes: &[Pass], ledger: &Ledger) {
        let area = self.grid.cell_area_m2();
        let mut rows = self.sums.chunks_exact(self.grid.height);
        for t in passes.iter().flat_map(|p| p.rule.tallies()) {
            let sum = fold(rows.next().unwrap_or_default());
            let amount = match t.unit {
                TallyUnit::Thickness => sum * area,
                TallyUnit::Count => sum,
            };
            match self.accounts.iter_mut().find(|(k, _)| k.account == t.account) {
                Some((_, total)) => *total += amount,
                None => self.accounts.push((*t, ledger.amount(t.account) + amount)),
            }
        }
    }

    /// Lends the world its layers while `f` works on it, which changes none but those in `changes`.
    fn lend(
        &mut self,
        world: &mut World,
        changes: &[(LayerSpec, f32)],
        f: impl FnOnce(&mut World) -> Result<()>,
    ) -> Result<()> {
        let staggers: Vec<usize> = self.world_fields().map(Field::stagger).collect();
        self.put_back(world);
        self.settle(world);
        let outcome = f(world);
        let sound = world.layers().len() == self.world_layers
            && world
                .layers()
                .iter()
                .all(|l| (l.field.width(), l.field.height()) == (self.grid.width, self.grid.height));
        assert!(sound, "an action changed what layers there are, or their size");
        for (l, layer) in world.layers_mut().iter_mut().enumerate() {
            let mut field = std::mem::replace(&mut layer.field, Field::new(0, 0, 0.0));
            if field.stagger() != staggers[l] {
                field = field.restaggered(staggers[l]);
            }
            // The padding of the others is what it was, and there are too many rows to look at for nothing.
            if changes.iter().any(|(spec, _)| spec.name == self.specs[l].name) {
                self.finish(&self.specs[l], &mut field);
            }
            self.fields[l][self.current[l]] = Some(field);
        }
        outcome
    }

    /// What [`Arena::restore`] needs.
    fn save(&mut self, world: &mut World) -> Saved {
        self.settle(world);
        Saved {
            fields: self.world_fields().cloned().collect(),
            ledger: world.ledger.clone(),
            components: world.components.clone(),
        }
    }

    /// Takes back everything since `saved`.
    fn restore(&mut self, world: &mut World, saved: Saved) {
        for (l, mut field) in saved.fields.into_iter().enumerate() {
            self.finish(&self.specs[l], &mut field);
            self.fields[l][self.current[l]] = Some(field);
        }
        self.accounts.clear();
        (world.ledger, world.components) = (saved.ledger, saved.components);
    }

    /// The current copies of the world's layers.
    fn world_fields(&self) -> impl Iterator<Item = &Field> {
        (0..self.world_layers).filter_map(|l| self.fields[l][self.current[l]].as_ref())
    }

    /// Puts the fields back into the world.
    fn put_back(&mut self, world: &mut World) {
        for (l, layer) in world.layers_mut().iter_mut().enumerate().take(self.world_layers) {
            if let Some(f) = self.fields[l][self.current[l]].take() {
                layer.field = f;
            }
        }
    }

    /// Puts the fields back into the world and the sums into its ledger.
    fn give_back(mut self, world: &mut World) {
        self.put_back(world);
        self.settle(world);
    }

    /// Writes the sums to the ledger.
    fn settle(&mut self, world: &mut World) {
        for (t, total) in self.accounts.drain(..) {
            let unit = match t.unit {
                TallyUnit::Thickness => "m3",
                TallyUnit::Count => "1",
            };
            world.ledger.set(t.account, total, unit, t.meaning, t.sign);
        }
    }
}

fn count_sums(passes: &[Pass]) -> usize {
    passes.iter().map(|p| p.rule.tallies().len()).sum()
}

/// The sum of all rows: every fourth from the north, then the four of them. One sum after the other would wait for each.
fn fold(rows: &[f64]) -> f64 {
    let mut parts = [0.0; 4];
    for four in rows.chunks(4) {
        parts.iter_mut().zip(four).for_each(|(p, v)| *p += v);
    }
    (parts[0] + parts[1]) + (parts[2] + parts[3])
}

/// How many buffers have each stagger. Buffers of one simulation get different ones as long as there are any.
#[derive(Default)]
struct Staggers([usize; STAGGERS]);

impl Staggers {
    /// The first of those that the fewest have; now one more has it.
    fn free(&mut self) -> usize {
        let least = (0..STAGGERS).min_by_key(|&i| self.0[i]).unwrap_or(0);
        self.0[least] += 1;
        least
    }

    /// `wanted` if nobody has it or nothing better is left, else a free one; now one more has it.
    fn this_or_free(&mut self, wanted: usize) -> usize {
        if self.0[wanted] == 0 || self.0.iter().all(|&n| n > 0) {
            self.0[wanted] += 1;
            return wanted;
        }
        self.free()
    }
}

/// Where the sums per row lie; a row's sums belong to whoever computes the row.
#[derive(Clone, Copy)]
struct SumsPointer(*mut f64);
// SAFETY: only an address; the schedule gives each row to one thread at a time.
unsafe impl Send for SumsPointer {}
// SAFETY: as above.
unsafe impl Sync for SumsPointer {}

/// One chain of passes over the grid.
struct Sweep<'a> {
    isa: Isa,
    grid: Grid,
    seed: u64,
    passes: &'a [Pass],
    schedule: &'a Schedule,
    specs: &'a [LayerSpec],
    raw: &'a [[Option<RawField>; 2]],
    zeros: RawField,
    dummy: RawField,
    /// Where the sums of each pass begin, in numbers of sums.
    first_sums: Vec<usize>,
    sums: SumsPointer,
}

impl Sweep<'_> {
    fn run(&self, band: usize) {
        let height = self.grid.height;
        let lag = self.schedule.longest_lag;
        let least = 2 * lag + 2 * MAX_REACH + 1;
        let wraps = self.grid.rim.y == Edge::Wrap;
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

    /// Passes that write southern faces also compute the northern rim's faces when that rim is open.
    fn first_row(&self, pass: usize) -> isize {
        let writes = &self.schedule.passes[pass].writes;
        let faces = writes.iter().any(|b| self.specs[b.layer].stagger == Stagger::FaceY);
        if faces && self.grid.rim.y == Edge::Open { -1 } else { 0 }
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
        for tick in first..last {
            for &(p, lag, low, high) in &rows {
                let y = tick - lag;
                if low <= y && y < high {
                    self.row(
                        p,
                        if self.grid.rim.y == Edge::Wrap { y.rem_euclid(self.grid.height as isize) } else { y },
                    );
                }
            }
        }
    }

    fn row(&self, p: usize, y: isize) {
        let (pass, scheduled) = (&self.passes[p], &self.schedule.passes[p]);
        let (g, last) = (&self.grid, self.grid.height as isize - 1);
        let mut job = RowJob {
            rows: [[std::ptr::null(); ROWS]; MAX_READS],
            out: [std::ptr::null_mut(); MAX_WRITES],
            west_face: [false; MAX_WRITES],
            width: g.width,
            y,
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
            let stagger = self.specs[buffer.layer].stagger;
            job.out[i] = if y < 0 && stagger != Stagger::FaceY {
                self.dummy.row(i as isize)
            } else {
                self.buffer(buffer.layer, buffer.copy).row(y)
            };
            job.west_face[i] = y >= 0 && g.rim.x == Edge::Open && stagger == Stagger::FaceX;
        }
        if y >= 0 {
            let (open_x, open_y) = (g.rim.x == Edge::Open, g.rim.y == Edge::Open);
            job.open = [open_x, open_x, open_y && y == 0, open_y && y == last];
        }
        pass.rule.row(self.isa, &mut job);
        for buffer in &scheduled.writes {
            let spec = &self.specs[buffer.layer];
            if y >= 0 || spec.stagger == Stagger::FaceY {
                // SAFETY: this row of the written buffers belongs to this call.
                unsafe { finish_row(self.buffer(buffer.layer, buffer.copy).row(y), g, spec, y) };
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
        let (height, rim) = (self.grid.height as isize, self.grid.rim.y);
        if (0..height).contains(&y) || (y == -1 && rim == Edge::Open && spec.stagger == Stagger::FaceY) {
            return raw.row(y);
        }
        match (rim, beyond(spec, rim)) {
            (Edge::Wrap, _) => raw.row(y.rem_euclid(height)),
            (_, Beyond::Nearest) => raw.row(y.clamp(0, height - 1)),
            (_, Beyond::Zero) => self.zeros.row(0),
        }
    }
}

fn beyond(spec: &LayerSpec, edge: Edge) -> Beyond {
    if edge == Edge::Open { spec.beyond_open } else { spec.beyond_closed }
}

/// Makes the columns beyond both ends of a row what the rim says, and shuts faces on closed rims.
///
/// # Safety
/// `row` must be column 0 of a row of a `Field` as wide as the grid, and nobody else may be using it.
unsafe fn finish_row(row: *mut f32, g: &Grid, spec: &LayerSpec, y: isize) {
    let width = g.width;
    // SAFETY: rows are padded by two blocks of lanes on the left and one block on the right after rounding up.
    let cells = unsafe { std::slice::from_raw_parts_mut(row.sub(WIDTH), WIDTH + width.next_multiple_of(WIDTH) + HALO) };
    let at = |x: isize| (x + WIDTH as isize) as usize;
    if spec.stagger == Stagger::FaceY && g.rim.y == Edge::Closed && y == g.height as isize - 1 {
        cells[at(0)..at(width as isize)].fill(0.0);
    }
    if spec.stagger == Stagger::FaceX && g.rim.x == Edge::Closed {
        cells[at(width as isize - 1)] = 0.0;
    }
    let end = cells.len() - WIDTH;
    match (g.rim.x, beyond(spec, g.rim.x)) {
        (Edge::Wrap, _) => {
            for i in 1..=HALO {
                cells[at(-(i as isize))] = cells[at((-(i as isize)).rem_euclid(width as isize))];
            }
            for x in width..end {
                cells[at(x as isize)] = cells[at((x % width) as isize)];
            }
        }
        (edge, beyond) => {
            let (west, east) = match beyond {
                Beyond::Nearest => (cells[at(0)], cells[at(width as isize - 1)]),
                Beyond::Zero => (0.0, 0.0),
            };
            // Column -1 of an open rim's faces has been computed.
            let computed = usize::from(edge == Edge::Open && spec.stagger == Stagger::FaceX);
            for i in 1 + computed..=HALO {
                cells[at(-(i as isize))] = west;
            }
            cells[at(width as isize)..].fill(east);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_a_field_is_known_before_there_is_one() {
        for (width, height) in [(1, 1), (7, 300), (192, 3), (208, 5), (1000, 2)] {
            let most = (0..STAGGERS).map(|s| Field::staggered(width, height, 0.0, s).bytes()).max();
            assert_eq!(most.map(|n| n as u128), Some(Field::bytes_of(width, height)), "{width} x {height}");
        }
    }

    /// Whether they were made by the world, copied or put in: the buffers of a simulation must not alias each other.
    #[test]
    fn buffers_get_different_staggers_however_the_world_came_about() {
        let grid = Grid { width: 20, height: 20, cell_x_m: 1.0, cell_y_m: 1.0, rim: crate::Rim::CLOSED };
        let mut world = World::new(grid, 1);
        let names = ["a", "b", "c", "d", "e"];
        for name in names {
            let spec = LayerSpec::new(name, "1", "", (0.0, 1.0));
            world.put(&spec, Field::from_fn(20, 20, |x, y| (x + y) as f32)).unwrap();
        }
        let staggers = |w: &World| w.layers().iter().map(|l| l.field.stagger()).collect::<Vec<_>>();
        let before = world.clone();
        Arena::new(&mut world).give_back(&mut world);
        assert_eq!(world, before);
        let mut found = staggers(&world);
        assert_eq!(found, staggers(&world.clone()), "a copy is as quick as the original");
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), names.len());
    }
}
