//! The reference: runs plans cell by cell on plain arrays, in single or double precision.
//!
//! Written to be obviously right rather than fast, and independent of the engine: no padding, no pointers, no waves. Tests
//! compare engines with it bit by bit (`f32`) and use it where single precision would hide an error (`f64`).

use crate::control::Control;
use crate::domain::{Domain, End};
use crate::engine::{Ahead, Borrowed, Engine, EngineError, Saved};
use crate::erased::View;
use crate::grid::{BoundaryCondition, Grid};
use crate::layer::{Centering, GhostFill, Layer, LayerSpec};
use crate::limits::Limits;
use crate::plan::{Pass, Plan};
use crate::process::{Scheduled, Span};
use crate::real::Real;
use crate::rng::{self, Key};
use crate::rule::{Side, TallyUnit};
use crate::stepper::{Simulation, prepare};
use crate::world::World;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A number that the reference can run in: `f32` or `f64`.
pub trait Number: Real + PartialEq + std::fmt::Debug + Into<f64> {
    #[doc(hidden)]
    fn cell(
        pass: &Pass,
        at: &dyn Fn(usize, isize, isize) -> Self,
        x: Self,
        y: Self,
        u: &dyn Fn(u32) -> f32,
    ) -> [Vec<Self>; 2];
}

impl Number for f32 {
    fn cell(
        pass: &Pass,
        at: &dyn Fn(usize, isize, isize) -> f32,
        x: f32,
        y: f32,
        u: &dyn Fn(u32) -> f32,
    ) -> [Vec<f32>; 2] {
        pass.rule.cell_f32(&View { at, uniform: u, x, y }).into()
    }
}

impl Number for f64 {
    fn cell(
        pass: &Pass,
        at: &dyn Fn(usize, isize, isize) -> f64,
        x: f64,
        y: f64,
        u: &dyn Fn(u32) -> f32,
    ) -> [Vec<f64>; 2] {
        pass.rule.cell_f64(&View { at, uniform: &|s| f64::from(u(s)), x, y }).into()
    }
}

/// One layer: values from column -1 and row -1 on, so that faces on an open rim have a place.
#[derive(Clone)]
struct Array<T> {
    spec: LayerSpec,
    values: Vec<T>,
}

/// A world of plain arrays of `T`.
pub struct Reference<T> {
    domain: Domain,
    /// The cells that are held.
    grid: Grid,
    seed: u64,
    /// Steps done.
    pub step: u64,
    /// Level of the sea, m.
    pub sea_level_m: f64,
    layers: Vec<Array<T>>,
    completed: u64,
    /// Sums for the ledger by account, in its units.
    pub ledger: BTreeMap<&'static str, f64>,
    /// What of these came from each of the cells that are held, row by row from the north.
    pub by_cell: BTreeMap<&'static str, Vec<f64>>,
}

impl<T: Number> Reference<T> {
    /// Copies a world.
    pub fn new(world: &World) -> Self {
        let mut r = Self {
            domain: world.domain(),
            grid: world.grid,
            seed: world.seed,
            step: world.step,
            sea_level_m: world.sea_level_m,
            layers: Vec::new(),
            completed: 0,
            ledger: BTreeMap::new(),
            by_cell: BTreeMap::new(),
        };
        world.layers().iter().for_each(|l| r.take(l));
        r
    }

    /// Copies a layer that is not there yet.
    fn take(&mut self, l: &Layer) {
        if self.layers.iter().any(|own| own.spec.name == l.spec.name) {
            return;
        }
        self.make(&l.spec, 0.0);
        for y in 0..self.grid.height {
            for x in 0..self.grid.width {
                let v = if self.is_shut(&l.spec, x as isize, y as isize) { 0.0 } else { l.field.get(x, y) };
                self.set(&l.spec.name, x, y, T::of(v));
            }
        }
        // What an earlier run left on the faces beyond an open rim.
        let (faces, at) = (l.field.outer_faces(), self.find(&l.spec.name));
        let (west, north) = faces.split_at(self.grid.height);
        for (y, v) in west.iter().enumerate().filter(|_| l.spec.centering == Centering::FaceX) {
            let i = self.index(-1, y as isize);
            self.layers[at].values[i] = T::of(*v);
        }
        for (x, v) in north.iter().enumerate().filter(|_| l.spec.centering == Centering::FaceY) {
            let i = self.index(x as isize, -1);
            self.layers[at].values[i] = T::of(*v);
        }
    }

    fn make(&mut self, spec: &LayerSpec, value: f32) {
        if !self.layers.iter().any(|l| l.spec.name == spec.name) {
            let n = (self.grid.width + 1) * (self.grid.height + 1);
            self.layers.push(Array { spec: spec.clone(), values: vec![T::of(value); n] });
        }
    }

    fn index(&self, x: isize, y: isize) -> usize {
        (y + 1) as usize * (self.grid.width + 1) + (x + 1) as usize
    }

    fn find(&self, name: &str) -> usize {
        self.layers.iter().position(|l| l.spec.name == name).unwrap_or_else(|| panic!("no layer {name}"))
    }

    /// Value of a layer.
    ///
    /// # Panics
    /// If there is no such layer or cell.
    pub fn get(&self, name: &str, x: usize, y: usize) -> T {
        self.layers[self.find(name)].values[self.index(x as isize, y as isize)]
    }

    /// Changes a value.
    ///
    /// # Panics
    /// As [`Reference::get`].
    pub fn set(&mut self, name: &str, x: usize, y: usize, v: T) {
        let (l, i) = (self.find(name), self.index(x as isize, y as isize));
        self.layers[l].values[i] = v;
    }

    /// Sum of a layer in double precision.
    ///
    /// # Panics
    /// If there is no such layer.
    pub fn sum(&self, name: &str) -> f64 {
        let cells = (0..self.grid.height).flat_map(|y| (0..self.grid.width).map(move |x| (x, y)));
        cells.map(|(x, y)| self.get(name, x, y).into()).sum()
    }

    /// Runs `steps` steps of the processes, whose layers are made if they are missing.
    ///
    /// # Panics
    /// If a process has an action: there is only one way to run those, so a reference would compare nothing. If a parameter does not
    /// fit this world.
    pub fn simulate(&mut self, processes: &[Scheduled], steps: u64) {
        assert!(processes.iter().all(|s| s.process.action().is_none()), "the reference runs rules only");
        let mut world = World::of_window(self.domain, self.seed);
        (world.step, world.sea_level_m) = (self.step, self.sea_level_m);
        for l in &self.layers {
            world.ensure(&l.spec, 0.0);
        }
        self.write(&mut world);
        let span = Span { from: 0, steps };
        // Layers that are made later would be brought in by way of single precision.
        let outcome = prepare(self, &mut world, processes)
            .and_then(|()| Simulation::new(processes).advance(self, &mut world, span, &Control::none()));
        outcome.unwrap_or_else(|e| panic!("the reference: {e}"));
    }

    /// Writes the values of the layers that a world has, rounded to what it holds.
    fn write(&self, world: &mut World) {
        let g = self.grid;
        for l in world.layers_mut() {
            let Some(own) = self.layers.iter().find(|own| own.spec.name == l.spec.name) else { continue };
            let value = |x: isize, y: isize| {
                let v: f64 = own.values[self.index(x, y)].into();
                v as f32
            };
            for y in 0..g.height {
                l.field.row_mut(y).iter_mut().enumerate().for_each(|(x, v)| *v = value(x as isize, y as isize));
            }
            let mut faces = l.field.outer_faces();
            let (west, north) = faces.split_at_mut(g.height);
            if l.spec.centering == Centering::FaceX {
                west.iter_mut().enumerate().for_each(|(y, v)| *v = value(-1, y as isize));
            }
            if l.spec.centering == Centering::FaceY {
                north.iter_mut().enumerate().for_each(|(x, v)| *v = value(x as isize, -1));
            }
            // There are as many faces as before.
            let _ = l.field.set_outer_faces(&faces);
        }
    }

    fn pass(&mut self, pass: &Pass) {
        let (g, domain) = (self.grid, self.domain);
        let (ends_x, ends_y) = (domain.ends_x(), domain.ends_y());
        let open = |end| end == End::Boundary(BoundaryCondition::Open);
        let reads: Vec<usize> = pass.reads().iter().map(|r| self.find(r.layer)).collect();
        let writes: Vec<usize> = pass.writes().iter().map(|w| self.find(w)).collect();
        let mut new: Vec<Vec<T>> = writes.iter().map(|&w| self.layers[w].values.clone()).collect();
        let area = g.cell_area_m2();
        for y in -1..g.height as isize {
            for x in -1..g.width as isize {
                let at = |slot: usize, dx: isize, dy: isize| self.look(reads[slot], x + dx, y + dy);
                let number = domain.cell_number(x, y);
                let uniform = |s| rng::unit::<f32>(rng::hash(Key::new(self.seed, s, pass.step), number));
                let (column, row) = (domain.column(x), domain.row(y));
                let [values, sums] = T::cell(pass, &at, T::of(column as f32), T::of(row as f32), &uniform);
                for (i, &w) in writes.iter().enumerate() {
                    let centering = self.layers[w].spec.centering;
                    let west = x < 0 && !(centering == Centering::FaceX && open(ends_x[0]) && y >= 0);
                    let north = y < 0 && !(centering == Centering::FaceY && open(ends_y[0]) && x >= 0);
                    if west || north {
                        continue;
                    }
                    let shut = self.is_shut(&self.layers[w].spec, x, y);
                    new[i][self.index(x, y)] = if shut { T::of(0.0) } else { values[i] };
                }
                let inside = |i: isize, cells: std::ops::Range<usize>| i >= 0 && cells.contains(&(i as usize));
                if !inside(x, domain.inside_columns()) || !inside(y, domain.inside_rows()) {
                    continue;
                }
                let mut sums: Vec<f64> = sums.into_iter().map(Into::into).collect();
                for side in Side::ALL {
                    let outside = match side {
                        Side::West => open(ends_x[0]) && x == 0,
                        Side::East => open(ends_x[1]) && x + 1 == g.width as isize,
                        Side::North => open(ends_y[0]) && y == 0,
                        Side::South => open(ends_y[1]) && y + 1 == g.height as isize,
                    };
                    if outside {
                        let at64 = |s: usize, dx: isize, dy: isize| -> f64 { at(s, dx, dy).into() };
                        let u64_ = |s| f64::from(uniform(s));
                        let view = View { at: &at64, uniform: &u64_, x: column as f64, y: row as f64 };
                        let left = pass.rule.leaving_f64(&view, side).unwrap_or_default();
                        sums.iter_mut().zip(left).for_each(|(a, b)| *a += b);
                    }
                }
                for (t, s) in pass.rule.tallies().iter().zip(sums) {
                    let scale = if t.unit == TallyUnit::Thickness { area } else { 1.0 };
                    *self.ledger.entry(t.account).or_default() += s * scale;
                    let cells = self.by_cell.entry(t.account).or_insert_with(|| vec![0.0; g.cells()]);
                    cells[y as usize * g.width + x as usize] += s * scale;
                }
            }
        }
        for (w, values) in writes.into_iter().zip(new) {
            self.layers[w].values = values;
        }
    }

    /// True for a face on a closed rim.
    fn is_shut(&self, spec: &LayerSpec, x: isize, y: isize) -> bool {
        let (g, shut) = (&self.grid, End::Boundary(BoundaryCondition::Closed));
        (spec.centering == Centering::FaceX && self.domain.ends_x()[1] == shut && x + 1 == g.width as isize)
            || (spec.centering == Centering::FaceY && self.domain.ends_y()[1] == shut && y + 1 == g.height as isize)
    }

    /// What a rule reads at (x, y), which may lie beyond the rim.
    fn look(&self, layer: usize, x: isize, y: isize) -> T {
        let (g, l) = (&self.grid, &self.layers[layer]);
        let column = place(x, g.width, self.domain.ends_x(), &l.spec, l.spec.centering == Centering::FaceX);
        let row = place(y, g.height, self.domain.ends_y(), &l.spec, l.spec.centering == Centering::FaceY);
        match (column, row) {
            (Some(x), Some(y)) => l.values[self.index(x, y)],
            _ => T::of(0.0),
        }
    }
}

impl<T: Number> Engine for Reference<T> {
    fn name(&self) -> String {
        "reference".to_owned()
    }

    fn limits(&self) -> Limits {
        Limits::default()
    }

    fn begin(&mut self, world: &mut World, _ahead: &Ahead<'_>) -> Result<(), EngineError> {
        world.layers().iter().for_each(|l| self.take(l));
        self.completed = 0;
        Ok(())
    }

    fn plan_end(&self, _ahead: &Ahead<'_>, at: u64) -> u64 {
        at + 1
    }

    fn run(&mut self, _world: &mut World, plan: &Plan, ahead: &Ahead<'_>) -> Result<(), EngineError> {
        plan.scratch_layers().iter().for_each(|spec| self.make(spec, 0.0));
        plan.passes().iter().for_each(|p| self.pass(p));
        self.completed += ahead.completes;
        Ok(())
    }

    fn lend(
        &mut self,
        world: &mut World,
        borrowed: &Borrowed,
        work: &mut dyn FnMut(&mut World) -> crate::Result<()>,
    ) -> Result<(), EngineError> {
        self.write(world);
        let outcome = work(world);
        self.layers.retain(|own| !borrowed.is_written(&own.spec.name));
        world.layers().iter().for_each(|l| self.take(l));
        Ok(outcome?)
    }

    fn save(&mut self, world: &mut World, writes: &[Cow<'static, str>]) -> Result<Saved, EngineError> {
        self.write(world);
        let mut saved = Saved::new(world);
        writes.iter().try_for_each(|name| saved.keep(world, name))?;
        Ok(saved)
    }

    fn restore(&mut self, world: &mut World, saved: Saved) {
        self.write(world);
        saved.put_back(world);
        self.release();
    }

    fn completed(&self) -> u64 {
        self.completed
    }

    fn wait(&mut self) -> Result<(), EngineError> {
        Ok(())
    }

    fn end(&mut self, world: &mut World) -> Result<(), EngineError> {
        (self.step, self.sea_level_m) = (world.step, world.sea_level_m);
        Ok(())
    }

    fn download(&mut self, world: &mut World) -> Result<(), EngineError> {
        self.write(world);
        Ok(())
    }

    fn release(&mut self) {
        self.layers.clear();
    }

    fn fall_back(&mut self, _world: &mut World) {}

    fn apply(&mut self, world: &mut World, plan: &Plan) -> Result<(), EngineError> {
        let mut other = Self::new(world);
        plan.scratch_layers().iter().for_each(|spec| other.make(spec, 0.0));
        plan.passes().iter().for_each(|p| other.pass(p));
        other.write(world);
        Ok(())
    }
}

/// The column or row that stands for `i`; `None` where there is nothing.
fn place(i: isize, n: usize, ends: [End; 2], spec: &LayerSpec, face: bool) -> Option<isize> {
    let n = n as isize;
    if (0..n).contains(&i) || (i == -1 && face && ends[0] == End::Boundary(BoundaryCondition::Open)) {
        return Some(i);
    }
    let beyond = match ends[usize::from(i > 0)] {
        End::Boundary(BoundaryCondition::Wrap) => return Some(i.rem_euclid(n)),
        End::Boundary(BoundaryCondition::Closed) => spec.beyond_closed,
        End::Boundary(BoundaryCondition::Open) => spec.beyond_open,
        End::Cut => GhostFill::Nearest,
    };
    (beyond == GhostFill::Nearest).then(|| i.clamp(0, n - 1))
}
