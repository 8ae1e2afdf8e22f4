//! Names of the files in the folder of a run.

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
