//! Recipes that have passed their checks.

use crate::error::{self, Python as Words};
use eyot::{Limits, Overrides, Preset, RecipeSource, Registry, Work};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::Value;
use std::path::PathBuf;

/// A checked recipe.
#[pyclass(module = "eyot._eyot", frozen)]
pub(crate) struct Recipe(pub(crate) eyot::Recipe);

/// The limits with another bound on memory, bytes.
pub(crate) fn limits(max_memory: Option<u64>) -> Limits {
    let d = Limits::default();
    match max_memory {
        // Four bytes a value: more cells than this cannot fit.
        Some(b) => Limits { max_bytes: b, max_cells: d.max_cells.max(b / 4), ..d },
        None => d,
    }
}

#[pymethods]
impl Recipe {
    /// Checks a document. `set` are changes as `key=value`; `size` are columns and rows, or the longer side alone.
    #[new]
    #[pyo3(signature = (name, text, folder, set, size=None, presets=Vec::new(), max_memory=None))]
    fn new(
        py: Python<'_>,
        name: String,
        text: String,
        folder: PathBuf,
        set: Vec<String>,
        size: Option<(u32, Option<u32>)>,
        presets: Vec<String>,
        max_memory: Option<u64>,
    ) -> PyResult<Self> {
        let known = presets.iter().map(|p| {
            Preset::from_name(p).ok_or_else(|| {
                error::raise(
                    py,
                    &format!("there is no preset `{p}`"),
                    Some("there is unreal, unity, godot, blender and gis"),
                )
            })
        });
        let presets = known.collect::<PyResult<Vec<_>>>()?;
        let overrides = Overrides { set, size, presets };
        let source = RecipeSource { name, text, folder };
        let parse = || eyot::Recipe::parse(source, overrides, &Registry::standard(), &limits(max_memory));
        crate::work::free(py, parse)?.map(Self).map_err(|p| error::recipe(py, &p))
    }

    /// Name, sentence, seed, sea level, grid and steps.
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (r, facts) = (&self.0, PyDict::new(py));
        facts.set_item("name", &r.name)?;
        facts.set_item("about", &r.about)?;
        facts.set_item("seed", r.seed)?;
        facts.set_item("sea_level", r.sea_level_m)?;
        facts.set_item("size", (r.grid.width, r.grid.height))?;
        facts.set_item("cell", (r.grid.cell_x_m, r.grid.cell_y_m))?;
        let steps = PyList::empty(py);
        for s in &r.steps {
            let step = PyDict::new(py);
            step.set_item("number", s.number)?;
            step.set_item("name", &s.name)?;
            step.set_item("enabled", s.enabled)?;
            match &s.work {
                Work::Generate(g) => {
                    step.set_item("generate", g.entry.name)?;
                    step.set_item("layer", g.layer.to_string())?;
                    step.set_item("steps", 1)?;
                }
                Work::Simulate(w) => {
                    let names: Vec<&str> = w.processes.iter().filter(|p| p.enabled).map(|p| p.actor.name()).collect();
                    step.set_item("simulate", names)?;
                    step.set_item("steps", w.steps)?;
                }
            }
            steps.append(step)?;
        }
        facts.set_item("steps", steps)?;
        let doubts: Vec<String> = r.doubts().iter().map(|d| d.worded(&Words)).collect();
        facts.set_item("doubts", doubts)?;
        Ok(facts)
    }

    /// The document with every key that has a value.
    fn effective_toml(&self) -> String {
        self.0.effective_toml()
    }
}

/// A JSON value as Python has it.
pub(crate) fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (value.to_string(),))
}
