//! Which recipes can be streamed, and how much memory runs take.

use super::stages::Stages;
use super::survey::coarse;
use super::{LARGE, Stream};
use crate::error::RunError;
use crate::keys::{Export, View};
use crate::need;
use crate::recipe::{Recipe, Step, Work};
use crate::run::RunOptions;
use crate::store::Subject;
use eyot_core::process::Reach;
use eyot_core::{Grid, Limits, Result};

/// Rows that writers hold at a time, with their compressed form: the shards of a Zarr store are the tallest.
const WRITER_ROWS: usize = 3 * 512;

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
            Work::Generate(work) => match work.make() {
                Ok(generator) if generator.reach(grid) != Reach::Whole => return None,
                _ => format!("`{}` as it is used here", work.entry.name),
            },
        };
        let reason = format!("step {} ({}): {what} needs the whole grid in memory", step.number, step.name);
        Some(Obstacle { place: Place::Step(step.number), reason })
    };
    let of_export = |(i, export): (usize, &Export)| {
        let file = export.files().into_iter().next().unwrap_or_default();
        let what = if export.preset.is_some() { "presets other than `gis` resample it" } else { "so does every mesh" };
        let reason = format!("the export `{file}` needs the whole grid in memory ({what})");
        (!export.streams()).then_some(Obstacle { place: Place::Export(i), reason })
    };
    steps
        .iter()
        .filter(|s| s.enabled)
        .find_map(of_step)
        .or_else(|| exports.iter().enumerate().filter(|(_, e)| e.enabled).find_map(of_export))
}

/// What a run without obstacles has to do.
pub(crate) struct Load<'a> {
    pub(crate) steps: &'a [Step],
    pub(crate) exports: &'a [Export],
    pub(crate) view: &'a View,
    pub(crate) grid: &'a Grid,
    pub(crate) limits: &'a Limits,
}

impl Load<'_> {
    /// Memory of the run in one piece.
    ///
    /// # Errors
    /// If a step is not what it seemed to be.
    pub(crate) fn whole(&self) -> Result<u128> {
        let peak = need::working(self.steps, self.grid)?;
        Ok(peak.bytes.max(peak.world_bytes + self.outputs(self.grid)))
    }

    /// The grid of the streamed run's overview, and memory that is held while exports are written and pictures drawn:
    /// windows and overview.
    ///
    /// # Errors
    /// If a step is not what it seemed to be.
    pub(crate) fn streamed(&self) -> Result<(Grid, u128)> {
        let stages = Stages::new(self.steps, *self.grid, 0.0)?;
        let windows = self.grid.width as u128 * 4 * stages.rows_held() as u128;
        let (_, coarse) = coarse(self.grid);
        Ok((coarse, windows + coarse.cells() as u128 * 4 * stages.layers().len() as u128))
    }

    /// Memory of the writers of a streamed run.
    pub(crate) fn writers(&self) -> u128 {
        self.grid.width as u128 * 4 * WRITER_ROWS.min(3 * self.grid.height) as u128
    }

    /// What is needed beside a world of this grid for the picture or export that needs most.
    fn outputs(&self, grid: &Grid) -> u128 {
        let pictures = [Subject::View, Subject::Relief].map(|s| need::picture(grid, self.view, s));
        let drawn = pictures.into_iter().filter(|_| self.view.enabled);
        let exports = self.exports.iter().filter(|e| e.enabled).map(|e| need::export(grid, e, self.limits));
        drawn.chain(exports).max().unwrap_or(0)
    }
}

/// Whether a run is streamed.
///
/// # Errors
/// If the options ask for what cannot be.
pub(crate) fn chosen(recipe: &Recipe, options: &RunOptions) -> Result<bool, RunError> {
    let Recipe { steps, exports, view, grid, .. } = recipe;
    let limits = &options.limits;
    let fail = |source| RunError::Step { step: "the grid".to_owned(), source };
    match (options.stream, obstacle(steps, exports, grid)) {
        (Stream::Always, Some(o)) => Err(RunError::NotStreamed(o.reason)),
        (Stream::Always, None) => Ok(true),
        (Stream::Auto, None) => {
            let whole = Load { steps, exports, view, grid, limits }.whole().map_err(fail)?;
            Ok(whole > u128::from(limits.max_bytes) || (options.out.is_some() && grid.cells() > LARGE))
        }
        // What does not fit was refused when the recipe was checked.
        (Stream::Auto | Stream::Never, Some(_)) => Ok(false),
        (Stream::Never, None) => {
            let peak = need::working(steps, grid).map_err(fail)?;
            limits.check_bytes("this recipe in one piece", peak.bytes).map(|()| false).map_err(fail)
        }
    }
}
