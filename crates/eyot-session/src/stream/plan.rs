//! Which recipes can be streamed, and how much memory runs take.

use super::stages::Stages;
use super::survey::coarse;
use super::{LARGE, Stream};
use crate::error::RunError;
use eyot_core::{Grid, Limits, Result};
use eyot_recipe::memory::{self, obstacle};
use eyot_recipe::{Estimator, Recipe, Step, Streamed};

/// Rows that writers hold at a time, with their compressed form: the shards of a Zarr store are the tallest.
const WRITER_ROWS: usize = 3 * 512;

/// What a streamed run holds while exports are written and pictures drawn.
///
/// # Errors
/// If a step is not what it seemed to be.
pub fn streamed_memory(steps: &[Step], grid: &Grid) -> Result<Streamed> {
    let stages = Stages::new(steps, *grid, 0.0)?;
    let windows = grid.width as u128 * 4 * stages.rows_held() as u128;
    let (_, overview) = coarse(grid);
    Ok(Streamed {
        overview,
        held: windows + overview.cells() as u128 * 4 * stages.layers().len() as u128,
        writers: grid.width as u128 * 4 * WRITER_ROWS.min(3 * grid.height) as u128,
    })
}

/// Whether a run is streamed.
///
/// # Errors
/// If the options ask for what cannot be.
pub(crate) fn chosen(
    recipe: &Recipe,
    stream: Stream,
    has_folder: bool,
    limits: &Limits,
    costs: &dyn Estimator,
) -> Result<bool, RunError> {
    let Recipe { steps, exports, view, grid, .. } = recipe;
    let fail = |source| RunError::Step { step: "the grid".to_owned(), source };
    match (stream, obstacle(steps, exports, grid)) {
        (Stream::Always, Some(o)) => Err(RunError::NotStreamed(o.reason)),
        (Stream::Always, None) => Ok(true),
        (Stream::Auto, None) => {
            let whole = memory::whole(steps, exports, view, grid, costs, limits).map_err(fail)?;
            Ok(whole > u128::from(limits.max_bytes) || (has_folder && grid.cells() > LARGE))
        }
        // What does not fit was refused when the recipe was checked.
        (Stream::Auto | Stream::Never, Some(_)) => Ok(false),
        // The check of the recipe was content with what it takes when it is streamed.
        (Stream::Never, None) => {
            let whole = memory::whole(steps, exports, view, grid, costs, limits).map_err(fail)?;
            limits
                .check_bytes("this recipe in one piece, with its files,", whole)
                .map(|()| false)
                .map_err(RunError::input)
        }
    }
}
