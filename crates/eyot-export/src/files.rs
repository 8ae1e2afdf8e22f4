//! Exports: which files they are, and how they come from a world.

use crate::error::ExportError;
use crate::import::row_order;
use eyot_core::remedy::Remedy;
use eyot_core::{Control, Limits, World};
use eyot_io::{self as io, About, ByteOrder, RasterFormat, RowOrder, Rows, WriteOptions};

use crate::materials::{self, Ground, Materials};
use crate::{corals, masks, preset, terrain, views};
use eyot_io::storage::Storage;
use eyot_io::{Source, Target};
use eyot_recipe::{Bytes, Export, ExportFormat, MATERIALS, What};
use eyot_reef::corals::Corals;
use eyot_render as render;
use serde_json::{Map, Value};

/// What all exports of a world share.
pub struct Job<'a> {
    /// The world; of a streamed one, an overview in coarser cells.
    pub world: &'a World,
    /// The layers in full.
    pub source: &'a dyn Source,
    /// The corals, if the recipe has some.
    pub corals: Option<Corals>,
    /// What the landscape is called.
    pub name: &'a str,
    /// What its ground looks like.
    pub looks: render::Looks,
    /// Where they go.
    pub out: &'a dyn Storage,
    /// What the files of research say of their origin.
    pub attributes: Map<String, Value>,
    /// Memory that may be taken.
    pub limits: &'a Limits,
    /// Stops the work.
    pub control: &'a Control<'a>,
    /// Called before each file with its name; may refuse to go on.
    pub begin: &'a mut dyn FnMut(&str) -> Result<(), ExportError>,
    /// Called with what a user should know.
    pub note: &'a dyn Fn(Remedy),
}

impl<'a> Job<'a> {
    /// The next file.
    pub(crate) fn file<'n>(&mut self, name: &'n str) -> Result<Target<'n>, ExportError>
    where
        'a: 'n,
    {
        (self.begin)(name)?;
        Ok(Target::blob(self.out, name))
    }

    /// The same job for another world in the same place.
    pub(crate) fn of<'b>(&'b mut self, world: &'b World) -> Job<'b> {
        Job {
            world,
            source: world,
            corals: self.corals.clone(),
            name: self.name,
            looks: self.looks.clone(),
            out: self.out,
            attributes: self.attributes.clone(),
            limits: self.limits,
            control: self.control,
            begin: self.begin,
            note: self.note,
        }
    }

    /// Says what a user should know.
    pub(crate) fn tell(&self, note: impl Into<Remedy>) {
        (self.note)(note.into());
    }
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

/// The formats of layers in recipes, and how they are written.
const RASTERS: [(ExportFormat, RasterFormat); 7] = [
    (ExportFormat::GeoTiff, RasterFormat::GeoTiff),
    (ExportFormat::Png16, RasterFormat::Png16),
    (ExportFormat::R16, RasterFormat::R16),
    (ExportFormat::R32, RasterFormat::R32),
    (ExportFormat::Exr, RasterFormat::Exr),
    (ExportFormat::Npy, RasterFormat::Npy),
    (ExportFormat::Zarr, RasterFormat::Zarr),
];

/// The raster format, if it is one.
fn raster(format: ExportFormat) -> Option<RasterFormat> {
    RASTERS.into_iter().find(|(f, _)| *f == format).map(|(_, raster)| raster)
}

/// Writes the files of an export.
pub fn write(job: &mut Job<'_>, export: &Export) -> Result<(), ExportError> {
    if let Some(preset) = export.preset {
        return preset::write(job, export, preset);
    }
    if let Some((reason, help)) = export.format_problem() {
        return Err(ExportError::refused(reason, help));
    }
    let (world, source, files) = (job.world, job.source, export.files());
    let present = |l: &String| world.get(l).is_some();
    let ground = Ground::of(job, export);
    for layer in export.layers.iter().filter(|l| export.knows(l) && !present(l)) {
        if let Some(remedy) = masks::missing(world, layer) {
            job.tell(format!("`{layer}` is not written: {remedy}"));
        }
    }
    let formats = export.formats();
    let format = formats[0];
    match export.shows() {
        What::Terrain => terrain::write(job, &files, export),
        What::Splat => {
            let path = job.file(&files[0])?;
            write_splat(job, path, export)
        }
        What::Contours => views::write_contours(job, export.interval, format, &files[0]),
        What::View(name) => views::write(job, &name, format, &files[0]),
        what if what.is_of_corals() => {
            let Some(reef) = job.corals.clone() else {
                job.tell(format!("`{}` is not written: no step with `corals` is switched on", files[0]));
                return Ok(());
            };
            corals::write(job, &reef, &what, &formats, &files)
        }
        What::Map => {
            for (name, layer) in files.iter().zip(&export.layers).filter(|(_, l)| present(l)) {
                let path = job.file(name)?;
                let picture = render::layer_map(world, layer, &crate::pictures::map_of(world, layer, None))
                    .map_err(ExportError::file)?;
                io::write_rgb_png(path, picture.width, picture.height, &picture.pixels).map_err(ExportError::file)?;
            }
            Ok(())
        }
        What::Mask => {
            for (name, layer) in files.iter().zip(&export.layers) {
                if let Some((about, mut rows)) = materials::layer(source, layer, &ground, true) {
                    let path = job.file(name)?;
                    if let Some((low, high)) = about.range.filter(|(low, high)| *low < 0.0 || *high > 1.0) {
                        job.tell(format!(
                            "layer `{layer}` holds values from {low} to {high}; in a mask those below 0 are 0 and those above 1 are 1"
                        ));
                    }
                    io::write_mask(path, &mut *rows).map_err(ExportError::file)?;
                }
            }
            Ok(())
        }
        _ if matches!(format, ExportFormat::Zarr | ExportFormat::Exr) && files.len() < 2 => {
            let exact = |l: &String| materials::layer(source, l, &ground, false);
            let mut layers: Vec<Layer<'_>> = export.layers.iter().filter_map(exact).collect();
            if layers.is_empty() {
                return Ok(());
            }
            say_place(job, raster(format));
            let path = job.file(&files[0])?;
            write_together(path, &mut layers, format, &job.attributes)
        }
        _ => {
            let Some(format) = raster(format) else { return Ok(()) };
            say_place(job, Some(format));
            for (name, layer) in files.iter().zip(&export.layers) {
                if let Some((about, mut rows)) = materials::layer(source, layer, &ground, false) {
                    let path = job.file(name)?;
                    io::write_rows(path, &mut *rows, &about, format, &write_options(export)).map_err(export_error)?;
                }
            }
            Ok(())
        }
    }
}

/// Notes what a file of this format cannot say of the world's place.
pub(crate) fn say_place(job: &Job<'_>, format: Option<RasterFormat>) {
    let place = job.world.georeference.as_ref();
    if let Some(lost) = place.zip(format).and_then(|(g, format)| io::lossy_georef(g, format)) {
        job.tell(lost);
    }
}

/// Several layers in one file.
pub(crate) fn write_together<'a>(
    to: impl Into<Target<'a>>,
    layers: &mut [Layer<'_>],
    format: ExportFormat,
    attributes: &Map<String, Value>,
) -> Result<(), ExportError> {
    let mut rows: Vec<(&About, &mut dyn Rows)> =
        layers.iter_mut().map(|(about, rows)| (&*about, &mut **rows as &mut dyn Rows)).collect();
    match format {
        ExportFormat::Zarr => io::write_store(to, &mut rows, attributes).map_err(export_error),
        _ => io::write_exr(to, &mut rows).map_err(export_error),
    }
}

/// What a layer is, and its rows.
pub(crate) type Layer<'a> = (About, Box<dyn Rows + 'a>);

/// The shares of all materials of a job's height.
pub(crate) fn write_splat(job: &Job<'_>, to: Target<'_>, export: &Export) -> Result<(), ExportError> {
    let Some(mut materials) = Materials::of(job.source, &Ground::of(job, export)) else { return Ok(()) };
    io::write_splat(to, materials.size(), &MATERIALS, &mut |first, out| materials.read_bytes(first, out))
        .map_err(export_error)
}

pub(crate) fn write_layer(
    source: &dyn Source,
    layer: &str,
    to: Target<'_>,
    format: RasterFormat,
    options: &WriteOptions,
) -> Result<(), ExportError> {
    match source.layer(layer) {
        Some((about, mut rows)) => io::write_rows(to, &mut *rows, &about, format, options).map_err(export_error),
        None => Ok(()),
    }
}

/// A refusal of the system may pass; values that do not fit a format will not, however often one tries.
fn export_error(e: io::Error) -> ExportError {
    if matches!(e, io::Error::Io { .. }) { ExportError::file(e) } else { ExportError::Values(e.into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recipes_and_writers_have_the_same_formats_of_layers() {
        assert_eq!(RASTERS.map(|(format, _)| format), *What::Layers.formats());
        for raster in RasterFormat::ALL {
            let of_recipes: Vec<_> = RASTERS.into_iter().filter(|(_, r)| *r == raster).collect();
            let [(format, _)] = *of_recipes else { panic!("{raster:?} stands there {} times", of_recipes.len()) };
            assert_eq!((format.name(), format.extension()), (raster.name(), raster.extension()));
        }
    }
}
