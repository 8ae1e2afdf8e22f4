//! Events of runs as dictionaries.

use crate::error::Python as Words;
use crate::recipe::to_python;
use eyot::Event;
use pyo3::prelude::*;

/// An event: its fields, and its kind as `event`. The world of a snapshot does not come along.
pub(crate) fn to_dict<'py>(py: Python<'py>, event: &Event) -> PyResult<Bound<'py, PyAny>> {
    let value = serde_json::to_value(event.worded(&Words)).unwrap_or_default();
    to_python(py, &value)
}
