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

#[cfg(feature = "gpu")]
mod card;
mod convert;
pub mod engines;
mod registry;
#[cfg(feature = "run")]
mod run;
pub mod store;

pub use eyot_core::{
    Boundary, BoundaryCondition, Cancel, Centering, Control, Error, Field, Georeference, Grid, Layer, LayerSpec,
    Ledger, Limits, World,
};
pub use eyot_export::Import;
pub use eyot_recipe::{
    Actor, BuiltIn, Bytes, Change, Choice, Citation, Citations, Description, Diagnostic, Export, ExportFormat,
    Expression, FirstRow, GenerateStep, Merge, Overrides, ParameterInfo, Preset, Problems, ProcessUse, RECIPES, Recipe,
    RecipeDoc, RecipeSource, SimulateStep, Source, Span, Step, StepDoc, View, What, Work, all_citations, cite,
    describe, keys, merge, nearest, recipe_schema,
};
pub use eyot_session::{
    Command, EngineChoice, EngineOptions, Event, JournalEntry, Look, OVERVIEW, Outcome, Progress, Record, RunError,
    Stream, Timeline, Watch, Watcher, shell_word,
};
#[cfg(feature = "run")]
pub use eyot_session::{Handle, Remote, RunOptions};

/// Measures of landscapes: of terrain, of climates, and of plates.
pub mod analyse {
    pub use eyot_climate::stats::{Planet, Zonal, planet};
    pub use eyot_land::analyse::{
        HortonRatios, Landform, LandformShares, Moments, PitCount, StreamOrder, TerrainCurves, TerrainOptions,
        TerrainStats, concavity, contours, count_pits, curvatures, erosion_score, geomorphons, hack_exponent,
        horton_ratios, hurst_exponent, moments, quantile, slope_deg, spectral_beta, strahler_orders, streams_by_order,
        terrain_curves, terrain_stats,
    };
    pub use eyot_plates::report as plates;
}

/// What worlds keep beside layers, as those see it who do not know its type.
pub mod component {
    pub use eyot_core::component::{Attribute, Attributes, Features, Form, Graph, Points, Shape, Table, Values, View};
}

/// Files of other programs, in and out, and checkpoints.
pub mod formats {
    pub use crate::convert::{ConvertOptions, Converted, convert};
    pub use eyot_io::{
        ByteOrder, Error, Input, Raster, RasterFormat, ReadOptions, RowOrder, Sample, Source, Target, WriteOptions,
        checkpoint, layer_names, read_raster, write_layer, write_rgb_png, write_rows,
    };
}

/// Rules, plans, generators and processes: those that come with Eyot, and what one's own are made of.
pub mod process {
    pub use eyot_climate::PROCESSES as CLIMATE;
    pub use eyot_core::engine::CpuEngine;
    pub use eyot_core::layer::known;
    pub use eyot_core::plan::Plan;
    pub use eyot_core::process::{Around, Entry, Generator, LayerUse, Moment, Process, Reach, Scheduled, Site, Span};
    pub use eyot_core::real::Real;
    pub use eyot_core::rule::{Cell, Read, Rule, read};
    pub use eyot_core::{Result, given, rule_params};
    pub use eyot_land::{generate, simulate};
    pub use eyot_plants::PROCESSES as PLANTS;
    pub use eyot_plates::PROCESSES as PLATES;
    pub use eyot_reef::PROCESSES as REEFS;
    pub use eyot_reef::corals::POPULATION as COLONIES;
    pub use eyot_strata::PROCESSES as STRATA;
}

/// What to do about errors, as values that front ends word.
pub mod remedy {
    pub use eyot_core::remedy::{Action, Neutral, Part, Remedy, Setting, Worded, Wording};
}

/// Recipes being carried out by a program's own loop, with storage of its own.
pub mod session {
    pub use eyot_export::RunFiles;
    pub use eyot_io::storage::{Folder, Memory, Storage};
    pub use eyot_session::{
        Branches, Budget, Clock, Engines, Events, Host, NewBranch, OpenEngine, Opened, Outputs, Results, Session,
        SessionOptions, State, Status,
    };
}

/// Recordings of runs, and ways back.
pub mod timeline {
    pub use eyot_session::timeline::{Branched, Branching, Damaged, Frame, Moment, Rewound, Timeline, branch, rewind};
}

/// Films of worlds, runs and recordings.
#[cfg(feature = "film")]
pub mod film {
    pub use eyot_film::{FilmOptions, FilmPath, FilmProgress, Filmed, MAX_FRAMES, Subject, Video, film};
}

/// Worlds over the network as they change: a server and its clients, and runs that are served.
#[cfg(feature = "live")]
pub mod live {
    pub use eyot_live::serve::{ServeOptions, Serving};
    pub use eyot_live::{
        Alga, Body, Changed, Client, Colony, Control, Ending, Error, Gone, HEADER, Hello, LayerInfo, Mirror, Moment,
        Notice, Options, Order, Permission, Raster, Record, Scene, Server, SpeciesInfo, Status, Tile, Why,
    };
}

/// Views of a world from a camera, by the processor or a graphics card, and what a window needs to draw its own.
#[cfg(feature = "film")]
pub mod view {
    pub use eyot_film::{Drawn, ViewRequest, draw_view};
    pub use eyot_render::{Camera, MapOptions, Picture, Stage, ViewOptions};
    #[cfg(feature = "view")]
    pub use eyot_view::{Canvas, Renderer, Scene, Shot};
}

pub use registry::{Registry, component_kinds};
#[cfg(feature = "run")]
pub use run::{Run, host};

/// Version of the engine.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
