//! Presets: all files that a program wants, in its own sizes, scales and orders.

use crate::error::ExportError;
use crate::files::{Job, say_place, write_layer, write_splat};
use crate::fit::{Samples, fit};
use crate::import::row_order;
use crate::{masks, materials, terrain};
use eyot_core::{Georeference, World};
use eyot_io::{self as io, ByteOrder, RasterFormat, Rows, WriteOptions};
use eyot_recipe::MATERIALS;
use eyot_recipe::{Export, FirstRow, Preset};
use serde_json::{Value, json};

/// Landscapes that Unreal makes of whole components: vertices along a side, quads of a section, sections and components
/// along a side.
const UNREAL: [(usize, usize, usize, usize); 5] =
    [(505, 63, 1, 8), (1009, 63, 2, 8), (2017, 63, 2, 16), (4033, 63, 2, 32), (8129, 127, 2, 32)];
/// What GIS users expect where nothing else is said.
const NODATA: f32 = -9999.0;

pub(crate) fn write(job: &mut Job<'_>, export: &Export, preset: Preset) -> Result<(), ExportError> {
    match preset {
        Preset::Unreal => unreal(job, export),
        Preset::Unity => unity(job, export),
        Preset::Godot => godot(job, export),
        Preset::Blender => blender(job, export),
        Preset::Gis => gis(job, export),
    }
}

/// The world on the program's number of vertices, and that number.
fn fitted(job: &Job<'_>, export: &Export, preset: Preset) -> Result<(World, usize), ExportError> {
    let g = &job.world.grid;
    let longer = g.width.max(g.height) as f64;
    let far = |n: usize| (n as f64 / longer).ln().abs();
    let nearest = preset.sizes().iter().copied().min_by(|&a, &b| far(a).total_cmp(&far(b)));
    let n = export.size.map_or(nearest.unwrap_or(g.width), |n| n as usize);
    if (g.width, g.height) != (n, n) {
        job.tell(format!(
            "{} takes {n} x {n} vertices: the {} x {} cells are resampled",
            preset.name(),
            g.width,
            g.height
        ));
    }
    let world = fit(job.world, &materials::layers(job.world), [Samples::Vertices(n); 2], job.limits)?;
    Ok((world, n))
}

/// Lowest and highest value of the height, at least a metre apart so that flat land has a scale, too.
fn range(world: &World) -> Result<(f64, f64), ExportError> {
    let (low, high) = world.layer("height").map_err(ExportError::file)?.field.min_max();
    let (low, high) = (f64::from(low), f64::from(high));
    Ok((low, if high > low { high } else { low + 1.0 }))
}

fn unreal(job: &mut Job<'_>, export: &Export) -> Result<(), ExportError> {
    let names = Preset::Unreal.files(&export.prefix);
    let (world, n) = fitted(job, export, Preset::Unreal)?;
    let (low, high) = range(&world)?;
    // At Z scale 100, the 65536 steps from 0 to 65536 are 512 m; 65535 is the highest that a file can say.
    let relief = (high - low) * 65536.0 / 65535.0;
    let middle = low + relief / 2.0;
    let options = WriteOptions { scale: Some((low, high)), ..WriteOptions::default() };
    for (name, format) in names.iter().zip([RasterFormat::Png16, RasterFormat::R16]) {
        let path = job.file(name)?;
        write_layer(&world, "height", path, format, &options)?;
    }
    let weights = write_materials(&mut job.of(&world), export, &names[2..])?;
    let masks = write_masks(&mut job.of(&world), export)?;
    let (_, quads, sections, components) = UNREAL.into_iter().find(|u| u.0 == n).unwrap_or(UNREAL[0]);
    let about = json!({
        "preset": "unreal",
        "heightmap": names[0],
        "heightmap_raw": { "file": names[1], "byte_order": "little-endian", "row_order": "north to south" },
        "resolution": [n, n],
        "section_size_quads": quads,
        "sections_per_component": [sections, sections],
        "components": [components, components],
        "scale": {
            "x": world.grid.cell_x_m * 100.0,
            "y": world.grid.cell_y_m * 100.0,
            "z": relief * 100.0 / 512.0,
        },
        "location_z_cm": middle * 100.0,
        "sea_level_z_cm": sea_level(&world)?.map(|s| s * 100.0),
        "value_of_0_m": low,
        "value_of_32768_m": middle,
        "value_of_65535_m": high,
        "axes": "x east, y south, z up",
        "weightmaps": weights,
        "masks": masks,
    });
    describe(job, &names, &about)
}

fn unity(job: &mut Job<'_>, export: &Export) -> Result<(), ExportError> {
    let names = Preset::Unity.files(&export.prefix);
    let (world, n) = fitted(job, export, Preset::Unity)?;
    let (low, high) = range(&world)?;
    // Unity puts the first row of a RAW at z = 0, unless it is told to flip it; so north becomes +z.
    let first_row = export.first_row.unwrap_or(FirstRow::South);
    let options = WriteOptions {
        scale: Some((low, high)),
        byte_order: ByteOrder::Little,
        row_order: row_order(first_row),
        nodata: None,
    };
    let path = job.file(&names[0])?;
    write_layer(&world, "height", path, RasterFormat::R16, &options)?;
    // Alpha maps have a texel for every quad.
    let path = job.file(&names[1])?;
    let quads = fit(job.world, &materials::layers(job.world), [Samples::Quads(n - 1); 2], job.limits)?;
    write_splat(&job.of(&quads), path, export)?;
    let masks = write_masks(&mut job.of(&quads), export)?;
    let about = json!({
        "preset": "unity",
        "heightmap": {
            "file": names[0], "depth": "16 bit", "resolution": n, "byte_order": "Windows",
            "flip_vertically": first_row == FirstRow::North, "row_order": row_order(first_row),
        },
        "terrain_size_m": {
            "x": world.grid.cell_x_m * (n - 1) as f64,
            "y": high - low,
            "z": world.grid.cell_y_m * (n - 1) as f64,
        },
        "position_y_m": low,
        "sea_level_y_m": sea_level(&world)?,
        "value_of_0_m": low,
        "value_of_65535_m": high,
        "axes": "x east, y up, z north",
        "splatmap": { "file": names[1], "resolution": n - 1, "row_order": "north to south", "layers": MATERIALS },
        "masks": masks,
    });
    describe(job, &names, &about)
}

fn godot(job: &mut Job<'_>, export: &Export) -> Result<(), ExportError> {
    let names = Preset::Godot.files(&export.prefix);
    let g = job.world.grid;
    // Terrain3D has one distance of vertices for both axes.
    let spacing = g.cell_x_m.min(g.cell_y_m);
    let count = |n: usize, cell: f64| (((n - 1) as f64 * cell / spacing).round() as usize + 1).max(2);
    let size = [count(g.width, g.cell_x_m), count(g.height, g.cell_y_m)];
    if size != [g.width, g.height] {
        job.tell(format!(
            "godot takes square cells: the {} x {} cells are resampled to {} x {} of {spacing} m",
            g.width, g.height, size[0], size[1]
        ));
    }
    let world = fit(job.world, &materials::layers(job.world), size.map(Samples::Vertices), job.limits)?;
    let path = job.file(&names[0])?;
    write_layer(&world, "height", path, RasterFormat::Exr, &WriteOptions::default())?;
    let path = job.file(&names[1])?;
    write_splat(&job.of(&world), path, export)?;
    let masks = write_masks(&mut job.of(&world), export)?;
    let about = json!({
        "preset": "godot",
        "plugin": "Terrain3D",
        "heightmap": names[0],
        "resolution": size,
        // Heights are metres: no range is needed for EXR.
        "import_scale": 1.0,
        "height_offset": 0.0,
        "vertex_spacing": spacing,
        "sea_level_y_m": sea_level(&world)?,
        "axes": "x east, y up, z south",
        "splatmap": { "file": names[1], "row_order": "north to south", "layers": MATERIALS },
        "masks": masks,
    });
    describe(job, &names, &about)
}

fn blender(job: &mut Job<'_>, export: &Export) -> Result<(), ExportError> {
    let names = Preset::Blender.files(&export.prefix);
    let world = job.world;
    terrain::write(job, &names[..1], export)?;
    let path = job.file(&names[1])?;
    write_layer(world, "height", path, RasterFormat::Exr, &WriteOptions::default())?;
    let materials = write_materials(job, export, &names[2..])?;
    let masks = write_masks(job, export)?;
    let all_masks: Vec<&Value> = [&materials, &masks].into_iter().filter_map(Value::as_array).flatten().collect();
    let g = &world.grid;
    let (low, high) = range(world)?;
    let about = json!({
        "preset": "blender",
        "mesh": names[0],
        "displacement": { "file": names[1], "colour_space": "Non-Color", "midlevel": 0.0, "scale": 1.0 },
        "size_m": [g.cell_x_m * (g.width - 1) as f64, g.cell_y_m * (g.height - 1) as f64],
        "vertices": [g.width, g.height],
        "lowest_m": low,
        "highest_m": high,
        "sea_level_z_m": sea_level(world)?,
        "masks": all_masks,
        "mesh_attributes": MATERIALS.map(|m| format!("_{}", m.to_uppercase())),
    });
    describe(job, &names, &about)
}

fn gis(job: &mut Job<'_>, export: &Export) -> Result<(), ExportError> {
    let options = WriteOptions { nodata: Some(NODATA), ..WriteOptions::default() };
    let (source, ground) = (job.source, materials::Ground::of(job, export));
    say_place(job, Some(RasterFormat::GeoTiff));
    for (name, layer) in export.files().iter().zip(&export.layers) {
        let Some((mut about, mut rows)) = materials::layer(source, layer, &ground, false) else { continue };
        let path = job.file(name)?;
        // The preset's nodata, not the source's.
        about.georeference = about.georeference.map(|g| Georeference { nodata: None, ..g });
        io::write_rows(path, &mut *rows, &about, RasterFormat::GeoTiff, &options).map_err(ExportError::file)?;
    }
    Ok(())
}

/// Writes a mask of each material and returns what they are.
fn write_materials(job: &mut Job<'_>, export: &Export, names: &[String]) -> Result<Value, ExportError> {
    let (source, ground) = (job.source, materials::Ground::of(job, export));
    let mut list = Vec::new();
    for (name, material) in names.iter().zip(MATERIALS) {
        let Some((_, mut rows)) = materials::layer(source, material, &ground, true) else { continue };
        let path = job.file(name)?;
        io::write_mask(path, &mut *rows).map_err(ExportError::file)?;
        list.push(json!({ "material": material, "file": name }));
    }
    Ok(json!(list))
}

/// Writes the masks that the world has the layers for, says how to get the others, and returns what they are.
fn write_masks(job: &mut Job<'_>, export: &Export) -> Result<Value, ExportError> {
    let ground = materials::Ground::of(job, export);
    let mut list = Vec::new();
    for mask in masks::all() {
        let name = export.mask_file(mask);
        let (unit, full, mut rows): (_, _, Box<dyn Rows + '_>) = match masks::of(job.world, mask, &ground) {
            Ok(Some(found)) => {
                let size = (job.world.grid.width, job.world.grid.height);
                let (unit, full) = (found.unit, found.full());
                (unit, full, Box::new(masks::Whole { size, values: found.shares().values }))
            }
            Ok(None) => match job.source.layer(mask).filter(|_| mask == "wetness") {
                Some((_, rows)) => ("1", 1.0, rows),
                None => continue,
            },
            Err(e) => return Err(ExportError::file(e)),
        };
        let path = job.file(&name)?;
        io::write_mask(path, &mut *rows).map_err(ExportError::file)?;
        list.push(json!({ "mask": mask, "file": name, "unit": unit, "value_of_0": 0.0, "value_of_255": full }));
    }
    for note in masks::all_missing(job.world, export) {
        job.tell(note);
    }
    Ok(json!(list))
}

/// The sea's level if some land lies below it.
fn sea_level(world: &World) -> Result<Option<f64>, ExportError> {
    let (low, _) = world.layer("height").map_err(ExportError::file)?.field.min_max();
    Ok((f64::from(low) < world.sea_level_m).then_some(world.sea_level_m))
}

fn describe(job: &mut Job<'_>, names: &[String], about: &Value) -> Result<(), ExportError> {
    let path = job.file(&names[names.len() - 1])?;
    io::write_text(path, &format!("{about:#}\n")).map_err(ExportError::file)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Epic, Landscape Technical Guide: a component has 1 or 2 x 2 sections of 7 to 255 quads, a landscape at most 1024
    /// components, and components share no vertices but those of their borders.
    #[test]
    fn landscapes_of_unreal_are_made_of_whole_components() {
        for (vertices, quads, sections, components) in UNREAL {
            assert_eq!(vertices, quads * sections * components + 1);
            assert!((quads + 1).is_power_of_two() && (7..=255).contains(&quads));
            assert!((1..=2).contains(&sections) && components * components <= 1024, "{vertices}");
        }
    }

    #[test]
    fn recipes_and_writers_agree_on_sizes() {
        assert_eq!(UNREAL.map(|u| u.0), *Preset::Unreal.sizes());
    }

    /// Unity, TerrainData.heightmapResolution: 33 to 4097, a power of two and one.
    #[test]
    fn terrains_of_unity_are_powers_of_two_and_one() {
        let sizes = Preset::Unity.sizes();
        assert!(sizes.iter().all(|n| (n - 1).is_power_of_two() && (33..=4097).contains(n)));
        assert!(sizes.is_sorted() && sizes.len() == 8);
    }
}
