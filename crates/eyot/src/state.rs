//! What a run remembers beside the world, so that it can be continued.

use crate::event::JournalEntry;
use crate::recipe::{Overrides, Recipe, RecipeSource};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What a checkpoint says about the run, beside the world.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct State {
    /// Steps of the recipe that are done, switched-off ones included.
    pub(crate) done_steps: usize,
    /// Steps of the simulation under way that are done.
    pub(crate) done: u64,
    /// Commands that changed the bytes.
    pub(crate) journal: Vec<JournalEntry>,
    /// Commands that are still to be given.
    pub(crate) replay: Vec<JournalEntry>,
    pub(crate) source_name: String,
    pub(crate) folder: PathBuf,
    pub(crate) overrides: Overrides,
    /// Time at work before the checkpoint, s.
    pub(crate) seconds: f64,
    /// Name and time of each step of the recipe that is done, s.
    pub(crate) timings: Vec<(String, f64)>,
    /// True in the file of a finished run.
    #[serde(default)]
    pub(crate) finished: bool,
    /// True if the run is streamed; the checkpoint then holds no layers.
    #[serde(default)]
    pub(crate) streamed: bool,
    /// Exports of a streamed run that are written, switched-off ones included.
    #[serde(default)]
    pub(crate) done_exports: usize,
}

impl State {
    pub(crate) fn new(recipe: &Recipe, mut replay: Vec<JournalEntry>) -> Self {
        replay.sort_by_key(|e| (e.recipe_step, e.step));
        Self {
            done_steps: 0,
            done: 0,
            journal: Vec::new(),
            replay,
            source_name: recipe.source.name.clone(),
            folder: recipe.source.folder.clone(),
            overrides: recipe.overrides.clone(),
            seconds: 0.0,
            timings: Vec::new(),
            finished: false,
            streamed: false,
            done_exports: 0,
        }
    }

    /// The same without anything that differs between two runs of one recipe: what a finished world carries.
    pub(crate) fn without_times(&self) -> Self {
        Self { seconds: 0.0, timings: Vec::new(), ..self.clone() }
    }

    pub(crate) fn source(&self, text: String) -> RecipeSource {
        RecipeSource { name: self.source_name.clone(), text, folder: self.folder.clone() }
    }
}
