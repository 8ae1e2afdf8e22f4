//! A world whose layers are on the card.

use super::account::Account;
use super::coming::Coming;
use super::dispatch::Kernel;
use super::{GpuEngine, SMALL};
use crate::arena::Arena;
use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::group::{Group, Layers, groups};
use crate::reduce::Ranging;
use eyot_core::engine::Saved;
use eyot_core::graph::Graph;
use eyot_core::plan::{Pass, Plan, RuleKind};
use eyot_core::process::{Moment, Scheduled, Span, acts, plan_step};
use eyot_core::rule::Tally;
use eyot_core::{BoundaryCondition, Centering, Field, Grid, LayerSpec, World};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

/// See the module.
pub(super) struct Resident {
    pub(super) arena: Arena,
    pub(super) specs: Vec<LayerSpec>,
    pub(super) world_layers: usize,
    /// Which of its two copies holds each layer.
    pub(super) current: Vec<usize>,
    /// Slots by layer and copy.
    pub(super) slots: HashMap<(usize, usize), usize>,
    /// Layers that the world's own copies of are out of date.
    pub(super) stale: Vec<bool>,
    pub(super) accounts: Vec<Account>,
    pub(super) seed: u64,
    pub(super) kernels: HashMap<Group, Arc<Kernel>>,
    pub(super) graphs: HashMap<RuleKind, Arc<Graph>>,
    /// Step and sea level of the world's own copies.
    pub(super) synced: (u64, f64),
    /// What actions have changed since the world was downloaded as a whole, as it was then: so that a lost device leaves no mixture.
    pub(super) held: Option<Saved>,
    /// What is on its way back, where nobody waits for it.
    pub(super) coming: Option<Coming>,
    /// The ranges of the layers that have changed, as [`GpuEngine::check_finite`] has asked for them.
    pub(super) checks: Vec<Ranging>,
}

impl Resident {
    pub(super) fn new(
        engine: &GpuEngine,
        world: &World,
        processes: &[Scheduled],
        span: Span,
        copies: &[(String, usize)],
    ) -> Result<Self> {
        let mut specs: Vec<LayerSpec> = world.layers().iter().map(|l| l.spec.clone()).collect();
        let world_layers = specs.len();
        // Which layers are looked at from other cells, and which are written, over enough steps to see every schedule.
        let mut moment = Moment::of(world);
        let (end, block) = (span.from + span.steps.clamp(1, 64), engine.block(&world.grid));
        let (mut plans, mut at) = (Vec::new(), span.from);
        while at < end {
            let mut plan = Plan::default();
            let next = block_end(processes, at, block).min(end);
            for step in at..next {
                plan_step(processes, step, &mut moment, &mut plan);
            }
            at = next;
            for spec in plan.scratch_layers() {
                if !specs.iter().any(|s| s.name == spec.name) {
                    specs.push(spec.clone());
                }
            }
            plans.push(plan);
        }
        let layers = Layers { specs: &specs, world_layers };
        let bounds = engine.bounds(&world.grid);
        let missing = || GpuError::Fault("a rule names a layer that its process does not".into());
        let mut all = Vec::new();
        for plan in &plans {
            all.extend(groups(plan.passes(), &layers, bounds).ok_or_else(missing)?);
        }
        let passes: Vec<&Pass> = plans.iter().flat_map(Plan::passes).collect();
        let mut slots = HashMap::new();
        let mut add = |key| {
            let n = slots.len();
            slots.entry(key).or_insert(n);
        };
        (0..world_layers).for_each(|l| add((l, 0)));
        for (layer, spec) in specs.iter().enumerate() {
            let written = passes.iter().any(|p| p.writes().contains(&&*spec.name));
            let read = passes.iter().any(|p| p.reads().iter().any(|r| r.layer == spec.name));
            // A span may end anywhere and cut a block; small grids have room for any copy that is then needed.
            let stored = layer < world_layers
                || world.grid.cells() <= SMALL
                || all.iter().any(|g| g.outputs.iter().any(|(l, _)| *l == layer));
            if written && stored {
                add((layer, 0));
                if read {
                    add((layer, 1));
                }
            }
        }
        for (name, copy) in copies {
            if let Some(layer) = specs.iter().position(|s| s.name == *name) {
                add((layer, *copy));
            }
        }
        let mut accounts: Vec<Account> = Vec::new();
        for t in passes.iter().flat_map(|p| p.tallies()) {
            if !accounts.iter().any(|a| a.tally.account == t.account) {
                let before = world.ledger.amount(t.account);
                accounts.push(Account { tally: *t, before, written: before });
            }
        }
        let bytes = u128::from(Arena::slot_bytes(&world.grid)) * slots.len() as u128;
        engine.options.limits.check_bytes("the layers of this simulation on the graphics card", bytes)?;
        let arena = Arena::new(
            &engine.gpu,
            &engine.bind_layout,
            &engine.job,
            world.grid,
            slots.len(),
            accounts.len(),
            engine.options.most_bytes,
        )?;
        let mut stale = vec![false; specs.len()];
        for (l, layer) in world.layers().iter().enumerate() {
            let field = shut(&layer.spec, &world.grid, &layer.field);
            arena.upload(&engine.gpu, slots[&(l, 0)], &field)?;
            stale[l] = matches!(field, Cow::Owned(_));
        }
        let r = Self {
            arena,
            current: vec![0; specs.len()],
            stale,
            specs,
            world_layers,
            slots,
            accounts,
            seed: world.seed,
            kernels: HashMap::new(),
            graphs: HashMap::new(),
            synced: (world.step, world.sea_level_m),
            held: None,
            coming: None,
            checks: Vec::new(),
        };
        r.share(&engine.gpu);
        Ok(r)
    }

    /// Copies the rows that slabs share.
    pub(super) fn share(&self, gpu: &Gpu) {
        if self.arena.split() {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            self.arena.share(&mut encoder);
            gpu.queue.submit([encoder.finish()]);
        }
    }

    /// Keeps what an action may change, ledger included, as it was when the world was last downloaded.
    pub(super) fn hold(&mut self, world: &World, wanted: impl Fn(&LayerSpec) -> bool) -> Result<()> {
        let held = self.held.get_or_insert_with(|| Saved::new(world));
        let mut wanted = self.specs[..self.world_layers].iter().filter(|s| wanted(s));
        Ok(wanted.try_for_each(|s| held.keep(world, &s.name))?)
    }

    /// Number of the account of a tally.
    pub(super) fn account(&self, tally: &Tally) -> Option<usize> {
        self.accounts.iter().position(|a| a.tally.account == tally.account)
    }

    /// The copies of layers that there is room for.
    pub(super) fn copies(&self) -> Vec<(String, usize)> {
        self.slots.keys().map(|&(l, copy)| (self.specs[l].name.to_string(), copy)).collect()
    }
}

/// The step after the last one of the block that begins at `at`: it ends at a multiple of `block` and before each step in which
/// some process acts.
pub(crate) fn block_end(processes: &[Scheduled], at: u64, block: u64) -> u64 {
    let end = at - at % block + block;
    (at + 1..end).find(|&step| acts(processes, step)).unwrap_or(end)
}

/// The layer as rules must find it: shut on the faces of closed rims.
fn shut<'a>(spec: &LayerSpec, grid: &Grid, field: &'a Field) -> Cow<'a, Field> {
    let (x, y) = (grid.rim.x == BoundaryCondition::Closed, grid.rim.y == BoundaryCondition::Closed);
    match spec.centering {
        Centering::FaceX if x => {
            let mut field = field.clone();
            field.rows_mut().for_each(|r| r[grid.width - 1] = 0.0);
            Cow::Owned(field)
        }
        Centering::FaceY if y => {
            let mut field = field.clone();
            field.row_mut(grid.height - 1).fill(0.0);
            Cow::Owned(field)
        }
        _ => Cow::Borrowed(field),
    }
}
