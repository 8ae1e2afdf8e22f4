//! The files of a finished run.

use crate::backend::io::{self, checkpoint};
use crate::backend::{self, render};
use crate::error::RunError;
use crate::event::Event;
use crate::exports::{self, Source};
use crate::keys::{Export, ExportFormat, View};
use crate::recipe::Recipe;
use crate::state::State;
use crate::store::{CHECKPOINT_FILE, PREVIEW_FILE, RELIEF_FILE, REPORT_FILE, Subject, WORLD_FILE};
use eyot_core::{Control, Limits, World};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// What a finished run leaves, and where.
pub(crate) struct Outputs<'a> {
    pub(crate) recipe: &'a Recipe,
    /// The world; of a streamed one, an overview in coarser cells.
    pub(crate) world: &'a World,
    /// The layers in full.
    pub(crate) source: &'a dyn Source,
    /// Of the whole world.
    pub(crate) fingerprint: u64,
    pub(crate) out: &'a Path,
    pub(crate) limits: &'a Limits,
    pub(crate) control: &'a Control<'a>,
    pub(crate) tell: &'a dyn Fn(Event),
}

impl Outputs<'_> {
    /// Writes everything: the world unless it is streamed, the exports, the pictures and the report. Each file appears whole
    /// or not at all; the checkpoint goes last, so that a failure here costs nothing.
    ///
    /// Exports that `state` counts as done and that are still there are left alone; `exported` is called after each other.
    pub(crate) fn write(
        &self,
        state: &mut State,
        exported: &mut dyn FnMut(&mut State) -> Result<(), RunError>,
    ) -> Result<Vec<PathBuf>, RunError> {
        let (recipe, out) = (self.recipe, self.out);
        // An older run's report must not vouch for a mixture of its files and these, nor its world pass for this one: the
        // report goes last, so that at no moment there is a world without one that is not this run's.
        if out.join(REPORT_FILE).exists() {
            for old in [WORLD_FILE, REPORT_FILE].map(|f| out.join(f)).into_iter().filter(|f| f.exists()) {
                std::fs::remove_file(&old).map_err(|source| RunError::Folder { path: old, source })?;
            }
        }
        let mut written = Vec::new();
        if !state.streamed {
            let value = serde_json::to_value(&*state).map_err(|e| RunError::Fault(e.to_string()))?;
            let path = self.begin(WORLD_FILE, &mut written);
            checkpoint::save(&path, self.world, &recipe.source.text, &value).map_err(file)?;
        }
        for (i, export) in recipe.exports.iter().enumerate().filter(|(_, e)| e.enabled) {
            let files = export.files();
            if i < state.done_exports && files.iter().all(|f| out.join(f).exists()) {
                written.extend(files.iter().map(|f| out.join(f)));
                continue;
            }
            self.export(export, &mut written)?;
            state.done_exports = i + 1;
            exported(state)?;
        }
        if recipe.view.enabled && self.world.get("height").is_some() {
            for (name, subject) in [(PREVIEW_FILE, Subject::View), (RELIEF_FILE, Subject::Relief)] {
                let path = self.begin(name, &mut written);
                let picture = draw(self.world, &recipe.view, subject).map_err(file)?;
                io::write_rgb_png(&path, picture.width, picture.height, &picture.pixels).map_err(file)?;
            }
        }
        let path = self.begin(REPORT_FILE, &mut written);
        let report = self.report(state, &written);
        let mut text = serde_json::to_string_pretty(&report).map_err(|e| RunError::Fault(e.to_string()))?;
        text.push('\n');
        backend::write_text(&path, &text).map_err(file)?;
        let left = out.join(CHECKPOINT_FILE);
        if left.exists() {
            std::fs::remove_file(&left).map_err(|source| RunError::Folder { path: left, source })?;
        }
        Ok(written)
    }

    fn begin(&self, name: &str, written: &mut Vec<PathBuf>) -> PathBuf {
        let path = self.out.join(name);
        (self.tell)(Event::Writing { path: path.clone() });
        written.push(path.clone());
        path
    }

    fn export(&self, export: &Export, written: &mut Vec<PathBuf>) -> Result<(), RunError> {
        let (world, recipe) = (self.world, self.recipe);
        let known =
            |l: &str| world.get(l).is_some() || (export.format == ExportFormat::Mask && exports::is_material(l));
        for layer in export.layers.iter().filter(|l| export.uses_layers() && !known(l)) {
            let message = format!("layer `{layer}` is not exported: the step that makes it is switched off");
            (self.tell)(Event::Warning { message });
        }
        let mut job = exports::Job {
            world,
            source: self.source,
            name: &recipe.name,
            out: self.out,
            attributes: exports::origin(world, &recipe.name, Some(&recipe.source.text)),
            limits: self.limits,
            control: self.control,
            begin: &mut |path| {
                (self.tell)(Event::Writing { path: path.clone() });
                written.push(path.clone());
                Ok(path)
            },
            note: &|message| (self.tell)(Event::Warning { message }),
        };
        exports::write(&mut job, export)
    }

    fn report(&self, state: &State, written: &[PathBuf]) -> Value {
        let (recipe, world) = (self.recipe, self.world);
        let names: Vec<String> =
            written.iter().filter_map(|p| Some(p.file_name()?.to_string_lossy().into_owned())).collect();
        let g = &recipe.grid;
        json!({
            "name": recipe.name,
            "about": recipe.about,
            "engine_version": crate::VERSION,
            "seed": recipe.seed,
            "size": [g.width, g.height],
            "cell_m": [g.cell_x_m, g.cell_y_m],
            "fingerprint": format!("{:016x}", self.fingerprint),
            "streamed": state.streamed,
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
        })
    }
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
