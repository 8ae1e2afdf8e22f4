//! A run whose world is made while its files are written. It is no session: its writers ask for the rows that they need.

use super::{LOOK, RunOptions};
use crate::error::RunError;
use crate::event::{Command, Event, Progress};
use crate::files::CHECKPOINT_FILE;
use crate::host::{Host, Results};
use crate::session::{Outcome, PROGRESS_TIME, Request, Requests};
use crate::state::State;
use crate::stream::{StreamedWorld, Survey};
use eyot_core::remedy;
use eyot_core::remedy::Worded;
use eyot_core::{Cancel, Control, Limits, World};
use eyot_io::checkpoint;
use eyot_recipe::Recipe;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Name of the survey among the steps.
const SURVEY: &str = "all steps, streamed";

/// A streamed run.
pub(super) struct Streamed {
    recipe: Recipe,
    limits: Limits,
    host: Host,
    out: Option<PathBuf>,
    world: World,
    state: State,
    cancel: Cancel,
    begun: Duration,
    seconds_before: f64,
}

/// Surveys the world, then writes its files. The checkpoint of such a run holds no layers: it says which exports are done.
pub(super) fn run(
    recipe: Recipe,
    options: &RunOptions,
    host: Host,
    world: World,
    state: State,
    inbox: Receiver<Command>,
    cancel: Cancel,
) -> Result<Outcome, RunError> {
    let begun = host.clock.now();
    let watch = Watch {
        requests: Requests::new(host.events.clone(), options.paused),
        inbox,
        host: host.clone(),
        cancel: cancel.clone(),
        number: recipe.enabled_steps().last().map_or(1, |s| s.number),
        begun,
        told: begun,
    };
    let engine = options.engine.clone().unwrap_or_else(|| state.engine.clone());
    let (events, limits, seconds_before) = (host.events.clone(), options.limits, state.seconds);
    let out = options.out.clone();
    let state = State { engine, ..state };
    let mut run = Streamed { recipe, limits, host, out, world, state, cancel, begun, seconds_before };
    let done = run.work(watch);
    events.tell(match &done {
        Ok(o) if o.finished => Event::Done {
            outputs: o.outputs.clone(),
            fingerprint: format!("{:016x}", o.fingerprint),
            seconds: run.seconds(),
        },
        Ok(o) => Event::Stopped { checkpoint: o.outputs.first().cloned() },
        Err(e) => Event::Failed { message: e.sentence(), help: e.help() },
    });
    done
}

impl Streamed {
    fn work(&mut self, watch: Watch) -> Result<Outcome, RunError> {
        let grid = self.world.grid;
        let resumed = self.state.seconds > 0.0 || self.state.finished;
        self.state.finished = false;
        self.host.events.tell(Event::Started {
            name: self.recipe.name.clone(),
            size: [grid.width, grid.height],
            cell_m: [grid.cell_x_m, grid.cell_y_m],
            seed: self.recipe.seed,
            steps: self.recipe.enabled_steps().count(),
            // Such a run has no simulations.
            engine: crate::engines::processor(self.limits).engine().name(),
            threads: rayon::current_num_threads(),
            resumed,
            out: self.out.clone(),
        });
        self.checkpoint()?;
        match self.stream(watch) {
            Ok(outcome) => Ok(outcome),
            // Whatever it was that the stop broke off.
            Err(_) if self.cancel.is_raised() => {
                self.checkpoint()?;
                let outputs = self.out.iter().map(|out| out.join(CHECKPOINT_FILE)).collect();
                let (fingerprint, journal) = (self.world.fingerprint(), std::mem::take(&mut self.state.journal));
                Ok(Outcome { world: self.world.clone(), fingerprint, finished: false, outputs, journal })
            }
            Err(e) => Err(e),
        }
    }

    fn stream(&mut self, watch: Watch) -> Result<Outcome, RunError> {
        let fail = |source| RunError::Step { step: SURVEY.to_owned(), source };
        let (recipe, host) = (self.recipe.clone(), self.host.clone());
        let number = watch.number;
        let watch = Mutex::new(watch);
        let report = |done, total| watch.lock().unwrap_or_else(PoisonError::into_inner).progress(done, total);
        let control = Control::new(self.cancel.clone(), &report);
        let tell = |event| host.events.tell(event);
        let begun = host.clock.now();
        let mut world = StreamedWorld::new(&recipe, self.state.done_exports, &self.cancel, &control).map_err(fail)?;
        tell(Event::StepBegun { number, name: SURVEY.to_owned(), total: world.rows_in_all() });
        let Survey { overview, fingerprint } = world.survey(&recipe).map_err(fail)?;
        let seconds = host.clock.since(begun).as_secs_f64();
        self.state.timings = vec![(SURVEY.to_owned(), seconds)];
        tell(Event::StepDone { number, name: SURVEY.to_owned(), seconds });
        let mut outputs = Vec::new();
        if let Some(writer) = host.outputs.as_ref() {
            let limits = self.limits;
            let state = State { seconds: self.seconds(), ..self.state.clone() };
            let results = Results {
                recipe: &recipe,
                world: &overview,
                source: &world,
                fingerprint,
                clock: None,
                state: &state,
                storage: host.storage.as_deref(),
                in_place: &|| host.in_place(),
                limits: &limits,
                control: &control,
                tell: &tell,
            };
            outputs = writer.write(&results, &mut |done_exports| {
                self.state.done_exports = done_exports;
                // Without it, going on would make this export again.
                if let Err(e) = self.checkpoint() {
                    tell(Event::Warning { message: remedy!["no checkpoint: ", e, "; the run goes on"] });
                }
            })?;
        }
        let journal = std::mem::take(&mut self.state.journal);
        Ok(Outcome { world: overview, fingerprint, finished: true, outputs, journal })
    }

    fn seconds(&self) -> f64 {
        self.seconds_before + self.host.clock.since(self.begun).as_secs_f64()
    }

    fn checkpoint(&mut self) -> Result<(), RunError> {
        let Some(out) = &self.out else { return Ok(()) };
        self.host.in_place()?;
        let path = out.join(CHECKPOINT_FILE);
        self.state.seconds = self.seconds();
        let state = serde_json::to_value(&self.state).map_err(|e| RunError::Fault(e.to_string()))?;
        checkpoint::save(&path, &self.world, &self.recipe.source.text, &state).map_err(RunError::file)?;
        self.host.events.tell(Event::Checkpoint { path });
        Ok(())
    }
}

/// Listens to commands between two bands of rows, and tells how far the run is.
struct Watch {
    /// Its steps are bands.
    requests: Requests,
    inbox: Receiver<Command>,
    host: Host,
    cancel: Cancel,
    number: usize,
    begun: Duration,
    /// When the client last heard of progress.
    told: Duration,
}

impl Watch {
    fn progress(&mut self, done: u64, total: u64) {
        let clock = &self.host.clock;
        if clock.since(self.told) >= PROGRESS_TIME {
            self.told = clock.now();
            let rate = done as f64 / clock.since(self.begun).as_secs_f64().max(1e-9);
            self.tell(Event::Progress(Progress {
                recipe_step: self.number,
                step: done,
                total,
                steps_per_s: rate,
                eta_s: Some((total - done) as f64 / rate.max(1e-9)),
                overall: done as f64 / total.max(1) as f64,
                erosion_score: None,
            }));
        }
        self.requests.did(1);
        self.attend(done);
    }

    fn attend(&mut self, done: u64) {
        while !self.cancel.is_raised() {
            self.inbox.try_iter().for_each(|command| self.requests.push(command));
            let refused = match self.requests.next(self.number, done) {
                Request::GoOn => return,
                Request::Stop => {
                    self.cancel.raise();
                    return;
                }
                Request::Wait => {
                    match self.inbox.recv_timeout(LOOK) {
                        Ok(command) => self.requests.push(command),
                        Err(RecvTimeoutError::Timeout) => {}
                        // Nobody is left who could let it go on.
                        Err(RecvTimeoutError::Disconnected) => self.cancel.raise(),
                    }
                    continue;
                }
                Request::Change(change) => format!("`{change}` was not set: no simulation is under way"),
                Request::Rewind(..) | Request::Branch(..) => {
                    "a streamed run is not recorded: there is no way back".to_owned()
                }
                Request::Snapshot => "a streamed run has no world to show before its end".to_owned(),
            };
            self.tell(Event::Warning { message: refused.into() });
        }
    }

    fn tell(&self, event: Event) {
        self.host.events.tell(event);
    }
}
