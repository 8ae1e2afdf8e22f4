//! From one file format to another, and to the files of a preset.

use crate::error::ExportError;
use crate::estimate;
use crate::files::{self, Job, Layer};
use crate::import::read_raster;
use crate::{below, open, terrain};
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Setting};
use eyot_core::{ComponentKinds, Control, Georeference, Grid, Limits, World};
use eyot_io::Source;
use eyot_io::storage::Folder;
use eyot_io::{self as io, About, ByteOrder, Origin, Raster, RasterFormat, ReadOptions, RowOrder, Rows, WriteOptions};
use eyot_recipe::memory::check_bytes;
use eyot_recipe::{Export, ExportFormat, FirstRow, Preset, View, What};
use serde_json::{Map, Value};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

mod misplaced;

/// What a conversion may be told. What cannot have an effect is refused.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConvertOptions {
    /// What the input leaves open, but for its layer.
    pub read: ReadOptions,
    /// Layers of a run, arrays of a Zarr store or channels of an EXR. By default all where the output holds several, or else
    /// the height.
    pub layers: Vec<String>,
    /// Values that 0 and 65535 stand for in the output; by default those of the input if that holds whole numbers, or the
    /// lowest and the highest value.
    pub range: Option<(f64, f64)>,
    /// Order of the bytes in an output without header; little-endian by default.
    pub byte_order: Option<ByteOrder>,
    /// Order of the rows in an output without header; north first by default, in Unity's files south first.
    pub row_order: Option<RowOrder>,
    /// Size of a cell, m; by default what the input says.
    pub cell_m: Option<(f64, f64)>,
    /// Write the files of this preset into a folder instead.
    pub preset: Option<Preset>,
    /// Vertices along each side for presets that resample.
    pub size: Option<u32>,
    /// Tiles of a mesh, from west to east and from north to south: a file each, `NAME_x0_y0.glb` in the north-west, and `NAME.json`.
    pub tiles: Option<[u32; 2]>,
    /// Most vertices of a mesh, or of each of its tiles.
    pub vertices: Option<u64>,
    /// Overwrite what is there already. Nothing tells the output of a former conversion from other files.
    pub force: bool,
}

impl ConvertOptions {
    fn write(&self) -> WriteOptions {
        WriteOptions {
            scale: self.range,
            byte_order: self.byte_order.unwrap_or_default(),
            row_order: self.row_order.unwrap_or_default(),
            nodata: None,
        }
    }
}

/// What came of a conversion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Converted {
    /// The files that were written.
    pub files: Vec<PathBuf>,
    /// Things to know about them.
    pub notes: Vec<Remedy>,
}

/// Converts a height map, or layers of a run, into the format that the name of `output` says, or into the files of a preset
/// in the folder `output`.
///
/// Values change only where the format must: floats of 32 bits stay the same bits, whole numbers of 16 bits the same numbers.
/// Cells without a value stay so in GeoTIFF and Zarr; elsewhere they are filled from their neighbours.
/// Place, cell size, name, unit and what else a file says of itself survive in all formats. Saved worlds may hold components of
/// these `kinds`.
///
/// # Errors
/// If the input cannot be read, the output's format is not known, an option cannot apply, or the output cannot be written, or is
/// there already and may not be overwritten.
pub fn convert(
    input: &Path,
    output: &Path,
    options: &ConvertOptions,
    limits: &Limits,
    kinds: &ComponentKinds,
) -> Result<Converted, ExportError> {
    // A conversion may take only some of the layers; what it leaves out would be lost.
    if let (Ok(from), Ok(to)) = (input.canonicalize(), output.canonicalize())
        && from == to
    {
        let message = format!("`{}` would be written over itself; choose another name for the result", input.display());
        return Err(ExportError::input(message));
    }
    let job =
        Conversion { input, output, from: Input::of(input)?, to: Output::of(output, options)?, options, limits, kinds };
    if let Some(message) = job.misplaced() {
        return Err(ExportError::input(message));
    }
    if options.preset.is_none() && options.tiles.is_none() {
        job.check_free([output.to_owned(), beside(output)])?;
    }
    if job.from == Input::Run { job.run() } else { job.file() }
}

/// What is read.
#[derive(PartialEq)]
enum Input {
    /// The folder or the world of a run.
    Run,
    /// A file that holds several layers of these names.
    Layers(Vec<String>),
    /// A file that holds one.
    One,
}

impl Input {
    fn of(input: &Path) -> Result<Self, ExportError> {
        if input.extension().is_some_and(|e| e == "eyot") || (input.is_dir() && !io::is_zarr(input)) {
            return Ok(Self::Run);
        }
        if input.to_str().is_some_and(|i| i.starts_with("builtin:")) {
            return Ok(Self::One);
        }
        let names = io::layer_names(input).map_err(ExportError::input)?;
        Ok(if names.is_empty() { Self::One } else { Self::Layers(names) })
    }
}

/// What is written.
#[derive(Clone, Copy, PartialEq)]
enum Output {
    /// Rows of numbers: CSV or Parquet.
    Table(ExportFormat),
    Raster(RasterFormat),
    Mesh(ExportFormat),
    Preset(Preset),
}

impl Output {
    fn of(output: &Path, options: &ConvertOptions) -> Result<Self, ExportError> {
        if let Some(preset) = options.preset {
            return Ok(Self::Preset(preset));
        }
        let extension = output.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match (extension.as_str(), RasterFormat::from_extension(&extension)) {
            ("csv", _) => Ok(Self::Table(ExportFormat::Csv)),
            ("parquet", _) => Ok(Self::Table(ExportFormat::Parquet)),
            ("glb", _) => Ok(Self::Mesh(ExportFormat::Glb)),
            ("obj", _) => Ok(Self::Mesh(ExportFormat::Obj)),
            (_, Some(format)) => Ok(Self::Raster(format)),
            _ => Err(ExportError::input(remedy![
                format!(
                    "`{}` does not say its format; end it in .tif, .png, .r16, .raw, .r32, .exr, .npy, .zarr, .glb, .obj, or \
                     for columns .csv or .parquet, or choose a ",
                    output.display()
                ),
                Setting::Preset,
            ])),
        }
    }

    /// The format that holds several layers in one file.
    fn together(self) -> Option<ExportFormat> {
        match self {
            Self::Raster(RasterFormat::Zarr) => Some(ExportFormat::Zarr),
            Self::Raster(RasterFormat::Exr) => Some(ExportFormat::Exr),
            _ => None,
        }
    }

    /// True if cells without a value stay so.
    fn marks_missing(self) -> bool {
        matches!(self, Self::Raster(RasterFormat::GeoTiff | RasterFormat::Zarr) | Self::Preset(Preset::Gis))
    }

    /// True if several layers can be written.
    fn takes_several(self) -> bool {
        self.together().is_some() || self == Self::Preset(Preset::Gis)
    }
}

struct Conversion<'a> {
    input: &'a Path,
    output: &'a Path,
    from: Input,
    to: Output,
    options: &'a ConvertOptions,
    limits: &'a Limits,
    kinds: &'a ComponentKinds,
}

/// The description beside a file without a header.
fn beside(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".json");
    name.into()
}

impl Conversion<'_> {
    /// Fails if one of these files is there already, unless it may be overwritten.
    fn check_free(&self, files: impl IntoIterator<Item = PathBuf>) -> Result<(), ExportError> {
        match files.into_iter().find(|f| !self.options.force && f.symlink_metadata().is_ok()) {
            Some(there) => Err(ExportError::refused(
                format!("`{}` is there already; nothing was written", there.display()),
                remedy!["choose another name, or overwrite it with ", Setting::Force],
            )),
            None => Ok(()),
        }
    }

    /// Fails if a raster of this size cannot be written within the limit beside so many bytes that are held.
    fn check_rows(&self, held: u128, width: usize, height: usize) -> Result<(), ExportError> {
        let bytes = held + estimate::rows(width, height);
        let help = remedy!["convert fewer cells, or raise the limit with ", Setting::MaxMemory];
        check_bytes(&format!("`{}`", self.output.display()), bytes, self.limits, help).map_err(ExportError::file)
    }

    /// From a file: where the output is a raster, no step in between could change anything.
    fn file(&self) -> Result<Converted, ExportError> {
        if let Output::Table(_) = self.to {
            return Err(self.no_table());
        }
        let (rasters, mut notes) = self.read()?;
        let first = &rasters.0[0];
        if matches!(self.to, Output::Raster(_) | Output::Preset(Preset::Gis)) {
            let held = |r: &Raster| (r.field.bytes() + r.missing.as_ref().map_or(0, Vec::len)) as u128;
            self.check_rows(rasters.0.iter().map(held).sum(), first.field.width(), first.field.height())?;
        }
        match (self.to, self.to.together()) {
            (Output::Raster(_), Some(format)) => {
                let attributes = io::store_attributes(self.input).map_err(ExportError::input)?;
                let mut layers: Vec<Layer<'_>> = rasters.0.iter().map(layer).collect();
                self.say_place(first.georeference.as_ref(), &mut notes);
                files::write_together(self.output, &mut layers, format, &attributes).map_err(alone)?;
                Ok(Converted { files: vec![self.output.to_owned()], notes })
            }
            (Output::Raster(format), None) => {
                let write = WriteOptions { scale: self.options.range.or(scale(first)), ..self.options.write() };
                self.say_place(first.georeference.as_ref(), &mut notes);
                let (about, mut rows) = layer(first);
                io::write_rows(self.output, &mut *rows, &about, format, &write).map_err(ExportError::file)?;
                Ok(Converted { files: vec![self.output.to_owned()], notes })
            }
            (Output::Preset(Preset::Gis), _) => {
                let names = rasters.0.iter().map(|r| r.name.clone()).collect();
                let (x, y) = first.cell_m.unwrap_or((1.0, 1.0));
                let (width, height) = (first.field.width(), first.field.height());
                // Only the layers count.
                let grid = Grid { width, height, cell_x_m: x, cell_y_m: y, rim: eyot_core::Boundary::CLOSED };
                self.exports(&World::new(grid, 0), &rasters, &View::default(), names, notes)
            }
            _ => {
                // Notes on the raster are those on the world.
                notes.clear();
                let Some(raster) = rasters.0.into_iter().next() else { return Ok(Converted::default()) };
                let opened = open::of_raster(raster, self.input, self.limits)?;
                self.exports(&opened.world, &opened.world, &opened.view, vec!["height".to_owned()], opened.notes)
            }
        }
    }

    fn read(&self) -> Result<(Rasters, Vec<Remedy>), ExportError> {
        let named = self.options.layers.iter().map(|l| Some(l.clone()));
        let wanted: Vec<Option<String>> = match &self.from {
            _ if named.len() > 0 => named.collect(),
            Input::Layers(all) if self.to.takes_several() => all.iter().map(|l| Some(l.clone())).collect(),
            _ => vec![None],
        };
        let (mut rasters, mut notes) = (Vec::new(), Vec::new());
        let mut left = *self.limits;
        for layer in wanted {
            let read = ReadOptions { layer, ..self.options.read.clone() };
            let mut raster =
                read_raster(&self.input.display().to_string(), &read, &left).map_err(ExportError::input)?;
            left.max_bytes = left.max_bytes.saturating_sub(raster.field.bytes() as u64);
            self.check(&raster)?;
            raster.cell_m = self.options.cell_m.or(raster.cell_m);
            if raster.name.is_empty() {
                raster.name = "height".to_owned();
                if raster.unit.is_empty() {
                    raster.unit = "m".to_owned();
                }
            }
            notes.extend(
                open::notes(&raster, self.to.marks_missing())
                    .into_iter()
                    .filter(|n| !notes.contains(n))
                    .collect::<Vec<_>>(),
            );
            rasters.push(raster);
        }
        Ok((Rasters(rasters), notes))
    }

    /// Adds a note if a raster cannot say all of its place.
    fn say_place(&self, place: Option<&Georeference>, notes: &mut Vec<Remedy>) {
        let Output::Raster(format) = self.to else { return };
        notes.extend(place.and_then(|g| io::lossy_georef(g, format)).map(Remedy::from));
    }

    /// The columns of a run as rows of numbers.
    fn table(
        &self,
        world: &World,
        engines: &[String],
        names: &[String],
        format: ExportFormat,
        notes: Vec<Remedy>,
    ) -> Result<Converted, ExportError> {
        if !matches!(names, [name] if name == below::COLUMNS) {
            return Err(self.no_table());
        }
        let about = Origin { name: &self.name(), engines, ..Origin::default() }.attributes(world);
        let table = below::table(world, about, self.limits).map_err(ExportError::input)?;
        match format {
            ExportFormat::Parquet => io::write_parquet(self.output, &table),
            _ => io::write_text(self.output, &table.csv()),
        }
        .map_err(ExportError::file)?;
        Ok(Converted { files: vec![self.output.to_owned()], notes })
    }

    fn no_table(&self) -> ExportError {
        ExportError::refused(
            format!("`{}` would be a table, and only the columns of a run are one", self.output.display()),
            "choose the layer `columns` of a run, or another format".to_owned(),
        )
    }

    /// From a run.
    fn run(&self) -> Result<Converted, ExportError> {
        let opened = open::open(self.input, self.limits, self.kinds)?;
        let (mut world, mut notes) = (opened.world, opened.notes);
        self.say_place(world.georeference.as_ref(), &mut notes);
        if let Some((x, y)) = self.options.cell_m {
            (world.grid.cell_x_m, world.grid.cell_y_m) = (x, y);
            world.grid = world.grid.checked(self.limits).map_err(ExportError::input)?;
        }
        let mut names = self.options.layers.clone();
        if names.is_empty() {
            names = match self.to.takes_several() {
                true => world.layers().iter().map(|l| l.spec.name.to_string()).collect(),
                false => vec!["height".to_owned()],
            };
        }
        if let Output::Table(format) = self.to {
            return self.table(&world, &opened.engines, &names, format, notes);
        }
        names = below::add(&mut world, &names, self.limits)?;
        for name in &names {
            world.layer(name).map_err(ExportError::input)?;
        }
        let held: usize = world.layers().iter().map(|l| l.field.bytes()).sum();
        self.check_rows((held + world.components.bytes()) as u128, world.grid.width, world.grid.height)?;
        let layers = names.iter().filter_map(|name| Source::layer(&world, name));
        match (self.to, self.to.together()) {
            (Output::Raster(_), Some(format)) => {
                let origin =
                    Origin { name: &self.name(), engines: &opened.engines, ..Origin::default() }.attributes(&world);
                files::write_together(self.output, &mut layers.collect::<Vec<_>>(), format, &origin).map_err(alone)?;
            }
            (Output::Raster(format), None) => {
                for (about, mut rows) in layers {
                    let write = self.options.write();
                    io::write_rows(self.output, &mut *rows, &about, format, &write).map_err(ExportError::file)?;
                }
            }
            _ => return self.exports(&world, &world, &opened.view, names, notes),
        }
        Ok(Converted { files: vec![self.output.to_owned()], notes })
    }

    fn name(&self) -> String {
        self.input.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned())
    }

    /// A mesh, or the files of a preset, whose ground looks as in the view.
    fn exports(
        &self,
        world: &World,
        source: &dyn Source,
        view: &View,
        layers: Vec<String>,
        notes: Vec<Remedy>,
    ) -> Result<Converted, ExportError> {
        let (name, notes) = (self.name(), RefCell::new(notes));
        let mut files = Vec::new();
        let preset = self.options.preset;
        let first_row = self.options.row_order.map(|r| match r {
            RowOrder::NorthFirst => FirstRow::North,
            RowOrder::SouthFirst => FirstRow::South,
        });
        let export = match self.to {
            Output::Mesh(format) => Export {
                what: Some(What::Terrain),
                format: Some(format),
                tiles: self.options.tiles.unwrap_or([1, 1]),
                vertices: self.options.vertices.unwrap_or(Export::default().vertices),
                ..Export::default()
            },
            _ => Export { preset, size: self.options.size, layers, first_row, ..Export::default() },
        };
        if export.needs_two_cells() && (world.grid.width < 2 || world.grid.height < 2) {
            let message = "less than 2 x 2 cells, which make no triangle; convert it to a raster such as .tif";
            return Err(ExportError::input(format!("`{}` has {message}", self.input.display())));
        }
        if preset.is_some() {
            let files = export.files().into_iter().map(|f| self.output.join(f));
            self.check_free(files.flat_map(|f| [beside(&f), f]))?;
        }
        let names = match self.output.file_name().map(|n| n.to_string_lossy().into_owned()) {
            Some(name) if export.tiles == [1, 1] => vec![name],
            _ => export
                .tile_files(&self.output.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned())),
        };
        if export.tiles != [1, 1] {
            self.check_free(names.iter().map(|name| self.output.with_file_name(name)))?;
        }
        let what = format!("`{}`", self.output.display());
        let bytes = estimate::export(&world.grid, &export, self.limits);
        let help = remedy!["convert fewer cells, or raise the limit with ", Setting::MaxMemory];
        estimate::check(&what, world, bytes, self.limits, help).map_err(ExportError::file)?;
        let made = preset.is_some() && !self.output.exists();
        if preset.is_some() {
            std::fs::create_dir_all(self.output)
                .map_err(|source| ExportError::Folder { path: self.output.to_owned(), source })?;
        }
        let folder = if preset.is_some() { self.output } else { self.output.parent().unwrap_or(Path::new("")) };
        let control = Control::none();
        let mut job = Job {
            world,
            source,
            corals: None,
            name: &name,
            looks: crate::pictures::looks(view),
            out: &Folder::new(folder),
            attributes: Map::<String, Value>::new(),
            limits: self.limits,
            control: &control,
            begin: &mut |name| {
                files.push(folder.join(name));
                Ok(())
            },
            note: &|n| notes.borrow_mut().push(n),
        };
        let done = match self.to {
            Output::Mesh(_) => terrain::write(&mut job, &names, &export),
            _ => files::write(&mut job, &export),
        };
        if done.is_err() && made {
            // Only an empty folder goes; files that are whole stay.
            let _ = std::fs::remove_dir(self.output);
        }
        done.map_err(alone)?;
        Ok(Converted { files, notes: notes.into_inner() })
    }
}

/// The scale at which 16 bits hold the very values, if they are still within it.
fn scale(raster: &Raster) -> Option<(f64, f64)> {
    let (low, high) = raster.field.min_max();
    raster.scale.filter(|s| s.0 <= f64::from(low) && f64::from(high) <= s.1)
}

/// A file that cannot be made is all that was asked for here; there are no others beside it.
fn alone(e: ExportError) -> ExportError {
    if let ExportError::Values(message) = e { ExportError::File(message) } else { e }
}

/// Layers of a file.
struct Rasters(Vec<Raster>);

impl Source for Rasters {
    fn layer<'a>(&'a self, name: &str) -> Option<(About, Box<dyn Rows + 'a>)> {
        self.0.iter().find(|r| r.name == name).map(layer)
    }
}

fn layer(raster: &Raster) -> Layer<'_> {
    let about = About { range: Some(raster.field.min_max()), ..raster.about() };
    (about, Box::new(raster.rows()))
}
