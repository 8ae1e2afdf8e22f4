//! The files of a finished run.

use crate::error::ExportError;
use crate::files::{Job, write};
use crate::pictures::{Subject, draw};
use crate::{corals, estimate};
use eyot_core::remedy::Remedy;
use eyot_core::{Error, World};
use eyot_io::run_folder::{CHECKPOINT_FILE, PREVIEW_FILE, RELIEF_FILE, REPORT_FILE, WORLD_FILE};
use eyot_io::storage::Storage;
use eyot_io::{self as io, Origin, Target, checkpoint};
use eyot_land::analyse::erosion_score;
use eyot_recipe::Export;
use eyot_session::{Event, Results, RunError};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Writes the files of a run into its storage, a folder or memory: the world unless it is streamed, the exports, the pictures and the
/// report. Each file appears whole or not at all, the report last. A session without storage has none.
///
/// [`RunError::Export`] means that values do not fit the file that they were to be exported to; everything else is written then.
/// After [`RunError::Stopped`] the files so far are whole, the world among them unless nothing was written.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunFiles;

impl eyot_session::Outputs for RunFiles {
    fn write(&self, results: &Results<'_>, exported: &mut dyn FnMut(usize)) -> Result<Vec<PathBuf>, RunError> {
        match results.storage {
            Some(out) => Outputs { results, out }.write(exported),
            None => Ok(Vec::new()),
        }
    }

    fn score(&self, world: &World) -> Option<f64> {
        let height = world.get("height")?;
        let land: Vec<bool> = height.iter().map(|z| f64::from(z) > world.sea_level_m).collect();
        erosion_score(height, &world.grid, |i| land[i]).ok().flatten()
    }
}

/// What a finished run leaves, and where.
struct Outputs<'a> {
    results: &'a Results<'a>,
    out: &'a dyn Storage,
}

impl Outputs<'_> {
    fn write(&self, exported: &mut dyn FnMut(usize)) -> Result<Vec<PathBuf>, RunError> {
        let Results { recipe, state, world, limits, control, .. } = *self.results;
        let mut written: Vec<String> = Vec::new();
        let mut unmade: Vec<Remedy> = Vec::new();
        let former = eyot_session::former_outputs(self.out);
        self.replace_world(&mut written)?;
        for (i, export) in recipe.exports.iter().enumerate().filter(|(_, e)| e.enabled) {
            let files = export.files();
            if i < state.done_exports && files.iter().all(|f| self.is_there(f)) {
                written.extend(files);
                continue;
            }
            let before = written.len();
            match self.export(export, &mut written) {
                // The others are wanted all the same.
                Err(RunError::Export(reason)) => {
                    written.truncate(before);
                    unmade.push(reason);
                }
                done => done?,
            }
            exported(i + 1);
        }
        let view = &recipe.view;
        if view.enabled && world.get("height").is_some() {
            let preview =
                if view.from_above { Subject::ReliefAt(view.size[0].max(view.size[1])) } else { Subject::View };
            for (name, subject) in [(PREVIEW_FILE, preview), (RELIEF_FILE, Subject::Relief)] {
                self.begin(name, &mut written).map_err(RunError::from)?;
                let picture = draw(world, view, subject, limits, control).map_err(stopped)?;
                io::write_rgb_png(Target::blob(self.out, name), picture.width, picture.height, &picture.pixels)
                    .map_err(RunError::file)?;
            }
        }
        self.begin(REPORT_FILE, &mut written).map_err(RunError::from)?;
        let stale = self.stale(former, &written);
        let report = self.report(&written, &stale);
        let mut text = serde_json::to_string_pretty(&report).map_err(|e| RunError::Fault(e.to_string()))?;
        text.push('\n');
        io::write_text(Target::blob(self.out, REPORT_FILE), &text).map_err(RunError::file)?;
        self.check_there(&written)?;
        if state.streamed {
            self.remove(CHECKPOINT_FILE)?;
        }
        self.warn_of(&stale);
        let places = || written.iter().map(|name| self.out.place(name)).collect();
        if unmade.is_empty() { Ok(places()) } else { Err(RunError::Export(Remedy::joined(unmade, "; "))) }
    }

    /// Writes the world and ends what an older run left. Until the new world is whole on the disk, an older run's results
    /// stay as they are. Then its report goes, for it must not vouch for a mixture of its files and these; from here to the
    /// new report, the checkpoint or, once it has the world's name, the world says where to go on.
    fn replace_world(&self, written: &mut Vec<String>) -> Result<(), RunError> {
        let Results { recipe, state, world, .. } = *self.results;
        if state.streamed {
            self.remove(REPORT_FILE)?;
            return self.remove(WORLD_FILE);
        }
        let value = serde_json::to_value(state.without_times()).map_err(|e| RunError::Fault(e.to_string()))?;
        self.begin(WORLD_FILE, written).map_err(RunError::from)?;
        checkpoint::save_in(self.out, CHECKPOINT_FILE, world, &recipe.source.text, &value).map_err(RunError::file)?;
        self.remove(REPORT_FILE)?;
        self.out.rename(CHECKPOINT_FILE, WORLD_FILE).map_err(RunError::file)
    }

    /// Files of earlier runs that this one did not write and that are still there.
    fn stale(&self, former: Vec<String>, written: &[String]) -> Vec<String> {
        let is_stale = |name: &String| !written.contains(name) && self.is_there(name);
        former.into_iter().filter(is_stale).collect()
    }

    /// Such files belong to the user, but no longer to the land in this folder.
    fn warn_of(&self, stale: &[String]) {
        let stale: Vec<String> = stale.iter().map(|name| format!("`{name}`")).collect();
        if !stale.is_empty() {
            let (files, they) = if stale.len() == 1 { ("file", "it shows") } else { ("files", "they show") };
            let message = format!(
                "`{}` still holds the {files} {} of an earlier run: {they} another land; remove what you do not need",
                self.out.place("").display(),
                stale.join(", ")
            );
            (self.results.tell)(Event::Warning { message: message.into() });
        }
    }

    fn remove(&self, name: &str) -> Result<(), RunError> {
        self.out.remove(name).map_err(RunError::file)
    }

    fn is_there(&self, name: &str) -> bool {
        self.out.bytes(name).is_some() || self.out.is_group(name)
    }

    /// Whoever reads the report must find what it lists.
    fn check_there(&self, written: &[String]) -> Result<(), RunError> {
        (self.results.in_place)()?;
        match written.iter().find(|name| !self.is_there(name)) {
            Some(name) => {
                let place = self.out.place(name);
                Err(RunError::File(format!("`{}` was removed while the run wrote others", place.display()).into()))
            }
            None => Ok(()),
        }
    }

    fn begin(&self, name: &str, written: &mut Vec<String>) -> Result<(), ExportError> {
        self.results.control.check().map_err(ExportError::stopped)?;
        (self.results.in_place)().map_err(ExportError::file)?;
        (self.results.tell)(Event::Writing { path: self.out.place(name) });
        written.push(name.to_owned());
        Ok(())
    }

    fn export(&self, export: &Export, written: &mut Vec<String>) -> Result<(), RunError> {
        let Results { recipe, state, world, limits, .. } = *self.results;
        let known = |l: &str| world.get(l).is_some() || export.knows(l);
        for layer in export.layers.iter().filter(|l| export.uses_layers() && !known(l)) {
            let message = format!("layer `{layer}` is not exported: the step that makes it is switched off");
            (self.results.tell)(Event::Warning { message: message.into() });
        }
        let what = format!("`{}`", export.files()[0]);
        let bytes = estimate::export(&world.grid, export, limits);
        estimate::check(&what, world, bytes, limits, estimate::export_remedy()).map_err(RunError::file)?;
        let mut job = Job {
            world,
            source: self.results.source,
            corals: corals::of(recipe),
            name: &recipe.name,
            looks: crate::pictures::looks(&recipe.view),
            out: self.out,
            attributes: Origin {
                name: &recipe.name,
                recipe: Some(&recipe.source.text),
                seconds_per_step: self.results.clock,
                engines: &state.engines,
            }
            .attributes(world),
            limits,
            control: self.results.control,
            begin: &mut |name| self.begin(name, written),
            note: &|message| (self.results.tell)(Event::Warning { message }),
        };
        write(&mut job, export).map_err(RunError::from)
    }

    /// That of the land above the sea; the overview of a streamed world has other cells and none.
    fn score(&self) -> Option<f64> {
        let Results { state, world, .. } = *self.results;
        if state.streamed { None } else { eyot_session::Outputs::score(&RunFiles, world) }
    }

    fn report(&self, written: &[String], stale: &[String]) -> Value {
        let Results { recipe, state, world, .. } = *self.results;
        let g = &recipe.grid;
        json!({
            "name": recipe.name,
            "about": recipe.about,
            "engine_version": eyot_session::VERSION,
            "seed": recipe.seed,
            "size": [g.width, g.height],
            "cell_m": [g.cell_x_m, g.cell_y_m],
            "fingerprint": format!("{:016x}", self.results.fingerprint),
            "engines": state.engines,
            "streamed": state.streamed,
            "steps_done": world.step,
            "sea_level_m": world.sea_level_m,
            "layers": world.layers().iter().map(|l| json!({ "name": l.spec.name, "unit": l.spec.unit, "meaning": l.spec.meaning })).collect::<Vec<_>>(),
            "ledger": world.ledger,
            "erosion_score": self.score(),
            "outputs": written,
            "vertical_exaggeration": recipe.view.enabled.then(|| recipe.view.vertical_exaggeration.unwrap_or(1.0)),
            // So that a later run knows them from files of others.
            "earlier_outputs": stale,
            "set": recipe.overrides.set,
            "size_flag": recipe.overrides.size,
            "journal": state.journal,
            "recipe_file": recipe.source.name,
            "recipe": recipe.source.text,
            "effective": recipe.effective(),
            // The only place of all results that differs between two runs.
            "timing": {
                "seconds": state.seconds,
                // What the graphics card itself spent on the rules; 0 without one.
                "card_seconds": state.card_seconds,
                "steps": state.timings.iter().map(|(name, seconds)| json!({ "step": name, "seconds": seconds })).collect::<Vec<_>>(),
            },
        })
    }
}

fn stopped(e: Error) -> RunError {
    ExportError::stopped(e).into()
}

impl From<ExportError> for RunError {
    fn from(e: ExportError) -> Self {
        match e {
            ExportError::Input { reason, help } => Self::Input { reason, help },
            ExportError::Values(reason) => Self::Export(reason),
            ExportError::Folder { path, source } => Self::Folder { path, source },
            ExportError::Stopped => Self::Stopped,
            other => Self::file(other),
        }
    }
}
