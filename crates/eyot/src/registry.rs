//! Every generator and process that comes with Eyot, in one place.

use crate::stream::streamed_memory;
use eyot_climate::PROCESSES as CLIMATE;
use eyot_core::ComponentKinds;
use eyot_core::process::{Entry, Generator, Process};
use eyot_core::{Grid, Limits, Result};
use eyot_export::{Files, IMPORT, estimate};
use eyot_land::{generate::GENERATORS, simulate::PROCESSES};
use eyot_plates::PROCESSES as TECTONICS;
use eyot_recipe::{Estimator, Export, Step, Streamed, View};
use std::ops::{Deref, DerefMut};

/// The generators and processes that a recipe may use, with the files of this machine and the costs of Eyot's own exports.
#[derive(Clone)]
pub struct Registry(eyot_recipe::Registry);

impl Default for Registry {
    fn default() -> Self {
        Self::standard()
    }
}

impl Registry {
    /// Everything that comes with Eyot.
    pub fn standard() -> Self {
        let mut registry = Self::new(GENERATORS, PROCESSES);
        [CLIMATE, TECTONICS, eyot_reef::PROCESSES].into_iter().for_each(|p| registry.add_processes(p));
        Self(registry.0.with_components(component_kinds()))
    }

    /// Only what is given, the import of files, and the components that every world can have.
    pub fn new(generators: &'static [Entry<dyn Generator>], processes: &'static [Entry<dyn Process>]) -> Self {
        let mut registry = eyot_recipe::Registry::new(generators, processes).with_files(Files).with_outputs(Outputs);
        registry.add(&IMPORT);
        Self(registry)
    }
}

impl Deref for Registry {
    type Target = eyot_recipe::Registry;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for Registry {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

/// What outputs of Eyot's recipes cost.
pub(crate) struct Outputs;

impl Estimator for Outputs {
    fn pictures(&self, grid: &Grid, view: &View) -> u128 {
        estimate::pictures(grid, view)
    }

    fn export(&self, grid: &Grid, export: &Export, limits: &Limits) -> u128 {
        estimate::export(grid, export, limits)
    }

    fn streamed(&self, steps: &[Step], grid: &Grid) -> Result<Option<Streamed>> {
        streamed_memory(steps, grid).map(Some)
    }
}

/// Every kind of components that the processes of this program keep in worlds.
pub fn component_kinds() -> ComponentKinds {
    ComponentKinds::core().with(eyot_plates::COMPONENTS).with(eyot_reef::COMPONENTS)
}
