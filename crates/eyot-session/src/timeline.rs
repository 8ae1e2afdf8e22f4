//! Recordings of runs: what is in them, and ways back.
//!
//! A run with [`RunOptions::record`](crate::RunOptions::record) writes frames to [`TIMELINE_STORE`] in its folder: every so
//! many steps of simulation, at both ends of each simulation, and at the end of the run. Of each step there is one frame, the
//! last state that had this step. A frame is a checkpoint: [`rewind`] sets a run back to one, [`branch`] begins another run
//! there, and [`Run::resume`](crate::Run::resume) goes on from either as the run itself did.

use crate::error::RunError;
use crate::files::{CHECKPOINT_FILE, TIMELINE_STORE, WORLD_FILE, unfinished};
pub use crate::frames::{Damaged, Frame, Moment};
use crate::frames::{Found, broken, find, fits, frame_of, of_json, other_frame, position, state_of};
use crate::lock::FolderLock;
use crate::state::State;
use eyot_core::remedy;
use eyot_core::remedy::{Action, Remedy, Worded};
use eyot_core::{ComponentKinds, Limits, World};
use eyot_io::checkpoint::{self, Checkpoint};
use eyot_io::storage::Folder;
use eyot_io::{self as io, timeline};
use eyot_recipe::{Recipe, Registry, View};
use serde::Serialize;
use std::path::{Component, Path, PathBuf};

/// The recording of a run, to look at.
#[derive(Debug)]
pub struct Timeline {
    store: timeline::Timeline,
    frames: Vec<Frame>,
    damaged: Vec<Damaged>,
}

impl Timeline {
    /// Opens the recording in the folder of a run. The run may be at work; frames that thin out meanwhile cannot be loaded.
    ///
    /// # Errors
    /// If there is none, or what belongs to all frames is damaged. Single frames that are missing or damaged are set apart.
    pub fn open(folder: &Path, limits: &Limits) -> Result<Self, RunError> {
        let path = recording(folder)?;
        // What a killed run had begun would hide frames.
        let lock = timeline::is_cut_off(&path).then(|| FolderLock::take(folder).ok()).flatten();
        let store = open(&path, lock.as_ref(), limits)?;
        let (mut frames, mut damaged) = (Vec::new(), Vec::new());
        for i in 0..store.frames().len() {
            match store.look(i).map_err(Remedy::from).and_then(|state| of_json(i, state)) {
                Ok(state) => frames.push(frame_of(&store, i, &state)),
                Err(reason) => damaged.push(broken(&store, i, reason)),
            }
        }
        Ok(Self { store, frames, damaged })
    }

    /// All frames whose files are there, oldest first. Numbers of others are left out.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// The frames that are missing or damaged, oldest first, as far as that shows before they are loaded.
    pub fn damaged(&self) -> &[Damaged] {
        &self.damaged
    }

    /// Steps of simulation from one frame to the next, and the bytes that all may take.
    pub fn record(&self) -> timeline::Record {
        self.store.record()
    }

    /// The frame that is meant.
    ///
    /// # Errors
    /// If there is none, or the frame of this number is damaged.
    pub fn find(&self, moment: Moment) -> Result<Frame, RunError> {
        let i = position(self.store.frames(), moment)?;
        let found =
            self.frames.iter().rfind(|f| if let Moment::Frame(_) = moment { f.frame == i } else { f.frame <= i });
        found.copied().ok_or_else(|| {
            let reasons = self.damaged.iter().filter(|d| d.frame <= i).map(Damaged::sentence);
            RunError::refused(Remedy::joined(reasons, "; "), other_frame())
        })
    }

    /// The view of its recipe.
    ///
    /// # Errors
    /// If the head of its last frame cannot be read any more.
    pub fn view(&self) -> Result<View, RunError> {
        let Some(last) = self.frames.last() else { return Ok(View::default()) };
        let recipe = self.store.recipe_toml(last.frame).map_err(RunError::input)?;
        let state = self.store.state(last.frame).map_err(RunError::input)?;
        Ok(eyot_recipe::view_of(&recipe.into(), &state["overrides"]["set"]))
    }

    /// The world of the frame with the number `i`, with components of these kinds.
    ///
    /// # Errors
    /// If there is no such frame, it is damaged or exceeds the limits.
    pub fn load(&self, i: usize, kinds: &ComponentKinds) -> Result<World, RunError> {
        self.store.load(i, kinds).map(|c| c.world).map_err(RunError::input)
    }
}

/// What [`rewind`] did.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Rewound {
    /// Where the run is now.
    #[serde(flatten)]
    pub frame: Frame,
    /// Later frames that were dropped.
    pub dropped: usize,
    /// Frames that would have come nearer but cannot be read.
    pub damaged: Vec<Damaged>,
    /// Whether the folder holds the results of the run as it was.
    pub has_results: bool,
}

/// Sets the run in a folder back to a recorded moment: later frames are dropped, and [`Run::resume`](crate::Run::resume) goes
/// on from there, with the same bytes as the first time. Changes by hand that came later will be made again, unless they are
/// to be forgotten. Results of a finished run stay until the run has new ones.
///
/// # Errors
/// If a run is at work in the folder, there is no recording or no such moment in it, or files cannot be written. A frame that cannot
/// be read is an error if it is asked for by its number; otherwise an earlier one takes its place.
pub fn rewind(
    folder: &Path,
    moment: Moment,
    forget: bool,
    registry: &Registry,
    limits: &Limits,
) -> Result<Rewound, RunError> {
    let path = recording(folder)?;
    let _lock = FolderLock::take(folder)?;
    io::remove_leftovers(folder);
    let mut store = timeline::Timeline::open_to_write(&path, limits).map_err(RunError::input)?;
    let Found { frame, saved, state, damaged } = find(&store, moment, registry.components())?;
    let recipe = state.recipe(saved.recipe_toml.clone(), state.overrides.clone(), registry, limits)?;
    fits(&recipe, &saved.world, &state).map_err(|e| of_no_run(&frame, &e))?;
    let state = state.again(&newest(folder, &store)?.changes(), forget);
    let dropped = store.frames().len() - 1 - frame.frame;
    save(&folder.join(CHECKPOINT_FILE), &saved, &state)?;
    // The checkpoint says that the run was set back: were this process killed here, `resume` would do the rest.
    store.truncate(frame.steps_done + 1).map_err(RunError::file)?;
    Ok(Rewound { frame, dropped, damaged, has_results: folder.join(WORLD_FILE).exists() })
}

/// What is different in a branch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Branching {
    /// Changes to the recipe from there on, as `--set` takes them.
    pub set: Vec<String>,
    /// Whether later changes by hand are dropped.
    pub forget: bool,
}

/// What [`branch`] did.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Branched {
    /// Where the new run is.
    #[serde(flatten)]
    pub frame: Frame,
    /// Frames that would have come nearer but cannot be read.
    pub damaged: Vec<Damaged>,
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
) -> Result<Branched, RunError> {
    let path = recording(folder)?;
    let lock = FolderLock::take(folder)?;
    let store = open(&path, Some(&lock), limits)?;
    let Found { frame, saved, state, damaged } = find(&store, moment, registry.components())?;
    let text = saved.recipe_toml.clone();
    let before = state.recipe(text.clone(), state.overrides.clone(), registry, limits)?;
    fits(&before, &saved.world, &state).map_err(|e| of_no_run(&frame, &e))?;
    let mut state = state.again(&newest(folder, &store)?.changes(), how.forget);
    if !how.set.is_empty() {
        let recipe = changed(&before, &state, text, &how.set, registry, limits)?;
        (state.overrides, state.texts) = (recipe.overrides, recipe.texts);
    }
    branch_off(&store, folder, frame.frame, &saved, &state, out)?;
    Ok(Branched { frame, damaged })
}

/// The recipe of a run with more changes.
fn changed(
    before: &Recipe,
    state: &State,
    text: String,
    set: &[String],
    registry: &Registry,
    limits: &Limits,
) -> Result<Recipe, RunError> {
    let mut overrides = state.overrides.clone();
    overrides.set.extend_from_slice(set);
    let after = state.recipe(text, overrides, registry, limits)?;
    let start = |r: &Recipe| (r.grid, r.seed, r.sea_level_m.to_bits(), r.steps.len());
    if start(before) != start(&after) {
        let reason = "grid, seed, sea level and number of steps are settled at this moment".to_owned();
        return Err(RunError::refused(reason, "start a new run with these changes"));
    }
    let done = state.done_steps.min(after.steps.len());
    let differ = |from: usize, to: usize| {
        before.steps[from..to].iter().zip(&after.steps[from..to]).find(|(a, b)| !a.does_as(b)).map(|(a, _)| a)
    };
    if let Some(step) = differ(0, done).filter(|_| differ(done, after.steps.len()).is_none()) {
        let reason = format!("step {} ({}) is done at this moment: a change comes too late", step.number, step.name);
        return Err(RunError::refused(reason, "branch at an earlier moment, or start a new run"));
    }
    Ok(after)
}

/// Puts frame `i` of the recording of the run in `folder`, which is `saved`, with those before it, into a new folder where it can be
/// resumed.
pub(crate) fn branch_off(
    store: &timeline::Timeline,
    folder: &Path,
    i: usize,
    saved: &Checkpoint,
    state: &State,
    out: &Path,
) -> Result<(), RunError> {
    let fail = |source| RunError::Folder { path: out.to_owned(), source };
    let (run, to) = (real(folder).map_err(fail)?, real(out).map_err(fail)?);
    let wrong = match (to.starts_with(&run), run.starts_with(&to)) {
        (true, true) => Some("is the folder of the run itself"),
        (true, false) => Some("lies in the folder of the run"),
        (false, true) => Some("holds the folder of the run"),
        (false, false) => None,
    };
    if let Some(what) = wrong {
        let reason = format!("`{}` {what} that it would branch off from", out.display());
        return Err(RunError::refused(reason, "name a new folder beside that of the run"));
    }
    std::fs::create_dir_all(out).map_err(fail)?;
    if std::fs::read_dir(out).map_err(fail)?.next().is_some() {
        let reason = format!("`{}` is not empty", out.display());
        return Err(RunError::refused(reason, "name a new folder for the branch"));
    }
    let _lock = FolderLock::take(out)?;
    store.copy(i + 1, &out.join(TIMELINE_STORE)).map_err(RunError::file)?;
    // Last: with it, there is a run that can be resumed.
    save(&out.join(CHECKPOINT_FILE), saved, state)
}

/// Where a path leads, through links and `..`; its last parts need not exist.
fn real(path: &Path) -> std::io::Result<PathBuf> {
    let mut real = PathBuf::new();
    for part in std::path::absolute(path)?.components() {
        match part {
            Component::ParentDir => drop(real.pop()),
            part => real.push(part),
        }
        if let Ok(there) = real.canonicalize() {
            real = there;
        }
    }
    Ok(real)
}

fn of_no_run(frame: &Frame, reason: &str) -> RunError {
    let reason = format!("frame {} does not fit its recipe: {reason}", frame.frame);
    RunError::refused(reason, other_frame())
}

/// The latest state of the run in a folder, which knows all changes by hand.
fn newest(folder: &Path, store: &timeline::Timeline) -> Result<State, RunError> {
    let read = |path: &Path| -> Result<State, RunError> {
        let state = checkpoint::load_state(path).map_err(RunError::input)?;
        serde_json::from_value(state).map_err(|e| RunError::input(format!("`{}`: {e}", path.display())))
    };
    let last = (0..store.frames().len()).rev().find_map(|i| state_of(store, i).ok());
    let unfinished = unfinished(&Folder::new(folder)).map(|name| folder.join(name));
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

fn recording(folder: &Path) -> Result<PathBuf, RunError> {
    let path = folder.join(TIMELINE_STORE);
    if path.is_dir() {
        return Ok(path);
    }
    let reason = format!("`{}` holds no recording of a run", folder.display());
    Err(RunError::refused(reason, remedy!["record one with ", Action::RecordForm]))
}

fn save(path: &Path, frame: &Checkpoint, state: &State) -> Result<(), RunError> {
    let state = serde_json::to_value(state).map_err(|e| RunError::Fault(e.to_string()))?;
    checkpoint::save(path, &frame.world, &frame.recipe_toml, &state).map_err(RunError::file)
}
