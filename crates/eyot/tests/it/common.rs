//! What the tests of files share: recipes from text, finished runs, and their files.

use eyot::{Event, Handle, Limits, Overrides, Recipe, RecipeSource, Registry, Run, RunOptions, World};
use eyot_io::{Raster, ReadOptions, read_raster};
use serde_json::Value;
use std::path::Path;
use std::time::Duration;

/// A recipe from `text` and some `[[export]]` tables, or its complaints.
pub(crate) fn parse(text: &str, exports: &[&str], overrides: Overrides, limits: &Limits) -> Result<Recipe, String> {
    let more: String = exports.iter().map(|e| format!("\n[[export]]\n{e}\n")).collect();
    let source = RecipeSource { name: "test.toml".into(), text: format!("{text}{more}"), folder: ".".into() };
    Recipe::parse(source, overrides, &Registry::standard(), limits).map_err(|p| p.to_string())
}

/// A recipe that is right.
pub(crate) fn recipe(text: &str, exports: &[&str]) -> Recipe {
    parse(text, exports, Overrides::default(), &Limits::default()).unwrap()
}

/// Runs a recipe to its end; its files go to `out`.
pub(crate) fn run(recipe: Recipe, out: &Path) -> World {
    let options = RunOptions { out: Some(out.to_owned()), ..RunOptions::default() };
    Run::start(recipe, options).unwrap().join().unwrap().world
}

pub(crate) fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// A raster that says of itself all that must be known.
pub(crate) fn raster(path: &Path) -> Raster {
    read_raster(path, &ReadOptions::default(), &Limits::default()).unwrap()
}

/// The next event that is wanted; what comes before it is dropped.
pub(crate) fn wait_for(handle: &Handle, wanted: impl Fn(&Event) -> bool) -> Event {
    loop {
        let event = handle.events().recv_timeout(Duration::from_secs(60)).expect("the run went silent");
        if wanted(&event) {
            return event;
        }
    }
}
