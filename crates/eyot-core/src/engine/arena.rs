//! Buffers of a simulation on the processor, from a world's layers and back.

// Reason for the exception: the padding of fields is written through raw rows.
#![allow(unsafe_code)]

use super::cpu::CpuEngine;
use super::sweep::{SumsPointer, Sweep, finish_row};
use crate::domain::{Domain, End};
use crate::error::Result;
use crate::field::{CACHE_OFFSETS, Field, RawField};
use crate::grid::{BoundaryCondition, Grid};
use crate::layer::{Centering, LayerSpec};
use crate::ledger::Ledger;
use crate::plan::{Pass, Plan};
use crate::rule::{MAX_WRITES, Tally, TallyUnit};
use crate::schedule::{Buffer, Schedule};
use crate::world::World;
use std::borrow::Cow;

/// Buffers of a simulation: two copies of each layer as needed, scratch layers, sums.
pub(super) struct Arena {
    domain: Domain,
    /// The cells that are held.
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
    pub(super) fn new(world: &mut World) -> Self {
        let g = world.grid;
        let specs: Vec<LayerSpec> = world.layers().iter().map(|l| l.spec.clone()).collect();
        let mut arena = Self {
            domain: world.domain(),
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
        let mut taken = CacheOffsets::default();
        for (l, layer) in world.layers_mut().iter_mut().enumerate().take(self.world_layers) {
            let mut field = std::mem::replace(&mut layer.field, Field::new(0, 0, 0.0));
            // Fields that were put into the world may all have the same one.
            let cache_offset = taken.this_or_free(field.cache_offset());
            if cache_offset != field.cache_offset() {
                field = field.at_cache_offset(cache_offset);
            }
            self.finish(&self.specs[l], &mut field);
            self.fields[l][self.current[l]] = Some(field);
        }
    }

    /// Makes the padding of a layer what the rim says.
    fn finish(&self, spec: &LayerSpec, field: &mut Field) {
        // Faces north of an open rim are a row of their own.
        let first = if spec.centering == Centering::FaceY
            && self.domain.ends_y()[0] == End::Boundary(BoundaryCondition::Open)
        {
            -1
        } else {
            0
        };
        for y in first..self.grid.height as isize {
            // SAFETY: this thread owns the field.
            unsafe { finish_row(field.raw().row(y), &self.domain, spec, y) };
        }
    }

    /// Runs a plan: as one chain, or as several if its lag would leave the bands too low. If it fails, nothing has changed.
    pub(super) fn run(&mut self, engine: &CpuEngine, plan: &Plan, ledger: &Ledger) -> Result<()> {
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
        let mut taken = CacheOffsets::default();
        self.fields.iter().flatten().flatten().for_each(|f| taken.0[f.cache_offset()] += 1);
        for b in missing {
            let field = Field::with_cache_offset(self.grid.width, self.grid.height, 0.0, taken.free());
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
            domain: self.domain,
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
    pub(super) fn lend(
        &mut self,
        world: &mut World,
        changes: &[Cow<'static, str>],
        f: impl FnOnce(&mut World) -> Result<()>,
    ) -> Result<()> {
        let cache_offsets: Vec<usize> = self.world_fields().map(Field::cache_offset).collect();
        self.put_back(world);
        self.flush_ledger(world);
        let outcome = f(world);
        let sound = world.layers().len() == self.world_layers
            && world
                .layers()
                .iter()
                .all(|l| (l.field.width(), l.field.height()) == (self.grid.width, self.grid.height));
        assert!(sound, "an action changed what layers there are, or their size");
        for (l, layer) in world.layers_mut().iter_mut().enumerate() {
            let mut field = std::mem::replace(&mut layer.field, Field::new(0, 0, 0.0));
            if field.cache_offset() != cache_offsets[l] {
                field = field.at_cache_offset(cache_offsets[l]);
            }
            // The padding of the others is what it was, and there are too many rows to look at for nothing.
            if changes.contains(&self.specs[l].name) {
                self.finish(&self.specs[l], &mut field);
            }
            self.fields[l][self.current[l]] = Some(field);
        }
        outcome
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
    pub(super) fn give_back(mut self, world: &mut World) {
        self.put_back(world);
        self.flush_ledger(world);
    }

    /// Writes the sums to the ledger.
    fn flush_ledger(&mut self, world: &mut World) {
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

/// How many buffers have each cache offset. Buffers of one simulation get different ones as long as there are any.
#[derive(Default)]
struct CacheOffsets([usize; CACHE_OFFSETS]);

impl CacheOffsets {
    /// The first of those that the fewest have; now one more has it.
    fn free(&mut self) -> usize {
        let least = (0..CACHE_OFFSETS).min_by_key(|&i| self.0[i]).unwrap_or(0);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_a_field_is_known_before_there_is_one() {
        for (width, height) in [(1, 1), (7, 300), (192, 3), (208, 5), (1000, 2)] {
            let most = (0..CACHE_OFFSETS).map(|s| Field::with_cache_offset(width, height, 0.0, s).bytes()).max();
            assert_eq!(most.map(|n| n as u128), Some(Field::bytes_of(width, height)), "{width} x {height}");
        }
    }

    /// Whether they were made by the world, copied or put in: the buffers of a simulation must not alias each other.
    #[test]
    fn buffers_get_different_staggers_however_the_world_came_about() {
        let grid = Grid { width: 20, height: 20, cell_x_m: 1.0, cell_y_m: 1.0, rim: crate::Boundary::CLOSED };
        let mut world = World::new(grid, 1);
        let names = ["a", "b", "c", "d", "e"];
        for name in names {
            let spec = LayerSpec::new(name, "1", "", (0.0, 1.0));
            world.put(&spec, Field::from_fn(20, 20, |x, y| (x + y) as f32)).unwrap();
        }
        let cache_offsets = |w: &World| w.layers().iter().map(|l| l.field.cache_offset()).collect::<Vec<_>>();
        let before = world.clone();
        Arena::new(&mut world).give_back(&mut world);
        assert_eq!(world, before);
        let mut found = cache_offsets(&world);
        assert_eq!(found, cache_offsets(&world.clone()), "a copy is as quick as the original");
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), names.len());
    }
}
