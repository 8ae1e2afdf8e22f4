//! From one file format to another, and to the files of a preset.

use crate::backend::io::{self, About, RasterFormat, ReadOptions, WriteOptions};
use crate::error::RunError;
use crate::exports::{self, Job};
use crate::import;
use crate::keys::{Export, ExportFormat, Preset};
use crate::store;
use eyot_core::{Control, Limits};
use std::path::{Path, PathBuf};

/// What a conversion may be told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConvertOptions {
    /// What the input leaves open.
    pub read: ReadOptions,
    /// What the output leaves open. Its scale is the input's if that holds whole numbers of 16 bits and none is given.
    pub write: WriteOptions,
    /// Size of a cell, m; by default what the input says.
    pub cell_m: Option<(f64, f64)>,
    /// Write the files of this preset into a folder instead.
    pub preset: Option<Preset>,
    /// Vertices along each side for presets that resample.
    pub size: Option<u32>,
}

/// What came of a conversion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Converted {
    /// The files that were written.
    pub files: Vec<PathBuf>,
    /// Things to know about them.
    pub notes: Vec<String>,
}

/// Converts a height map, or layers of a run, into the format that the name of `output` says, or into the files of a preset
/// in the folder `output`.
///
/// Values change only where the format must: floats stay the same bits, whole numbers of 16 bits the same numbers. Place,
/// cell size, name and unit survive in all formats that can say them. From a run, `options.read.layer` says which layer; a
/// store (`.zarr`) or an image of channels (`.exr`) takes all if none is named, other formats the height.
///
/// # Errors
/// If the input cannot be read, the output's format is not known, or it cannot be written.
pub fn convert(input: &Path, output: &Path, options: &ConvertOptions, limits: &Limits) -> Result<Converted, RunError> {
    let is_run = input.extension().is_some_and(|e| e == "eyot") || (input.is_dir() && !io::is_zarr(input));
    // A conversion may take only some of the layers; what it leaves out would be lost.
    if let (Ok(from), Ok(to)) = (input.canonicalize(), output.canonicalize())
        && from == to
    {
        let message = format!("`{}` would be written over itself; choose another name for the result", input.display());
        return Err(RunError::input(message));
    }
    let kind = if options.preset.is_some() { Kind::Preset } else { Kind::of(output)? };
    match kind {
        Kind::Raster(format) if !is_run => raster(input, output, format, options, limits),
        _ => world(input, output, kind, options, limits),
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Raster(RasterFormat),
    Mesh(ExportFormat),
    Preset,
}

impl Kind {
    fn of(output: &Path) -> Result<Self, RunError> {
        let extension = output.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match (extension.as_str(), RasterFormat::from_extension(&extension)) {
            ("glb", _) => Ok(Self::Mesh(ExportFormat::Glb)),
            ("obj", _) => Ok(Self::Mesh(ExportFormat::Obj)),
            (_, Some(format)) => Ok(Self::Raster(format)),
            _ => Err(RunError::input(format!(
                "`{}` does not say its format; end it in .tif, .png, .r16, .raw, .r32, .exr, .npy, .zarr, .glb or .obj, or \
                 choose a --preset",
                output.display()
            ))),
        }
    }
}

/// From raster to raster: no step in between that could change anything.
fn raster(
    input: &Path,
    output: &Path,
    format: RasterFormat,
    options: &ConvertOptions,
    limits: &Limits,
) -> Result<Converted, RunError> {
    let mut done = Converted::default();
    let mut raster = import::read(&input.display().to_string(), &options.read, limits).map_err(RunError::input)?;
    raster.cell_m = options.cell_m.or(raster.cell_m);
    if raster.cell_m.is_none() {
        done.notes.push("the input does not say how large its cells are; 1 m is assumed (--cell)".to_owned());
    }
    if raster.filled > 0 {
        done.notes.push(format!("{} cells without a value were filled from their neighbours", raster.filled));
    }
    let mut about = raster.about();
    if about.name.is_empty() {
        about.name = "height".to_owned();
        about.unit = "m".to_owned();
    }
    let write = WriteOptions { scale: options.write.scale.or(raster.scale), ..options.write.clone() };
    io::write_rows(output, &mut &raster.field, &about, format, &write).map_err(file)?;
    done.files.push(output.to_owned());
    Ok(done)
}

fn world(
    input: &Path,
    output: &Path,
    kind: Kind,
    options: &ConvertOptions,
    limits: &Limits,
) -> Result<Converted, RunError> {
    let opened = store::open_with(input, &options.read, limits)?;
    let mut notes = opened.notes;
    let mut world = opened.world;
    if let Some((x, y)) = options.cell_m {
        (world.grid.cell_x_m, world.grid.cell_y_m) = (x, y);
        world.grid = world.grid.checked(limits).map_err(file)?;
        notes.retain(|n| !n.contains("1 m is assumed"));
    }
    let name = input.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let more = std::cell::RefCell::new(Vec::new());
    let mut files = Vec::new();
    let folder = match kind {
        Kind::Preset => {
            std::fs::create_dir_all(output).map_err(|source| RunError::Folder { path: output.to_owned(), source })?;
            output
        }
        _ => output.parent().unwrap_or(Path::new("")),
    };
    let control = Control::none();
    let mut job = Job {
        world: &world,
        source: &world,
        name: &name,
        out: folder,
        attributes: exports::origin(&world, &name, None),
        limits,
        control: &control,
        begin: &mut |path: PathBuf| {
            files.push(path.clone());
            Ok(path)
        },
        note: &|n| more.borrow_mut().push(n),
    };
    let wanted = options.read.layer.as_deref();
    match kind {
        Kind::Preset => {
            if let (Some(preset), Some(size)) = (options.preset, options.size)
                && let Some((problem, help)) = exports::size_problem(preset, size)
            {
                return Err(RunError::input(format!("{problem}; {help}")));
            }
            let layers = vec![wanted.unwrap_or("height").to_owned()];
            let export = Export { preset: options.preset, size: options.size, layers, ..Export::default() };
            if export.needs_two_cells() && (world.grid.width < 2 || world.grid.height < 2) {
                return Err(RunError::input(format!("`{}` has less than 2 x 2 cells", input.display())));
            }
            exports::write(&mut job, &export)?;
        }
        Kind::Mesh(format) => exports::write_mesh(&mut job, output, &Export { format, ..Export::default() })?,
        Kind::Raster(format @ (RasterFormat::Zarr | RasterFormat::Exr)) if wanted.is_none() => {
            let all: Vec<&str> = world.layers().iter().map(|l| &*l.spec.name).collect();
            let together = if format == RasterFormat::Zarr { ExportFormat::Zarr } else { ExportFormat::Exr };
            exports::write_together(&job, output, &all, together)?;
            files.push(output.to_owned());
        }
        Kind::Raster(format) => {
            let layer = world.layer(wanted.unwrap_or("height")).map_err(RunError::input)?;
            let about = About::of(&world, layer);
            io::write_rows(output, &mut &layer.field, &about, format, &options.write).map_err(file)?;
            files.push(output.to_owned());
        }
    }
    notes.extend(more.into_inner());
    Ok(Converted { files, notes })
}

fn file(e: impl std::fmt::Display) -> RunError {
    RunError::File(e.to_string())
}
