//! How much memory pictures and meshes need beside the world, so that they are refused before the work and not in it.

use crate::backend::{mesh, render};
use crate::keys::{Export, ExportFormat, Preset, View};
use crate::outputs;
use crate::store::Subject;
use eyot_core::{Error, Grid, Limits, Result, World};

/// What helps where a picture does not fit.
pub(crate) const PICTURE_REMEDY: &str =
    "make it smaller with `size`, leave it out with view.enabled=false, or raise the limit with --max-memory";
/// What helps where an export does not fit.
pub(crate) const EXPORT_REMEDY: &str =
    "leave out this export with its enabled=false, choose a smaller grid, or raise the limit with --max-memory";

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
