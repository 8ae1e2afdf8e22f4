//! What lies below the ground as layers, made on demand: `bed_1_top` to `bed_13_top`, and `columns`.
//!
//! `bed_N_top` is the height of the top of a bed, worn away or not, m; of a sequence that repeats, that of its first turn.
//!
//! `columns` stands for the layers `run_1_material`, `run_1_thickness`, `run_2_material` and so on: the runs of each cell from the surface
//! down, as many as the column with most of them has. The material is its number in the layer `material`; numbers after those of the materials are
//! ground, sand and soil, and reef limestone. A column with fewer runs has thickness 0 and material -1 in the others. Columns reach as deep below the
//! lowest ground as the land is high above it, at least 100 m; the thicknesses of all runs and that floor sum to the height.
//!
//! As a table `columns` has a row for each run: `x` and `y` of the middle of its cell, m from the south-western corner, `run` from 1 at the surface,
//! `material`, and `top` and `bottom`, m.

use crate::error::ExportError;
use eyot_core::layer::LayerSpec;
use eyot_core::layer::known::HEIGHT;
use eyot_core::{Error, Field, Limits, World};
use eyot_io::{Column, Table};
use eyot_recipe::bed_of_top;
use eyot_strata::{Run, Subsurface};
use serde_json::{Map, Value};
use std::borrow::Cow;

/// The name that stands for all runs of all columns.
pub(crate) const COLUMNS: &str = "columns";

/// Puts layers that are asked for and not there into a world, and returns the names that are then to be written.
///
/// # Errors
/// If the world has no such bed, or the layers exceed the limits.
pub(crate) fn add(world: &mut World, names: &[String], limits: &Limits) -> Result<Vec<String>, ExportError> {
    let mut all = Vec::new();
    for name in names {
        if world.get(name).is_some() {
            all.push(name.clone());
        } else if name == COLUMNS {
            for (spec, field) in columns(world, limits).map_err(ExportError::input)? {
                all.push(spec.name.to_string());
                world.put(&spec, field).map_err(ExportError::input)?;
            }
        } else {
            if let Some(field) = top(world, name).map_err(ExportError::input)? {
                world.put(&spec(name, "m", TOP, (-1e6, 1e6)), field).map_err(ExportError::input)?;
            }
            all.push(name.clone());
        }
    }
    Ok(all)
}

/// What a layer of a top means.
pub(crate) const TOP: &str = "Height of the top of this bed, worn away or not";

fn spec(name: &str, unit: &'static str, meaning: &str, range: (f32, f32)) -> LayerSpec {
    let blank = LayerSpec::new("", unit, "", range);
    LayerSpec { name: Cow::Owned(name.to_owned()), meaning: Cow::Owned(meaning.to_owned()), ..blank }
}

/// The top of a bed; `None` if the name is none of one, or the world has no such bed.
///
/// # Errors
/// If the world's strata are damaged.
pub(crate) fn top(world: &World, name: &str) -> eyot_core::Result<Option<Field>> {
    let Some(bed) = bed_of_top(name) else { return Ok(None) };
    let below = Subsurface::of(world)?;
    if below.sequence().is_none_or(|s| bed > s.beds.len()) {
        return Ok(None);
    }
    let (width, height) = (world.grid.width, world.grid.height);
    Ok(Some(Field::from_fn(width, height, |x, y| below.top_of_bed(x, y, bed - 1).unwrap_or_default() as f32)))
}

/// How deep columns reach, m.
fn floor_m(world: &World) -> eyot_core::Result<f64> {
    let (low, high) = world.layer(&HEIGHT.name)?.field.min_max();
    Ok(f64::from(low) - f64::from(high - low).max(100.0))
}

fn columns(world: &World, limits: &Limits) -> eyot_core::Result<Vec<(LayerSpec, Field)>> {
    let (below, floor_m) = (Subsurface::of(world)?, floor_m(world)?);
    let (width, height) = (world.grid.width, world.grid.height);
    let mut runs: Vec<Run> = Vec::new();
    let mut all: Vec<(LayerSpec, Field)> = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        below.of_cell(x, y, floor_m, &mut runs);
        if 2 * runs.len() > all.len() {
            // Two layers for each run, beside those of the world.
            let layers = world.layers().len() + 2 * runs.len();
            if layers > limits.max_layers {
                return Err(Error::Limit {
                    what: "layers of columns".into(),
                    needed: format!("at least {layers}"),
                    limit: limits.max_layers.to_string(),
                    remedy: "give beds that are thicker or do not repeat".into(),
                });
            }
            limits.check_bytes("columns of runs", Field::bytes_of(width, height) * layers as u128)?;
            for n in all.len() / 2..runs.len() {
                let name = |what: &str| format!("run_{}_{what}", n + 1);
                let material =
                    "Material of this run of the column, counted from the surface, by its number; -1 if there is none";
                let thickness =
                    format!("Thickness of this run of the column, counted from the surface; all end at {floor_m} m");
                all.push((spec(&name("material"), "1", material, (-1.0, 300.0)), Field::new(width, height, -1.0)));
                all.push((spec(&name("thickness"), "m", &thickness, (0.0, 1e6)), Field::new(width, height, 0.0)));
            }
        }
        for (n, run) in runs.iter().enumerate() {
            all[2 * n].1.set(x, y, run.kind as f32);
            all[2 * n + 1].1.set(x, y, run.thickness_m() as f32);
        }
    }
    Ok(all)
}

/// All runs of all columns as a table, and what is to be said about it.
///
/// # Errors
/// If the world has no height, its strata are damaged, or the table exceeds the limits.
pub(crate) fn table(world: &World, about: Map<String, Value>, limits: &Limits) -> eyot_core::Result<Table> {
    let (below, floor_m) = (Subsurface::of(world)?, floor_m(world)?);
    let grid = &world.grid;
    let names = [("x", "m"), ("y", "m"), ("run", "1"), ("material", "1"), ("top", "m"), ("bottom", "m")];
    let mut values: [Vec<f64>; 6] = Default::default();
    let mut runs: Vec<Run> = Vec::new();
    for y in 0..grid.height {
        let north = (grid.height as f64 - y as f64 - 0.5) * grid.cell_y_m;
        for x in 0..grid.width {
            below.of_cell(x, y, floor_m, &mut runs);
            let east = (x as f64 + 0.5) * grid.cell_x_m;
            for (n, r) in (1..).zip(&runs) {
                let row = [east, north, f64::from(n), r.kind as f64, r.top_m, r.bottom_m];
                values.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
            }
        }
        // The world, and each number as it is and as text.
        let held = world.layers().iter().map(|l| l.field.bytes() as u128).sum::<u128>();
        limits.check_bytes("columns as a table", held + 32 * 6 * values[0].len() as u128)?;
    }
    let column = |((name, unit), values): ((&str, &str), Vec<f64>)| {
        let is_whole = matches!(name, "run" | "material");
        Column { name: name.into(), unit: unit.into(), is_whole, values }
    };
    Ok(Table { columns: names.into_iter().zip(values).map(column).collect(), about })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::{ConvertOptions, convert};
    use crate::import::read_raster;
    use eyot_core::{Boundary, ComponentKinds, Grid};
    use eyot_io::{ReadOptions, checkpoint};
    use eyot_strata::{BED_DATUM, BEDROCK, Bed, COMPONENTS, MATERIAL, STRATA, Strata};

    /// 6 x 4 cells that rise to the east, with a metre of loose ground on limestone to 80 m, schist to 60 m, and granite.
    fn beds() -> World {
        let grid = Grid::new(6, 4, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
        let mut w = World::new(grid, 1);
        let ground = |x: usize| 50.0 + 10.0 * x as f32;
        w.put(&HEIGHT, Field::from_fn(6, 4, |x, _| ground(x))).unwrap();
        w.put(&BEDROCK, Field::from_fn(6, 4, |x, _| ground(x) - 1.0)).unwrap();
        w.put(&BED_DATUM, Field::new(6, 4, 110.0)).unwrap();
        w.put(&MATERIAL, Field::new(6, 4, 0.0)).unwrap();
        let bed = |material: &str, thickness| Bed { material: material.into(), thickness };
        let beds = vec![bed("limestone", 30.0), bed("schist", 20.0), bed("granite", 1.0)];
        w.components.insert(STRATA, Strata { beds, ..Strata::default() }.sequence().unwrap());
        w
    }

    /// Every raster format gives the tops back; Zarr holds the columns.
    #[test]
    fn tops_and_columns_come_back_from_files() {
        let folder = tempfile::tempdir().unwrap();
        let (saved, limits) = (folder.path().join("world.eyot"), Limits::default());
        checkpoint::save(&saved, &beds(), "", &serde_json::json!({ "finished": true })).unwrap();
        let kinds = ComponentKinds::core().with(COMPONENTS);
        let to = |name: &str, layer: &str| {
            let path = folder.path().join(name);
            let o = ConvertOptions { layers: vec![layer.to_owned()], ..ConvertOptions::default() };
            convert(&saved, &path, &o, &limits, &kinds).map(|_| path)
        };
        let read = |path: &std::path::Path, layer: &str| {
            let o = ReadOptions { layer: Some(layer.to_owned()).filter(|l| !l.is_empty()), ..ReadOptions::default() };
            read_raster(&path.display().to_string(), &o, &limits).unwrap().field
        };
        for (bed, height) in [(1, 110.0), (2, 80.0), (3, 60.0)] {
            for format in ["npy", "r32", "zarr"] {
                let path = to(&format!("{bed}.{format}"), &format!("bed_{bed}_top")).unwrap();
                assert_eq!(read(&path, "").to_vec(), [height; 24], "{bed} as {format}");
            }
        }
        assert!(to("none.npy", "bed_4_top").unwrap_err().to_string().contains("bed_4_top"));
        let path = to("material.npy", "material").unwrap();
        assert_eq!(read(&path, "").to_vec(), [0.0; 24]);
        // As a table: what the middle of the first cell has, from the surface down.
        let text = std::fs::read_to_string(to("columns.csv", "columns").unwrap()).unwrap();
        let rows: Vec<&str> = text.lines().collect();
        assert_eq!(rows[..2], ["x,y,run,material,top,bottom", "5,35,1,0,50,49"], "{text}");
        assert!(rows[2].starts_with("5,35,2,6,49,-50"), "{text}");
        assert!(to("columns.parquet", "columns").is_ok());
        let refused = to("height.csv", "height").unwrap_err().to_string();
        assert!(refused.contains("only the columns of a run are one"), "{refused}");
        let path = to("columns.zarr", "columns").unwrap();
        // The floor lies 100 m below the lowest ground, at -50 m.
        let run = |n: usize, what: &str| read(&path, &format!("run_{n}_{what}"));
        for x in 0..6 {
            let ground = 50.0 + 10.0 * x as f32;
            let column: Vec<(f32, f32)> =
                (1..=4).map(|n| (run(n, "material").get(x, 2), run(n, "thickness").get(x, 2))).collect();
            let want: Vec<(f32, f32)> = [(0.0, ground - 1.0), (3.0, 80.0), (4.0, 60.0), (6.0, -50.0)]
                .into_iter()
                .scan(ground, |top, (kind, bottom): (f32, f32)| {
                    let thickness = (*top - bottom).max(0.0);
                    *top = top.min(bottom);
                    Some((kind, thickness))
                })
                .filter(|(_, t)| *t > 0.0)
                .collect();
            assert_eq!(column[..want.len()], want, "column {x}");
            assert!(column[want.len()..].iter().all(|r| *r == (-1.0, 0.0)), "column {x}: {column:?}");
            assert_eq!(column.iter().map(|r| r.1).sum::<f32>(), ground + 50.0);
        }
    }
}
