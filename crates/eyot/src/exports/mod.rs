//! Exports: which files they are, and how they come from a world.

pub(crate) mod corals;
mod dive;
mod fit;
mod materials;
mod plots;
mod preset;
mod source;

use crate::backend::io::{self, About, ByteOrder, RasterFormat, RowOrder, Rows, WriteOptions};
use crate::backend::{mesh, render};
use crate::error::RunError;
use crate::import::row_order;
use crate::keys::{Bytes, Export, ExportFormat, Preset};
use crate::outputs::stopped;
use eyot_core::{Control, Limits, World};
use eyot_recipe::MATERIALS;
use eyot_reef::corals::Corals;
use materials::Materials;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

pub(crate) use corals::of as corals_of;
pub(crate) use source::Source;

/// What all exports of a world share.
pub(crate) struct Job<'a> {
    /// The world; of a streamed one, an overview in coarser cells.
    pub(crate) world: &'a World,
    /// The layers in full.
    pub(crate) source: &'a dyn Source,
    /// The corals, if the recipe has some.
    pub(crate) corals: Option<Corals>,
    /// What the landscape is called.
    pub(crate) name: &'a str,
    /// The folder.
    pub(crate) out: &'a Path,
    /// What the files of research say of their origin.
    pub(crate) attributes: Map<String, Value>,
    pub(crate) limits: &'a Limits,
    pub(crate) control: &'a Control<'a>,
    /// Called before each file with its path; may refuse to go on.
    pub(crate) begin: &'a mut dyn FnMut(PathBuf) -> Result<PathBuf, RunError>,
    /// Called with what a user should know.
    pub(crate) note: &'a dyn Fn(String),
}

impl Job<'_> {
    /// The next file.
    fn file(&mut self, name: &str) -> Result<PathBuf, RunError> {
        (self.begin)(self.out.join(name))
    }

    /// The same job for another world in the same place.
    fn of<'b>(&'b mut self, world: &'b World) -> Job<'b> {
        Job {
            world,
            source: world,
            corals: self.corals.clone(),
            name: self.name,
            out: self.out,
            attributes: self.attributes.clone(),
            limits: self.limits,
            control: self.control,
            begin: self.begin,
            note: self.note,
        }
    }
}

/// What the root of a Zarr store says of its origin.
pub(crate) fn origin(world: &World, name: &str, recipe: Option<&str>, clock: Option<f64>) -> Map<String, Value> {
    let mut m = Map::new();
    m.insert("title".to_owned(), json!(name));
    m.insert("source".to_owned(), json!(format!("Eyot {}", crate::VERSION)));
    m.insert("engine_version".to_owned(), json!(crate::VERSION));
    m.insert("backend".to_owned(), json!("cpu"));
    m.insert("seed".to_owned(), json!(world.seed));
    m.insert("steps_done".to_owned(), json!(world.step));
    m.insert("sea_level_m".to_owned(), json!(world.sea_level_m));
    m.extend(clock.map(|seconds| (io::SECONDS.to_owned(), json!(seconds))));
    if let Some(recipe) = recipe {
        m.insert("recipe".to_owned(), json!(recipe));
    }
    m
}

/// How values of layers are written.
fn write_options(export: &Export) -> WriteOptions {
    WriteOptions {
        scale: export.range.map(|[low, high]| (low, high)),
        byte_order: if export.bytes == Bytes::Big { ByteOrder::Big } else { ByteOrder::Little },
        row_order: export.first_row.map_or(RowOrder::NorthFirst, row_order),
        nodata: None,
    }
}

/// The raster format, if it is one.
pub(crate) fn raster(format: ExportFormat) -> Option<RasterFormat> {
    Some(match format {
        ExportFormat::Png16 => RasterFormat::Png16,
        ExportFormat::GeoTiff => RasterFormat::GeoTiff,
        ExportFormat::R32 => RasterFormat::R32,
        ExportFormat::R16 => RasterFormat::R16,
        ExportFormat::Exr => RasterFormat::Exr,
        ExportFormat::Npy => RasterFormat::Npy,
        ExportFormat::Zarr => RasterFormat::Zarr,
        _ => return None,
    })
}

/// Writes the files of an export.
pub(crate) fn write(job: &mut Job<'_>, export: &Export) -> Result<(), RunError> {
    if let Some(preset) = export.preset {
        return preset::write(job, export, preset);
    }
    let (world, source, files) = (job.world, job.source, export.files());
    let present = |l: &String| world.get(l).is_some();
    let sea_level_m = world.sea_level_m;
    match export.format {
        ExportFormat::Glb | ExportFormat::Obj => write_mesh(job, Path::new(&files[0]), export),
        ExportFormat::Splat => {
            let path = job.file(&files[0])?;
            write_splat(job, &path, export)
        }
        ExportFormat::Zarr | ExportFormat::Exr if files.len() < 2 => {
            let exact = |l: &String| materials::layer(source, l, sea_level_m, export, false);
            let mut layers: Vec<Layer<'_>> = export.layers.iter().filter_map(exact).collect();
            if layers.is_empty() {
                return Ok(());
            }
            say_place(job, raster(export.format));
            let path = job.file(&files[0])?;
            write_together(&path, &mut layers, export.format, &job.attributes)
        }
        format if format.is_of_corals() => {
            let Some(reef) = job.corals.clone() else {
                (job.note)(format!("`{}` is not written: no step with `corals` is switched on", files[0]));
                return Ok(());
            };
            corals::write(job, &reef, format, &files)
        }
        ExportFormat::Map => {
            for (name, layer) in files.iter().zip(&export.layers).filter(|(_, l)| present(l)) {
                let path = job.file(name)?;
                let picture =
                    render::layer_map(world, layer, &crate::outputs::map_options(layer)).map_err(RunError::file)?;
                io::write_rgb_png(&path, picture.width, picture.height, &picture.pixels).map_err(RunError::file)?;
            }
            Ok(())
        }
        ExportFormat::Mask => {
            for (name, layer) in files.iter().zip(&export.layers) {
                if let Some((about, mut rows)) = materials::layer(source, layer, sea_level_m, export, true) {
                    let path = job.file(name)?;
                    if let Some((low, high)) = about.range.filter(|(low, high)| *low < 0.0 || *high > 1.0) {
                        (job.note)(format!(
                            "layer `{layer}` holds values from {low} to {high}; in a mask those below 0 are 0 and those above 1 are 1"
                        ));
                    }
                    io::write_mask(&path, &mut *rows).map_err(RunError::file)?;
                }
            }
            Ok(())
        }
        other => {
            let Some(format) = raster(other) else { return Ok(()) };
            say_place(job, Some(format));
            for (name, layer) in files.iter().zip(&export.layers) {
                if let Some((about, mut rows)) = materials::layer(source, layer, sea_level_m, export, false) {
                    let path = job.file(name)?;
                    io::write_rows(&path, &mut *rows, &about, format, &write_options(export)).map_err(unmade)?;
                }
            }
            Ok(())
        }
    }
}

/// Notes what a file of this format cannot say of the world's place.
fn say_place(job: &Job<'_>, format: Option<RasterFormat>) {
    let place = job.world.georeference.as_ref();
    if let Some(lost) = place.zip(format).and_then(|(g, format)| io::unsaid(g, format)) {
        (job.note)(lost.to_owned());
    }
}

/// Several layers in one file.
pub(crate) fn write_together(
    path: &Path,
    layers: &mut [Layer<'_>],
    format: ExportFormat,
    attributes: &Map<String, Value>,
) -> Result<(), RunError> {
    let mut rows: Vec<(&About, &mut dyn Rows)> =
        layers.iter_mut().map(|(about, rows)| (&*about, &mut **rows as &mut dyn Rows)).collect();
    match format {
        ExportFormat::Zarr => io::write_store(path, &mut rows, attributes).map_err(unmade),
        _ => io::write_exr(path, &mut rows).map_err(unmade),
    }
}

/// What a layer is, and its rows.
pub(crate) type Layer<'a> = (About, Box<dyn Rows + 'a>);

/// The shares of all materials of a job's height.
fn write_splat(job: &Job<'_>, path: &Path, export: &Export) -> Result<(), RunError> {
    let Some(mut materials) = Materials::of(job.source, job.world.sea_level_m, export) else { return Ok(()) };
    io::write_splat(path, materials.size(), &MATERIALS, &mut |first, out| materials.read_bytes(first, out))
        .map_err(unmade)
}

fn write_layer(
    source: &dyn Source,
    layer: &str,
    path: &Path,
    format: RasterFormat,
    options: &WriteOptions,
) -> Result<(), RunError> {
    match source.layer(layer) {
        Some((about, mut rows)) => io::write_rows(path, &mut *rows, &about, format, options).map_err(unmade),
        None => Ok(()),
    }
}

/// A refusal of the system may pass; values that do not fit a format will not, however often one tries.
fn unmade(e: io::Error) -> RunError {
    if matches!(e, io::Error::Io { .. }) { RunError::file(e) } else { RunError::Export(e.to_string()) }
}

/// The terrain as a mesh, in the job's folder under the name at the end of `name`.
pub(crate) fn write_mesh(job: &mut Job<'_>, name: &Path, export: &Export) -> Result<(), RunError> {
    let path = job.file(&name.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned()))?;
    let world = job.world;
    let height = &world.layer("height").map_err(RunError::file)?.field;
    let colours = render::terrain_colours(world).map_err(RunError::file)?;
    let mut terrain = mesh::terrain(height, &world.grid, &colours, &mesh::MeshOptions::default(), job.limits)
        .map_err(RunError::file)?;
    if export.preset == Some(Preset::Blender) {
        for material in MATERIALS {
            let found = materials::layer(job.source, material, world.sea_level_m, export, false);
            let mut shares = vec![0.0; world.grid.cells()];
            found.map_or(Ok(()), |(_, mut rows)| rows.read(0, &mut shares)).map_err(RunError::file)?;
            terrain.add_attribute(material, &shares).map_err(RunError::file)?;
        }
    }
    if path.extension().is_some_and(|e| e == "obj") {
        return io::write_terrain_obj(&path, &terrain.mesh, job.name).map_err(RunError::file);
    }
    // Each level has a quarter of the triangles of the one before: half the detail along each axis.
    let ratios: Vec<f64> = (0..export.levels).map(|i| 0.25_f64.powi(i as i32)).collect();
    job.control.check().map_err(stopped)?;
    let levels = mesh::levels_of_detail_controlled(&terrain, &ratios, job.control).map_err(stopped)?;
    io::write_terrain_glb(&path, &levels, job.name).map_err(RunError::file)
}
