//! The Rust half of the Python package `eyot`: recipes, runs and worlds as classes, for the Python half to wrap.
//!
//! Python's lock is free while Rust works (`work`), arrays show the memory of a `world` without a copy, and what goes wrong is an
//! exception with its place and its remedy (`error`).

mod component;
mod error;
mod event;
mod look;
mod recipe;
mod session;
mod work;
mod world;

use pyo3::prelude::*;

/// The engine of the package `eyot`.
#[pymodule]
mod _eyot {
    #[pymodule_export]
    use super::look::{cite, describe, find_recipe, names, open, schema, write_raster};
    #[pymodule_export]
    use super::recipe::Recipe;
    #[pymodule_export]
    use super::session::Session;
    #[pymodule_export]
    use super::world::World;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::work::begin();
        module.add("VERSION", eyot::VERSION)
    }
}
