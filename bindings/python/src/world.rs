//! Worlds that nobody changes any more, and their layers as arrays on the same memory.

// Reason for the exception: an array of NumPy borrows the memory of a layer, whose owner it keeps alive.
#![allow(unsafe_code)]

use crate::component;
use crate::error::{self, Python as Words};
use crate::recipe::{limits, to_python};
use crate::work::free;
use eyot::analyse::TerrainOptions;
use eyot::store::{self, Opened, Subject};
use eyot::view::ViewRequest;
use numpy::ndarray::{ArrayView2, ShapeBuilder};
use numpy::{PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use std::sync::Arc;

/// A world that does not change.
#[pyclass(module = "eyot._eyot", frozen)]
pub(crate) struct World(pub(crate) Arc<Opened>);

impl World {
    /// The world of a run, which is drawn as its recipe says.
    pub(crate) fn of_run(world: eyot::World, view: eyot::View) -> Self {
        Self(Arc::new(store::of_run(world, view)))
    }
}

#[pymethods]
impl World {
    /// Grid, seed, clock, sea level and place on Earth.
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (w, facts) = (&self.0.world, PyDict::new(py));
        facts.set_item("size", (w.grid.width, w.grid.height))?;
        facts.set_item("cell", (w.grid.cell_x_m, w.grid.cell_y_m))?;
        let rim = [w.grid.rim.x, w.grid.rim.y].map(|edge| format!("{edge:?}").to_lowercase());
        facts.set_item("rim", rim)?;
        facts.set_item("seed", w.seed)?;
        facts.set_item("step", w.step)?;
        facts.set_item("sea_level", w.sea_level_m)?;
        facts.set_item("has_sea", self.0.has_sea)?;
        facts.set_item("file", self.0.file.display().to_string())?;
        if let Some(place) = &w.georeference {
            let entry = PyDict::new(py);
            entry.set_item("transform", place.transform.to_vec())?;
            entry.set_item("epsg", place.epsg)?;
            entry.set_item("geographic", place.geographic)?;
            facts.set_item("georeference", entry)?;
        }
        Ok(facts)
    }

    /// Name, unit, meaning, valid range and where on a cell it lives, of each layer.
    fn layers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        for layer in self.0.world.layers() {
            let (spec, entry) = (&layer.spec, PyDict::new(py));
            entry.set_item("name", &*spec.name)?;
            entry.set_item("unit", &*spec.unit)?;
            entry.set_item("meaning", &*spec.meaning)?;
            entry.set_item("range", spec.range)?;
            entry.set_item("centering", format!("{:?}", spec.centering))?;
            list.append(entry)?;
        }
        Ok(list)
    }

    /// A layer as an array on the world's own memory, row 0 north. Nobody can write to it.
    fn array<'py>(this: Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let py = this.py();
        let opened = this.get().0.clone();
        let layer = opened.world.layer(name).map_err(|e| error::plain(py, &e))?;
        let (values, stride) = layer.field.as_strided();
        let shape = (layer.field.height(), layer.field.width());
        let view =
            ArrayView2::from_shape(shape.strides((stride, 1)), values).map_err(|e| error::fault(py, &e.to_string()))?;
        // SAFETY: the values lie in a world behind an `Arc` that the array's owner `this` holds for as long as it lives: `World` is
        // frozen, and nothing changes or moves a layer of a world that is shared.
        let array = unsafe { PyArray2::borrow_from_array(&view, this.into_any()) };
        array.readwrite().make_nonwriteable();
        Ok(array)
    }

    /// Hexadecimal.
    fn fingerprint(&self, py: Python<'_>) -> PyResult<String> {
        let opened = self.0.clone();
        Ok(format!("{:016x}", free(py, move || opened.world.fingerprint())?))
    }

    /// Name, amount, unit, meaning and sign of each account.
    fn ledger(&self) -> Vec<(String, f64, String, String, i8)> {
        let accounts = self.0.world.ledger.iter();
        accounts.map(|(n, a)| (n.to_owned(), a.amount, a.unit.clone(), a.meaning.clone(), a.sign)).collect()
    }

    /// Names and shapes of what the world keeps beside layers.
    fn components(&self) -> Vec<(String, String)> {
        let views = self.0.world.components.views();
        views.map(|(name, shape)| (name, format!("{shape:?}").to_lowercase())).collect()
    }

    /// What a component shows under this name: columns, positions, edges, parts.
    fn component<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.0.world.components.view(name).map(|view| component::to_dict(py, &view)).transpose()
    }

    /// Draws into a PNG file: the view, `relief` from above, or a map of a layer; says who drew and what is to be known.
    #[pyo3(signature = (path, subject, look, drape=None, engine=None, adapter=None))]
    fn draw(
        &self,
        py: Python<'_>,
        path: PathBuf,
        subject: &str,
        look: &str,
        drape: Option<String>,
        engine: Option<&str>,
        adapter: Option<String>,
    ) -> PyResult<(String, Vec<String>)> {
        let mut view = serde_json::to_value(&self.0.view).unwrap_or_default();
        let changes: serde_json::Value = serde_json::from_str(look).unwrap_or_default();
        for (key, value) in changes.as_object().into_iter().flatten() {
            view[key] = value.clone();
        }
        let view: eyot::View = serde_json::from_value(view).map_err(|e| {
            error::raise(py, &format!("this is no way to look: {e}"), Some("`eyot.describe(\"view\")` lists the keys"))
        })?;
        let engine = crate::session::engine(py, engine, adapter)?.unwrap_or_default();
        let (opened, limits) = (self.0.clone(), limits(None));
        let longer = view.size[0].max(view.size[1]);
        let subject = subject.to_owned();
        let drawn = free(py, move || match subject.as_str() {
            "view" => {
                let request = ViewRequest { view, drape, engine };
                eyot::view::draw_view(&opened.world, &request, &path, &limits).map(|d| {
                    let notes = d.notes.iter().map(|n| n.worded(&Words)).collect();
                    (d.engine.to_string(), notes)
                })
            }
            other => {
                let subject = match other.strip_prefix("layer:") {
                    Some(layer) => Subject::LayerAt(layer, longer),
                    None => Subject::ReliefAt(longer),
                };
                store::draw(&opened.world, &view, subject, &path, &limits).map(|()| ("cpu".to_owned(), Vec::new()))
            }
        })?;
        drawn.map_err(|e| error::run(py, &e))
    }

    /// Statistics of the terrain, and of climate, plates, rivers and lakes if there are some.
    #[pyo3(signature = (channel_area_m2=None))]
    fn stats<'py>(&self, py: Python<'py>, channel_area_m2: Option<f64>) -> PyResult<Bound<'py, PyAny>> {
        let opened = self.0.clone();
        let usual = TerrainOptions::default();
        let options = TerrainOptions { channel_area_m2: channel_area_m2.or(usual.channel_area_m2), ..usual };
        let stats = free(py, move || store::stats(&opened, &options, &limits(None)))?;
        to_python(py, &stats.map_err(|e| error::run(py, &e))?)
    }
}
