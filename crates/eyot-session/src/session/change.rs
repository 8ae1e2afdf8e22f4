//! Changes by hand to a simulation at work, of its processes and of its world; and the same again at their steps in a later run.

use super::Session;
use super::device::Layers;
use crate::error::RunError;
use crate::event::{Event, JournalEntry};
use eyot_core::engine::MemoryEstimate;
use eyot_core::layer::known;
use eyot_core::process::{Moment, Span};
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Worded};
use eyot_core::{Centering, World, check_clock};
use eyot_recipe::process_set::{self, WorldChange};
use eyot_recipe::{Change, Problems, ProcessUse, Step, Work, schedule};

impl Session {
    /// True if a change to the world itself is to be made again now: then the world has to be brought up to date.
    pub(super) fn is_world_change_due(&self, step: &Step) -> bool {
        let due = self.state.replay.iter().filter(|e| e.recipe_step == step.number && e.step <= self.state.done);
        due.into_iter().any(|e| touches_world(&e.set))
    }

    /// Makes the changes again that are due.
    pub(super) fn replay_due(&mut self, step: &Step, uses: &mut Vec<ProcessUse>) -> Result<(), RunError> {
        while let Some(i) =
            self.state.replay.iter().position(|e| e.recipe_step == step.number && e.step <= self.state.done)
        {
            let entry = self.state.replay.remove(i);
            let changed = self.changed(step, uses, &entry.set).map_err(|reason| RunError::Replay {
                set: entry.set.clone(),
                step: step.number,
                reason,
            })?;
            self.make(changed, uses);
            self.state.journal.push(JournalEntry { step: self.state.done, ..entry });
        }
        Ok(())
    }

    /// Applies a change to processes.
    pub(super) fn apply(&self, uses: &mut [ProcessUse], set: &str) -> Result<Vec<WorldChange>, Problems> {
        let has = |name: &str| self.world.get(name).is_some();
        process_set::apply(uses, set, &self.host.registry, &self.world.grid, &has)
    }

    /// Changes the simulation under way, or says why not.
    pub(super) fn change(&mut self, step: &Step, uses: Option<&mut Vec<ProcessUse>>, change: &Change) {
        let set = change.to_string();
        let changed = match &uses {
            None => Err("no simulation is under way".into()),
            Some(uses) => self.changed(step, uses, &set),
        };
        match (changed, uses) {
            (Ok(changed), Some(uses)) => {
                self.go_on_from_here();
                self.make(changed, uses);
                let entry = JournalEntry { recipe_step: step.number, step: self.state.done, set };
                self.state.journal.push(entry.clone());
                self.tell(Event::Changed(entry));
            }
            (Err(reason), _) => self.tell(Event::NotChanged { set, reason }),
            (Ok(_), None) => {}
        }
    }

    /// The processes as a change makes them, and what it does to the world; or why it cannot be, by all that a recipe is checked by.
    fn changed(&self, step: &Step, uses: &[ProcessUse], set: &str) -> Result<Changed, Remedy> {
        let mut uses = uses.to_vec();
        let world = self.apply(&mut uses, set).map_err(|problems| problems.sentence())?;
        let mut moment = Moment::of(&self.world);
        for change in &world {
            if let WorldChange::SeaLevel(level_m) = change {
                check_clock(self.world.step, *level_m).map_err(|e| e.sentence())?;
                moment.sea_level_m = *level_m;
            }
            fits(&self.world, change)?;
        }
        let steps = self.recipe.steps.iter().filter(|s| s.enabled && s.number >= step.number);
        let simulations = steps.filter_map(|s| match &s.work {
            Work::Simulate(work) if s.number == step.number => {
                let done = self.state.done.min(work.steps);
                Some((uses.as_slice(), Span { from: done, steps: work.steps - done }))
            }
            Work::Simulate(work) => Some((work.processes.as_slice(), Span { from: 0, steps: work.steps })),
            Work::Generate(_) => None,
        });
        process_set::foresee(moment, simulations).map_err(|(_, e)| e.sentence())?;
        let scheduled = schedule(&uses).map_err(|e| e.sentence())?;
        let own: Vec<_> = scheduled.iter().flat_map(|s| s.process.layers()).map(|l| l.spec.name).collect();
        let mut names: Vec<&str> = self.world.layers().iter().map(|l| &*l.spec.name).collect();
        names.extend(own.iter().map(|name| &**name));
        names.sort_unstable();
        names.dedup();
        let bytes = MemoryEstimate::of(&self.world.grid, names.len(), &scheduled).bytes(&self.world.grid);
        self.options.limits.check_bytes("simulating that", bytes).map_err(|e| e.sentence())?;
        Ok(Changed { uses, world })
    }

    /// Makes a change that was found sound.
    fn make(&mut self, changed: Changed, uses: &mut Vec<ProcessUse>) {
        *uses = changed.uses;
        self.keep_time(uses);
        if changed.world.is_empty() {
            return;
        }
        self.settle();
        for change in &changed.world {
            put(&mut self.world, change);
        }
        // What the engine holds is the world before.
        self.engine.engine_mut().release();
        self.layers = Layers::Current;
        self.settled = self.state.done;
        self.invalidate_view();
        self.show(self.state.done);
    }
}

/// A change that can be made.
struct Changed {
    uses: Vec<ProcessUse>,
    world: Vec<WorldChange>,
}

/// As [`Change::touches_world`], for the text of a change.
pub(super) fn touches_world(set: &str) -> bool {
    Change::parse(set).is_ok_and(|c| c.touches_world())
}

/// Finds values that a layer cannot have.
fn fits(world: &World, change: &WorldChange) -> Result<(), Remedy> {
    let WorldChange::Layer { name, value } = change else { return Ok(()) };
    let spec = &world.layer(name).map_err(|e| e.sentence())?.spec;
    if spec.centering != Centering::Cell && *value != 0.0 {
        // On a closed rim matter would come out of nothing.
        return Err(remedy![format!("`layer.{name}` is on the faces of cells, and takes 0 alone")]);
    }
    let (low, high) = spec.range;
    if (low..=high).contains(value) {
        return Ok(());
    }
    Err(remedy![format!("`layer.{name}` takes {low} to {high} {}, not {value}", spec.unit)])
}

/// Changes the world; what is put in or taken out has an account.
fn put(world: &mut World, change: &WorldChange) {
    match change {
        WorldChange::SeaLevel(level_m) => world.sea_level_m = *level_m,
        WorldChange::Layer { name, value } => {
            let (cells, area_m2) = (world.grid.cells() as f64, world.grid.cell_area_m2());
            let Ok(layer) = world.layer_mut(name) else { return };
            let added = (f64::from(*value) * cells - layer.field.sum()) * area_m2;
            layer.field.map_in_place(|_| *value);
            let is_face = layer.spec.centering != Centering::Cell;
            if is_face {
                let faces = vec![*value; layer.field.outer_faces().len()];
                // As many as there are.
                let _ = layer.field.set_outer_faces(&faces);
            }
            let unit = match &*layer.spec.unit {
                _ if is_face => None,
                "m" => Some("m3".to_owned()),
                unit => unit.strip_suffix("/m2").map(str::to_owned),
            };
            let material = if *name == known::HEIGHT.name { "ground" } else { name };
            if let Some(unit) = unit {
                let meaning = "Put in by hand; below 0, taken out";
                world.ledger.add(&format!("{material}.by_hand"), added, &unit, meaning, 1);
            }
        }
        other => debug_assert!(false, "nobody makes {other:?}"),
    }
}
