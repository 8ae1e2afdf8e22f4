//! What a run remembers beside the world, so that it can be continued.

use crate::engines::EngineOptions;
use crate::event::JournalEntry;
use eyot_core::Limits;
use eyot_recipe::{Overrides, Problems, Recipe, RecipeSource, Registry, Texts};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What a checkpoint says about the run, beside the world.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct State {
    /// Steps of the recipe that are done, switched-off ones included.
    pub done_steps: usize,
    /// Steps of the simulation under way that are done.
    pub done: u64,
    /// Commands that changed the bytes.
    pub journal: Vec<JournalEntry>,
    /// Commands that are still to be given.
    pub replay: Vec<JournalEntry>,
    /// Name of the recipe's file.
    pub source_name: String,
    /// Folder of the recipe's file.
    pub folder: PathBuf,
    /// Changes to the recipe, as they were given.
    pub overrides: Overrides,
    /// Text files that the recipe names.
    #[serde(default, skip_serializing_if = "Texts::is_empty")]
    pub texts: Texts,
    /// Time at work before the checkpoint, s.
    pub seconds: f64,
    /// Name and time of each step of the recipe that is done, s.
    pub timings: Vec<(String, f64)>,
    /// A graphics card's own time in all of them, s.
    #[serde(default)]
    pub card_seconds: f64,
    /// True in the file of a finished run.
    #[serde(default)]
    pub finished: bool,
    /// True if the run is streamed; the checkpoint then holds no layers.
    #[serde(default)]
    pub streamed: bool,
    /// Exports of a streamed run that are written, switched-off ones included.
    #[serde(default)]
    pub done_exports: usize,
    /// True if the run was set back and has not gone on since: recorded frames may be later than it is.
    #[serde(default)]
    pub rewound: bool,
    /// The engine that was asked for, with which the run goes on.
    #[serde(default)]
    pub engine: EngineOptions,
    /// What has simulated so far: `cpu`, or `gpu` with the adapter's name; more than one if it changed.
    #[serde(default)]
    pub engines: Vec<String>,
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
            texts: recipe.texts.clone(),
            seconds: 0.0,
            timings: Vec::new(),
            card_seconds: 0.0,
            finished: false,
            streamed: false,
            done_exports: 0,
            rewound: false,
            engine: EngineOptions::default(),
            engines: Vec::new(),
        }
    }

    /// How far the run is: steps of the recipe, and steps of the simulation under way.
    pub(crate) fn place(&self) -> (usize, u64) {
        (self.done_steps, self.done)
    }

    /// All changes by hand, those that are still to be made last.
    pub(crate) fn changes(&self) -> Vec<JournalEntry> {
        self.journal.iter().chain(&self.replay).cloned().collect()
    }

    /// This earlier moment of a run with all its `changes`, from where it goes on: later ones are made again, or forgotten.
    pub(crate) fn again(self, changes: &[JournalEntry], forget: bool) -> Self {
        let later = if forget { Vec::new() } else { changes.iter().skip(self.journal.len()).cloned().collect() };
        Self { replay: later, rewound: true, ..self }
    }

    /// The same without anything that differs between two runs of one recipe: what a finished world carries.
    pub fn without_times(&self) -> Self {
        Self { seconds: 0.0, timings: Vec::new(), card_seconds: 0.0, engine: EngineOptions::default(), ..self.clone() }
    }

    /// The recipe of the run from the text that a checkpoint holds, with the text files that it read when it began.
    ///
    /// # Errors
    /// If the recipe does not pass its checks.
    pub fn recipe(
        &self,
        text: String,
        overrides: Overrides,
        registry: &Registry,
        limits: &Limits,
    ) -> Result<Recipe, Problems> {
        Recipe::parse_with(self.source(text), overrides, registry, limits, self.texts.clone())
    }

    fn source(&self, text: String) -> RecipeSource {
        RecipeSource { name: self.source_name.clone(), text, folder: self.folder.clone() }
    }
}
