//! Every generator and process that comes with Eyot, in one place.

use eyot_climate::PROCESSES as CLIMATE;
use eyot_core::ComponentKinds;
use eyot_core::process::{Entry, Generator, Process};
use eyot_export::{Costs, Files, IMPORT};
use eyot_land::{generate::GENERATORS, simulate::PROCESSES};
use eyot_plates::PROCESSES as TECTONICS;
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
        [
            CLIMATE,
            TECTONICS,
            eyot_reef::PROCESSES,
            eyot_strata::PROCESSES,
            eyot_plants::PROCESSES,
            eyot_water::PROCESSES,
            eyot_ice::PROCESSES,
        ]
        .into_iter()
        .for_each(|p| registry.add_processes(p));
        Self(registry.0.with_components(component_kinds()))
    }

    /// Only what is given, the import of files, and the components that every world can have.
    pub fn new(generators: &'static [Entry<dyn Generator>], processes: &'static [Entry<dyn Process>]) -> Self {
        let mut registry = eyot_recipe::Registry::new(generators, processes).with_files(Files).with_outputs(Costs);
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

/// Every kind of components that the processes of this program keep in worlds.
pub fn component_kinds() -> ComponentKinds {
    let own = ComponentKinds::core().with(eyot_plates::COMPONENTS).with(eyot_reef::COMPONENTS);
    own.with(eyot_strata::COMPONENTS)
}
