//! How long a step of a run takes, if its processes agree on that.

use crate::event::JournalEntry;
use eyot_core::Grid;
use eyot_recipe::{ProcessUse, Recipe, Registry, Work, process_set};

/// Seconds of a step of simulation: what all processes with clocks say in all of a recipe's simulations, whatever was changed by
/// hand. `None` if no process has one or if they differ, for then steps are all that can be counted.
pub(crate) fn of_run(recipe: &Recipe, journal: &[JournalEntry], registry: &Registry) -> Option<f64> {
    let mut seconds = None;
    for step in recipe.enabled_steps() {
        let Work::Simulate(work) = &step.work else { continue };
        let mut uses = work.processes.clone();
        agree(&mut seconds, of_step(&uses, &recipe.grid)?)?;
        for entry in journal.iter().filter(|e| e.recipe_step == step.number) {
            process_set::apply(&mut uses, &entry.set, registry, &recipe.grid, &|_| true).ok()?;
            agree(&mut seconds, of_step(&uses, &recipe.grid)?)?;
        }
    }
    seconds
}

/// What the processes of one simulation agree on.
pub(crate) fn of_step(uses: &[ProcessUse], grid: &Grid) -> Option<f64> {
    let mut seconds = None;
    for u in uses.iter().filter(|u| u.enabled) {
        if let Some(own) = u.make().ok()?.seconds_per_step(grid) {
            agree(&mut seconds, own / u.every.max(1) as f64)?;
        }
    }
    seconds
}

fn agree(all: &mut Option<f64>, one: f64) -> Option<()> {
    let before = *all.get_or_insert(one);
    ((before - one).abs() <= 1e-6 * before).then_some(())
}
