//! A generator of a recipe.

use super::{PROGRESS_TIME, Phase, Session, label, overall};
use crate::error::RunError;
use crate::event::{Event, Progress};
use eyot_core::layer::known;
use eyot_core::process::Site;
use eyot_core::{Control, Error};
use eyot_recipe::{GenerateStep, Merge, Step, layers};
use std::sync::Mutex;

impl Session {
    /// Makes a layer, in one piece.
    pub(super) fn generate_step(&mut self, step: &Step, work: &GenerateStep) -> Result<(), RunError> {
        self.tell(Event::StepBegun { number: step.number, name: step.name.clone(), total: 1 });
        let begun = self.host.clock.now();
        if !self.generate(step, work)? {
            self.engine.keep();
            self.phase = Phase::Ending { stopped: true };
            return Ok(());
        }
        let seconds = self.host.clock.since(begun).as_secs_f64();
        self.state.timings.push((step.name.clone(), seconds));
        self.tell(Event::StepDone { number: step.number, name: step.name.clone(), seconds });
        self.step_done();
        Ok(())
    }

    /// False if it was broken off.
    fn generate(&mut self, step: &Step, work: &GenerateStep) -> Result<bool, RunError> {
        let fail = |source| RunError::Step { step: label(step), source };
        let generator = work.make().map_err(fail)?;
        self.go_on_from_here();
        let recipe = self.recipe.clone();
        self.world.ensure(&layers::spec(&work.layer, &step.name, &recipe.steps), 0.0);
        let (before, share) = overall(&recipe.steps, step.number);
        let (clock, events) = (self.host.clock.clone(), self.host.events.clone());
        let last = Mutex::new(clock.now());
        let report = |done: u64, total: u64| {
            let Ok(mut last) = last.lock() else { return };
            if clock.since(*last) >= PROGRESS_TIME && total > 0 {
                *last = clock.now();
                let overall = before + share * done as f64 / total as f64;
                let progress = Progress { recipe_step: step.number, step: done, total, overall, ..Progress::default() };
                events.tell(Event::Progress(progress));
            }
        };
        let control = Control::new(self.cancel.clone(), &report);
        let site = Site::whole(self.world.grid, work.seed, &self.world, &control);
        let base = &self.world.layer(&work.layer).map_err(fail)?.field;
        let new = match generator.generate(&site, base) {
            Ok(new) => new,
            Err(Error::Cancelled(_)) => return Ok(false),
            Err(e) => return Err(fail(e)),
        };
        let missing = match work.layer == known::HEIGHT.name {
            true => generator.missing(&site.grid).map_err(fail)?,
            false => None,
        };
        let grid = self.world.grid;
        if (new.width(), new.height()) != (grid.width, grid.height) {
            let found = new.width() * new.height();
            return Err(fail(Error::Shape {
                what: format!("the result of {}", work.entry.name),
                expected: grid.cells(),
                found,
            }));
        }
        let mask = match &work.mask {
            Some(name) => Some(self.world.layer(name).map_err(fail)?.field.clone()),
            None => None,
        };
        let layer = self.world.layer_mut(&work.layer).map_err(fail)?;
        work.merge.apply(&mut layer.field, &new, work.amount, mask.as_ref());
        if let Some(missing) = missing {
            let marks = self.world.ensure(&known::MISSING, 0.0);
            Merge::Max.apply(&mut marks.field, &missing, 1.0, None);
        }
        self.world.check_finite(&label(step)).map_err(fail)?;
        self.show(1);
        self.did(1);
        Ok(true)
    }
}
