//! Tables, points and lines that processes keep beside layers, as files.

use crate::error::ExportError;
use crate::estimate;
use crate::files::Job;
use eyot_core::component::View;
use eyot_io as io;
use eyot_recipe::ExportFormat;

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

/// How many numbers the table of a view has.
fn numbers(view: &View<'_>) -> usize {
    match view {
        View::Table(t) => t.len() * t.columns().len(),
        View::Points(p) => p.len() * (3 + p.attributes().columns().len()),
        View::Lines(g) => g.edges().len() * (2 + g.edge_attributes().columns().len()),
        View::Features(f) => f.len() * f.attributes().columns().len(),
        _ => 0,
    }
}
