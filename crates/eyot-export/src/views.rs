//! Tables, points and lines that processes keep beside layers, as files.

use crate::error::ExportError;
use crate::estimate;
use crate::files::Job;
use eyot_core::component::View;
use eyot_io::{self as io, Vectors};
use eyot_land::analyse::{contours, round_interval};
use eyot_recipe::ExportFormat;
use std::borrow::Cow;

/// Bytes that a number takes on its way into a file: as double precision, and as text.
const BYTES_OF_NUMBER: u128 = 8 + 24;

/// Writes what a component of the world shows under this name.
pub(crate) fn write(job: &mut Job<'_>, name: &str, format: ExportFormat, file: &str) -> Result<(), ExportError> {
    let world = job.world;
    let Some(view) = world.components.view(name) else {
        job.tell(format!("`{file}` is not written: the step that leaves `{name}` is switched off"));
        return Ok(());
    };
    let numbers = numbers(&view) as u128;
    estimate::check(&format!("`{file}`"), world, BYTES_OF_NUMBER * numbers, job.limits, estimate::export_remedy())
        .map_err(ExportError::file)?;
    if let ExportFormat::GeoJson | ExportFormat::FlatGeobuf | ExportFormat::GeoPackage = format {
        return write_vectors(job, name, &view, format, file);
    }
    let Some(table) = io::Table::of_view(&view, job.attributes.clone()) else {
        job.tell(format!("`{file}` is not written: `{name}` has no rows"));
        return Ok(());
    };
    write_table(job, &table, format, file)
}

/// Writes a table in a format that tables have.
pub(crate) fn write_table(
    job: &mut Job<'_>,
    table: &io::Table,
    format: ExportFormat,
    file: &str,
) -> Result<(), ExportError> {
    let path = job.file(file)?;
    match format {
        ExportFormat::Parquet => io::write_parquet(path, table),
        _ => io::write_text(path, &table.csv()),
    }
    .map_err(ExportError::file)
}

/// Writes points, lines or polygons in a format of geographic programs.
fn write_vectors(
    job: &mut Job<'_>,
    name: &str,
    view: &View<'_>,
    format: ExportFormat,
    file: &str,
) -> Result<(), ExportError> {
    let world = job.world;
    let place = world.georeference.as_ref();
    let Some(vectors) = Vectors::of(name, view, &world.grid, place) else {
        let message =
            format!("`{name}` is a table: it lies nowhere, and `{}` holds what lies somewhere", format.name());
        return Err(ExportError::refused(message, "write it as csv or parquet".to_owned()));
    };
    if format == ExportFormat::GeoJson && place.is_none_or(|g| g.epsg.is_none()) {
        job.tell(format!(
            "`{file}` has metres from the south-west corner as coordinates, which programs may take for degrees"
        ));
    }
    if format == ExportFormat::FlatGeobuf && vectors.is_empty() {
        job.tell(format!("`{file}` is not written: there are no `{name}`"));
        return Ok(());
    }
    let path = job.file(file)?;
    match format {
        ExportFormat::FlatGeobuf => io::write_flatgeobuf(path, &vectors),
        ExportFormat::GeoPackage => io::write_geopackage(path, &[vectors]),
        _ => io::write_geojson(path, &vectors),
    }
    .map_err(ExportError::file)
}

/// Writes the contour lines of the height.
pub(crate) fn write_contours(
    job: &mut Job<'_>,
    interval: Option<f64>,
    format: ExportFormat,
    file: &str,
) -> Result<(), ExportError> {
    let world = job.world;
    let height = &world.layer("height").map_err(ExportError::file)?.field;
    let (low, high) = height.min_max();
    let interval = interval.unwrap_or_else(|| round_interval(low, high));
    let lines = contours(height, &world.grid, interval, job.control).map_err(ExportError::file)?;
    write_vectors(job, "contours", &View::Features(Cow::Owned(lines)), format, file)
}

/// How many numbers the table of a view has.
fn numbers(view: &View<'_>) -> usize {
    match view {
        View::Table(t) => t.len() * t.columns().len(),
        View::Points(p) => p.len() * (3 + p.attributes().columns().len()),
        View::Lines(g) => g.edges().len() * (2 + g.edge_attributes().columns().len()),
        View::Features(f) => 3 * f.vertices().len() + f.len() * f.attributes().columns().len(),
        _ => 0,
    }
}
