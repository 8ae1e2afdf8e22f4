//! The thread of a run: goes through the recipe's steps, listens to commands, writes checkpoints.

use crate::backend::io::checkpoint;
use crate::clock;
use crate::diagnostic::Problems;
use crate::engines::{Engine, EngineChoice, EngineOptions, Failure};
use crate::error::RunError;
use crate::event::{Command, Event, JournalEntry, Progress};
use crate::layers;
use crate::outputs::Outputs;
use crate::process_set;
use crate::recipe::{GenerateStep, ProcessUse, Recipe, SimulateStep, Step, Work, schedule};
use crate::run::{Outcome, RunOptions};
use crate::state::State;
use crate::store::{self, CHECKPOINT_FILE, WORLD_FILE};
use crate::watch::Watching;
use eyot_core::process::{Site, Span};
use eyot_core::{Cancel, Control, Error, World};
use eyot_gpu::GpuError;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

mod commands;
mod recording;
mod streamed;
mod watching;

use commands::{Asked, Commands};
use recording::Recorder;

/// Chunks of steps aim at this long: short enough for commands, long enough to cost nothing.
const CHUNK_TIME: Duration = Duration::from_millis(300);
/// A device that is lost more often than this is not tried again.
const MOST_DEVICES_LOST: u32 = 3;
/// Progress of a generator is passed on at most this often.
const PROGRESS_TIME: Duration = Duration::from_millis(100);

/// The end of a run and the time it took, s.
pub(crate) struct End {
    pub(crate) outcome: Outcome,
    pub(crate) seconds: f64,
}

/// Whether to go on.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Flow {
    Continue,
    /// The run was set back: world and state say where to go on.
    Back,
    Stop,
}

pub(crate) struct Driver {
    recipe: Recipe,
    options: RunOptions,
    world: World,
    state: State,
    commands: Commands,
    outbox: Sender<Event>,
    cancel: Cancel,
    begun: Instant,
    seconds_before: f64,
    last_checkpoint: Instant,
    warned_of_checkpoint: bool,
    resumed: bool,
    /// How to find an engine.
    asked: EngineOptions,
    engine: Engine,
    /// Steps of the simulation under way that the world's own layers have seen; the engine may be ahead of them.
    settled: u64,
    devices_lost: u32,
    recorder: Option<Recorder>,
    watching: Option<Watching>,
}

impl Driver {
    pub(crate) fn new(
        recipe: Recipe,
        options: RunOptions,
        world: World,
        state: State,
        inbox: Receiver<Command>,
        outbox: Sender<Event>,
        cancel: Cancel,
    ) -> Self {
        let now = Instant::now();
        let limits = options.limits;
        let commands = Commands::new(inbox, outbox.clone(), options.paused);
        let watching = options.watch.clone().map(Watching::new);
        let (seconds_before, resumed) = (state.seconds, state.seconds > 0.0 || state.finished);
        let asked = options.engine.clone().unwrap_or_else(|| state.engine.clone());
        let state = State { finished: false, engine: asked.clone(), ..state };
        Self {
            recipe,
            options,
            world,
            state,
            commands,
            outbox,
            cancel,
            begun: now,
            seconds_before,
            last_checkpoint: now,
            warned_of_checkpoint: false,
            resumed,
            asked,
            engine: Engine::cpu(limits),
            settled: 0,
            devices_lost: 0,
            recorder: None,
            watching,
        }
    }

    /// Runs to the end, to a stop or to an error.
    pub(crate) fn drive(mut self) -> Result<End, RunError> {
        let (engine, warning) = if self.state.streamed {
            // Such a run has no simulations.
            (Engine::cpu(self.options.limits), None)
        } else {
            Engine::open(&self.asked, self.options.limits)?
        };
        self.engine = engine;
        let grid = self.world.grid;
        self.tell(Event::Started {
            name: self.recipe.name.clone(),
            size: [grid.width, grid.height],
            cell_m: [grid.cell_x_m, grid.cell_y_m],
            seed: self.recipe.seed,
            steps: self.recipe.enabled_steps().count(),
            engine: self.engine.name(),
            threads: rayon::current_num_threads(),
            resumed: self.resumed,
            out: self.options.out.clone(),
        });
        let other = self.state.engines.last().filter(|last| **last != self.engine.kind()).map(|last| {
            let now = self.engine.kind();
            format!("{last} has simulated so far and {now} goes on: not to the bytes of a run in one piece")
        });
        for message in warning.into_iter().chain(other) {
            self.tell(Event::Warning { message });
        }
        if self.state.streamed {
            return self.drive_streamed();
        }
        self.begin_recording();
        self.begin_watching()?;
        if self.state.place() != (0, 0) {
            self.show(self.state.done);
        }
        let steps = std::mem::take(&mut self.recipe.steps);
        let mut flow = Flow::Continue;
        while let Some(step) = steps.get(self.state.done_steps) {
            flow = if step.enabled { self.step(step, &steps)? } else { Flow::Continue };
            match flow {
                Flow::Stop => break,
                Flow::Back => {
                    flow = Flow::Continue;
                    self.show(self.state.done);
                }
                Flow::Continue => {
                    self.state.done_steps += 1;
                    self.state.done = 0;
                    self.checkpoint_if_due();
                }
            }
        }
        if flow == Flow::Continue {
            self.record();
        }
        self.recipe.steps = steps;
        self.engine.keep_pipelines();
        self.end(flow)
    }

    fn step(&mut self, step: &Step, all: &[Step]) -> Result<Flow, RunError> {
        // A simulation listens before each of its own steps.
        if matches!(step.work, Work::Generate(_)) {
            let flow = self.commands(step, None)?;
            if flow != Flow::Continue {
                return Ok(flow);
            }
        }
        let total = if let Work::Simulate(s) = &step.work { s.steps } else { 1 };
        self.tell(Event::StepBegun { number: step.number, name: step.name.clone(), total });
        let begun = Instant::now();
        let card_seconds = self.state.card_seconds - self.engine.card_seconds();
        let flow = match &step.work {
            Work::Generate(g) => self.generate(step, g, all),
            Work::Simulate(s) => self.simulate(step, s, all),
        }?;
        // Less what a device took with it that was lost on the way.
        self.state.card_seconds = (card_seconds + self.engine.card_seconds()).max(0.0);
        if flow == Flow::Continue {
            let seconds = begun.elapsed().as_secs_f64();
            self.state.timings.push((step.name.clone(), seconds));
            self.tell(Event::StepDone { number: step.number, name: step.name.clone(), seconds });
            if matches!(step.work, Work::Simulate(_)) {
                self.tell(Event::Ledger { ledger: self.world.ledger.clone() });
            }
        }
        Ok(flow)
    }

    fn generate(&mut self, step: &Step, work: &GenerateStep, all: &[Step]) -> Result<Flow, RunError> {
        let fail = |source| RunError::Step { step: label(step), source };
        let generator = work.make().map_err(fail)?;
        self.go_on_from_here();
        self.world.ensure(&layers::spec(&work.layer, &step.name, all), 0.0);
        let (before, share) = overall(all, step.number);
        let last = Mutex::new(Instant::now());
        let outbox = Mutex::new(self.outbox.clone());
        let report = |done: u64, total: u64| {
            let (Ok(mut last), Ok(outbox)) = (last.lock(), outbox.lock()) else { return };
            if last.elapsed() >= PROGRESS_TIME && total > 0 {
                *last = Instant::now();
                let overall = before + share * done as f64 / total as f64;
                let progress = Progress { recipe_step: step.number, step: done, total, overall, ..Progress::default() };
                // Nobody may be listening.
                let _ = outbox.send(Event::Progress(progress));
            }
        };
        let control = Control::new(self.cancel.clone(), &report);
        let site = Site::whole(self.world.grid, work.seed, &self.world, &control);
        let base = &self.world.layer(&work.layer).map_err(fail)?.field;
        let new = match generator.generate(&site, base) {
            Ok(new) => new,
            Err(Error::Cancelled(_)) => return Ok(Flow::Stop),
            Err(e) => return Err(fail(e)),
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
        self.world.check_finite(&label(step)).map_err(fail)?;
        self.show(1);
        self.commands.did(1);
        Ok(Flow::Continue)
    }

    fn simulate(&mut self, step: &Step, work: &SimulateStep, all: &[Step]) -> Result<Flow, RunError> {
        let fail = |source| RunError::Step { step: label(step), source };
        // Steps before this one may have changed the world.
        self.engine.release();
        self.settled = self.state.done;
        if self.state.done == 0 {
            self.record();
        }
        let mut uses = self.uses_now(step, work)?;
        let mut scheduled = schedule(&uses).map_err(fail)?;
        let mut chunk = self.options.chunk.unwrap_or(1).max(1);
        let mut rate = 0.0;
        loop {
            if self.state.done >= work.steps {
                match self.bring_back() {
                    Ok(()) => return Ok(Flow::Continue),
                    Err(Failure::Work(e)) => return Err(fail(e)),
                    Err(Failure::Device(e)) => {
                        self.go_on_without(e, step)?;
                        uses = self.uses_now(step, work)?;
                        scheduled = schedule(&uses).map_err(fail)?;
                        continue;
                    }
                }
            }
            let changes = self.state.journal.len();
            let flow = self.commands(step, Some(&mut uses))?;
            if flow != Flow::Continue {
                return Ok(flow);
            }
            self.go_on_from_here();
            self.note_engine();
            self.replay_due(step, &mut uses)?;
            if self.state.journal.len() > changes {
                scheduled = schedule(&uses).map_err(fail)?;
            }
            // The time that steps take must not decide where a graphics card's blocks of steps are cut.
            let block = if self.options.chunk.is_some() { 1 } else { self.engine.block(&self.world.grid) };
            let wanted = (self.state.done + chunk).next_multiple_of(block) - self.state.done;
            let mut steps = wanted.min(work.steps - self.state.done).min(self.steps_to_frame());
            steps = steps.min(self.steps_to_look());
            steps = steps.min(self.commands.allowed());
            if let Some(next) = self
                .state
                .replay
                .iter()
                .filter(|e| e.recipe_step == step.number)
                .map(|e| e.step)
                .find(|s| *s > self.state.done)
            {
                steps = steps.min(next - self.state.done);
            }
            let (begun, first) = (Instant::now(), self.world.step);
            let control = Control::new(self.cancel.clone(), &|_, _| {});
            if self.asked.lose_device_after.is_some_and(|n| self.state.done >= n) && self.devices_lost == 0 {
                self.engine.lose_device();
            }
            let span = Span { from: self.state.done, steps };
            let result = self.engine.simulate(&mut self.world, &scheduled, span, &control);
            if let Err(Failure::Device(e)) = result {
                self.go_on_without(e, step)?;
                uses = self.uses_now(step, work)?;
                scheduled = schedule(&uses).map_err(fail)?;
                continue;
            }
            let did = self.world.step - first;
            self.state.done += did;
            self.commands.did(did);
            match result {
                Err(Failure::Work(Error::Cancelled(_))) => return Ok(Flow::Stop),
                Err(Failure::Work(e)) => return Err(fail(e)),
                Ok(()) | Err(Failure::Device(_)) => {}
            }
            let seconds = begun.elapsed().as_secs_f64().max(1e-9);
            let now = did as f64 / seconds;
            rate = if rate == 0.0 { now } else { 0.7 * rate + 0.3 * now };
            if self.options.chunk.is_none() {
                // At most twice as long as before: the first steps can be untypically fast.
                chunk = ((now * CHUNK_TIME.as_secs_f64()) as u64).clamp(1, chunk.saturating_mul(2));
            }
            let eta = (work.steps - self.state.done) as f64 / rate.max(1e-9);
            let (before, share) = overall(all, step.number);
            self.tell(Event::Progress(Progress {
                recipe_step: step.number,
                step: self.state.done,
                total: work.steps,
                steps_per_s: rate,
                eta_s: Some(eta),
                overall: before + share * self.state.done as f64 / work.steps as f64,
            }));
            if self.steps_to_frame() == self.frame_distance() || self.state.done >= work.steps {
                self.record();
            }
            if self.steps_to_look() == self.look_distance() || self.state.done >= work.steps {
                self.show(self.state.done);
            }
            self.checkpoint_if_due();
        }
    }

    /// Writes down what simulates, if it is not what did last.
    fn note_engine(&mut self) {
        let kind = self.engine.kind();
        if self.state.engines.last() != Some(&kind) {
            self.state.engines.push(kind);
        }
    }

    /// The processes of a step with the changes by hand that have been made so far.
    fn uses_now(&self, step: &Step, work: &SimulateStep) -> Result<Vec<ProcessUse>, RunError> {
        let mut uses = work.processes.clone();
        for entry in self.state.journal.iter().filter(|e| e.recipe_step == step.number) {
            self.apply(&mut uses, &entry.set).map_err(RunError::Recipe)?;
        }
        Ok(uses)
    }

    /// Brings the world up to what the engine has done.
    fn bring_back(&mut self) -> Result<(), Failure> {
        self.engine.bring_back(&mut self.world)?;
        self.settled = self.state.done;
        Ok(())
    }

    /// As [`Driver::bring_back`] where the run is about to stop or to look at the world: if the device is lost, the world is
    /// what it was before, and so is the count of its steps.
    fn settle(&mut self) {
        if let Err(Failure::Device(e)) = self.bring_back() {
            let message =
                format!("{e}; {} steps since the world was last saved are lost", self.state.done - self.settled);
            self.tell(Event::Warning { message });
            self.unwind();
        }
    }

    /// Takes the steps back that only the engine knew; changes by hand since then will be made again at their steps.
    fn unwind(&mut self) {
        self.state.done = self.settled;
        let number = self.state.done_steps + 1;
        let (settled, journal) = (self.settled, std::mem::take(&mut self.state.journal));
        let (later, kept) = journal.into_iter().partition(|e| e.recipe_step == number && e.step > settled);
        self.state.journal = kept;
        self.state.replay.splice(0..0, Vec::<JournalEntry>::into_iter(later));
    }

    /// Goes on from the last world that was brought back: on the device opened anew, or on the processor if that was left open.
    fn go_on_without(&mut self, error: GpuError, step: &Step) -> Result<(), RunError> {
        self.unwind();
        self.devices_lost += 1;
        let auto = self.asked.choice == EngineChoice::Auto;
        let again = if error.is_lost() && self.devices_lost <= MOST_DEVICES_LOST {
            Engine::open(&self.asked, self.options.limits).ok()
        } else if auto {
            let cpu = EngineOptions { choice: EngineChoice::Cpu, ..self.asked.clone() };
            Engine::open(&cpu, self.options.limits).ok()
        } else {
            None
        };
        let Some((engine, _)) = again else {
            // What has been done must not be lost with the device.
            self.checkpoint_if_possible();
            return Err(RunError::Gpu(error));
        };
        self.engine = engine;
        let message = format!(
            "{error}; step {} goes on after {} steps with {}",
            step.number,
            self.state.done,
            self.engine.name()
        );
        self.tell(Event::Warning { message });
        Ok(())
    }

    fn replay_due(&mut self, step: &Step, uses: &mut [ProcessUse]) -> Result<(), RunError> {
        while let Some(i) =
            self.state.replay.iter().position(|e| e.recipe_step == step.number && e.step <= self.state.done)
        {
            let entry = self.state.replay.remove(i);
            self.apply(uses, &entry.set).map_err(RunError::Recipe)?;
            self.keep_time(uses);
            self.state.journal.push(JournalEntry { step: self.state.done, ..entry });
        }
        Ok(())
    }

    /// Does what the client asked for; waits while the run is paused.
    fn commands(&mut self, step: &Step, mut uses: Option<&mut Vec<ProcessUse>>) -> Result<Flow, RunError> {
        loop {
            match self.commands.next(step.number, self.state.done) {
                Asked::GoOn => return Ok(Flow::Continue),
                Asked::Stop => return Ok(Flow::Stop),
                Asked::Wait => self.checkpoint_if_due(),
                Asked::Set(set) => self.set(step, uses.as_deref_mut(), set),
                Asked::Snapshot => {
                    self.settle();
                    let world = Arc::new(self.world.clone());
                    self.tell(Event::Snapshot { recipe_step: step.number, step: self.state.done, world });
                }
                Asked::Rewind(to, forget) => match self.rewind_to(to, forget) {
                    Ok(()) => return Ok(Flow::Back),
                    Err(e) => self.tell(Event::Warning { message: format!("the run was not set back: {e}") }),
                },
                Asked::Branch(from, out) => {
                    if let Err(e) = self.branch(from, &out) {
                        self.tell(Event::Warning { message: format!("`{}` was not made: {e}", out.display()) });
                    }
                }
            }
        }
    }

    fn apply(&self, uses: &mut [ProcessUse], set: &str) -> Result<(), Problems> {
        process_set::apply(uses, set, &crate::Registry::standard(), &self.world.grid, &|name| {
            self.world.get(name).is_some()
        })
    }

    fn set(&mut self, step: &Step, uses: Option<&mut Vec<ProcessUse>>, set: String) {
        let refused = match uses {
            None => "no simulation is under way".to_owned(),
            Some(uses) => match self.apply(uses, &set) {
                Ok(()) => {
                    self.go_on_from_here();
                    self.keep_time(uses);
                    let entry = JournalEntry { recipe_step: step.number, step: self.state.done, set };
                    self.state.journal.push(entry.clone());
                    return self.tell(Event::Changed(entry));
                }
                Err(problems) => problems.to_string(),
            },
        };
        self.tell(Event::Warning { message: format!("`{set}` was not set: {refused}") });
    }

    fn seconds(&self) -> f64 {
        self.seconds_before + self.begun.elapsed().as_secs_f64()
    }

    /// Writes a checkpoint if it is time. One that cannot be written is no reason to end: the next may succeed.
    fn checkpoint_if_due(&mut self) {
        if self.last_checkpoint.elapsed() < self.options.checkpoint_every {
            return;
        }
        let begun = Instant::now();
        match self.checkpoint() {
            Ok(_) => self.warned_of_checkpoint = false,
            // Once is enough until one succeeds again.
            Err(e) if !std::mem::replace(&mut self.warned_of_checkpoint, true) => {
                let message = format!("no checkpoint: {e}; the run goes on and tries again");
                self.tell(Event::Warning { message });
            }
            Err(_) => {}
        }
        // A slow disk must not take more than a tenth of the time.
        let rest = begun.elapsed() * 10;
        self.last_checkpoint = Instant::now() + rest.saturating_sub(self.options.checkpoint_every);
    }

    /// Writes a checkpoint if the run has begun anything; used on the way out of an error, which is told anyway.
    fn checkpoint_if_possible(&mut self) {
        if self.state.done > 0 || self.state.done_steps > 0 {
            let _ = self.checkpoint();
        }
    }

    fn checkpoint(&mut self) -> Result<Option<PathBuf>, RunError> {
        let Some(out) = &self.options.out else { return Ok(None) };
        let path = out.join(CHECKPOINT_FILE);
        self.settle();
        self.state.seconds = self.seconds();
        let state = serde_json::to_value(&self.state).map_err(|e| RunError::Fault(e.to_string()))?;
        checkpoint::save(&path, &self.world, &self.recipe.source.text, &state)
            .map_err(|e| RunError::File(e.to_string()))?;
        self.last_checkpoint = Instant::now();
        self.tell(Event::Checkpoint { path: path.clone() });
        Ok(Some(path))
    }

    fn end(mut self, flow: Flow) -> Result<End, RunError> {
        self.settle();
        if self.state.place() != (0, 0) {
            self.show(self.state.done);
        }
        let fingerprint = self.world.fingerprint();
        let mut finished = flow == Flow::Continue && !self.cancel.is_raised();
        let outputs = match self.options.out.clone().filter(|_| finished) {
            Some(out) => match self.results(&out, fingerprint) {
                Ok(files) => files,
                Err(RunError::Stopped) => {
                    finished = false;
                    // The world, which is written first, is where writing goes on.
                    let world = store::unfinished(&out).filter(|p| p.ends_with(WORLD_FILE));
                    world.map_or_else(|| self.checkpoint(), |w| Ok(Some(w)))?.into_iter().collect()
                }
                Err(e) => return Err(e),
            },
            None if finished => Vec::new(),
            None => self.checkpoint()?.into_iter().collect(),
        };
        let seconds = self.seconds();
        let outcome = Outcome { world: self.world, fingerprint, finished, outputs, journal: self.state.journal };
        Ok(End { outcome, seconds })
    }

    fn results(&self, out: &Path, fingerprint: u64) -> Result<Vec<PathBuf>, RunError> {
        let outputs = Outputs {
            recipe: &self.recipe,
            world: &self.world,
            source: &self.world,
            fingerprint,
            clock: clock::of_run(&self.recipe, &self.state.journal),
            out,
            limits: &self.options.limits,
            control: &Control::new(self.cancel.clone(), &|_, _| {}),
            tell: &|event| drop(self.outbox.send(event)),
        };
        let state = State { seconds: self.seconds(), finished: true, ..self.state.clone() };
        outputs.write(&state, &mut |_| {})
    }

    fn tell(&self, event: Event) {
        // A client that has gone does not stop a run; its files are still wanted.
        let _ = self.outbox.send(event);
    }
}

fn label(step: &Step) -> String {
    format!("step {} ({})", step.number, step.name)
}

/// Share of the run before a step of the recipe, and that step's own share. A generator counts as a hundredth of all
/// simulation steps.
fn overall(all: &[Step], number: usize) -> (f64, f64) {
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
