//! The steps of a simulation, chunk by chunk.

use super::device::Failure;
use super::{Heard, Phase, Session, label, overall};
use crate::error::RunError;
use crate::event::{Event, JournalEntry, Progress};
use eyot_core::process::Span;
use eyot_core::stepper;
use eyot_core::{Control, Error};
use eyot_recipe::{Change, Problems, ProcessUse, SimulateStep, Step, Work, process_set, schedule};
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
    begun: Duration,
    /// The card's own time before this simulation, less what the engine had counted by then, s.
    card_seconds: f64,
}

impl Session {
    pub(super) fn begin_simulation(&mut self, step: &Step, work: &SimulateStep) -> Result<(), RunError> {
        self.tell(Event::StepBegun { number: step.number, name: step.name.clone(), total: work.steps });
        let begun = self.host.clock.now();
        let card_seconds = self.state.card_seconds - self.engine.device_seconds();
        // Steps before this one may have changed the world.
        self.engine.engine_mut().release();
        self.settled = self.state.done;
        if self.state.done == 0 {
            self.record();
        }
        let chunk = self.options.chunk.unwrap_or(1).max(1);
        let (uses, scheduled) = self.scheduled(step, work)?;
        self.phase = Phase::Simulating(Box::new(Simulation { uses, scheduled, chunk, rate: 0.0, begun, card_seconds }));
        Ok(())
    }

    /// Does a chunk of steps, or ends the simulation. False if the session waits.
    pub(super) fn simulate(&mut self, mut s: Box<Simulation>) -> Result<bool, RunError> {
        let recipe = self.recipe.clone();
        let Some((step, work)) = recipe.steps.get(self.state.done_steps).and_then(|step| match &step.work {
            Work::Simulate(work) => Some((step, work)),
            Work::Generate(_) => None,
        }) else {
            return Err(RunError::Fault("a simulation lost its step".to_owned()));
        };
        let fail = |source| RunError::Step { step: label(step), source };
        if self.state.done >= work.steps {
            match self.download() {
                Ok(()) => self.end_simulation(step, &s),
                Err(Failure::Work(e)) => return Err(fail(e)),
                Err(Failure::Device(e)) => {
                    self.go_on_without(e, step)?;
                    (s.uses, s.scheduled) = self.scheduled(step, work)?;
                    self.phase = Phase::Simulating(s);
                }
            }
            return Ok(true);
        }
        let changes = self.state.journal.len();
        match self.attend(step, Some(&mut s.uses))? {
            Heard::GoOn => {}
            Heard::Wait => {
                if self.state.journal.len() > changes {
                    s.scheduled = stepper::Simulation::new(schedule(&s.uses).map_err(fail)?);
                }
                self.phase = Phase::Simulating(s);
                return Ok(false);
            }
            heard => {
                self.count_card(&s);
                return Ok(self.turn_away(&heard));
            }
        }
        self.go_on_from_here();
        self.note_engine();
        self.replay_due(step, &mut s.uses)?;
        if self.state.journal.len() > changes {
            s.scheduled = stepper::Simulation::new(schedule(&s.uses).map_err(fail)?);
        }
        let steps = self.steps_now(step, work, s.chunk);
        let (begun, first) = (self.host.clock.now(), self.world.step);
        let control = Control::new(self.cancel.clone(), &|_, _| {});
        if self.asked.lose_device_after.is_some_and(|n| self.state.done >= n) && self.devices_lost == 0 {
            self.engine.lose_device();
        }
        let span = Span { from: self.state.done, steps };
        let engine = self.engine.engine_mut();
        let result = s.scheduled.advance(engine, &mut self.world, span, &control).map_err(Failure::from);
        if let Err(Failure::Device(e)) = result {
            self.go_on_without(e, step)?;
            (s.uses, s.scheduled) = self.scheduled(step, work)?;
            self.phase = Phase::Simulating(s);
            return Ok(true);
        }
        let did = self.world.step - first;
        self.state.done += did;
        self.did(did);
        match result {
            Err(Failure::Work(Error::Cancelled(_))) => {
                self.count_card(&s);
                return Ok(self.turn_away(&Heard::Stop));
            }
            Err(Failure::Work(e)) => return Err(fail(e)),
            Ok(()) | Err(Failure::Device(_)) => {}
        }
        self.measure(&mut s, did, self.host.clock.since(begun));
        let eta = (work.steps - self.state.done) as f64 / s.rate.max(1e-9);
        let (before, share) = overall(&recipe.steps, step.number);
        self.tell(Event::Progress(Progress {
            recipe_step: step.number,
            step: self.state.done,
            total: work.steps,
            steps_per_s: s.rate,
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
        self.phase = Phase::Simulating(s);
        Ok(true)
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
    fn measure(&self, s: &mut Simulation, did: u64, time: Duration) {
        let now = did as f64 / time.as_secs_f64().max(1e-9);
        s.rate = if s.rate == 0.0 { now } else { 0.7 * s.rate + 0.3 * now };
        if self.options.chunk.is_none() {
            // At most twice as long as before: the first steps can be untypically fast.
            s.chunk = ((now * self.chunk_time.as_secs_f64()) as u64).clamp(1, s.chunk.saturating_mul(2));
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
            self.apply(&mut uses, &entry.set).map_err(RunError::Recipe)?;
        }
        let scheduled = schedule(&uses).map_err(|source| RunError::Step { step: label(step), source })?;
        Ok((uses, stepper::Simulation::new(scheduled)))
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

    fn apply(&self, uses: &mut [ProcessUse], set: &str) -> Result<(), Problems> {
        let has = |name: &str| self.world.get(name).is_some();
        process_set::apply(uses, set, &self.host.registry, &self.world.grid, &has)
    }

    /// Changes a parameter of the simulation under way, or warns why not.
    pub(super) fn change(&mut self, step: &Step, uses: Option<&mut Vec<ProcessUse>>, change: &Change) {
        let set = change.to_string();
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
        self.tell(Event::Warning { message: format!("`{set}` was not set: {refused}").into() });
    }
}
