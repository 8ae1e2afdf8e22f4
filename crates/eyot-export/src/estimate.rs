//! How much memory the files of a run need, so that it is refused before the work and not in it.

use crate::pictures::{self, Subject};
use crate::{dive, masks, open_water, terrain};
use eyot_core::remedy::Remedy;
use eyot_core::{Grid, Limits, Result, World};
use eyot_recipe::memory::check_bytes;
use eyot_recipe::{Estimator, Export, Preset, Step, Streamed, View, What};
use {eyot_mesh as mesh, eyot_render as render};

pub use eyot_recipe::memory::{export_remedy, picture_remedy};

/// What the outputs of a recipe cost that this crate makes, for registries.
#[derive(Clone, Copy, Debug, Default)]
pub struct Costs;

impl Estimator for Costs {
    fn pictures(&self, grid: &Grid, view: &View) -> u128 {
        pictures(grid, view)
    }

    fn export(&self, grid: &Grid, what: &Export, limits: &Limits) -> u128 {
        export(grid, what, limits)
    }

    fn streamed(&self, steps: &[Step], grid: &Grid) -> Result<Option<Streamed>> {
        eyot_session::streamed_memory(steps, grid).map(Some)
    }
}

/// Bytes that the pictures of a run take while they are drawn, beside the world.
pub fn pictures(grid: &Grid, view: &View) -> u128 {
    picture(grid, view, Subject::View).max(picture(grid, view, Subject::Relief))
}

/// Bytes that a picture takes while it is drawn, beside the world.
pub fn picture(grid: &Grid, options: &View, subject: Subject<'_>) -> u128 {
    let cells = [grid.width, grid.height];
    match subject {
        Subject::View => render::perspective_bytes(cells, &pictures::view_options(options)),
        Subject::Relief => render::relief_bytes(cells, &pictures::relief_options(options, None)),
        Subject::ReliefAt(n) => render::relief_bytes(cells, &pictures::relief_options(options, Some(n))),
        Subject::Layer(name) => render::layer_map_bytes(cells, &pictures::map_options(name, None)),
        Subject::LayerAt(name, n) => render::layer_map_bytes(cells, &pictures::map_options(name, Some(n))),
    }
}

/// Bytes that an export takes while it is made, beside the world. Rasters are written row by row.
pub fn export(grid: &Grid, export: &Export, limits: &Limits) -> u128 {
    let cells = [grid.width, grid.height];
    let mesh = || {
        render::terrain_colours_bytes(cells)
            + if export.water { open_water::BYTES_PER_CELL * grid.cells() as u128 } else { 0 }
            + mesh::terrain_bytes(grid, terrain::tiles(export), &terrain::options(export), limits)
    };
    match (export.preset, export.shows()) {
        (Some(Preset::Gis), _) => 0,
        // The mesh, and the shares of a material on their way to its vertices.
        (Some(Preset::Blender), _) => mesh() + 24 * grid.cells() as u128 + masks::BYTES_PER_CELL * grid.cells() as u128,
        // What the ground follows from on other vertices, rows on their way there, and one band of shares.
        (Some(_), _) => {
            (72 + masks::BYTES_PER_CELL) * export.size.map_or(grid.cells() as u128, |n| u128::from(n) * u128::from(n))
        }
        (None, What::Terrain) => mesh(),
        (None, What::Layers | What::Mask) if !export.streams() => masks::BYTES_PER_CELL * grid.cells() as u128,
        (None, What::Map) => render::layer_map_bytes(cells, &render::MapOptions::default()),
        // Lines are about as long as twice all sides of the grid for each level; 200 bytes a vertex on their way into a file.
        (None, What::Contours) => 40 * 200 * 2 * (grid.width as u128 + grid.height as u128),
        // The pixels; how many colonies there will be, nobody knows yet.
        (None, What::Dive) => dive::least_bytes(),
        _ => 0,
    }
}

/// Bytes that writers of rasters hold: the rows of a band with their compressed form. The shards of a Zarr store are the tallest.
pub fn rows(width: usize, height: usize) -> u128 {
    const ROWS: usize = 3 * 512;
    4 * width as u128 * ROWS.min(3 * height) as u128
}

/// Checks that `bytes` fit beside a world that is there.
///
/// # Errors
/// [`eyot_core::Error::Limit`] with this remedy.
pub fn check(what: &str, world: &World, bytes: u128, limits: &Limits, remedy: Remedy) -> Result<()> {
    let held: usize = world.layers().iter().map(|l| l.field.bytes()).sum();
    check_bytes(what, (held + world.components.bytes()) as u128 + bytes, limits, remedy)
}
