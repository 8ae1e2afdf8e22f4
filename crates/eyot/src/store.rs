//! Worlds that lie in files: finished and stopped runs, and height maps.

use crate::backend::analyse;
use crate::backend::io::{self, ReadOptions, checkpoint};
use crate::error::RunError;
use crate::import;
use crate::keys::View;
use crate::outputs;
use crate::registry::{Registry, component_kinds};
use eyot_core::layer::known;
use eyot_core::{Control, Grid, Limits, Rim, World};
use eyot_recipe::value_of;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The world of a finished run.
pub const WORLD_FILE: &str = "world.eyot";
/// Where a stopped run can be continued from.
pub const CHECKPOINT_FILE: &str = "checkpoint.eyot";
/// The recording of a run.
pub const TIMELINE_STORE: &str = "timeline.zarr";
/// The land as a camera sees it.
pub const PREVIEW_FILE: &str = "preview.png";
/// The land from above.
pub const RELIEF_FILE: &str = "relief.png";
/// What the run was and what it took.
pub const REPORT_FILE: &str = "run.json";

/// Where the run in a folder can be continued from, if it did not come to its end: its checkpoint, or the world of a run
/// that ended while it wrote its results. The report is what comes last.
pub(crate) fn unfinished(folder: &Path) -> Option<PathBuf> {
    let [checkpoint, world] = [CHECKPOINT_FILE, WORLD_FILE].map(|f| folder.join(f));
    if checkpoint.exists() {
        return Some(checkpoint);
    }
    (world.exists() && !folder.join(REPORT_FILE).exists()).then_some(world)
}

/// A world from a file.
#[derive(Debug)]
pub struct Opened {
    /// The world.
    pub world: World,
    /// The file it came from.
    pub file: PathBuf,
    /// False for height maps, which say nothing of a sea.
    pub has_sea: bool,
    /// Whether the recipe's view is from above, as a map.
    pub from_above: bool,
    /// Things to know about it.
    pub notes: Vec<String>,
}

/// Opens the folder of a run, a saved world or any height map.
///
/// # Errors
/// If there is nothing that can be opened; the text says what would be right.
pub fn open(path: &Path, limits: &Limits) -> Result<Opened, RunError> {
    open_with(path, &ReadOptions { bare_numbers: true, ..ReadOptions::default() }, limits)
}

/// As [`open`], with what a height map itself leaves open.
///
/// # Errors
/// As [`open`].
pub fn open_with(path: &Path, options: &ReadOptions, limits: &Limits) -> Result<Opened, RunError> {
    let nothing = |e: std::io::Error| unusable(format!("cannot open `{}`: {e}", path.display()));
    let meta = std::fs::metadata(path).map_err(nothing)?;
    if meta.is_dir() && !io::is_zarr(path) {
        let found = [WORLD_FILE, CHECKPOINT_FILE].iter().map(|f| path.join(f)).find(|f| f.is_file());
        let Some(file) = found else {
            if let Some(opened) = streamed(path, limits) {
                return opened;
            }
            return Err(unusable(format!("`{}` holds no run: there is no {WORLD_FILE} in it", path.display())));
        };
        return saved(&file, limits);
    }
    if path.extension().is_some_and(|e| e == "eyot") {
        return saved(path, limits);
    }
    let raster = import::read(&path.display().to_string(), options, limits).map_err(RunError::input)?;
    of_raster(raster, path, limits)
}

/// The world of a height map.
pub(crate) fn of_raster(mut raster: io::Raster, path: &Path, limits: &Limits) -> Result<Opened, RunError> {
    let (dx, dy) = raster.cell_m.unwrap_or((1.0, 1.0));
    let grid = Grid {
        width: raster.field.width(),
        height: raster.field.height(),
        cell_x_m: dx,
        cell_y_m: dy,
        rim: Rim::CLOSED,
    };
    let grid = grid.checked(limits).map_err(RunError::input)?;
    let mut notes = notes(&raster, false);
    if raster.to_metres() {
        notes.push("heights in feet were turned into metres".to_owned());
    }
    let mut world = World::new(grid, 0);
    world.georeference = raster.georeference;
    world.put(&known::HEIGHT, raster.field).map_err(RunError::input)?;
    // A bare height map has no sea: far below everything.
    world.sea_level_m = f64::from(known::HEIGHT.range.0);
    Ok(Opened { world, file: path.to_owned(), has_sea: false, from_above: false, notes })
}

/// What one should know of a height map; `holes_stay` if what is made of it marks missing cells.
pub(crate) fn notes(raster: &io::Raster, holes_stay: bool) -> Vec<String> {
    let mut notes = Vec::new();
    if raster.cell_m.is_none() {
        notes
            .push("the file does not say how large its cells are; 1 m is assumed (eyot convert has --cell)".to_owned());
    }
    if raster.numbers == io::Numbers::Bare {
        notes.push(
            "the file does not say which heights its whole numbers stand for; metres are assumed (eyot convert has \
             --from-range)"
                .to_owned(),
        );
    }
    if raster.missing.is_some() {
        let fate = if holes_stay { "stay without one" } else { "were filled from their neighbours" };
        notes.push(format!("{} cells without a value {fate}", raster.filled()));
    }
    if raster.rounded_by > 0.0 {
        let by = raster.rounded_by;
        notes.push(format!("the file holds numbers of more than 32 bits; they were rounded, by {by:.1e} at most"));
    }
    if raster.steps > 1 {
        notes.push(format!("the file holds {} steps of time; this is the last", raster.steps));
    }
    notes
}

/// The height of a streamed run from what it exported; `None` if the folder holds no such run.
fn streamed(folder: &Path, limits: &Limits) -> Option<Result<Opened, RunError>> {
    /// Endings of names, exact formats first.
    const ENDINGS: [&str; 7] =
        ["height.tif", "world.zarr", "height.exr", "height.npy", "height.r32", "height.r16", "height.png"];
    let report: Value = serde_json::from_slice(&std::fs::read(folder.join(REPORT_FILE)).ok()?).ok()?;
    if report["streamed"] != Value::Bool(true) {
        return None;
    }
    let names: Vec<&str> = report["outputs"].as_array()?.iter().filter_map(Value::as_str).collect();
    let Some(name) = ENDINGS.iter().find_map(|e| names.iter().find(|n| n.ends_with(e))) else {
        return Some(Err(RunError::input(format!(
            "`{}` holds a streamed run, which keeps no {WORLD_FILE}, and none of its exports is a raster of the height; \
             add one to the recipe and run it again",
            folder.display()
        ))));
    };
    let opened = open(&folder.join(name), limits).map(|mut opened| {
        opened.world.sea_level_m = report["sea_level_m"].as_f64().unwrap_or_default();
        opened.has_sea = true;
        opened.from_above = seen_from_above(&report["recipe"], &report["set"]);
        opened.notes.push(format!("the run was streamed; this is its export `{name}`"));
        opened
    });
    Some(opened)
}

fn saved(file: &Path, limits: &Limits) -> Result<Opened, RunError> {
    let saved = checkpoint::load(file, limits, &component_kinds()).map_err(RunError::input)?;
    let mut notes = Vec::new();
    if saved.state["finished"] != Value::Bool(true) {
        notes.push("this run is not finished; this is its last checkpoint".to_owned());
    }
    let from_above = seen_from_above(&json!(saved.recipe_toml), &saved.state["overrides"]["set"]);
    Ok(Opened { world: saved.world, file: file.to_owned(), has_sea: true, from_above, notes })
}

/// Whether a run's recipe, a text, with its `--set`, a list of texts, wants its view from above.
pub(crate) fn seen_from_above(recipe: &Value, set: &Value) -> bool {
    // What a run was begun with has passed its checks.
    let set: Vec<&str> = set.as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let recipe = recipe.as_str().unwrap_or_default();
    value_of(recipe, &set, &["view", "from_above"], &Registry::standard()) == Some(Value::Bool(true))
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject<'a> {
    /// The land as a camera sees it.
    View,
    /// The land from above, with shaded relief.
    Relief,
    /// As `Relief`, with so many pixels along the longer side.
    ReliefAt(u32),
    /// A map of one layer.
    Layer(&'a str),
}

/// Draws a world into a PNG file.
///
/// # Errors
/// If `path` has another extension than `.png`, the layer is not there, the picture exceeds the limits, or the file cannot be
/// written, which is found out first.
pub fn draw(world: &World, options: &View, subject: Subject<'_>, path: &Path, limits: &Limits) -> Result<(), RunError> {
    check_picture_name(path)?;
    if let Subject::Layer(name) = subject {
        world.layer(name).map_err(RunError::input)?;
    }
    let picture =
        outputs::draw(world, options, subject, limits, &Control::none()).map_err(|e| RunError::File(e.to_string()))?;
    io::write_rgb_png(path, picture.width, picture.height, &picture.pixels).map_err(|e| RunError::File(e.to_string()))
}

/// Fails unless a PNG picture can be written to `path`.
pub(crate) fn check_picture_name(path: &Path) -> Result<(), RunError> {
    if let Some(other) = path.extension().filter(|e| !e.eq_ignore_ascii_case("png")) {
        let reason = format!("`{}` would be a PNG picture that is called .{}", path.display(), other.display());
        return Err(RunError::Input { reason, help: Some("give it a name that ends in .png") });
    }
    io::check_place(path).map_err(|e| RunError::File(e.to_string()))
}

/// Something that cannot be opened.
fn unusable(reason: String) -> RunError {
    let help = "give the --out folder of a run, or a height map (.tif, .png, .exr, .npy, .r16, .r32, .zarr)";
    RunError::Input { reason, help: Some(help) }
}

/// Statistics of a world's terrain, and of its climate if it has one.
///
/// # Errors
/// If the world has no height, or one that cannot be measured within the limits.
pub fn stats(opened: &Opened, limits: &Limits) -> Result<Value, RunError> {
    let world = &opened.world;
    let height = &world.layer("height").map_err(RunError::input)?.field;
    let sea = opened.has_sea.then_some(world.sea_level_m);
    let stats = analyse::terrain_stats(height, &world.grid, sea, &analyse::TerrainOptions::default(), limits);
    let fault = |e: serde_json::Error| RunError::Fault(e.to_string());
    let mut all = serde_json::to_value(stats.map_err(RunError::file)?).map_err(fault)?;
    if let Some(planet) = eyot_climate::stats::planet(world) {
        all["planet"] = serde_json::to_value(planet).map_err(fault)?;
    }
    if let Some(plates) = eyot_plates::report(world).map_err(RunError::file)? {
        all["plates"] = serde_json::to_value(plates).map_err(fault)?;
    }
    Ok(all)
}
