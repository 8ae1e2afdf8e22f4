//! How steps are named and how far a session is.

use eyot_recipe::{Step, Work};

/// A step of the recipe, for messages.
pub(super) fn label(step: &Step) -> String {
    format!("step {} ({})", step.number, step.name)
}

/// Share of the run before a step of the recipe, and that step's own share. A generator counts as a hundredth of all
/// simulation steps.
pub(super) fn overall(all: &[Step], number: usize) -> (f64, f64) {
    let simulated: u64 =
        all.iter().filter(|s| s.enabled).map(|s| if let Work::Simulate(w) = &s.work { w.steps } else { 0 }).sum();
    let weight = |s: &Step| match &s.work {
        _ if !s.enabled => 0.0,
        Work::Simulate(w) => w.steps as f64,
        Work::Generate(_) => (simulated as f64 / 100.0).max(1.0),
    };
    let total: f64 = all.iter().map(weight).sum::<f64>().max(1.0);
    let before: f64 = all.iter().filter(|s| s.number < number).map(weight).sum();
    let own = all.iter().find(|s| s.number == number).map_or(0.0, weight);
    (before / total, own / total)
}
