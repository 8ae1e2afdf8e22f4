//! What a recipe may say and most likely does not mean.

use crate::recipe::{Actor, ProcessUse, Recipe, Step, Work};
use eyot_core::layer::known;
use eyot_core::plan::Plan;
use eyot_core::process::{Access, Moment, Process};
use eyot_core::remedy;
use eyot_core::remedy::Remedy;

impl Recipe {
    /// What can be run and was most likely not meant, a sentence each with its remedy.
    pub fn doubts(&self) -> Vec<Remedy> {
        let mut all: Vec<Remedy> = no_ground(&self.steps).map(Remedy::from).into_iter().collect();
        all.extend(blind_to_rock(&self.steps).into_iter().map(Remedy::from));
        all.extend(before_its_maker(self).into_iter().map(Remedy::from));
        all.extend(crate::rock::doubts(self).into_iter().map(Remedy::from));
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

/// The parameter by which a process can be told that it should know the rock.
const BY_ROCK: &str = "by_rock";

/// Processes that wear the land as if it were loose although rock is known, and those that ask for rock that is not.
fn blind_to_rock(steps: &[Step]) -> Vec<String> {
    let rock = known::ERODIBILITY.name;
    let (mut known, mut all) = (false, Vec::new());
    for step in steps.iter().filter(|s| s.enabled) {
        let work = match &step.work {
            Work::Generate(g) => {
                known |= g.layer == rock;
                continue;
            }
            Work::Simulate(work) => work,
        };
        let acting: Vec<&ProcessUse> = work.processes.iter().filter(|u| u.enabled).collect();
        let here = acting.iter().any(|u| u.make().is_ok_and(|p| p.writes().contains(&rock)));
        known |= here;
        for u in acting {
            let (name, number, title) = (u.actor.name(), step.number, &step.name);
            match u.in_force()[BY_ROCK].as_bool() {
                Some(false) if here => all.push(format!(
                    "step {number} ({title}) knows the rock, but `{name}` wears all of it as if it were loose; say {name}.{BY_ROCK} = true"
                )),
                Some(true) if !known => all.push(format!(
                    "step {number} ({title}): {name}.{BY_ROCK} needs the layer `{rock}`, which nothing makes, so that all ground counts as \
                     loose; simulate `strata` in the same step, or make the layer with a generate step before it"
                )),
                _ => {}
            }
        }
    }
    all
}

/// Processes that begin with a constant layer, because they come before the one that gives it its first values.
fn before_its_maker(recipe: &Recipe) -> Vec<String> {
    let moment = Moment::whole(recipe.grid, 0, recipe.sea_level_m);
    let gives = |process: &dyn Process, layer: &str| {
        let mut plan = Plan::default();
        process.start(layer, &moment, &mut plan);
        !plan.passes().is_empty()
    };
    let (mut there, mut all): (Vec<String>, Vec<String>) = Default::default();
    for step in recipe.steps.iter().filter(|s| s.enabled) {
        let work = match &step.work {
            Work::Generate(g) => {
                there.push(g.layer.clone());
                continue;
            }
            Work::Simulate(work) => work,
        };
        let acting = work.processes.iter().filter(|u| u.enabled);
        let acting: Vec<_> = acting.filter_map(|u| Some((u.actor.name(), u.make().ok()?))).collect();
        for (i, (name, process)) in acting.iter().enumerate() {
            let mut said = false;
            for layer in process.layers().into_iter().map(|l| l.spec.name) {
                if there.iter().any(|l| *l == layer) {
                    continue;
                }
                let makes = |p: &dyn Process| p.layers().iter().any(|l| l.spec.name == layer) && gives(p, &layer);
                let maker = acting[i + 1..].iter().find(|(_, p)| !gives(&**process, &layer) && makes(&**p));
                if let Some((maker, _)) = maker.filter(|_| !said) {
                    said = true;
                    all.push(format!(
                        "step {} ({}): `{name}` comes before `{maker}`, which makes the layer `{layer}`, and so begins with the same value \
                         everywhere; list `{maker}` before it",
                        step.number, step.name
                    ));
                }
                there.push(layer.into_owned());
            }
        }
    }
    all
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
