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
pub use eyot_io as io;
pub use eyot_land as land;
pub use eyot_plates as plates;
pub use eyot_reef as reef;
pub use eyot_render as render;
pub use eyot_rules as rules;

#[cfg(feature = "gpu")]
mod card;
pub mod convert;
pub mod engines;
mod registry;
#[cfg(feature = "run")]
mod run;
pub mod store;

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
/// Films of worlds, runs and recordings.
#[cfg(feature = "film")]
pub mod film {
    pub use eyot_film::{FilmOptions, FilmPath, FilmProgress, Filmed, MOST_FRAMES, Subject, Video, film};
}

/// Worlds over the network as they change: a server and its clients, and runs that are served.
#[cfg(feature = "live")]
pub mod live {
    pub use eyot_live::serve::{ServeOptions, Serving};
    pub use eyot_live::{
        Alga, Body, Client, Colony, Ending, Error, Gone, HEADER, Hello, LayerInfo, Mirror, Moment, Notice, Options,
        Order, Raster, Record, Scene, Server, SpeciesInfo, Status, Tile, Why,
    };
}

#[cfg(feature = "film")]
pub use eyot_film::{Drawn, ViewRequest, draw_view};
pub use registry::{Registry, component_kinds};
#[cfg(feature = "run")]
pub use run::{Run, host};

/// Version of the engine.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
