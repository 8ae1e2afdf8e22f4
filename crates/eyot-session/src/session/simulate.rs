//! The steps of a simulation, chunk by chunk.

use super::device::{Failure, Layers};
use super::trial::{After, Trial};
use super::{CHUNK_TIME, Heard, Phase, Session, Turn, label, overall};
use crate::error::RunError;
use crate::event::{Event, Progress};
use eyot_core::engine::{DeviceError, EngineError};
use eyot_core::process::Span;
use eyot_core::stepper;
use eyot_core::{Control, Error};
use eyot_recipe::{ProcessUse, SimulateStep, Step, Work, schedule};
use std::time::Duration;

/// A simulation under way.
pub(super) struct Simulation {
    /// The processes with the changes by hand so far.
    uses: Vec<ProcessUse>,
    scheduled: stepper::Simulation,
    /// Steps to be done at a time.
    chunk: u64,
    /// Steps per second lately.
    rate: f64,
    trial: Trial,
    score: Score,
    begun: Duration,
    /// The card's own time before this simulation, less what the engine had counted by then, s.
    card_seconds: f64,
    stage: Stage,
}

/// The erosion score as it was measured last.
#[derive(Default)]
struct Score {
    value: Option<f64>,
    /// When that was, and how long it took.
    measured: Option<(Duration, Duration)>,
}

/// So many times as long as the last measuring of the score took passes before the next.
const SCORE_REST: u32 = 50;

/// What comes next in a simulation.
enum Stage {
    /// To hear the client, and to begin a chunk.
    Between,
    /// Its steps.
    Steps(Chunk),
    /// What the world is wanted for after them.
    After,
}

/// Steps that are done before anybody is heard.
struct Chunk {
    span: Span,
    /// Steps that the world had seen.
    first: u64,
    begun: Duration,
    /// Whether the engine was not ready in between.
    waited: bool,
}

/// How a stage of a chunk went.
enum Next {
    /// The next one follows at once.
    GoOn,
    /// The simulation goes on at the next turn.
    Later(Turn),
    /// The simulation is left: the phase says for what.
    Left(Turn),
}

impl Session {
    pub(super) fn begin_simulation(&mut self, step: &Step, work: &SimulateStep) -> Result<(), RunError> {
        self.tell(Event::StepBegun { number: step.number, name: step.name.clone(), total: work.steps });
        let begun = self.host.clock.now();
        let card_seconds = self.state.card_seconds - self.engine.device_seconds();
        // Steps before this one may have changed the world.
        self.engine.engine_mut().release();
        (self.settled, self.layers) = (self.state.done, Layers::Current);
        if self.state.done == 0 {
            self.record();
        }
        let chunk = self.options.chunk.unwrap_or(1).max(1);
        let (uses, scheduled) = self.scheduled(step, work)?;
        let (trial, score, stage) = (Trial::default(), Score::default(), Stage::Between);
        let simulation = Simulation { uses, scheduled, chunk, rate: 0.0, trial, score, begun, card_seconds, stage };
        self.phase = Phase::Simulating(Box::new(simulation));
        Ok(())
    }

    /// Does a chunk of steps, or as much of it as the engine is ready for; or ends the simulation.
    pub(super) fn simulate(&mut self, mut s: Box<Simulation>) -> Result<Turn, RunError> {
        let recipe = self.recipe.clone();
        let Some((step, work)) = recipe.steps.get(self.state.done_steps).and_then(|step| match &step.work {
            Work::Simulate(work) => Some((step, work)),
            Work::Generate(_) => None,
        }) else {
            return Err(RunError::Fault("a simulation lost its step".to_owned()));
        };
        let mut turn = Turn::Worked;
        for stage in [Self::begin_chunk, Self::do_chunk, Self::after_chunk] {
            match stage(self, step, work, &mut s)? {
                Next::GoOn => {}
                Next::Left(turn) => return Ok(turn),
                Next::Later(later) => {
                    turn = later;
                    break;
                }
            }
        }
        self.phase = Phase::Simulating(s);
        Ok(turn)
    }

    /// Hears the client and begins a chunk of steps, if none is under way; or ends the simulation.
    fn begin_chunk(&mut self, step: &Step, work: &SimulateStep, s: &mut Simulation) -> Result<Next, RunError> {
        if !matches!(s.stage, Stage::Between) {
            return Ok(Next::GoOn);
        }
        let fail = |source| RunError::Step { step: label(step), source };
        let is_over = self.state.done >= work.steps;
        let wanted = self.requests.want_world() || self.is_world_change_due(step);
        if (is_over || wanted) && !self.is_brought_back() {
            return Ok(Next::Later(Turn::Waiting));
        }
        if is_over {
            return match self.download() {
                Ok(()) => {
                    self.end_simulation(step, s);
                    Ok(Next::Left(Turn::Worked))
                }
                Err(Failure::Work(e)) => Err(fail(e)),
                Err(Failure::Device(e)) => self.go_on_elsewhere(e, step, work, s),
            };
        }
        let changes = self.state.journal.len();
        match self.attend(step, Some(&mut s.uses))? {
            Heard::GoOn => {}
            Heard::Wait => {
                if self.state.journal.len() > changes {
                    s.scheduled = stepper::Simulation::new(schedule(&s.uses).map_err(fail)?);
                }
                return Ok(Next::Later(Turn::Paused));
            }
            heard => {
                self.count_card(s);
                return Ok(Next::Left(self.turn_away(&heard)));
            }
        }
        self.go_on_from_here();
        self.note_engine();
        self.replay_due(step, &mut s.uses)?;
        if self.state.journal.len() > changes {
            s.scheduled = stepper::Simulation::new(schedule(&s.uses).map_err(fail)?);
        }
        if self.asked.lose_device_after.is_some_and(|n| self.state.done >= n) && self.devices_lost == 0 {
            self.engine.lose_device();
        }
        let span = Span { from: self.state.done, steps: self.steps_now(step, work, s.chunk) };
        s.stage = Stage::Steps(Chunk { span, first: self.world.step, begun: self.host.clock.now(), waited: false });
        Ok(Next::GoOn)
    }

    /// Does the steps that are under way.
    fn do_chunk(&mut self, step: &Step, work: &SimulateStep, s: &mut Simulation) -> Result<Next, RunError> {
        let Stage::Steps(chunk) = &mut s.stage else { return Ok(Next::GoOn) };
        self.layers = Layers::Behind;
        let control = Control::new(self.cancel.clone(), &|_, _| {});
        let result = s.scheduled.advance(self.engine.engine_mut(), &mut self.world, chunk.span, &control);
        if let Err(EngineError::NotReady) = result {
            chunk.waited = true;
            return Ok(Next::Later(Turn::Waiting));
        }
        let did = self.world.step.saturating_sub(chunk.first);
        let (time, waited) = (self.host.clock.since(chunk.begun), chunk.waited);
        s.stage = Stage::After;
        let result = result.map_err(Failure::from);
        if let Err(Failure::Device(e)) = result {
            return self.go_on_elsewhere(e, step, work, s);
        }
        self.state.done += did;
        self.did(did);
        match result {
            Err(Failure::Work(Error::Cancelled(_))) => {
                self.count_card(s);
                return Ok(Next::Left(self.turn_away(&Heard::Stop)));
            }
            Err(Failure::Work(e)) => return Err(RunError::Step { step: label(step), source: e }),
            Ok(()) | Err(Failure::Device(_)) => {}
        }
        // An engine that does not hold the host's thread may be at work for longer than the host has time.
        let aim = if waited { CHUNK_TIME } else { self.chunk_time };
        self.measure(s, did, time, aim);
        let left = work.steps - self.state.done;
        if let Some(event) = s.trial.count(did, time, left, &After::of(&self.recipe.steps, step.number, work)) {
            self.tell(event);
        }
        // The processor's world is always at hand.
        if self.engine.engine().kind() == "cpu" && self.is_brought_back() {
            self.measure_score(&mut s.score);
        }
        let eta = (work.steps - self.state.done) as f64 / s.rate.max(1e-9);
        let (before, share) = overall(&self.recipe.steps, step.number);
        self.tell(Event::Progress(Progress {
            recipe_step: step.number,
            step: self.state.done,
            total: work.steps,
            steps_per_s: s.rate,
            eta_s: Some(eta),
            overall: before + share * self.state.done as f64 / work.steps as f64,
            erosion_score: s.score.value,
        }));
        Ok(Next::GoOn)
    }

    /// Shows the world to those who are to see it after a chunk.
    fn after_chunk(&mut self, _: &Step, work: &SimulateStep, s: &mut Simulation) -> Result<Next, RunError> {
        let is_over = self.state.done >= work.steps;
        let records = is_over || self.steps_to_frame() == self.frame_distance();
        let shows = is_over || self.steps_to_look() == self.look_distance();
        if (records || shows || self.checkpoint_is_due()) && !self.is_brought_back() {
            return Ok(Next::Later(Turn::Waiting));
        }
        if let Layers::Current = self.layers {
            self.measure_score(&mut s.score);
        }
        if records {
            self.record();
        }
        if shows {
            self.show(self.state.done);
        }
        self.checkpoint_if_due();
        s.stage = Stage::Between;
        Ok(Next::GoOn)
    }

    /// Measures the erosion score of the world, which has been brought back, unless that was done lately.
    fn measure_score(&self, score: &mut Score) {
        let Some(outputs) = &self.host.outputs else { return };
        let begun = self.host.clock.now();
        if score.measured.is_some_and(|(at, took)| begun.saturating_sub(at) < took * SCORE_REST) {
            return;
        }
        score.value = outputs.score(&self.world);
        let done = self.host.clock.now();
        score.measured = Some((done, done.saturating_sub(begun)));
    }

    /// Goes on with another engine from the last world that this one gave back.
    fn go_on_elsewhere(
        &mut self,
        lost: DeviceError,
        step: &Step,
        work: &SimulateStep,
        s: &mut Simulation,
    ) -> Result<Next, RunError> {
        self.go_on_without(lost, step)?;
        (s.uses, s.scheduled) = self.scheduled(step, work)?;
        s.stage = Stage::Between;
        Ok(Next::Later(Turn::Worked))
    }

    /// Steps to do before the next look at anything.
    fn steps_now(&self, step: &Step, work: &SimulateStep, chunk: u64) -> u64 {
        let done = self.state.done;
        // The time that steps take must not decide where a graphics card's blocks of steps are cut.
        let block = if self.options.chunk.is_some() { 1 } else { self.engine.engine().block(&self.world.grid) };
        let wanted = (done + chunk).next_multiple_of(block) - done;
        let due = self.state.replay.iter().filter(|e| e.recipe_step == step.number).map(|e| e.step);
        let to_replay = due.filter(|s| *s > done).map(|s| s - done).next().unwrap_or(u64::MAX);
        wanted
            .min(work.steps - done)
            .min(self.steps_to_frame())
            .min(self.steps_to_look())
            .min(self.requests.allowed())
            .min(self.steps_left.max(1))
            .min(to_replay)
    }

    /// Learns from a chunk how many steps the next one should have.
    fn measure(&self, s: &mut Simulation, did: u64, time: Duration, aim: Duration) {
        let now = did as f64 / time.as_secs_f64().max(1e-9);
        s.rate = if s.rate == 0.0 { now } else { 0.7 * s.rate + 0.3 * now };
        if self.options.chunk.is_none() {
            // At most twice as long as before: the first steps can be untypically fast.
            s.chunk = ((now * aim.as_secs_f64()) as u64).clamp(1, s.chunk.saturating_mul(2));
        }
    }

    fn end_simulation(&mut self, step: &Step, s: &Simulation) {
        self.count_card(s);
        let seconds = self.host.clock.since(s.begun).as_secs_f64();
        self.state.timings.push((step.name.clone(), seconds));
        self.tell(Event::StepDone { number: step.number, name: step.name.clone(), seconds });
        self.tell(Event::Ledger { ledger: self.world.ledger.clone() });
        self.step_done();
    }

    fn count_card(&mut self, s: &Simulation) {
        // Less what a device took with it that was lost on the way.
        self.state.card_seconds = (s.card_seconds + self.engine.device_seconds()).max(0.0);
    }

    /// Writes down what simulates, if it is not what did last.
    fn note_engine(&mut self) {
        let kind = self.engine.engine().kind();
        if self.state.engines.last() != Some(&kind) {
            self.state.engines.push(kind);
        }
    }

    /// The processes of a step with the changes by hand that have been made so far.
    fn scheduled(&self, step: &Step, work: &SimulateStep) -> Result<(Vec<ProcessUse>, stepper::Simulation), RunError> {
        let mut uses = work.processes.clone();
        for entry in self.state.journal.iter().filter(|e| e.recipe_step == step.number) {
            // What it did to the world is in the world.
            self.apply(&mut uses, &entry.set).map_err(RunError::Recipe)?;
        }
        let scheduled = schedule(&uses).map_err(|source| RunError::Step { step: label(step), source })?;
        Ok((uses, stepper::Simulation::new(scheduled)))
    }
}
