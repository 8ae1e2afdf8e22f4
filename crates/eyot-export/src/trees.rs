//! Single trees as tables, and as copies of bodies.

use crate::error::ExportError;
use crate::files::Job;
use crate::tree_bodies::body;
use crate::{estimate, views};
use eyot_core::component::View;
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Setting};
use eyot_io as io;
use eyot_plants::trees::{Kind, Tree, Trees, points};
use eyot_plants::types::TYPES;
use eyot_recipe::{Export, ExportFormat};
use serde_json::{Value, json};
use std::borrow::Cow;

/// Bytes that a tree takes on its way into a file, with the squares of the lattice that it is chosen from.
const BYTES_OF_TREE: u128 = 400;

/// What to do about a forest that is too large.
fn remedy() -> Remedy {
    remedy!["export a smaller grid, leave out `trees`, or raise ", Setting::MaxMemory]
}

/// Writes the trees of the world into the job's folder under `names`: a file, or one for each tile and the list of tiles.
pub(crate) fn write(
    job: &mut Job<'_>,
    names: &[String],
    format: ExportFormat,
    export: &Export,
) -> Result<(), ExportError> {
    let world = job.world;
    let Some(forest) = Trees::of(world) else {
        job.tell(format!(
            "`{}` is not written: no step leaves a layer `forest`, as \"forest\" and \"plants\" do",
            names[0]
        ));
        return Ok(());
    };
    let needed = BYTES_OF_TREE * u128::from(forest.most());
    estimate::check("the trees", world, needed, job.limits, remedy()).map_err(ExportError::file)?;
    if !forest.fits() {
        job.tell(format!(
            "`{}` is not written: the grid is too wide for single trees; export a smaller part of it",
            names[0]
        ));
        return Ok(());
    }
    let trees = forest.all();
    job.control.check().map_err(ExportError::stopped)?;
    if trees.is_empty() {
        job.tell(format!("`{}` is not written: there is no tree", names[0]));
        return Ok(());
    }
    if format != ExportFormat::Glb {
        let points = points(&trees).map_err(ExportError::file)?;
        let mut about = job.attributes.clone();
        about.insert("kinds".to_owned(), Kind::ALL.map(Kind::name).to_vec().into());
        if trees.iter().any(|t| t.species.is_some()) {
            about.insert("species".to_owned(), TYPES.map(|t| t.name).to_vec().into());
        }
        let table = io::Table::of_view(&View::Points(Cow::Owned(points)), about).unwrap_or_default();
        return views::write_table(job, &table, format, &names[0]);
    }
    let [nx, ny] = export.tiles.map(|n| n as usize);
    let sides = [world.grid.width as f64 * world.grid.cell_x_m, world.grid.height as f64 * world.grid.cell_y_m];
    let tile = |t: &Tree| {
        let along = |i: usize, n: usize| ((f64::from(t.place[i]) / sides[i] * n as f64) as usize).min(n - 1);
        along(1, ny) * nx + along(0, nx)
    };
    let mut tiles: Vec<Vec<Tree>> = vec![Vec::new(); nx * ny];
    trees.into_iter().for_each(|t| tiles[tile(&t)].push(t));
    let mut list = Vec::new();
    for (i, (trees, name)) in tiles.iter().zip(names).enumerate() {
        job.control.check().map_err(ExportError::stopped)?;
        if trees.is_empty() {
            job.tell(format!("`{name}` is not written: no tree stands there"));
            continue;
        }
        let title = if names.len() == 1 { job.name } else { name.strip_suffix(".glb").unwrap_or(name) };
        let path = job.file(name)?;
        write_bodies(path, title, trees, sides)?;
        list.push(json!({ "file": name, "x": i % nx, "y": i / nx, "trees": trees.len() }));
    }
    match names.get(tiles.len()) {
        Some(name) => write_list(job.file(name)?, export, &list),
        None => Ok(()),
    }
}

/// Copies of a body for each kind, in the coordinates of the terrain's mesh.
fn write_bodies(to: io::Target<'_>, title: &str, trees: &[Tree], sides: [f64; 2]) -> Result<(), ExportError> {
    let bodies = Kind::ALL.map(body);
    let copies = Kind::ALL.iter().zip(&bodies).map(|(kind, body)| {
        let of: Vec<&Tree> = trees.iter().filter(|t| t.kind == *kind).collect();
        let middle = sides.map(|s| (0.5 * s) as f32);
        io::Instances {
            mesh: io::SceneMesh {
                name: kind.name(),
                positions: &body.positions,
                normals: &body.normals,
                colours: &body.colours,
                texture: &[],
                indices: &body.indices,
                material: 0,
            },
            places: of.iter().map(|t| [t.place[0] - middle[0], t.place[2], t.place[1] - middle[1]]).collect(),
            turns: of.iter().map(|t| t.yaw).collect(),
            sizes: of.iter().map(|t| [t.crown, t.height, t.crown]).collect(),
        }
    });
    io::write_instances_glb(to, title, &copies.collect::<Vec<_>>()).map_err(ExportError::file)
}

fn write_list(to: io::Target<'_>, export: &Export, list: &[Value]) -> Result<(), ExportError> {
    let about = json!({
        "tiles": export.tiles,
        "naming": "_xCOLUMN_yROW, counted from the north-west",
        "axes": "x east, y up, z south",
        "origin": "of all tiles the middle of the landscape at height 0, as that of the terrain: load them without moving them",
        "files": list,
    });
    io::write_text(to, &format!("{about:#}\n")).map_err(ExportError::file)
}
