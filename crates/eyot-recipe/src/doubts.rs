//! What a recipe may say and most likely does not mean.

use crate::recipe::{Actor, ProcessUse, Recipe, Step, Work};
use eyot_core::layer::known;
use eyot_core::process::Access;
use eyot_core::remedy;
use eyot_core::remedy::Remedy;

impl Recipe {
    /// What can be run and was most likely not meant, a sentence each with its remedy.
    pub fn doubts(&self) -> Vec<Remedy> {
        let mut all: Vec<Remedy> = no_ground(&self.steps).map(Remedy::from).into_iter().collect();
        for step in self.enabled_steps() {
            let Work::Generate(g) = &step.work else { continue };
            let of_step = |d| remedy![format!("step {} ({}): ", step.number, step.name), d];
            all.extend(g.doubts.iter().cloned().map(of_step));
        }
        all
    }
}

/// A simulation of land that no step has made.
fn no_ground(steps: &[Step]) -> Option<String> {
    for step in steps.iter().filter(|s| s.enabled) {
        let work = match &step.work {
            Work::Generate(g) if g.layer == known::HEIGHT.name => return None,
            Work::Generate(_) => continue,
            Work::Simulate(work) => work,
        };
        let acting: Vec<&ProcessUse> = work.processes.iter().filter(|u| u.enabled).collect();
        if acting.iter().any(|u| makes_ground(u)) {
            return None;
        }
        if let Some(shapes) = acting.iter().find(|u| shapes_ground(u)) {
            return Some(format!(
                "step {} ({}) simulates `{}` without ground: no step before it makes the layer `height`, so it begins with a \
                 plain at 0 m; put a [[step]] such as generate = \"fbm\" before it",
                step.number,
                step.name,
                shapes.actor.name()
            ));
        }
    }
    None
}

/// Whether the ground may come from this: from plates, or from a rule of the recipe's own.
fn makes_ground(u: &ProcessUse) -> bool {
    match &u.actor {
        Actor::Process(_) => u.make().is_ok_and(|p| p.makes_ground()),
        Actor::Rule(_) => u.make().is_ok_and(|p| p.writes().contains(&known::HEIGHT.name)),
    }
}

fn shapes_ground(u: &ProcessUse) -> bool {
    let is_height = |l: &eyot_core::process::LayerUse| l.spec.name == known::HEIGHT.name && l.access == Access::Change;
    u.make().is_ok_and(|p| p.layers().iter().any(is_height))
}
