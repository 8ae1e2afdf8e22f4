//! What a session keeps in its storage, by name.

use crate::error::RunError;
use eyot_core::remedy;
use eyot_core::remedy::Setting;
use eyot_io::run_folder::{PREVIEW_FILE, RELIEF_FILE};
use eyot_io::storage::{Storage, read_bytes};
use eyot_recipe::Recipe;
use serde_json::Value;
use std::path::Path;

pub use eyot_io::run_folder::{CHECKPOINT_FILE, REPORT_FILE, TIMELINE_STORE, WORLD_FILE};

/// Where the run in a storage can be continued from, if it did not come to its end: its checkpoint, or the world of a run
/// that ended while it wrote its results. The report is what comes last.
pub(crate) fn unfinished(storage: &dyn Storage) -> Option<&'static str> {
    let exists = |name| storage.bytes(name).is_some();
    if exists(CHECKPOINT_FILE) {
        return Some(CHECKPOINT_FILE);
    }
    (exists(WORLD_FILE) && !exists(REPORT_FILE)).then_some(WORLD_FILE)
}

/// Reports hold the recipe and what was done by hand; anything far larger is something else.
const MAX_REPORT_BYTES: u64 = 256 << 20;

/// The files that the report of an earlier run in a storage lists: its own, and what runs before it had left.
pub fn former_outputs(storage: &dyn Storage) -> Vec<String> {
    let report = read_bytes(storage, REPORT_FILE, MAX_REPORT_BYTES).ok();
    let report = report.and_then(|text| serde_json::from_slice::<Value>(&text).ok());
    let lists = ["outputs", "earlier_outputs"].map(|key| report.as_ref().and_then(|r| r[key].as_array()));
    let names = lists.into_iter().flatten().flatten().filter_map(Value::as_str);
    names.filter(|name| Path::new(name).file_name().is_some_and(|n| n == *name)).map(str::to_owned).collect()
}

/// Fails if a run of this recipe would overwrite files that no earlier run in the folder has written.
pub(crate) fn check_free(recipe: &Recipe, streamed: bool, storage: &dyn Storage) -> Result<(), RunError> {
    if unfinished(storage).is_some() {
        // A run that was stopped found no others when it began, and may not have come to listing its own.
        return Ok(());
    }
    let pictures = [PREVIEW_FILE, RELIEF_FILE].into_iter().filter(|_| recipe.view.enabled);
    let world = [REPORT_FILE].into_iter().chain((!streamed).then_some(WORLD_FILE));
    let exports = recipe.exports.iter().filter(|e| e.enabled).flat_map(|e| e.files());
    let planned = world.chain(pictures).map(str::to_owned).chain(exports);
    let former = former_outputs(storage);
    let foreign: Vec<String> = planned
        .filter(|name| !former.contains(name) && storage.place(name).symlink_metadata().is_ok())
        .map(|name| format!("`{name}`"))
        .collect();
    if foreign.is_empty() {
        return Ok(());
    }
    let (which, them) = if foreign.len() == 1 { ("which is", "it") } else { ("which are", "them") };
    let reason = format!(
        "the run would overwrite {} in `{}`, {which} not of a former run",
        foreign.join(", "),
        storage.place("").display()
    );
    let help = remedy![
        "choose another folder with ",
        Setting::Out,
        format!(", move {them} away, or overwrite {them} with "),
        Setting::Force,
    ];
    Err(RunError::refused(reason, help))
}
