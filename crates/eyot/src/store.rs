//! Worlds that lie in files: finished and stopped runs, and height maps.

use crate::registry::component_kinds;
use eyot_core::{Limits, World};
use eyot_io::ReadOptions;
use eyot_land::analyse;
use eyot_recipe::View;
use eyot_session::RunError;
use serde_json::Value;
use std::path::{Path, PathBuf};

pub use eyot_export::open::{Opened, of_run};
pub use eyot_export::pictures::Subject;
pub use eyot_export::section::{Drawn, SectionOptions};
pub use eyot_export::sheets::{Picture, SheetCell, contact_sheet};
pub use eyot_io::read_rgb_png;
pub use eyot_io::run_folder::*;

/// Opens the folder of a run, a saved world or any height map.
///
/// # Errors
/// If there is nothing that can be opened; the text says what would be right.
pub fn open(path: &Path, limits: &Limits) -> Result<Opened, RunError> {
    eyot_export::open::open(path, limits, &component_kinds()).map_err(RunError::from)
}

/// As [`open`], with what a height map itself leaves open.
///
/// # Errors
/// As [`open`].
pub fn open_with(path: &Path, options: &ReadOptions, limits: &Limits) -> Result<Opened, RunError> {
    eyot_export::open::open_with(path, options, limits, &component_kinds()).map_err(RunError::from)
}

/// Draws a world into a PNG file.
///
/// # Errors
/// If `path` has another extension than `.png`, the layer is not there, the picture exceeds the limits, or the file cannot be
/// written, which is found out first.
pub fn draw(world: &World, options: &View, subject: Subject<'_>, path: &Path, limits: &Limits) -> Result<(), RunError> {
    eyot_export::pictures::draw_file(world, options, subject, path, limits).map_err(RunError::from)
}

/// Draws a section through a world into a file, as SVG or PNG by its name.
///
/// # Errors
/// If the name has another extension, the world has no height, the line is none on its grid, or the file cannot be written.
pub fn section(world: &World, options: &SectionOptions, path: &Path) -> Result<Drawn, RunError> {
    eyot_export::section::write_section(world, options, path).map_err(RunError::from)
}

/// Statistics of a world's terrain, and of its climate, plates, rivers and lakes if it has some.
///
/// # Errors
/// If the world has no height, or one that cannot be measured within the limits, or an option is out of its range.
pub fn stats(opened: &Opened, options: &analyse::TerrainOptions, limits: &Limits) -> Result<Value, RunError> {
    let world = &opened.world;
    let height = &world.layer("height").map_err(RunError::input)?.field;
    let sea = opened.has_sea.then_some(world.sea_level_m);
    let stats = analyse::terrain_stats(height, &world.grid, sea, options, limits);
    let fault = |e: serde_json::Error| RunError::Fault(e.to_string());
    let mut all = serde_json::to_value(stats.map_err(RunError::file)?).map_err(fault)?;
    if let Some(planet) = eyot_climate::stats::planet(world) {
        all["planet"] = serde_json::to_value(planet).map_err(fault)?;
    }
    if let Some(plates) = eyot_plates::report(world).map_err(RunError::file)? {
        all["plates"] = serde_json::to_value(plates).map_err(fault)?;
    }
    if let Some(rivers) = eyot_water::graph_stats(world).map_err(RunError::file)? {
        all["rivers"] = serde_json::to_value(rivers).map_err(fault)?;
    }
    Ok(all)
}

/// Draws curves of a world's terrain into a folder that is there, as SVG and PNG: hypsometry, slope against drained area, and profiles of rivers.
/// `name` stands in their titles.
///
/// # Errors
/// As [`stats`], and if a file cannot be written.
pub fn plots(
    opened: &Opened,
    options: &analyse::TerrainOptions,
    name: &str,
    folder: &Path,
    limits: &Limits,
) -> Result<Vec<PathBuf>, RunError> {
    let world = &opened.world;
    let height = &world.layer("height").map_err(RunError::input)?.field;
    let sea = opened.has_sea.then_some(world.sea_level_m);
    let curves = analyse::terrain_curves(height, &world.grid, sea, options, limits).map_err(RunError::file)?;
    eyot_export::terrain_plots(&curves, name, folder).map_err(RunError::from)
}

/// Statistics as a table of two columns, `measure,value`: a row each, with the names of nested ones joined by dots and the places of
/// lists counted from 1. What a world does not have is an empty value.
pub fn stats_csv(stats: &Value) -> String {
    fn rows(name: &str, value: &Value, out: &mut String) {
        let under = |key: &str| if name.is_empty() { key.to_owned() } else { format!("{name}.{key}") };
        match value {
            Value::Object(map) => map.iter().for_each(|(key, v)| rows(&under(key), v, out)),
            Value::Array(list) => list.iter().enumerate().for_each(|(i, v)| rows(&under(&(i + 1).to_string()), v, out)),
            Value::Null => *out += &format!("{},\n", quoted(name)),
            Value::String(text) => *out += &format!("{},{}\n", quoted(name), quoted(text)),
            number => *out += &format!("{},{number}\n", quoted(name)),
        }
    }
    /// As RFC 4180 asks where a text has a comma, a quote or a line's end.
    fn quoted(text: &str) -> String {
        if text.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    }
    let mut out = "measure,value\n".to_owned();
    rows("", stats, &mut out);
    out
}
