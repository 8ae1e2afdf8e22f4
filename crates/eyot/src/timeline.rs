//! Recordings of runs: what is in them, and ways back.
//!
//! A run with [`RunOptions::record`](crate::RunOptions::record) writes frames to [`TIMELINE_STORE`] in its folder: every so
//! many steps of simulation, at both ends of each simulation, and at the end of the run. Of each step there is one frame, the
//! last state that had this step. A frame is a checkpoint: [`rewind`] sets a run back to one, [`branch`] begins another run
//! there, and [`Run::resume`](crate::Run::resume) goes on from either as the run itself did.

use crate::backend::io::checkpoint::{self, Checkpoint};
use crate::backend::io::{self, timeline};
use crate::error::RunError;
use crate::lock::FolderLock;
use crate::need;
use crate::recipe::{Recipe, Work};
use crate::registry::Registry;
use crate::run::RunOptions;
use crate::state::State;
use crate::store::{self, CHECKPOINT_FILE, TIMELINE_STORE, WORLD_FILE};
use eyot_core::{Limits, World};
use serde::Serialize;
use std::path::Path;

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

/// Which frame is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// The last one that has at most so many steps of simulation done.
    Step(u64),
    /// That of this number, from 0.
    Frame(usize),
}

/// The recording of a run, to look at.
#[derive(Debug)]
pub struct Timeline {
    store: timeline::Timeline,
    frames: Vec<Frame>,
}

impl Timeline {
    /// Opens the recording in the folder of a run. The run may be at work; frames that thin out meanwhile cannot be loaded.
    ///
    /// # Errors
    /// If there is none, or it is damaged.
    pub fn open(folder: &Path, limits: &Limits) -> Result<Self, RunError> {
        let path = recording(folder)?;
        // What a killed run had begun would hide frames.
        let lock = timeline::is_cut_off(&path).then(|| FolderLock::take(folder).ok()).flatten();
        let store = open(&path, lock.as_ref(), limits)?;
        let frames = (0..store.frames().len()).map(|i| frame_of(&store, i)).collect::<Result<_, _>>()?;
        Ok(Self { store, frames })
    }

    /// All frames, oldest first.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Steps of simulation from one frame to the next, and the bytes that all may take.
    pub fn record(&self) -> timeline::Record {
        self.store.record()
    }

    /// The frame that is meant.
    ///
    /// # Errors
    /// If there is none.
    pub fn find(&self, moment: Moment) -> Result<Frame, RunError> {
        find(&self.store, moment).map(|i| self.frames[i])
    }

    /// The world of frame `i`.
    ///
    /// # Errors
    /// If there is no such frame, it is damaged or exceeds the limits.
    pub fn load(&self, i: usize) -> Result<World, RunError> {
        self.store.load(i).map(|c| c.world).map_err(RunError::input)
    }
}

/// What [`rewind`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Rewound {
    /// Where the run is now.
    #[serde(flatten)]
    pub frame: Frame,
    /// Later frames that were dropped.
    pub dropped: usize,
    /// Whether the folder holds the results of the run as it was.
    pub has_results: bool,
}

/// Sets the run in a folder back to a recorded moment: later frames are dropped, and [`Run::resume`](crate::Run::resume) goes
/// on from there, with the same bytes as the first time. Changes by hand that came later will be made again, unless they are
/// to be forgotten. Results of a finished run stay until the run has new ones.
///
/// # Errors
/// If a run is at work in the folder, there is no recording or no such moment in it, or files cannot be written.
pub fn rewind(folder: &Path, moment: Moment, forget: bool, limits: &Limits) -> Result<Rewound, RunError> {
    let path = recording(folder)?;
    let _lock = FolderLock::take(folder)?;
    io::remove_leftovers(folder);
    let mut store = timeline::Timeline::open_to_write(&path, limits).map_err(RunError::input)?;
    let i = find(&store, moment)?;
    let state = state_of(&store, i)?.again(&newest(folder, &store)?.changes(), forget);
    let frame = frame_of(&store, i)?;
    let dropped = store.frames().len() - 1 - i;
    save(&folder.join(CHECKPOINT_FILE), &store.load(i).map_err(RunError::input)?, &state)?;
    // The checkpoint says that the run was set back: were this process killed here, `resume` would do the rest.
    store.truncate(frame.steps_done + 1).map_err(RunError::file)?;
    Ok(Rewound { frame, dropped, has_results: folder.join(WORLD_FILE).exists() })
}

/// What is different in a branch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Branching {
    /// Changes to the recipe from there on, as `--set` takes them.
    pub set: Vec<String>,
    /// Whether later changes by hand are dropped.
    pub forget: bool,
}

/// Begins another run in the folder `out`, which is new, at a recorded moment of the one in `folder`, which stays as it is.
///
/// # Errors
/// As [`rewind`]; if `out` is not empty, or if the recipe does not pass its checks with the changes or they would have changed
/// what is already there.
pub fn branch(
    folder: &Path,
    moment: Moment,
    out: &Path,
    how: &Branching,
    registry: &Registry,
    limits: &Limits,
) -> Result<Frame, RunError> {
    let path = recording(folder)?;
    let lock = FolderLock::take(folder)?;
    let store = open(&path, Some(&lock), limits)?;
    let i = find(&store, moment)?;
    let mut state = state_of(&store, i)?.again(&newest(folder, &store)?.changes(), how.forget);
    if !how.set.is_empty() {
        let text = store.load(i).map_err(RunError::input)?.recipe_toml;
        let recipe = changed(&state, text, &how.set, registry, limits)?;
        (state.overrides, state.texts) = (recipe.overrides, recipe.texts);
    }
    branch_off(&store, i, &state, out)?;
    frame_of(&store, i)
}

/// The recipe of a run with more changes.
fn changed(
    state: &State,
    text: String,
    set: &[String],
    registry: &Registry,
    limits: &Limits,
) -> Result<Recipe, RunError> {
    let mut overrides = state.overrides.clone();
    let before = Recipe::of_run(state, text.clone(), overrides.clone(), registry, limits)?;
    overrides.set.extend_from_slice(set);
    let after = Recipe::of_run(state, text, overrides, registry, limits)?;
    let start = |r: &Recipe| (r.grid, r.seed, r.sea_level_m.to_bits(), r.steps.len());
    if start(&before) != start(&after) {
        let reason = "grid, seed, sea level and number of steps are settled at this moment".to_owned();
        return Err(RunError::Input { reason, help: Some("start a new run with these changes") });
    }
    let done = state.done_steps.min(after.steps.len());
    let differ = |from: usize, to: usize| {
        before.steps[from..to].iter().zip(&after.steps[from..to]).find(|(a, b)| !a.does_as(b)).map(|(a, _)| a)
    };
    if let Some(step) = differ(0, done).filter(|_| differ(done, after.steps.len()).is_none()) {
        let reason = format!("step {} ({}) is done at this moment: a change comes too late", step.number, step.name);
        return Err(RunError::Input { reason, help: Some("branch at an earlier moment, or start a new run") });
    }
    Ok(after)
}

/// Puts frame `i` of a recording, with those before it, into a new folder where it can be resumed.
pub(crate) fn branch_off(store: &timeline::Timeline, i: usize, state: &State, out: &Path) -> Result<(), RunError> {
    let fail = |source| RunError::Folder { path: out.to_owned(), source };
    std::fs::create_dir_all(out).map_err(fail)?;
    if std::fs::read_dir(out).map_err(fail)?.next().is_some() {
        let reason = format!("`{}` is not empty", out.display());
        return Err(RunError::Input { reason, help: Some("name a new folder for the branch") });
    }
    let _lock = FolderLock::take(out)?;
    let saved = store.load(i).map_err(RunError::input)?;
    store.copy(i + 1, &out.join(TIMELINE_STORE)).map_err(RunError::file)?;
    // Last: with it, there is a run that can be resumed.
    save(&out.join(CHECKPOINT_FILE), &saved, state)
}

/// What a stopped run goes on from: its checkpoint at `path`, or the last frame that was recorded if that is later.
pub(crate) fn latest(
    folder: &Path,
    path: &Path,
    limits: &Limits,
    warnings: &mut Vec<String>,
) -> Result<(Checkpoint, State), String> {
    let of_checkpoint = checkpoint::load(path, limits).map_err(|e| e.to_string()).and_then(|saved| {
        let state: State = serde_json::from_value(saved.state.clone())
            .map_err(|e| format!("`{}` holds no state of a run: {e}", path.display()))?;
        Ok((saved, state))
    });
    // Where a run was set back, later frames are of another future.
    if !path.ends_with(CHECKPOINT_FILE) || of_checkpoint.as_ref().is_ok_and(|(_, s)| s.rewound) {
        return of_checkpoint;
    }
    match last_frame(folder, of_checkpoint.as_ref().ok().map(|(_, s)| s.place()), limits) {
        Ok(Some((saved, state))) => {
            if let Err(e) = of_checkpoint {
                warnings.push(format!("{e}; the run goes on from its recording"));
            }
            Ok((saved, state))
        }
        Ok(None) => of_checkpoint,
        Err(e) => {
            if of_checkpoint.is_ok() {
                warnings.push(format!("{e}; the run goes on from its checkpoint"));
            }
            of_checkpoint
        }
    }
}

/// The last frame in a folder if it is later than `than`.
fn last_frame(
    folder: &Path,
    than: Option<(usize, u64)>,
    limits: &Limits,
) -> Result<Option<(Checkpoint, State)>, RunError> {
    let path = folder.join(TIMELINE_STORE);
    if !timeline::is_recording(&path) {
        return Ok(None);
    }
    let store = timeline::Timeline::open_to_write(&path, limits).map_err(RunError::input)?;
    let Some(last) = store.frames().len().checked_sub(1) else { return Ok(None) };
    let state = state_of(&store, last)?;
    if than.is_some_and(|place| state.place() <= place) {
        return Ok(None);
    }
    Ok(Some((store.load(last).map_err(RunError::input)?, state)))
}

/// Refuses recordings that cannot be: nowhere, of nothing, or within a bound that is too small.
pub(crate) fn check(recipe: &Recipe, options: &RunOptions) -> Result<(), RunError> {
    let Some(record) = options.record else { return Ok(()) };
    let refuse = |reason: &str, help| Err(RunError::Input { reason: reason.to_owned(), help: Some(help) });
    if options.out.is_none() {
        return refuse("a run without a folder cannot be recorded", "give it a folder for its results");
    }
    if !recipe.enabled_steps().any(|s| matches!(s.work, Work::Simulate(_))) {
        return refuse("the recipe simulates nothing, so there is nothing to record", "leave out --record");
    }
    let peak = need::working(&recipe.steps, &recipe.grid).map_err(RunError::input)?;
    let least = timeline::Record::least_bytes(peak.world_bytes, peak.layers, recipe.source.text.len());
    if u128::from(record.max_bytes) < least {
        let reason = format!(
            "a recording within {} KiB cannot hold two frames of this world; it needs {} KiB",
            record.max_bytes >> 10,
            least.div_ceil(1 << 10)
        );
        return Err(RunError::Input { reason, help: Some("raise --record-limit, or choose a smaller grid") });
    }
    Ok(())
}

/// The frame of at most `step` steps that comes last.
pub(crate) fn position(frames: &[timeline::Frame], step: u64) -> Result<usize, RunError> {
    frames.partition_point(|f| f.step <= step).checked_sub(1).ok_or_else(|| {
        let reason = match frames.first() {
            Some(first) => format!("the recording begins at step {}, {step} is before that", first.step),
            None => "the recording has no frames yet".to_owned(),
        };
        RunError::Input { reason, help: Some("`eyot timeline` lists what there is") }
    })
}

fn find(store: &timeline::Timeline, moment: Moment) -> Result<usize, RunError> {
    match moment {
        Moment::Step(step) => position(store.frames(), step),
        Moment::Frame(i) if i < store.frames().len() => Ok(i),
        Moment::Frame(i) => {
            let reason = format!("there is no frame {i}, the recording has {}", store.frames().len());
            Err(RunError::Input { reason, help: Some("`eyot timeline` lists what there is; the first is 0") })
        }
    }
}

/// What the run remembers in a frame.
pub(crate) fn state_of(store: &timeline::Timeline, i: usize) -> Result<State, RunError> {
    let state = store.state(i).map_err(RunError::input)?;
    serde_json::from_value(state).map_err(|e| RunError::input(format!("frame {i} holds no state of a run: {e}")))
}

fn frame_of(store: &timeline::Timeline, i: usize) -> Result<Frame, RunError> {
    let (frame, state) = (store.frames()[i], state_of(store, i)?);
    Ok(Frame {
        frame: i,
        steps_done: frame.step,
        recipe_step: state.done_steps + 1,
        step: state.done,
        bytes: frame.bytes,
    })
}

/// The latest state of the run in a folder, which knows all changes by hand.
fn newest(folder: &Path, store: &timeline::Timeline) -> Result<State, RunError> {
    let read = |path: &Path| -> Result<State, RunError> {
        let state = checkpoint::load_state(path).map_err(RunError::input)?;
        serde_json::from_value(state).map_err(|e| RunError::input(format!("`{}`: {e}", path.display())))
    };
    let last = store.frames().len().checked_sub(1).map(|i| state_of(store, i)).transpose()?;
    let unfinished = store::unfinished(folder);
    let file = unfinished.clone().unwrap_or_else(|| folder.join(WORLD_FILE));
    match (last, file.exists()) {
        (Some(last), true) => {
            let saved = read(&file)?;
            let frame_is_later = unfinished.is_some() && !saved.rewound && last.place() > saved.place();
            Ok(if frame_is_later { last } else { saved })
        }
        (Some(last), false) => Ok(last),
        (None, _) => read(&file),
    }
}

/// A recording to read; with a lock, what a killed run had begun with it is done first.
fn open(path: &Path, lock: Option<&FolderLock>, limits: &Limits) -> Result<timeline::Timeline, RunError> {
    let opened = match lock {
        Some(_) if timeline::is_cut_off(path) => timeline::Timeline::open_to_write(path, limits),
        _ => timeline::Timeline::open(path, limits),
    };
    opened.map_err(RunError::input)
}

fn recording(folder: &Path) -> Result<std::path::PathBuf, RunError> {
    let path = folder.join(TIMELINE_STORE);
    if path.is_dir() {
        return Ok(path);
    }
    let reason = format!("`{}` holds no recording of a run", folder.display());
    Err(RunError::Input { reason, help: Some("record one with `eyot run RECIPE --record STEPS`") })
}

fn save(path: &Path, frame: &Checkpoint, state: &State) -> Result<(), RunError> {
    let state = serde_json::to_value(state).map_err(|e| RunError::Fault(e.to_string()))?;
    checkpoint::save(path, &frame.world, &frame.recipe_toml, &state).map_err(RunError::file)
}
