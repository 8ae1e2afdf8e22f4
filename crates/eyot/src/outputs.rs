//! The files of a finished run.

use crate::backend::io::{self, checkpoint};
use crate::backend::{self, render};
use crate::error::RunError;
use crate::event::Event;
use crate::exports;
use crate::keys::{ExportFormat, View};
use crate::need;
use crate::recipe::Recipe;
use crate::state::State;
use crate::store::{CHECKPOINT_FILE, PREVIEW_FILE, RELIEF_FILE, REPORT_FILE, Subject, WORLD_FILE};
use eyot_core::{Cancel, Control, Error, Limits, World};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Writes everything that a finished run leaves: the world, the exports, the pictures and the report. Each file
/// appears whole or not at all, the report last.
///
/// # Errors
/// [`RunError::Stopped`] on a request to stop: the files so far are whole, the world among them unless nothing was written.
pub(crate) fn write_all(
    recipe: &Recipe,
    world: &World,
    state: &State,
    out: &Path,
    limits: &Limits,
    cancel: &Cancel,
    tell: &dyn Fn(Event),
) -> Result<Vec<PathBuf>, RunError> {
    let control = Control::new(cancel.clone(), &|_, _| {});
    let mut written = Vec::new();
    let mut begin = |path: PathBuf| {
        control.check().map_err(stopped)?;
        tell(Event::Writing { path: path.clone() });
        written.push(path.clone());
        Ok(path)
    };
    let value = serde_json::to_value(state.without_times()).map_err(|e| RunError::Fault(e.to_string()))?;
    // Until the new world is whole on the disk, an older run's results stay as they are. Then its report goes, for it must
    // not vouch for a mixture of its files and these; from here to the new report, the checkpoint or, once it has the world's
    // name, the world says where to go on.
    let (path, checkpoint) = (begin(out.join(WORLD_FILE))?, out.join(CHECKPOINT_FILE));
    checkpoint::save(&checkpoint, world, &recipe.source.text, &value).map_err(file)?;
    let fail = |source| RunError::Folder { path: out.to_owned(), source };
    if out.join(REPORT_FILE).exists() {
        std::fs::remove_file(out.join(REPORT_FILE)).map_err(fail)?;
    }
    std::fs::rename(&checkpoint, &path).map_err(fail)?;
    for export in recipe.exports.iter().filter(|e| e.enabled) {
        let known =
            |l: &str| world.get(l).is_some() || (export.format == ExportFormat::Mask && exports::is_material(l));
        for layer in export.layers.iter().filter(|l| export.uses_layers() && !known(l)) {
            let message = format!("layer `{layer}` is not exported: the step that makes it is switched off");
            tell(Event::Warning { message });
        }
        let what = format!("`{}`", export.files()[0]);
        let bytes = need::export(&world.grid, export, limits);
        need::check(&what, world, bytes, limits, need::EXPORT_REMEDY).map_err(file)?;
        let mut job = exports::Job {
            world,
            name: &recipe.name,
            out,
            attributes: exports::origin(world, &recipe.name, Some(&recipe.source.text)),
            limits,
            control: &control,
            begin: &mut begin,
            note: &|message| tell(Event::Warning { message }),
        };
        exports::write(&mut job, export)?;
    }
    if recipe.view.enabled && world.get("height").is_some() {
        for (name, subject) in [(PREVIEW_FILE, Subject::View), (RELIEF_FILE, Subject::Relief)] {
            let path = begin(out.join(name))?;
            let picture = draw(world, &recipe.view, subject, limits, &control).map_err(stopped)?;
            io::write_rgb_png(&path, picture.width, picture.height, &picture.pixels).map_err(file)?;
        }
    }
    let path = begin(out.join(REPORT_FILE))?;
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
        "layers": world.layers().iter().map(|l| json!({ "name": l.spec.name, "unit": l.spec.unit, "meaning": l.spec.meaning })).collect::<Vec<_>>(),
        "ledger": world.ledger,
        "outputs": names,
        "set": recipe.overrides.set,
        "size_flag": recipe.overrides.size,
        "journal": state.journal,
        "recipe_file": recipe.source.name,
        "recipe": recipe.source.text,
        // The only place of all results that differs between two runs.
        "timing": {
            "seconds": state.seconds,
            "steps": state.timings.iter().map(|(name, seconds)| json!({ "step": name, "seconds": seconds })).collect::<Vec<_>>(),
        },
    });
    let mut text = serde_json::to_string_pretty(&report).map_err(|e| RunError::Fault(e.to_string()))?;
    text.push('\n');
    backend::write_text(&path, &text).map_err(file)?;
    Ok(written)
}

/// Draws a picture as the options say.
pub(crate) fn draw(
    world: &World,
    options: &View,
    subject: Subject<'_>,
    limits: &Limits,
    control: &Control<'_>,
) -> eyot_core::Result<render::Picture> {
    let bytes = need::picture(&world.grid, options, subject);
    need::check("this picture", world, bytes, limits, need::PICTURE_REMEDY)?;
    match subject {
        Subject::View => render::perspective_controlled(world, &view_options(options), control),
        Subject::Relief => render::relief_controlled(world, &relief_options(options, None), control),
        Subject::ReliefAt(n) => render::relief_controlled(world, &relief_options(options, Some(n)), control),
        Subject::Layer(name) => render::layer_map(world, name, &render::MapOptions::default()),
    }
}

/// What the view of a recipe is to the camera.
pub(crate) fn view_options(v: &View) -> render::ViewOptions {
    let d = render::ViewOptions::default();
    render::ViewOptions {
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
    }
}

/// What the view of a recipe is to a relief: its longer side bounds the relief's, unless that is given.
pub(crate) fn relief_options(v: &View, size: Option<u32>) -> render::ReliefOptions {
    let d = render::ReliefOptions::default();
    render::ReliefOptions {
        vertical_exaggeration: v.vertical_exaggeration.or(d.vertical_exaggeration),
        max_size: v.size[0].max(v.size[1]) as usize,
        size: size.map(|n| n as usize),
        sun_azimuth_deg: v.sun_azimuth.unwrap_or(d.sun_azimuth_deg),
        sun_elevation_deg: v.sun_elevation.unwrap_or(d.sun_elevation_deg),
        ..d
    }
}

/// Errors of work that can be stopped.
pub(crate) fn stopped(e: Error) -> RunError {
    if matches!(e, Error::Cancelled(_)) { RunError::Stopped } else { file(e) }
}

/// Errors of files and pictures name the file and the remedy themselves.
fn file(e: impl std::fmt::Display) -> RunError {
    RunError::File(e.to_string())
}
