//! The land as meshes: in one file, or in tiles with a list of them.

use crate::error::ExportError;
use crate::files::Job;
use crate::materials::{self, Ground};
use crate::open_water::open_water;
use eyot_io::{self as io, Target, TerrainParts};
use eyot_mesh::{self as mesh, Lod, MeshOptions, OpenWater, Rim, Terrain, TerrainMesh, Tiling};
use eyot_recipe::{Export, MATERIALS, Preset};
use eyot_render as render;
use rayon::prelude::*;
use serde_json::{Value, json};

/// Share of triangles that each level of detail has of the one before: half the detail along each axis.
const COARSER: f64 = 0.25;

/// What an export says of the number of vertices.
pub(crate) fn options(export: &Export) -> MeshOptions {
    MeshOptions { max_vertices: export.vertices }
}

/// How an export cuts the land.
pub(crate) fn tiles(export: &Export) -> [usize; 2] {
    export.tiles.map(|n| n as usize)
}

/// One tile with its coarser levels.
struct Tile {
    at: [usize; 2],
    full: Terrain,
    levels: Vec<Lod>,
    water: Option<TerrainMesh>,
}

/// Writes the land as a mesh into the job's folder under `names`: a file, or one for each tile and the list of tiles.
pub(crate) fn write(job: &mut Job<'_>, names: &[String], export: &Export) -> Result<(), ExportError> {
    let (world, limits, control) = (job.world, job.limits, job.control);
    let height = &world.layer("height").map_err(ExportError::file)?.field;
    let tiling = Tiling::new(&world.grid, tiles(export), &options(export), limits).map_err(ExportError::file)?;
    if tiling.stride() > 1 {
        let (g, n) = (&world.grid, tiling.stride());
        job.tell(format!(
            "`{}` has a vertex in each {} column and row of the {} x {} cells, so that it has no more than {} vertices; \
             allow more vertices or cut it into tiles to keep every cell",
            names[0], ordinal(n), g.width, g.height, export.vertices
        ));
    }
    let colours = render::terrain_colours(world, &job.looks).map_err(ExportError::file)?;
    let water = match export.water {
        true => open_water(world, control).map_err(ExportError::stopped)?,
        false => None,
    };
    let attributes = match export.preset {
        Some(Preset::Blender) => shares(job, export)?,
        _ => Vec::new(),
    };
    let rim = if export.tiles == [1, 1] || export.skirt == Some(0.0) { Rim::Fixed } else { Rim::Straight };
    let obj = names[0].ends_with(".obj");
    let count = if obj { 1 } else { export.levels };
    let ratios: Vec<f64> = (1..count).map(|i| COARSER.powi(i as i32)).collect();
    let make = |at: [usize; 2]| -> Result<Tile, ExportError> {
        control.check().map_err(ExportError::stopped)?;
        let mut full = tiling.terrain(at, height, &colours, limits).map_err(ExportError::file)?;
        for (name, values) in &attributes {
            full.add_attribute(name, values).map_err(ExportError::file)?;
        }
        let surface = |w: &OpenWater| tiling.water(at, w, height);
        let water = water.as_ref().and_then(surface);
        let levels = mesh::levels_of_detail_controlled(&full, &ratios, rim, control).map_err(ExportError::stopped)?;
        Ok(Tile { at, full, levels, water })
    };
    let all: Vec<[usize; 2]> = tiling.all().collect();
    let tiles: Vec<Tile> = all.into_par_iter().map(make).collect::<Result<_, _>>()?;
    let depth_m = match (rim, export.skirt) {
        (Rim::Fixed, _) => 0.0,
        (Rim::Straight, Some(depth_m)) => depth_m,
        (Rim::Straight, None) => skirt_depth(&tiles, world.grid.cell_x_m.min(world.grid.cell_y_m), tiling.stride()),
    };
    let mut list = Vec::new();
    for (tile, name) in tiles.iter().zip(names) {
        let path = job.file(name)?;
        if obj {
            let ground = &tile.levels[0].mesh;
            return io::write_terrain_obj(path, ground, tile.water.as_ref(), job.name).map_err(ExportError::file);
        }
        let skirt = |level: &Lod| tiling.skirt(tile.at, &tile.full, &level.mesh, depth_m);
        let skirts: Vec<TerrainMesh> = match depth_m > 0.0 {
            true => tile.levels.iter().map(skirt).collect(),
            false => Vec::new(),
        };
        let parts = TerrainParts {
            levels: &tile.levels,
            skirts: &skirts,
            water: tile.water.as_ref(),
            name: match names.len() {
                1 => job.name,
                _ => name.strip_suffix(".glb").unwrap_or(name),
            },
        };
        io::write_terrain_glb(path, &parts).map_err(ExportError::file)?;
        list.push(said(tile, name));
    }
    match names.get(tiles.len()) {
        Some(name) => write_list(job.file(name)?, export, &tiling, depth_m, &list),
        None => Ok(()),
    }
}

/// The shares of the four materials, one a cell, under their names.
fn shares(job: &Job<'_>, export: &Export) -> Result<Vec<(&'static str, Vec<f32>)>, ExportError> {
    let ground = Ground::of(job, export);
    let of = |material: &'static str| {
        let mut shares = vec![0.0; job.world.grid.cells()];
        let found = materials::layer(job.source, material, &ground, false);
        found.map_or(Ok(()), |(_, mut rows)| rows.read(0, &mut shares)).map_err(ExportError::file)?;
        Ok((material, shares))
    };
    MATERIALS.into_iter().map(of).collect()
}

/// Two rims are at most as far apart as the errors of both together; engines that make levels of their own have no such bound, so there is
/// a skirt even where Eyot's levels leave no gap.
fn skirt_depth(tiles: &[Tile], cell_m: f64, stride: usize) -> f32 {
    let error = |t: &Tile| t.levels.iter().skip(1).map(|l| mesh::rim_error(&t.full, l)).fold(0.0, f32::max);
    let most = tiles.par_iter().map(error).reduce(|| 0.0, f32::max);
    (2.0 * most).max(0.5 * cell_m as f32 * stride as f32)
}

/// What the list says of a tile.
fn said(tile: &Tile, name: &str) -> Value {
    let p = &tile.full.mesh.positions;
    let (low, high) = p.iter().fold((f32::MAX, f32::MIN), |(a, b), p| (a.min(p[1]), b.max(p[1])));
    let (first, last) = (p[0], p[p.len() - 1]);
    let level = |l: &Lod| json!({ "triangles": l.mesh.triangles(), "error_m": l.error_m });
    json!({
        "file": name,
        "x": tile.at[0],
        "y": tile.at[1],
        "vertices": [tile.full.columns, tile.full.rows],
        "min_m": [first[0], low, first[2]],
        "max_m": [last[0], high, last[2]],
        "levels": tile.levels.iter().map(level).collect::<Vec<_>>(),
        "water": tile.water.is_some(),
    })
}

fn write_list(
    to: Target<'_>,
    export: &Export,
    tiling: &Tiling,
    skirt_m: f32,
    list: &[Value],
) -> Result<(), ExportError> {
    let about = json!({
        "tiles": export.tiles,
        "naming": "_xCOLUMN_yROW, counted from the north-west",
        "axes": "x east, y up, z south",
        "origin": "of all tiles the middle of the landscape at height 0: load them without moving them",
        "texture": "TEXCOORD_0 goes over the whole landscape, from the north-western corner of its first cell",
        "stride": tiling.stride(),
        "skirt_m": skirt_m,
        "files": list,
    });
    io::write_text(to, &format!("{about:#}\n")).map_err(ExportError::file)
}

/// `second`, `3rd`.
fn ordinal(n: usize) -> String {
    match n {
        2 => "second".to_owned(),
        3 => "third".to_owned(),
        n => format!("{n}th"),
    }
}
