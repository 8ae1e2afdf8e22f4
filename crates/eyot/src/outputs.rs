//! The files of a finished run.

use crate::backend::io::{self, checkpoint};
use crate::backend::{self, render};
use crate::error::RunError;
use crate::event::Event;
use crate::exports;
use crate::keys::{ExportFormat, View};
use crate::recipe::Recipe;
use crate::state::State;
use crate::store::{CHECKPOINT_FILE, PREVIEW_FILE, RELIEF_FILE, REPORT_FILE, Subject, WORLD_FILE};
use eyot_core::{Control, Limits, World};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Writes everything that a finished run leaves: the world, the exports, the pictures and the report. Each file
/// appears whole or not at all; the checkpoint goes last, so that a failure here costs nothing.
pub(crate) fn write_all(
    recipe: &Recipe,
    world: &World,
    state: &State,
    out: &Path,
    limits: &Limits,
    tell: &dyn Fn(Event),
) -> Result<Vec<PathBuf>, RunError> {
    // An older run's report must not vouch for a mixture of its files and these, nor its world pass for this one: the
    // report goes last, so that at no moment there is a world without one that is not this run's.
    if out.join(REPORT_FILE).exists() {
        for old in [WORLD_FILE, REPORT_FILE].map(|f| out.join(f)).into_iter().filter(|f| f.exists()) {
            std::fs::remove_file(&old).map_err(|source| RunError::Folder { path: old, source })?;
        }
    }
    let mut written = Vec::new();
    let mut begin = |path: PathBuf| {
        tell(Event::Writing { path: path.clone() });
        written.push(path.clone());
        path
    };
    let value = serde_json::to_value(state).map_err(|e| RunError::Fault(e.to_string()))?;
    let path = begin(out.join(WORLD_FILE));
    checkpoint::save(&path, world, &recipe.source.text, &value).map_err(file)?;
    for export in recipe.exports.iter().filter(|e| e.enabled) {
        let known = |l: &str| world.get(l).is_some() || (export.format == ExportFormat::Mask && exports::is_material(l));
        for layer in export.layers.iter().filter(|l| export.uses_layers() && !known(l)) {
            let message = format!("layer `{layer}` is not exported: the step that makes it is switched off");
            tell(Event::Warning { message });
        }
        let mut job = exports::Job {
            world,
            name: &recipe.name,
            out,
            attributes: exports::origin(world, &recipe.name, Some(&recipe.source.text)),
            limits,
            control: &Control::none(),
            begin: &mut |path| Ok(begin(path)),
            note: &|message| tell(Event::Warning { message }),
        };
        exports::write(&mut job, export)?;
    }
    if recipe.view.enabled && world.get("height").is_some() {
        for (name, subject) in [(PREVIEW_FILE, Subject::View), (RELIEF_FILE, Subject::Relief)] {
            let path = begin(out.join(name));
            let picture = draw(world, &recipe.view, subject).map_err(file)?;
            io::write_rgb_png(&path, picture.width, picture.height, &picture.pixels).map_err(file)?;
        }
    }
    let path = begin(out.join(REPORT_FILE));
    let names: Vec<String> =
        written.iter().filter_map(|p| Some(p.file_name()?.to_string_lossy().into_owned())).collect();
    let g = &world.grid;
    let report = json!({
        "name": recipe.name,
        "about": recipe.about,
        "engine_version": crate::VERSION,
        "seed": recipe.seed,
        "size": [g.width, g.height],
        "cell_m": [g.cell_x_m, g.cell_y_m],
        "fingerprint": format!("{:016x}", world.fingerprint()),
        "steps_done": world.step,
        "sea_level_m": world.sea_level_m,
        "seconds": state.seconds,
        "timings": state.timings.iter().map(|(name, seconds)| json!({ "step": name, "seconds": seconds })).collect::<Vec<_>>(),
        "layers": world.layers().iter().map(|l| json!({ "name": l.spec.name, "unit": l.spec.unit, "meaning": l.spec.meaning })).collect::<Vec<_>>(),
        "ledger": world.ledger,
        "outputs": names,
        "set": recipe.overrides.set,
        "size_flag": recipe.overrides.size,
        "journal": state.journal,
        "recipe_file": recipe.source.name,
        "recipe": recipe.source.text,
    });
    let mut text = serde_json::to_string_pretty(&report).map_err(|e| RunError::Fault(e.to_string()))?;
    text.push('\n');
    backend::write_text(&path, &text).map_err(file)?;
    let left = out.join(CHECKPOINT_FILE);
    if left.exists() {
        std::fs::remove_file(&left).map_err(|source| RunError::Folder { path: left, source })?;
    }
    Ok(written)
}

/// Draws a picture as the options say.
pub(crate) fn draw(world: &World, options: &View, subject: Subject<'_>) -> eyot_core::Result<render::Picture> {
    match subject {
        Subject::View => view(world, options),
        Subject::Relief => relief(world, options),
        Subject::Layer(name) => render::layer_map(world, name, &render::MapOptions::default()),
    }
}

fn view(world: &World, v: &View) -> eyot_core::Result<render::Picture> {
    let d = render::ViewOptions::default();
    let options = render::ViewOptions {
        width: v.size[0] as usize,
        height: v.size[1] as usize,
        azimuth_deg: v.azimuth.unwrap_or(d.azimuth_deg),
        elevation_deg: v.elevation.or(d.elevation_deg),
        distance: v.distance.or(d.distance),
        field_of_view_deg: v.field_of_view.unwrap_or(d.field_of_view_deg),
        vertical_exaggeration: v.vertical_exaggeration.or(d.vertical_exaggeration),
        sun_azimuth_deg: v.sun_azimuth.unwrap_or(d.sun_azimuth_deg),
        sun_elevation_deg: v.sun_elevation.unwrap_or(d.sun_elevation_deg),
        ..d
    };
    render::perspective(world, &options)
}

fn relief(world: &World, v: &View) -> eyot_core::Result<render::Picture> {
    let d = render::ReliefOptions::default();
    let options = render::ReliefOptions {
        vertical_exaggeration: v.vertical_exaggeration.or(d.vertical_exaggeration),
        max_size: v.size[0].max(v.size[1]) as usize,
        sun_azimuth_deg: v.sun_azimuth.unwrap_or(d.sun_azimuth_deg),
        sun_elevation_deg: v.sun_elevation.unwrap_or(d.sun_elevation_deg),
        ..d
    };
    render::relief(world, &options)
}

/// Errors of files and pictures name the file and the remedy themselves.
fn file(e: impl std::fmt::Display) -> RunError {
    RunError::File(e.to_string())
}
