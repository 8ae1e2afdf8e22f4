//! **Eyot**, one engine for natural landscapes: recipes, runs and everything they need.
//!
//! A [`Recipe`] says everything that decides the bytes of a landscape; a [`Run`] carries it out on a thread of its own,
//! takes [`Command`]s and tells [`Event`]s. Front ends use this crate and no other.
//!
//! ```
//! use eyot::{Limits, Overrides, Recipe, RecipeSource, Registry, Run, RunOptions};
//!
//! let text = r#"
//!     name = "Hill"
//!     [grid]
//!     size = 32
//!     cell = 20.0
//!     [[step]]
//!     generate = "cone"
//!     height = 300.0
//! "#;
//! let source = RecipeSource { name: "hill.toml".into(), text: text.into(), folder: ".".into() };
//! let recipe = Recipe::parse(source, Overrides::default(), &Registry::standard(), &Limits::default())?;
//! let outcome = Run::start(recipe, RunOptions::default())?.join()?;
//! let (low, high) = outcome.world.layer("height")?.field.min_max();
//! assert!(low == 0.0 && high > 200.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What is wrong with a recipe comes back as [`Problems`], each with its place and its remedy.

pub use eyot_climate as climate;
pub use eyot_core as core;
pub use eyot_gpu as gpu;
pub use eyot_io as io;
pub use eyot_land as land;
pub use eyot_mesh as mesh;
pub use eyot_plates as plates;
pub use eyot_reef as reef;
pub use eyot_render as render;
pub use eyot_rules as rules;
pub use eyot_stream as network;
pub use eyot_view as view;

mod artist;
pub mod convert;
pub mod engines;
pub mod film;
mod registry;
mod run;
pub mod serve;
pub mod store;

pub use artist::{Drawn, ViewRequest, draw_view};
pub use eyot_core::{Cancel, Control, Edge, Field, Georeference, Grid, Layer, LayerSpec, Ledger, Limits, Rim, World};
pub use eyot_export::Import;
pub use eyot_recipe::{
    Actor, BuiltIn, Bytes, Change, Choice, Citation, Citations, Description, Diagnostic, Export, ExportFormat,
    Expression, FirstRow, GenerateStep, Merge, Overrides, ParameterInfo, Preset, Problems, ProcessUse, RECIPES, Recipe,
    RecipeDoc, RecipeSource, SimulateStep, Source, Span, Step, StepDoc, View, What, Work, all_citations, cite,
    describe, keys, merge, nearest, recipe_schema,
};
pub use eyot_session as session;
pub use eyot_session::{
    Command, EngineChoice, EngineOptions, Event, Handle, JournalEntry, Look, OVERVIEW, Outcome, Progress, Record,
    Remote, RunError, RunOptions, Stream, Timeline, Watch, Watcher, shell_word, timeline,
};
pub use registry::{Registry, component_kinds};
pub use run::{Run, host};

/// Version of the engine.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
