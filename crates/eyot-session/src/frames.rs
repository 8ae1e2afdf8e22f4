//! Frames of a recording and what a stopped run goes on from.

use crate::error::RunError;
use crate::files::{CHECKPOINT_FILE, TIMELINE_STORE};
use crate::state::State;
use eyot_core::remedy;
use eyot_core::remedy::{Action, Remedy, Setting, Worded};
use eyot_core::{ComponentKinds, Limits, World};
use eyot_io::checkpoint::{self, Checkpoint};
use eyot_io::storage::Storage;
use eyot_io::timeline;
use eyot_recipe::{Recipe, Registry, Work, memory};
use serde::Serialize;
use std::sync::Arc;

/// A recorded moment of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Frame {
    /// Its number, from 0.
    pub frame: usize,
    /// Steps of simulation done, of all steps of the recipe together.
    pub steps_done: u64,
    /// Number of the recipe's step that is under way or comes next, from 1.
    pub recipe_step: usize,
    /// Steps done of it.
    pub step: u64,
    /// Bytes of its files.
    pub bytes: u64,
}

/// A recorded moment that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Damaged {
    /// The frame's number, from 0.
    pub frame: usize,
    /// Steps of simulation done.
    pub steps_done: u64,
    /// What is missing or wrong, with its file.
    pub reason: Remedy,
}

impl Worded for Damaged {
    fn sentence(&self) -> Remedy {
        remedy![format!("frame {} of step {} cannot be read: ", self.frame, self.steps_done), self.reason.clone()]
    }
}

impl std::fmt::Display for Damaged {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.sentence().fmt(f)
    }
}

/// Which frame is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Moment {
    /// The last one that has at most so many steps of simulation done.
    Step(u64),
    /// That of this number, from 0.
    Frame(usize),
}

/// What a stopped run goes on from: its checkpoint `name`, or the last frame that was recorded if that is later.
fn latest(
    storage: &Arc<dyn Storage>,
    name: &str,
    limits: &Limits,
    kinds: &ComponentKinds,
    warnings: &mut Vec<Remedy>,
) -> Result<(Checkpoint, State), Remedy> {
    let of_checkpoint = checkpoint::load_in(&**storage, name, limits, kinds).map_err(Remedy::from).and_then(|saved| {
        let state: State = serde_json::from_value(saved.state.clone())
            .map_err(|e| format!("`{}` holds no state of a run: {e}", storage.place(name).display()))
            .map_err(Remedy::from)?;
        Ok((saved, state))
    });
    // Where a run was set back, later frames are of another future.
    if name != CHECKPOINT_FILE || of_checkpoint.as_ref().is_ok_and(|(_, s)| s.rewound) {
        return of_checkpoint;
    }
    match last_frame(storage, of_checkpoint.as_ref().ok().map(|(_, s)| s.place()), limits, kinds, warnings) {
        Ok(Some((saved, state))) => {
            if let Err(e) = of_checkpoint {
                warnings.push(remedy![e, "; the run goes on from its recording"]);
            }
            Ok((saved, state))
        }
        Ok(None) => of_checkpoint,
        Err(e) => {
            if of_checkpoint.is_ok() {
                warnings.push(remedy![e, "; the run goes on from its checkpoint"]);
            }
            of_checkpoint
        }
    }
}

/// The stopped run in a storage, that goes on from its checkpoint `name` or from a later frame.
pub(crate) fn stopped(
    storage: &Arc<dyn Storage>,
    name: &str,
    limits: &Limits,
    registry: &Registry,
    warnings: &mut Vec<Remedy>,
) -> Result<(Recipe, World, State), RunError> {
    let damaged = |reason: Remedy| RunError::Checkpoint { folder: storage.place(""), reason };
    let (saved, state) = latest(storage, name, limits, registry.components(), warnings).map_err(damaged)?;
    let recipe = state.recipe(saved.recipe_toml, state.overrides.clone(), registry, limits)?;
    fits(&recipe, &saved.world, &state)
        .map_err(|e| damaged(format!("`{}` does not fit its recipe: {e}", storage.place(name).display()).into()))?;
    if state.place() == (0, 0) && !state.rewound {
        warnings.push("the run was stopped before its first step was done; it begins anew".into());
    }
    if saved.engine_version != crate::VERSION {
        let message = format!(
            "the checkpoint was written by version {}, this is {}; the result may differ from a run in one piece",
            saved.engine_version,
            crate::VERSION
        );
        warnings.push(message.into());
    }
    Ok((recipe, saved.world, state))
}

/// The last frame in a storage that can be read, if it is later than `than`.
fn last_frame(
    storage: &Arc<dyn Storage>,
    than: Option<(usize, u64)>,
    limits: &Limits,
    kinds: &ComponentKinds,
    warnings: &mut Vec<Remedy>,
) -> Result<Option<(Checkpoint, State)>, RunError> {
    if !timeline::is_recording_in(&**storage, TIMELINE_STORE) {
        return Ok(None);
    }
    let opened = timeline::Timeline::open_to_write_in(storage.clone(), TIMELINE_STORE, limits);
    let store = opened.map_err(RunError::input)?;
    for i in (0..store.frames().len()).rev() {
        let state = state_of(&store, i);
        if than.is_some_and(|place| state.as_ref().is_ok_and(|s| s.place() <= place)) {
            break;
        }
        match state.and_then(|state| Ok((store.load(i, kinds).map_err(Remedy::from)?, state))) {
            Ok(found) => return Ok(Some(found)),
            Err(reason) => warnings.push(broken(&store, i, reason).sentence()),
        }
    }
    Ok(None)
}

/// Refuses recordings that cannot be: nowhere, of nothing, or within a bound that is too small.
pub(crate) fn check(recipe: &Recipe, record: Option<timeline::Record>, has_folder: bool) -> Result<(), RunError> {
    let Some(record) = record else { return Ok(()) };
    let refuse = |reason: &'static str, help: Remedy| Err(RunError::refused(reason, help));
    if !has_folder {
        return refuse("a run without a folder cannot be recorded", "give it a folder for its results".into());
    }
    if !recipe.enabled_steps().any(|s| matches!(s.work, Work::Simulate(_))) {
        return refuse(
            "the recipe simulates nothing, so there is nothing to record",
            remedy!["leave out ", Setting::Record],
        );
    }
    let peak = memory::working(&recipe.steps, &recipe.grid).map_err(RunError::input)?;
    let least = timeline::Record::least_bytes(peak.world_bytes, peak.layers, recipe.source.text.len());
    if u128::from(record.max_bytes) < least {
        let reason = format!(
            "a recording within {} KiB cannot hold two frames of this world; it needs {} KiB",
            record.max_bytes >> 10,
            least.div_ceil(1 << 10)
        );
        return Err(RunError::refused(reason, remedy!["raise ", Setting::RecordLimit, ", or choose a smaller grid"]));
    }
    Ok(())
}

/// What to do about a frame that cannot be read.
pub(crate) fn other_frame() -> Remedy {
    remedy!["choose another frame: ", Action::Timeline, " lists them, and those whose head is lost"]
}

/// A frame that could be read.
pub(crate) struct Found {
    pub(crate) frame: Frame,
    pub(crate) saved: Checkpoint,
    pub(crate) state: State,
    /// Frames that would have come nearer but cannot be read.
    pub(crate) damaged: Vec<Damaged>,
}

/// The frame that is meant. If that of a step cannot be read, the next earlier one that can.
pub(crate) fn find(store: &timeline::Timeline, moment: Moment, kinds: &ComponentKinds) -> Result<Found, RunError> {
    let last = position(store.frames(), moment)?;
    let first = if let Moment::Frame(i) = moment { i } else { 0 };
    let mut damaged = Vec::new();
    for i in (first..=last).rev() {
        let read = state_of(store, i).and_then(|s| Ok((store.load(i, kinds).map_err(Remedy::from)?, s)));
        match read {
            Ok((saved, state)) => {
                damaged.reverse();
                return Ok(Found { frame: frame_of(store, i, &state), saved, state, damaged });
            }
            Err(reason) => damaged.push(broken(store, i, reason)),
        }
    }
    Err(RunError::refused(Remedy::joined(damaged.iter().rev().map(Damaged::sentence), "; "), other_frame()))
}

/// The number of the frame that is meant, whether it can be read or not.
pub(crate) fn position(frames: &[timeline::Frame], moment: Moment) -> Result<usize, RunError> {
    let refuse = |reason: String, help: Remedy| Err(RunError::refused(reason, help));
    match moment {
        Moment::Step(step) => match frames.partition_point(|f| f.step <= step).checked_sub(1) {
            Some(i) => Ok(i),
            None => {
                let reason = match frames.first() {
                    Some(first) => format!("the recording begins at step {}, {step} is before that", first.step),
                    None => "the recording has no frames yet".to_owned(),
                };
                refuse(reason, remedy![Action::Timeline, " lists what there is"])
            }
        },
        Moment::Frame(i) if i < frames.len() => Ok(i),
        Moment::Frame(i) => {
            let reason = format!("there is no frame {i}, the recording has {}", frames.len());
            refuse(reason, remedy![Action::Timeline, " lists what there is; the first is 0"])
        }
    }
}

/// What the run remembers in a frame, whose values may be damaged.
pub(crate) fn state_of(store: &timeline::Timeline, i: usize) -> Result<State, Remedy> {
    of_json(i, store.state(i).map_err(Remedy::from)?)
}

pub(crate) fn of_json(i: usize, state: serde_json::Value) -> Result<State, Remedy> {
    serde_json::from_value(state).map_err(|e| format!("frame {i} holds no state of a run: {e}").into())
}

pub(crate) fn frame_of(store: &timeline::Timeline, i: usize, state: &State) -> Frame {
    let frame = store.frames()[i];
    Frame { frame: i, steps_done: frame.step, recipe_step: state.done_steps + 1, step: state.done, bytes: frame.bytes }
}

pub(crate) fn broken(store: &timeline::Timeline, i: usize, reason: Remedy) -> Damaged {
    Damaged { frame: i, steps_done: store.frames()[i].step, reason }
}

/// Refuses a saved world and its state that no run of the recipe comes to.
pub(crate) fn fits(recipe: &Recipe, world: &World, state: &State) -> Result<(), String> {
    if state.done_steps > recipe.steps.len() {
        return Err(format!("{} steps of the recipe are done, it has {}", state.done_steps, recipe.steps.len()));
    }
    if world.grid != recipe.grid {
        let size =
            |g: &eyot_core::Grid| format!("{} x {} cells of {} x {} m", g.width, g.height, g.cell_x_m, g.cell_y_m);
        return Err(format!("its world has {}, the recipe's {}", size(&world.grid), size(&recipe.grid)));
    }
    let steps = |work: &Work| if let Work::Simulate(s) = work { s.steps } else { 0 };
    let most = recipe.steps.get(state.done_steps).map_or(0, |s| steps(&s.work));
    if state.done > most {
        return Err(format!("{} steps of recipe step {} are done, it has {most}", state.done, state.done_steps + 1));
    }
    let all: u64 = recipe.steps.iter().map(|s| steps(&s.work)).sum();
    if world.step > all {
        return Err(format!("its world is at step {}, the recipe has {all}", world.step));
    }
    Ok(())
}
