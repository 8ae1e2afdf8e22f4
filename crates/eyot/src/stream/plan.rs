//! Which recipes can be streamed, and how much memory runs take.

use super::stages::Stages;
use super::{LARGE, OVERVIEW, Stream};
use crate::error::RunError;
use crate::keys::Export;
use crate::recipe::{Recipe, Step, Work};
use crate::run::RunOptions;
use eyot_core::process::Reach;
use eyot_core::{Grid, Result};

/// Rows that writers hold at a time, with their compressed form: the shards of a Zarr store are the tallest.
const WRITER_ROWS: usize = 3 * 512;
/// What drawing needs for each cell of the overview. Measured: 96.
const PICTURE_BYTES: u128 = 96;

/// Where in a recipe something stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// The step of this number, from 1.
    Step(usize),
    /// The export at this index.
    Export(usize),
}

/// Why a recipe cannot be streamed.
pub(crate) struct Obstacle {
    pub(crate) place: Place,
    /// One clause: `X needs the whole grid in memory`.
    pub(crate) reason: String,
}

/// The first thing that needs the whole grid in memory.
pub(crate) fn obstacle(steps: &[Step], exports: &[Export], grid: &Grid) -> Option<Obstacle> {
    let of_step = |step: &Step| {
        let what = match &step.work {
            Work::Simulate(_) => "a simulation".to_owned(),
            Work::Generate(work) => match (work.entry.make)(work.parameters.clone()) {
                Ok(generator) if generator.reach(grid) != Reach::Whole => return None,
                _ => format!("`{}` as it is used here", work.entry.name),
            },
        };
        let reason = format!("step {} ({}): {what} needs the whole grid in memory", step.number, step.name);
        Some(Obstacle { place: Place::Step(step.number), reason })
    };
    let of_export = |(i, export): (usize, &Export)| {
        let file = export.files().into_iter().next().unwrap_or_default();
        let reason = format!("the export `{file}` needs the whole grid in memory");
        (!export.streams()).then_some(Obstacle { place: Place::Export(i), reason })
    };
    steps
        .iter()
        .filter(|s| s.enabled)
        .find_map(of_step)
        .or_else(|| exports.iter().enumerate().filter(|(_, e)| e.enabled).find_map(of_export))
}

/// Memory of a run in one piece: two buffers a layer while the engine runs, and two more fields for a generator at work.
pub(crate) fn bytes_whole(steps: &[Step], layers: usize, grid: &Grid) -> u128 {
    let generates = steps.iter().any(|s| matches!(s.work, Work::Generate(_)));
    let fields = layers.max(1) * 2 + if generates { 2 } else { 0 };
    grid.cells() as u128 * 4 * fields as u128
}

/// Memory of a streamed run: the windows, the overview, and whichever is more of writers and pictures.
///
/// # Errors
/// If a step is not what it seemed to be.
pub(crate) fn bytes_streamed(steps: &[Step], grid: &Grid) -> Result<u128> {
    let stages = Stages::new(steps, *grid, 0.0)?;
    let row = grid.width as u128 * 4;
    let overview = grid.cells().min(OVERVIEW * OVERVIEW) as u128;
    let writers = row * WRITER_ROWS.min(3 * grid.height) as u128;
    let windows = row * stages.rows_held() as u128;
    Ok(windows + overview * 4 * stages.layers().len() as u128 + writers.max(overview * PICTURE_BYTES))
}

/// Whether a run is streamed.
///
/// # Errors
/// If the options ask for what cannot be.
pub(crate) fn chosen(recipe: &Recipe, options: &RunOptions) -> Result<bool, RunError> {
    let layers = Stages::layer_names(&recipe.steps).len();
    let whole = bytes_whole(&recipe.steps, layers, &recipe.grid);
    let obstacle = obstacle(&recipe.steps, &recipe.exports, &recipe.grid);
    let too_large = whole > u128::from(options.limits.max_bytes);
    match (options.stream, obstacle) {
        (Stream::Always, Some(o)) => Err(RunError::NotStreamed(o.reason)),
        (Stream::Always, None) => Ok(true),
        (Stream::Auto, None) if too_large || (options.out.is_some() && recipe.grid.cells() > LARGE) => Ok(true),
        (Stream::Never, _) => {
            let check = options.limits.check_bytes("this recipe in one piece", whole);
            check.map(|()| false).map_err(|source| RunError::Step { step: "the grid".to_owned(), source })
        }
        // What does not fit was refused when the recipe was checked.
        (Stream::Auto, _) => Ok(false),
    }
}
