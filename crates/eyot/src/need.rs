//! How much memory a run needs, step by step and file by file, so that it is refused before the work and not in it.

use crate::backend::{mesh, render};
use crate::keys::{Export, ExportFormat, Preset, View};
use crate::outputs;
use crate::recipe::{Step, Work};
use crate::store::Subject;
use eyot_core::{Error, Field, Grid, Limits, Result, World, engine};

/// What helps where a picture does not fit.
pub(crate) const PICTURE_REMEDY: &str =
    "make it smaller with `size`, leave it out with view.enabled=false, or raise the limit with --max-memory";
/// What helps where an export does not fit.
pub(crate) const EXPORT_REMEDY: &str =
    "leave out this export with its enabled=false, choose a smaller grid, or raise the limit with --max-memory";

/// The step of a run in one piece that needs most memory, and how much that is.
pub(crate) struct Peak<'a> {
    pub(crate) step: Option<&'a Step>,
    pub(crate) bytes: u128,
    /// Of all layers once the last step is done.
    pub(crate) world_bytes: u128,
    /// Their number.
    pub(crate) layers: usize,
}

/// What the enabled steps need in one piece: the layers so far, and what generators and processes hold beside them.
///
/// # Errors
/// If the parameters of a step make no generator or process; recipes that were checked have none such.
pub(crate) fn working<'a>(steps: &'a [Step], grid: &Grid) -> Result<Peak<'a>> {
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

/// Bytes that a picture takes while it is drawn, beside the world.
pub(crate) fn picture(grid: &Grid, options: &View, subject: Subject<'_>) -> u128 {
    let cells = [grid.width, grid.height];
    match subject {
        Subject::View => render::perspective_bytes(cells, &outputs::view_options(options)),
        Subject::Relief => render::relief_bytes(cells, &outputs::relief_options(options, None)),
        Subject::ReliefAt(n) => render::relief_bytes(cells, &outputs::relief_options(options, Some(n))),
        Subject::Layer(_) => render::layer_map_bytes(cells, &render::MapOptions::default()),
    }
}

/// Bytes that an export takes while it is made, beside the world. Rasters are written row by row.
pub(crate) fn export(grid: &Grid, export: &Export, limits: &Limits) -> u128 {
    let cells = [grid.width, grid.height];
    let mesh = || {
        render::terrain_colours_bytes(cells)
            + mesh::terrain_bytes(grid.width, grid.height, &mesh::MeshOptions::default(), limits)
    };
    match (export.preset, export.format) {
        (Some(Preset::Gis), _) => 0,
        // The mesh, and the shares of a material on their way to its vertices.
        (Some(Preset::Blender), _) => mesh() + 24 * grid.cells() as u128,
        // Heights on other vertices, rows on their way there, and one band of shares.
        (Some(_), _) => 16 * export.size.map_or(grid.cells() as u128, |n| u128::from(n) * u128::from(n)),
        (None, ExportFormat::Glb | ExportFormat::Obj) => mesh(),
        (None, ExportFormat::Map) => render::layer_map_bytes(cells, &render::MapOptions::default()),
        _ => 0,
    }
}

/// Checks that `bytes` fit beside a world that is there.
pub(crate) fn check(what: &str, world: &World, bytes: u128, limits: &Limits, remedy: &'static str) -> Result<()> {
    let held: usize = world.layers().iter().map(|l| l.field.bytes()).sum();
    check_bytes(what, held as u128 + bytes, limits, remedy)
}

/// Checks a sum of bytes against the limit on memory.
pub(crate) fn check_bytes(what: &str, bytes: u128, limits: &Limits, remedy: &'static str) -> Result<()> {
    limits.check_bytes(what, bytes).map_err(|e| match e {
        Error::Limit { what, needed, limit, .. } => Error::Limit { what, needed, limit, remedy },
        other => other,
    })
}
