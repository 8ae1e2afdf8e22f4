//! What worlds keep beside layers, as dictionaries of arrays.

use eyot::component::{Attributes, Form, Values, View};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// A view: `columns` (name, unit, values) and, by what it is, `positions`, `edges` with `edge_columns`, or `features`.
pub(crate) fn to_dict<'py>(py: Python<'py>, view: &View<'_>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    match view {
        View::Table(table) => dict.set_item("columns", columns(py, table)?)?,
        View::Points(points) => {
            dict.set_item("columns", columns(py, points.attributes())?)?;
            dict.set_item("positions", places(py, points.positions())?)?;
        }
        View::Lines(graph) => {
            dict.set_item("columns", columns(py, graph.nodes().attributes())?)?;
            dict.set_item("positions", places(py, graph.nodes().positions())?)?;
            let edges: Vec<u32> = graph.edges().iter().flatten().copied().collect();
            dict.set_item("edges", PyArray1::from_vec(py, edges).call_method1("reshape", (-1, 2))?)?;
            dict.set_item("edge_columns", columns(py, graph.edge_attributes())?)?;
        }
        View::Features(features) => {
            dict.set_item("columns", columns(py, features.attributes())?)?;
            dict.set_item("form", if features.form() == Form::Lines { "lines" } else { "polygons" })?;
            let all = PyList::empty(py);
            for i in 0..features.len() {
                let parts = PyList::empty(py);
                for part in features.parts(i) {
                    parts.append(places(py, part)?)?;
                }
                all.append(parts)?;
            }
            dict.set_item("features", all)?;
            // Of each feature its polygons, of each polygon the number of its rings: the outside and its holes.
            let rings = |i| features.polygons(i).iter().map(Vec::len).collect::<Vec<_>>();
            dict.set_item("rings", (0..features.len()).map(rings).collect::<Vec<_>>())?;
        }
        other => {
            let name = format!("{other:?}");
            dict.set_item("unknown", name.split('(').next().unwrap_or_default())?;
        }
    }
    Ok(dict)
}

/// Places as an array of three columns: m east of the west side, m south of the north side, m above the datum.
fn places<'py>(py: Python<'py>, places: &[[f32; 3]]) -> PyResult<Bound<'py, PyAny>> {
    let flat: Vec<f32> = places.iter().flatten().copied().collect();
    PyArray1::from_vec(py, flat).call_method1("reshape", (-1, 3))
}

fn columns<'py>(py: Python<'py>, attributes: &Attributes) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for column in attributes.columns() {
        let values = match &column.values {
            Values::U8(v) => PyArray1::from_slice(py, v).into_any(),
            Values::U32(v) => PyArray1::from_slice(py, v).into_any(),
            Values::U64(v) => PyArray1::from_slice(py, v).into_any(),
            Values::F32(v) => PyArray1::from_slice(py, v).into_any(),
            Values::F64(v) => PyArray1::from_slice(py, v).into_any(),
            _ => continue,
        };
        list.append((&column.name, &column.unit, values))?;
    }
    Ok(list)
}
