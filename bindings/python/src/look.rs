//! What there is, and worlds that lie in files.

use crate::error::{self, Python as Words};
use crate::recipe::{Recipe, limits, to_python};
use crate::work::free;
use crate::world::World;
use eyot::formats::{RasterFormat, Source, WriteOptions, write_rows};
use eyot::process::known;
use eyot::{Boundary, Field, Georeference, Grid, LayerSpec, RecipeSource, Registry};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Name, text and folder of a built-in recipe or of a recipe file.
#[pyfunction]
pub(crate) fn find_recipe(py: Python<'_>, name: &str) -> PyResult<(String, String, PathBuf)> {
    let found = RecipeSource::find(name).map_err(|p| error::recipe(py, &p))?;
    Ok((found.name, found.text, found.folder))
}

/// Names and sentences of what comes with Eyot: `recipes`, `generators` or `processes`.
#[pyfunction]
pub(crate) fn names(py: Python<'_>, what: &str) -> PyResult<Vec<(String, String)>> {
    let registry = Registry::standard();
    let about = |name: &str| eyot::describe(name, &registry).map(|d| (name.to_owned(), d.summary)).ok();
    Ok(match what {
        "recipes" => eyot::RECIPES.iter().map(|r| (r.name.to_owned(), r.about())).collect(),
        "generators" => registry.generator_names().filter_map(about).collect(),
        "processes" => registry.process_names().filter_map(about).collect(),
        other => return Err(error::raise(py, &format!("nothing is called `{other}`"), None)),
    })
}

/// What a generator, a process or a table of recipes is, with its parameters.
#[pyfunction]
pub(crate) fn describe<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let description = eyot::describe(name, &Registry::standard()).map_err(|m| error::raise(py, &m, None))?;
    to_python(py, &serde_json::to_value(description).unwrap_or_default())
}

/// The JSON Schema of recipes.
#[pyfunction]
pub(crate) fn schema(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    to_python(py, &eyot::recipe_schema(&Registry::standard()))
}

/// What a recipe rests on: `text`, `bibtex` or `json`.
#[pyfunction]
pub(crate) fn cite(py: Python<'_>, recipe: &Recipe, form: &str) -> PyResult<String> {
    let citations = eyot::cite(&recipe.0).map_err(|m| error::raise(py, &m, None))?;
    Ok(match form {
        "bibtex" => citations.to_bibtex(),
        "json" => citations.to_json().to_string(),
        _ => citations.to_text(),
    })
}

/// The world of a finished or stopped run, a saved one, or any height map.
#[pyfunction]
#[pyo3(signature = (path, max_memory=None))]
pub(crate) fn open(py: Python<'_>, path: PathBuf, max_memory: Option<u64>) -> PyResult<(World, Vec<String>)> {
    let opened = free(py, move || eyot::store::open(&path, &limits(max_memory)))?.map_err(|e| error::run(py, &e))?;
    let notes = opened.notes.iter().map(|n| n.worded(&Words)).collect();
    Ok((World(Arc::new(opened)), notes))
}

/// Writes heights as a GeoTIFF, for a recipe to import. Cells without a value are NaN.
#[pyfunction]
#[pyo3(signature = (path, values, cell, transform=None, epsg=None, geographic=false))]
pub(crate) fn write_raster(
    py: Python<'_>,
    path: PathBuf,
    values: PyReadonlyArray2<'_, f32>,
    cell: (f64, f64),
    transform: Option<[f64; 6]>,
    epsg: Option<u32>,
    geographic: bool,
) -> PyResult<()> {
    let array = values.as_array();
    let (rows, columns) = array.dim();
    if let Some(((y, x), v)) = array.indexed_iter().find(|(_, v)| v.is_infinite()) {
        let message = format!("the array holds {v} at row {y}, column {x}");
        return Err(error::raise(py, &message, Some("heights are finite numbers; NaN marks cells without one")));
    }
    let field = Field::from_fn(columns, rows, |x, y| array[[y, x]]);
    let empty = field.iter().filter(|v| v.is_nan()).count();
    if empty == array.len() {
        return Err(error::raise(py, "the array has no cell with a value", Some("NaN marks cells without a height")));
    }
    let (cell_x_m, cell_y_m) = cell;
    let grid = Grid { width: columns, height: rows, cell_x_m, cell_y_m, rim: Boundary::CLOSED };
    let grid = grid.checked(&limits(None)).map_err(|e| error::plain(py, &e))?;
    let place = transform.map(|transform| Georeference { transform, epsg, geographic, ..Georeference::default() });
    let write = move |path: &Path| -> Result<(), eyot::RunError> {
        let mut world = eyot::World::new(grid, 0);
        world.georeference = place;
        let spec = LayerSpec::new("height", "m", "Height of the ground", (-12_000.0, 12_000.0));
        if empty > 0 {
            let marks = Field::from_fn(columns, rows, |x, y| f32::from(u8::from(field.get(x, y).is_nan())));
            world.put(&known::MISSING, marks).map_err(eyot::RunError::file)?;
        }
        let mut field = field;
        field.map_in_place(|v| if v.is_nan() { 0.0 } else { v });
        world.put(&spec, field).map_err(eyot::RunError::file)?;
        // As a source it leaves out the cells that are missing.
        let Some((about, mut rows)) = Source::layer(&world, "height") else {
            return Err(eyot::RunError::Fault("the height is lost".to_owned()));
        };
        write_rows(path, &mut *rows, &about, RasterFormat::GeoTiff, &WriteOptions::default())
            .map_err(eyot::RunError::file)
    };
    free(py, move || write(&path))?.map_err(|e| error::run(py, &e))
}
