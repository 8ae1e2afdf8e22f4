//! How much memory the steps of a recipe need, and what keeps a recipe from being streamed.

use crate::host::Estimator;
use crate::keys::{Export, View, What};
use crate::recipe::{Step, Work};
use eyot_core::process::Reach;
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Setting};
use eyot_core::{Error, Field, Grid, Limits, Result, engine};

/// What helps where a picture does not fit.
pub fn picture_remedy() -> Remedy {
    remedy![
        "make it smaller with `size`, leave it out with view.enabled=false, or raise the limit with ",
        Setting::MaxMemory,
    ]
}

/// What helps where an export does not fit.
pub fn export_remedy() -> Remedy {
    remedy![
        "leave out this export with its enabled=false, choose a smaller grid, or raise the limit with ",
        Setting::MaxMemory,
    ]
}

/// The step of a run in one piece that needs most memory, and how much that is.
pub struct Peak<'a> {
    /// The step; `None` if no step needs more than one layer.
    pub step: Option<&'a Step>,
    /// Bytes.
    pub bytes: u128,
    /// Bytes of all layers once the last step is done.
    pub world_bytes: u128,
    /// Number of the layers.
    pub layers: usize,
}

/// What the enabled steps need in one piece: the layers so far, and what generators and processes hold beside them.
///
/// # Errors
/// If the parameters of a step make no generator or process; recipes that were checked have none such.
pub fn working<'a>(steps: &'a [Step], grid: &Grid) -> Result<Peak<'a>> {
    let field = Field::bytes_of(grid.width, grid.height);
    let mut layers: Vec<String> = Vec::new();
    let mut peak = Peak { step: None, bytes: field, world_bytes: 0, layers: 0 };
    for step in steps.iter().filter(|s| s.enabled) {
        let bytes = match &step.work {
            Work::Generate(work) => {
                add(&mut layers, &work.layer);
                let each = work.make()?.bytes_per_cell(grid).div_ceil(size_of::<f32>());
                field * (layers.len() + each + usize::from(work.mask.is_some())) as u128
            }
            Work::Simulate(work) => {
                let scheduled = work.schedule()?;
                scheduled.iter().flat_map(|s| s.process.layers()).for_each(|l| add(&mut layers, &l.spec.name));
                engine::MemoryEstimate::of(grid, layers.len(), &scheduled).bytes(grid)
            }
        };
        if bytes > peak.bytes {
            (peak.bytes, peak.step) = (bytes, Some(step));
        }
    }
    peak.layers = layers.len();
    peak.world_bytes = field * layers.len() as u128;
    Ok(peak)
}

fn add(layers: &mut Vec<String>, name: &str) {
    if !layers.iter().any(|l| l == name) {
        layers.push(name.to_owned());
    }
}

/// Memory of a run in one piece, with its pictures and exports.
///
/// # Errors
/// As [`working`].
pub fn whole(
    steps: &[Step],
    exports: &[Export],
    view: &View,
    grid: &Grid,
    outputs: &dyn Estimator,
    limits: &Limits,
) -> Result<u128> {
    let peak = working(steps, grid)?;
    let drawn = view.enabled.then(|| outputs.pictures(grid, view));
    let exported = exports.iter().filter(|e| e.enabled).map(|e| outputs.export(grid, e, limits));
    Ok(peak.bytes.max(peak.world_bytes + exported.chain(drawn).max().unwrap_or(0)))
}

/// Checks a sum of bytes against the limit on memory.
///
/// # Errors
/// [`Error::Limit`] with this remedy.
pub fn check_bytes(what: &str, bytes: u128, limits: &Limits, remedy: Remedy) -> Result<()> {
    limits.check_bytes(what, bytes).map_err(|e| match e {
        Error::Limit { what, needed, limit, .. } => Error::Limit { what, needed, limit, remedy },
        other => other,
    })
}

/// Where in a recipe something stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// The step of this number, from 1.
    Step(usize),
    /// The export at this index.
    Export(usize),
}

/// Why a recipe cannot be streamed.
pub struct Obstacle {
    /// What stands in the way.
    pub place: Place,
    /// One clause: `X needs the whole grid in memory`.
    pub reason: String,
}

/// The first thing that needs the whole grid in memory.
pub fn obstacle(steps: &[Step], exports: &[Export], grid: &Grid) -> Option<Obstacle> {
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
        let what = match (export.preset, export.shows()) {
            (Some(_), _) => "presets other than `gis` resample it",
            (None, What::Terrain | What::Corals) => "so does every mesh",
            _ => "so does all that simulations leave beside layers",
        };
        let reason = format!("the export `{file}` needs the whole grid in memory ({what})");
        (!export.streams()).then_some(Obstacle { place: Place::Export(i), reason })
    };
    steps
        .iter()
        .filter(|s| s.enabled)
        .find_map(of_step)
        .or_else(|| exports.iter().enumerate().filter(|(_, e)| e.enabled).find_map(of_export))
}
