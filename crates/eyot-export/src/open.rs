//! Worlds that lie in files: finished and stopped runs, and height maps.

use crate::error::ExportError;
use crate::import::read_raster;
use eyot_core::layer::known;
use eyot_core::remedy;
use eyot_core::remedy::{Action, Remedy, Setting};
use eyot_core::{Boundary, ComponentKinds, Grid, Limits, World};
use eyot_io::run_folder::{CHECKPOINT_FILE, REPORT_FILE, WORLD_FILE};
use eyot_io::{self as io, ReadOptions, checkpoint};
use eyot_recipe::keys::NO_SEA_M;
use eyot_recipe::{View, view_of};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A world from a file.
#[derive(Debug)]
pub struct Opened {
    /// The world.
    pub world: World,
    /// The file it came from.
    pub file: PathBuf,
    /// False for height maps, which say nothing of a sea.
    pub has_sea: bool,
    /// The recipe's view; the default one for height maps.
    pub view: View,
    /// Engines that simulated, in order; empty if that is not known.
    pub engines: Vec<String>,
    /// Things to know about it.
    pub notes: Vec<Remedy>,
}

/// Opens the folder of a run, a saved world or any height map. Saved worlds may hold components of these kinds.
///
/// # Errors
/// If there is nothing that can be opened; the text says what would be right.
pub fn open(path: &Path, limits: &Limits, kinds: &ComponentKinds) -> Result<Opened, ExportError> {
    open_with(path, &ReadOptions { bare_numbers: true, ..ReadOptions::default() }, limits, kinds)
}

/// As [`open`], with what a height map itself leaves open.
///
/// # Errors
/// As [`open`].
pub fn open_with(
    path: &Path,
    options: &ReadOptions,
    limits: &Limits,
    kinds: &ComponentKinds,
) -> Result<Opened, ExportError> {
    let nothing = |e: std::io::Error| unusable(format!("cannot open `{}`: {e}", path.display()));
    let meta = std::fs::metadata(path).map_err(nothing)?;
    if meta.is_dir() && !io::is_zarr(path) {
        let found = [WORLD_FILE, CHECKPOINT_FILE].iter().map(|f| path.join(f)).find(|f| f.is_file());
        let Some(file) = found else {
            if let Some(opened) = streamed(path, limits, kinds) {
                return opened;
            }
            return Err(unusable(format!("`{}` holds no run: there is no {WORLD_FILE} in it", path.display())));
        };
        return saved(&file, limits, kinds);
    }
    if path.extension().is_some_and(|e| e == "eyot") {
        return saved(path, limits, kinds);
    }
    let raster = read_raster(&path.display().to_string(), options, limits).map_err(ExportError::input)?;
    of_raster(raster, path, limits)
}

/// A world that a run left, as the folder of that run would be opened.
pub fn of_run(world: World, view: View) -> Opened {
    let has_sea = world.sea_level_m > NO_SEA_M;
    Opened { world, file: PathBuf::new(), has_sea, view, engines: Vec::new(), notes: Vec::new() }
}

/// The world of a height map.
pub fn of_raster(mut raster: io::Raster, path: &Path, limits: &Limits) -> Result<Opened, ExportError> {
    let (dx, dy) = raster.cell_m.unwrap_or((1.0, 1.0));
    let grid = Grid {
        width: raster.field.width(),
        height: raster.field.height(),
        cell_x_m: dx,
        cell_y_m: dy,
        rim: Boundary::CLOSED,
    };
    let grid = grid.checked(limits).map_err(ExportError::input)?;
    let mut notes = notes(&raster, false);
    if raster.to_metres() {
        notes.push("heights in feet were turned into metres".into());
    }
    let mut world = World::new(grid, 0);
    world.georeference = raster.georeference;
    world.put(&known::HEIGHT, raster.field).map_err(ExportError::input)?;
    // A bare height map has no sea: far below everything.
    world.sea_level_m = NO_SEA_M;
    Ok(Opened { world, file: path.to_owned(), has_sea: false, view: View::default(), engines: Vec::new(), notes })
}

/// What one should know of a height map; `holes_stay` if what is made of it marks missing cells.
pub fn notes(raster: &io::Raster, holes_stay: bool) -> Vec<Remedy> {
    let mut notes = Vec::new();
    if raster.cell_m.is_none() {
        notes.push(remedy![
            "the file does not say how large its cells are; 1 m is assumed (",
            Action::Converter,
            " has ",
            Setting::Cell,
            ")",
        ]);
    }
    if raster.numbers == io::Numbers::Bare {
        notes.push(remedy![
            "the file does not say which heights its whole numbers stand for; metres are assumed (",
            Action::Converter,
            " has ",
            Setting::InputRange,
            ")",
        ]);
    }
    if raster.missing.is_some() {
        let fate = if holes_stay { "stay without one" } else { "were filled from their neighbours" };
        notes.push(format!("{} cells without a value {fate}", raster.filled()).into());
    }
    if let Some((mark, cells)) = raster.suspect() {
        notes.push(remedy![
            format!("{cells} cells hold {mark}, which usually marks missing cells; if it does here, say so with "),
            Setting::Nodata,
            " (",
            Action::Converter,
            ")",
        ]);
    }
    if raster.rounded_by > 0.0 {
        let by = raster.rounded_by;
        notes.push(
            format!("the file holds numbers of more than 32 bits; they were rounded, by {by:.1e} at most").into(),
        );
    }
    if raster.steps > 1 {
        notes.push(format!("the file holds {} steps of time; this is the last", raster.steps).into());
    }
    notes
}

/// The height of a streamed run from what it exported; `None` if the folder holds no such run.
fn streamed(folder: &Path, limits: &Limits, kinds: &ComponentKinds) -> Option<Result<Opened, ExportError>> {
    /// Endings of names, exact formats first.
    const ENDINGS: [&str; 7] =
        ["height.tif", "world.zarr", "height.exr", "height.npy", "height.r32", "height.r16", "height.png"];
    let report: Value = serde_json::from_slice(&std::fs::read(folder.join(REPORT_FILE)).ok()?).ok()?;
    if report["streamed"] != Value::Bool(true) {
        return None;
    }
    let names: Vec<&str> = report["outputs"].as_array()?.iter().filter_map(Value::as_str).collect();
    let Some(name) = ENDINGS.iter().find_map(|e| names.iter().find(|n| n.ends_with(e))) else {
        return Some(Err(ExportError::input(format!(
            "`{}` holds a streamed run, which keeps no {WORLD_FILE}, and none of its exports is a raster of the height; \
             add one to the recipe and run it again",
            folder.display()
        ))));
    };
    let opened = open(&folder.join(name), limits, kinds).map(|mut opened| {
        opened.world.sea_level_m = report["sea_level_m"].as_f64().unwrap_or_default();
        opened.has_sea = opened.world.sea_level_m > NO_SEA_M;
        opened.view = view_of(&report["recipe"], &report["set"]);
        opened.engines = engines(&report["engines"]);
        opened.notes.push(format!("the run was streamed; this is its export `{name}`").into());
        opened
    });
    Some(opened)
}

fn saved(file: &Path, limits: &Limits, kinds: &ComponentKinds) -> Result<Opened, ExportError> {
    let saved = checkpoint::load(file, limits, kinds).map_err(ExportError::input)?;
    let mut notes = Vec::new();
    if saved.state["finished"] != Value::Bool(true) {
        notes.push("this run is not finished; this is its last checkpoint".into());
    }
    let engines = engines(&saved.state["engines"]);
    let view = view_of(&json!(saved.recipe_toml), &saved.state["overrides"]["set"]);
    let has_sea = saved.world.sea_level_m > NO_SEA_M;
    Ok(Opened { world: saved.world, file: file.to_owned(), has_sea, view, engines, notes })
}

fn engines(list: &Value) -> Vec<String> {
    list.as_array().into_iter().flatten().filter_map(Value::as_str).map(str::to_owned).collect()
}

/// Something that cannot be opened.
fn unusable(reason: String) -> ExportError {
    let map = " folder of a run, or a height map (.tif, .png, .exr, .npy, .r16, .r32, .zarr)";
    ExportError::refused(reason, remedy!["give the ", Setting::Out, map])
}
