//! **Recipes**: documents that say everything that decides the bytes of a landscape.
//!
//! A recipe is written as TOML, or built in code as a [`RecipeDoc`]. [`Recipe::parse`] and [`Recipe::check`] check it against
//! a [`Registry`] and collect everything that is wrong, with its place in the text and a remedy.
//!
//! Nothing here reads rasters, draws or writes. What lies outside is asked through two traits that the registry carries:
//! [`Resolver`] for the files that a recipe names, [`Estimator`] for the memory that its outputs take.
//!
//! ```
//! use eyot_recipe::{Limits, Overrides, Recipe, RecipeDoc, Registry, StepDoc};
//! # use eyot_core::{Field, Result, about, process::{Entry, Generator, Site}};
//! # #[derive(Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
//! # #[serde(default)]
//! # struct Level { height: f32 }
//! # impl Generator for Level {
//! #     fn generate(&self, site: &Site<'_>, _: &Field) -> Result<Field> {
//! #         Ok(Field::new(site.grid.width, site.grid.height, self.height))
//! #     }
//! # }
//! # static GENERATORS: [Entry<dyn Generator>; 1] = [Entry::<dyn Generator>::generator::<Level>("level", "", &[])];
//!
//! let registry = Registry::new(&GENERATORS, &[]);
//! let doc = RecipeDoc::new("Plateau").square(64, 10.0).step(StepDoc::generate("level").set("height", 120.0));
//! let recipe = Recipe::check(&doc, Overrides::default(), &registry, &Limits::default()).unwrap();
//! assert_eq!((recipe.grid.width, recipe.steps.len()), (64, 1));
//!
//! let wrong = doc.step(StepDoc::generate("level").set("heigth", 5.0));
//! let problems = Recipe::check(&wrong, Overrides::default(), &registry, &Limits::default()).err().unwrap();
//! assert!(problems.to_string().contains("did you mean `height`?"), "{problems}");
//! ```

mod builtin;
mod change;
mod check;
mod cite;
mod describe;
mod diagnostic;
mod doc;
mod doubts;
mod effective;
mod export;
#[cfg(feature = "fs")]
pub mod fs;
mod host;
pub mod keys;
pub mod layers;
mod looks;
pub mod memory;
pub mod merge;
mod node;
mod parse;
pub mod process_set;
mod recipe;
mod registry;
mod rock;
mod schema;
mod set;
mod texts;
mod toml_text;
mod validate;

pub use builtin::{BuiltIn, DATA, Data, RECIPES, data};
pub use change::Change;
pub use cite::{Citation, Citations, REFERENCES, all_citations, cite};
pub use describe::{Choice, Description, Expression, ParameterInfo, describe};
pub use diagnostic::{Diagnostic, Problems, Source, alternatives, nearest};
pub use doc::{RecipeDoc, StepDoc};
pub use export::{GROUND, GROUND_BEFORE, MASKS, MATERIALS, PLACES, bed_of_top};
pub use eyot_core::Limits;
pub use host::{Estimator, NoFiles, NoOutputs, RasterInfo, Refusal, Resolver, Streamed};
pub use keys::{Bytes, Export, ExportFormat, FirstRow, Preset, View, What};
pub use looks::{Colour, Palette, Season, Stop};
pub use merge::Merge;
pub use node::Span;
pub use recipe::{
    Actor, GenerateStep, Overrides, ProcessUse, Recipe, RecipeSource, SimulateStep, Step, Texts, Work, schedule,
};
pub use registry::{DOCUMENT_KEYS, GENERATE_KEYS, Registry, SCHEDULE_KEYS, SIMULATE_KEYS};
pub use schema::recipe_schema;
pub use set::{value_of, view_of};
