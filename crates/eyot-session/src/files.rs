//! What a session keeps in its storage, by name.

use eyot_io::storage::Storage;

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
