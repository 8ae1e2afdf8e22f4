//! What a session keeps in its storage, by name.

use eyot_io::storage::Storage;

/// The world of a finished run.
pub const WORLD_FILE: &str = "world.eyot";
/// Where a stopped run can be continued from.
pub const CHECKPOINT_FILE: &str = "checkpoint.eyot";
/// The recording of a run.
pub const TIMELINE_STORE: &str = "timeline.zarr";
/// What the run was and what it took.
pub const REPORT_FILE: &str = "run.json";

/// Where the run in a storage can be continued from, if it did not come to its end: its checkpoint, or the world of a run
/// that ended while it wrote its results. The report is what comes last.
pub(crate) fn unfinished(storage: &dyn Storage) -> Option<&'static str> {
    let exists = |name| storage.bytes(name).is_some();
    if exists(CHECKPOINT_FILE) {
        return Some(CHECKPOINT_FILE);
    }
    (exists(WORLD_FILE) && !exists(REPORT_FILE)).then_some(WORLD_FILE)
}
