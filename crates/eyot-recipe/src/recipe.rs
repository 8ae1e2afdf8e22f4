//! Recipes: the documents that say everything that decides the bytes.

use crate::builtin;
use crate::keys::{Export, Preset, View};
use crate::merge::Merge;
use eyot_core::process::{Entry, Generator, Process, Scheduled, over};
use eyot_core::remedy::Remedy;
use eyot_core::{Georeference, Grid};
use eyot_expr::{ExprProcess, ParameterizedProcess, Scope, Terms, TextRule};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Texts of files by the names that the recipe gives them.
///
/// Checkpoints carry them, so that a run that goes on, is set back or is run again has the same ones, whatever has become of the files.
pub type Texts = BTreeMap<String, String>;

/// Where a recipe came from: enough to read it again after a resume.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecipeSource {
    /// File name, or the name of a built-in recipe; for messages.
    pub name: String,
    /// The document as it was written.
    pub text: String,
    /// The folder that files named in the recipe are relative to.
    pub folder: PathBuf,
}

/// Changes to a document before it is checked.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Overrides {
    /// `key=value` texts as `--set` takes them, in order.
    pub set: Vec<String>,
    /// Other numbers of columns and rows for the same extent. One number is the longer side; the other follows.
    pub size: Option<(u32, Option<u32>)>,
    /// Presets whose files are written beside the recipe's own exports.
    #[serde(default)]
    pub presets: Vec<Preset>,
}

/// A checked recipe, ready to run.
#[derive(Clone)]
pub struct Recipe {
    /// What the landscape is called.
    pub name: String,
    /// One sentence about it.
    pub about: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The grid.
    pub grid: Grid,
    /// Where the grid lies, if it was taken from a georeferenced file.
    pub georeference: Option<Georeference>,
    /// Level of the sea at the start, m.
    pub sea_level_m: f64,
    /// What to do, in order; also the steps that are switched off.
    pub steps: Vec<Step>,
    /// Files to write in the end.
    pub exports: Vec<Export>,
    /// The preview picture.
    pub view: View,
    /// Where the recipe came from.
    pub source: RecipeSource,
    /// What was changed by flags.
    pub overrides: Overrides,
    /// Text files that it names.
    pub texts: Texts,
    /// The document after its changes.
    pub(crate) document: Value,
}

/// One `[[step]]`.
#[derive(Clone)]
pub struct Step {
    /// Position in the recipe, from 1.
    pub number: usize,
    /// Its name, or what it does.
    pub name: String,
    /// Whether it is done.
    pub enabled: bool,
    /// What it does.
    pub work: Work,
}

impl Step {
    /// Whether the other does the same.
    pub fn does_as(&self, other: &Self) -> bool {
        let work = match (&self.work, &other.work) {
            (Work::Generate(a), Work::Generate(b)) => {
                let what = |g: &GenerateStep| (g.entry.name, g.merge, g.amount.to_bits(), g.seed);
                what(a) == what(b) && (&a.parameters, &a.layer, &a.mask) == (&b.parameters, &b.layer, &b.mask)
            }
            (Work::Simulate(a), Work::Simulate(b)) => {
                let texts = |u: &ProcessUse| {
                    u.terms.list().iter().map(|t| (t.parameter().to_owned(), t.text().to_owned())).collect::<Vec<_>>()
                };
                let what =
                    |u: &ProcessUse| (u.actor.name().to_owned(), u.parameters.clone(), texts(u), u.every, u.enabled);
                a.steps == b.steps && a.processes.iter().map(what).eq(b.processes.iter().map(what))
            }
            _ => false,
        };
        self.enabled == other.enabled && work
    }
}

/// What a step does.
#[derive(Clone)]
pub enum Work {
    /// Makes or changes a layer.
    Generate(GenerateStep),
    /// Lets processes act for a while.
    Simulate(SimulateStep),
}

/// A step that makes or changes a layer.
#[derive(Clone)]
pub struct GenerateStep {
    /// The generator.
    pub entry: &'static Entry<dyn Generator>,
    /// Its parameters, checked.
    pub parameters: Value,
    /// The layer.
    pub layer: String,
    /// How the result joins the layer.
    pub merge: Merge,
    /// A layer that limits the change.
    pub mask: Option<String>,
    /// Strength of the merge.
    pub amount: f32,
    /// Seed of the step.
    pub seed: u64,
    /// What it can do and most likely was not meant to, as its check found; see [`Generator::doubts`].
    pub doubts: Vec<Remedy>,
}

/// A step that lets processes act.
#[derive(Clone)]
pub struct SimulateStep {
    /// How often.
    pub steps: u64,
    /// The processes, in the order in which they act.
    pub processes: Vec<ProcessUse>,
}

/// What acts in a step.
#[derive(Clone)]
#[non_exhaustive]
pub enum Actor {
    /// A process that comes with Eyot.
    Process(&'static Entry<dyn Process>),
    /// A rule of the recipe's own.
    Rule(Arc<TextRule>),
}

/// A process with its parameters in a step.
#[derive(Clone)]
pub struct ProcessUse {
    /// The process.
    pub actor: Actor,
    /// Its parameters, checked.
    pub parameters: Value,
    /// Those that are expressions.
    pub terms: Arc<Terms>,
    /// What expressions may name here.
    pub scope: Arc<Scope>,
    /// It acts in every n-th step.
    pub every: u64,
    /// Whether it acts.
    pub enabled: bool,
}

impl GenerateStep {
    /// The generator with its parameters.
    ///
    /// # Errors
    /// If they are no parameters of it; [`Recipe::parse`] lets none such through.
    pub fn make(&self) -> Result<Box<dyn Generator>, eyot_core::Error> {
        (self.entry.make)(self.parameters.clone()).map_err(|e| unfit(self.entry.name, &e))
    }
}

impl SimulateStep {
    /// The processes that are switched on, with their parameters.
    ///
    /// # Errors
    /// As [`GenerateStep::make`].
    pub fn schedule(&self) -> Result<Vec<Scheduled>, eyot_core::Error> {
        schedule(&self.processes)
    }
}

impl Actor {
    /// Its name in recipes.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Process(entry) => entry.name,
            Self::Rule(rule) => rule.name,
        }
    }

    /// JSON Schema of its parameters.
    pub fn schema(&self) -> Value {
        let rule = match self {
            Self::Process(entry) => return (entry.schema)().to_value(),
            Self::Rule(rule) => rule,
        };
        let parameter = |(name, value): &(String, f32)| {
            let about = "A parameter of the recipe's own rule.";
            (name.clone(), json!({ "type": "number", "format": "float", "default": value, "description": about }))
        };
        let properties: serde_json::Map<String, Value> = rule.parameters.iter().map(parameter).collect();
        json!({ "type": "object", "properties": properties })
    }

    /// Keys of the literature behind it.
    pub fn cites(&self) -> &'static [&'static str] {
        match self {
            Self::Process(entry) => entry.cites,
            Self::Rule(_) => &[],
        }
    }

    /// Its parameters if a recipe gives none.
    pub fn defaults(&self) -> Value {
        match self {
            Self::Process(entry) => (entry.defaults)(),
            Self::Rule(rule) => rule.parameters.iter().map(|(name, value)| (name.clone(), json!(value))).collect(),
        }
    }

    /// The process; parameters that are missing have their defaults.
    pub fn make(&self, parameters: &Value) -> Result<Box<dyn Process>, serde_json::Error> {
        match self {
            Self::Process(entry) => (entry.make)(parameters.clone()),
            Self::Rule(rule) => {
                let value = |(name, usual): &(String, f32)| parameters[name].as_f64().map_or(*usual, |v| v as f32);
                let values = rule.parameters.iter().map(value).collect();
                Ok(Box::new(ExprProcess { rule: Arc::clone(rule), values }))
            }
        }
    }
}

impl ProcessUse {
    /// All its parameters: those that are given and the defaults of the others. In place of an expression stands the default.
    pub fn in_force(&self) -> Value {
        // What a recipe was checked with fits together.
        over(&self.actor.defaults(), self.parameters.clone()).unwrap_or_else(|_| self.parameters.clone())
    }

    /// The process with its parameters.
    pub fn make(&self) -> Result<Box<dyn Process>, serde_json::Error> {
        match self.actor {
            Actor::Process(entry) if !self.terms.list().is_empty() => {
                Ok(Box::new(ParameterizedProcess::new(entry, self.parameters.clone(), Arc::clone(&self.terms))?))
            }
            _ => self.actor.make(&self.parameters),
        }
    }
}

/// The processes that are switched on, ready for the engine.
pub fn schedule(uses: &[ProcessUse]) -> Result<Vec<Scheduled>, eyot_core::Error> {
    let scheduled = |u: &ProcessUse| {
        let process = u.make().map_err(|e| unfit(u.actor.name(), &e))?;
        Ok(Scheduled { name: u.actor.name(), process, every: u.every.max(1) })
    };
    uses.iter().filter(|u| u.enabled).map(scheduled).collect()
}

fn unfit(owner: &str, e: &serde_json::Error) -> eyot_core::Error {
    eyot_core::Error::BadParameter { owner: owner.into(), field: "parameters".into(), reason: e.to_string() }
}

impl Recipe {
    /// The steps that will be done.
    pub fn enabled_steps(&self) -> impl Iterator<Item = &Step> {
        self.steps.iter().filter(|s| s.enabled)
    }

    /// A process as the last step has it that uses it.
    pub fn last_use(&self, process: &str) -> Option<&ProcessUse> {
        let steps = self.steps.iter().rev().filter(|s| s.enabled);
        let uses = steps.filter_map(|s| if let Work::Simulate(w) = &s.work { Some(&w.processes) } else { None });
        uses.flatten().find(|u| u.enabled && matches!(&u.actor, Actor::Process(e) if e.name == process))
    }
}

impl RecipeSource {
    /// A built-in recipe.
    pub fn builtin(name: &str) -> Option<Self> {
        let r = builtin::RECIPES.iter().find(|r| r.name == name)?;
        Some(Self { name: format!("{name} (built in)"), text: r.text.to_owned(), folder: PathBuf::from(".") })
    }
}
