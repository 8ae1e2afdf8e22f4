//! A run whose world is made while its files are written.

use super::commands::{Asked, Commands};
use super::{Driver, End, PROGRESS_TIME};
use crate::error::RunError;
use crate::event::{Event, Progress};
use crate::outputs::Outputs;
use crate::run::Outcome;
use crate::state::State;
use crate::stream::{StreamedWorld, Survey};
use eyot_core::{Cancel, Control};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Name of the survey among the steps.
const SURVEY: &str = "all steps, streamed";

impl Driver {
    /// Surveys the world, then writes its files. The checkpoint of such a run holds no layers: it says which exports are
    /// done.
    pub(super) fn drive_streamed(mut self) -> Result<End, RunError> {
        self.checkpoint()?;
        let number = self.recipe.enabled_steps().last().map_or(1, |s| s.number);
        let watch = Mutex::new(Watch {
            // From here on, this run listens between bands only.
            commands: std::mem::replace(&mut self.commands, Commands::new(channel().1, self.outbox.clone(), false)),
            outbox: self.outbox.clone(),
            cancel: self.cancel.clone(),
            number,
            begun: Instant::now(),
            told: Instant::now(),
        });
        let report = |done, total| watch.lock().unwrap_or_else(PoisonError::into_inner).progress(done, total);
        let control = Control::new(self.cancel.clone(), &report);
        match self.stream(number, &control) {
            Ok(outcome) => Ok(End { outcome, seconds: self.seconds() }),
            // Whatever it was that the stop broke off.
            Err(_) if self.cancel.is_raised() => {
                let outputs = self.checkpoint()?.into_iter().collect();
                let seconds = self.seconds();
                let (fingerprint, journal) = (self.world.fingerprint(), self.state.journal);
                let outcome = Outcome { world: self.world, fingerprint, finished: false, outputs, journal };
                Ok(End { outcome, seconds })
            }
            Err(e) => Err(e),
        }
    }

    fn stream(&mut self, number: usize, control: &Control<'_>) -> Result<Outcome, RunError> {
        let fail = |source| RunError::Step { step: SURVEY.to_owned(), source };
        let (recipe, options, outbox) = (self.recipe.clone(), self.options.clone(), self.outbox.clone());
        let begun = Instant::now();
        let mut world = StreamedWorld::new(&recipe, self.state.done_exports, &self.cancel, control).map_err(fail)?;
        self.tell(Event::StepBegun { number, name: SURVEY.to_owned(), total: world.rows_in_all() });
        let Survey { overview, fingerprint } = world.survey(&recipe).map_err(fail)?;
        let seconds = begun.elapsed().as_secs_f64();
        self.state.timings = vec![(SURVEY.to_owned(), seconds)];
        self.tell(Event::StepDone { number, name: SURVEY.to_owned(), seconds });
        let mut outputs = Vec::new();
        if let Some(out) = &options.out {
            let job = Outputs {
                recipe: &recipe,
                world: &overview,
                source: &world,
                fingerprint,
                clock: None,
                out,
                limits: &options.limits,
                control,
                tell: &|event| drop(outbox.send(event)),
            };
            let state = State { seconds: self.seconds(), ..self.state.clone() };
            outputs = job.write(&state, &mut |done_exports| {
                self.state.done_exports = done_exports;
                // Without it, going on would make this export again.
                if let Err(e) = self.checkpoint() {
                    self.tell(Event::Warning { message: format!("no checkpoint: {e}; the run goes on") });
                }
            })?;
        }
        let journal = std::mem::take(&mut self.state.journal);
        Ok(Outcome { world: overview, fingerprint, finished: true, outputs, journal })
    }
}

/// Listens to commands between two bands of rows, and tells how far the run is.
struct Watch {
    /// Its steps are bands.
    commands: Commands,
    outbox: Sender<Event>,
    cancel: Cancel,
    number: usize,
    begun: Instant,
    /// When the client last heard of progress.
    told: Instant,
}

impl Watch {
    fn progress(&mut self, done: u64, total: u64) {
        if self.told.elapsed() >= PROGRESS_TIME {
            self.told = Instant::now();
            let rate = done as f64 / self.begun.elapsed().as_secs_f64().max(1e-9);
            self.tell(Event::Progress(Progress {
                recipe_step: self.number,
                step: done,
                total,
                steps_per_s: rate,
                eta_s: Some((total - done) as f64 / rate.max(1e-9)),
                overall: done as f64 / total.max(1) as f64,
            }));
        }
        self.commands.did(1);
        self.attend(done);
    }

    fn attend(&mut self, done: u64) {
        while !self.cancel.is_raised() {
            match self.commands.next(self.number, done) {
                Asked::GoOn => return,
                Asked::Stop => self.cancel.raise(),
                Asked::Wait => {}
                Asked::Set(set) => {
                    let message = format!("`{set}` was not set: no simulation is under way");
                    self.tell(Event::Warning { message });
                }
                Asked::Rewind(..) | Asked::Branch(..) => {
                    let message = "a streamed run is not recorded: there is no way back".to_owned();
                    self.tell(Event::Warning { message });
                }
                Asked::Snapshot => {
                    let message = "a streamed run has no world to show before its end".to_owned();
                    self.tell(Event::Warning { message });
                }
            }
        }
    }

    fn tell(&self, event: Event) {
        // A client that has gone does not stop a run; its files are still wanted.
        let _ = self.outbox.send(event);
    }
}
