//! What a session does for its recording: frames on the way, and the way back.

use super::Session;
use super::device::Layers;
use crate::clock;
use crate::error::RunError;
use crate::event::Event;
use crate::files::{CHECKPOINT_FILE, TIMELINE_STORE};
use crate::frames::{Damaged, Found, Moment, find, state_of};
use crate::host::NewBranch;
use crate::state::State;
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Worded};
use eyot_io::Origin;
use eyot_io::timeline::{self, Timeline};
use eyot_recipe::{ProcessUse, Recipe, Step, Work};
use serde_json::{Map, Value};
use std::path::Path;

/// The recording of a session at work.
pub(super) struct Recorder {
    timeline: Timeline,
    /// Seconds of a step at the beginning, if they are known.
    clock: Option<f64>,
    /// Whether the last frame shows the world as it is.
    is_current: bool,
    /// Once is enough until a frame succeeds again.
    warned: bool,
}

impl Session {
    /// Begins a recording if the options ask for one, or goes on with that in the folder. Without it the run is the same.
    pub(super) fn begin_recording(&mut self) {
        match self.open_recording() {
            Ok(recorder) => self.recorder = recorder,
            Err(e) => self.tell(Event::Warning { message: remedy!["nothing is recorded: ", e] }),
        }
    }

    fn open_recording(&mut self) -> Result<Option<Recorder>, RunError> {
        let Some(storage) = self.host.storage.clone() else { return Ok(None) };
        let limits = self.options.limits;
        let mut timeline = match self.options.record {
            _ if timeline::is_recording_in(&*storage, TIMELINE_STORE) => {
                Timeline::open_to_write_in(storage.clone(), TIMELINE_STORE, &limits).map_err(RunError::file)?
            }
            Some(record) => {
                let origin = self.origin();
                Timeline::create_in(storage.clone(), TIMELINE_STORE, record, &origin, &limits)
                    .map_err(RunError::file)?
            }
            None => return Ok(None),
        };
        if let Some(record) = self.options.record.filter(|r| *r != timeline.record()) {
            timeline.set_record(record).map_err(RunError::file)?;
        }
        // What is later belongs to another future, or could not be read.
        timeline.truncate(self.world.step + 1).map_err(RunError::file)?;
        self.state.rewound = false;
        if storage.bytes(CHECKPOINT_FILE).is_none() && self.state.place() == (0, 0) {
            // Whoever finds frames beside it knows that the run is not finished.
            self.checkpoint()?;
        }
        let last = timeline.frames().last().filter(|f| f.step == self.world.step);
        // A frame after the last step of a simulation is also one before the next, whichever of both a checkpoint says; written again,
        // it would say the other.
        let here = settled(&self.recipe, self.state.place());
        let is_here = |s: &State| settled(&self.recipe, s.place()) == here;
        let is_current = last.is_some() && state_of(&timeline, timeline.frames().len() - 1).is_ok_and(|s| is_here(&s));
        let clock = clock::of_run(&self.recipe, &self.state.journal, &self.host.registry);
        Ok(Some(Recorder { timeline, clock, is_current, warned: false }))
    }

    /// What the root of the recording says, beside its time.
    fn origin(&self) -> Map<String, Value> {
        let clock = clock::of_run(&self.recipe, &self.state.journal, &self.host.registry);
        let origin = Origin {
            name: &self.recipe.name,
            recipe: Some(&self.recipe.source.text),
            seconds_per_step: clock,
            engines: &self.state.engines,
        };
        let origin = origin.attributes(&self.world);
        origin.into_iter().filter(|(key, _)| !["steps_done", "sea_level_m"].contains(&key.as_str())).collect()
    }

    /// Steps of simulation from one frame to the next.
    pub(super) fn frame_distance(&self) -> u64 {
        self.recorder.as_ref().map_or(u64::MAX, |r| r.timeline.record().every)
    }

    /// Steps of simulation to the next frame.
    pub(super) fn steps_to_frame(&self) -> u64 {
        let distance = self.frame_distance();
        distance - self.world.step % distance
    }

    /// Writes a frame of the world as it is, in the place of any of the same step. One that cannot be written is no reason to
    /// end: the next may succeed.
    pub(super) fn record(&mut self) {
        if self.recorder.as_ref().is_none_or(|r| r.is_current) {
            return;
        }
        self.settle();
        self.state.seconds = self.seconds();
        let state = serde_json::to_value(State { rewound: false, ..self.state.clone() });
        let Some(recorder) = &mut self.recorder else { return };
        let (timeline, world) = (&mut recorder.timeline, &self.world);
        let written = state.map_err(|e| Remedy::from(e.to_string())).and_then(|state| {
            timeline.truncate(world.step).map_err(Remedy::from)?;
            timeline.append(world, &self.recipe.source.text, &state).map_err(Remedy::from)
        });
        recorder.is_current = written.is_ok();
        let silent = std::mem::replace(&mut recorder.warned, written.is_err());
        let frames = timeline.frames();
        match (written, frames.last()) {
            (Ok(()), Some(frame)) => {
                let (frame, number) = (*frame, frames.len() - 1);
                self.tell(Event::Recorded { frame: number, steps_done: frame.step, bytes: frame.bytes });
            }
            (Err(e), _) if !silent => {
                self.tell(Event::Warning { message: remedy!["no frame: ", e, "; the run goes on and tries again"] });
            }
            _ => {}
        }
    }

    /// To be called before the world or the processes change: frames of another future go.
    pub(super) fn go_on_from_here(&mut self) {
        let was_set_back = std::mem::take(&mut self.state.rewound);
        self.invalidate_view();
        let Some(recorder) = &mut self.recorder else { return };
        recorder.is_current = false;
        if was_set_back && let Err(e) = recorder.timeline.truncate(self.world.step + 1) {
            self.tell(Event::Warning { message: remedy!["frames of another future are still there: ", e] });
        }
    }

    /// To be called when parameters have changed: a recording whose steps differ in length has none.
    pub(super) fn keep_time(&mut self, uses: &[ProcessUse]) {
        let clock = clock::of_step(uses, &self.world.grid);
        let Some(recorder) = &mut self.recorder else { return };
        let lost = if recorder.clock == clock { Ok(()) } else { recorder.timeline.lose_clock() };
        if let Err(e) = lost {
            self.tell(Event::Warning { message: remedy!["the recording's times are wrong from here on: ", e] });
        }
    }

    /// Sets the run back, or forth again, to the last frame of at most `step` steps.
    pub(super) fn rewind_to(&mut self, step: u64, forget: bool) -> Result<(), RunError> {
        let recorder = self.recorder.as_mut().ok_or_else(not_recorded)?;
        let Found { frame, saved, state, damaged } =
            find(&recorder.timeline, Moment::Step(step), self.host.registry.components())?;
        recorder.is_current = true;
        self.tell_damaged(&damaged);
        self.invalidate_view();
        self.world = saved.world;
        // What it holds belongs to the moment before.
        self.engine.engine_mut().release();
        self.layers = Layers::Current;
        self.state = State { engine: self.asked.clone(), ..state.again(&self.state.changes(), forget) };
        self.settled = self.state.done;
        self.tell(Event::Rewound {
            frame: frame.frame,
            steps_done: self.world.step,
            recipe_step: self.state.done_steps + 1,
            step: self.state.done,
        });
        Ok(())
    }

    /// Puts the last frame of at most `step` steps into another folder.
    pub(super) fn branch(&mut self, step: u64, out: &Path) -> Result<(), RunError> {
        let recorder = self.recorder.as_ref().ok_or_else(not_recorded)?;
        let Found { frame, saved, state, damaged } =
            find(&recorder.timeline, Moment::Step(step), self.host.registry.components())?;
        let state = state.again(&self.state.changes(), false);
        let branches = self.host.branches.as_ref().ok_or_else(|| RunError::input("there is no place for it here"))?;
        let recording = &recorder.timeline;
        branches.begin(&NewBranch { recording, frame: frame.frame, saved: &saved, state: &state, out })?;
        self.tell_damaged(&damaged);
        self.tell(Event::Branched { out: out.to_owned(), steps_done: frame.steps_done });
        Ok(())
    }

    fn tell_damaged(&self, damaged: &[Damaged]) {
        for d in damaged {
            self.tell(Event::Warning { message: remedy![d.sentence(), "; an earlier frame took its place"] });
        }
    }
}

/// A place in a recipe, with all behind it that changes nothing more: the same for all places where the world is the same.
fn settled(recipe: &Recipe, (mut step, mut done): (usize, u64)) -> (usize, u64) {
    let is_over = |step: &Step, done: u64| match &step.work {
        _ if !step.enabled => true,
        Work::Simulate(work) => done >= work.steps,
        Work::Generate(_) => false,
    };
    while recipe.steps.get(step).is_some_and(|s| is_over(s, done)) {
        (step, done) = (step + 1, 0);
    }
    (step, done)
}

fn not_recorded() -> RunError {
    RunError::input("the run is not recorded")
}
