//! Every generator and process that recipes can name, and what else their check asks for.

use crate::host::{Estimator, NoFiles, NoOutputs, Resolver};
use eyot_core::ComponentKinds;
use eyot_core::process::{Entry, Generator, Process};
use std::sync::Arc;

/// Keys of a generating step that are not the generator's own.
pub const GENERATE_KEYS: [&str; 9] =
    ["name", "about", "enabled", "generate", "layer", "merge", "mask", "amount", "seed"];
/// Keys of a simulating step that are not a process's name.
pub const SIMULATE_KEYS: [&str; 5] = ["name", "about", "enabled", "simulate", "steps"];
/// Keys of a process's table that are not the process's own.
pub const SCHEDULE_KEYS: [&str; 2] = ["every", "enabled"];
/// Tables and keys of a document that are neither a process nor the name of a step.
pub const DOCUMENT_KEYS: [&str; 11] =
    ["name", "about", "seed", "sea_level", "grid", "material", "layer", "rule", "step", "export", "view"];
/// Those of [`DOCUMENT_KEYS`] that are tables, or lists of them.
pub(crate) const TABLES: [&str; 7] = ["grid", "material", "layer", "rule", "step", "export", "view"];

/// The generators and processes that a recipe may use, the files that it may name, and what its outputs cost.
#[derive(Clone)]
pub struct Registry {
    generators: Vec<&'static Entry<dyn Generator>>,
    processes: Vec<&'static Entry<dyn Process>>,
    components: ComponentKinds,
    files: Arc<dyn Resolver>,
    outputs: Arc<dyn Estimator>,
}

impl Registry {
    /// What is given; no files, and outputs that cost nothing.
    pub fn new(generators: &'static [Entry<dyn Generator>], processes: &'static [Entry<dyn Process>]) -> Self {
        Self {
            generators: generators.iter().collect(),
            processes: processes.iter().collect(),
            components: ComponentKinds::core(),
            files: Arc::new(NoFiles),
            outputs: Arc::new(NoOutputs),
        }
    }

    /// The same with files that recipes may name.
    #[must_use]
    pub fn with_files(self, files: impl Resolver + 'static) -> Self {
        Self { files: Arc::new(files), ..self }
    }

    /// The same for worlds with components of these kinds, which processes keep in them.
    #[must_use]
    pub fn with_components(self, components: ComponentKinds) -> Self {
        Self { components, ..self }
    }

    /// The same with costs of outputs.
    #[must_use]
    pub fn with_outputs(self, outputs: impl Estimator + 'static) -> Self {
        Self { outputs: Arc::new(outputs), ..self }
    }

    /// Adds a generator; it takes the place of one of the same name.
    pub fn add(&mut self, generator: &'static Entry<dyn Generator>) {
        self.generators.retain(|e| e.name != generator.name);
        self.generators.push(generator);
    }

    /// Adds processes; they take the places of those of the same names.
    pub fn add_processes(&mut self, processes: &'static [Entry<dyn Process>]) {
        self.processes.retain(|e| !processes.iter().any(|p| p.name == e.name));
        self.processes.extend(processes);
    }

    /// The kinds of components that worlds can have.
    pub fn components(&self) -> &ComponentKinds {
        &self.components
    }

    /// The files that recipes may name.
    pub fn files(&self) -> &dyn Resolver {
        &*self.files
    }

    /// What outputs cost.
    pub fn outputs(&self) -> &dyn Estimator {
        &*self.outputs
    }

    /// All generators.
    pub fn generators(&self) -> &[&'static Entry<dyn Generator>] {
        &self.generators
    }

    /// All processes.
    pub fn processes(&self) -> &[&'static Entry<dyn Process>] {
        &self.processes
    }

    /// The generator of that name.
    pub fn generator(&self, name: &str) -> Option<&'static Entry<dyn Generator>> {
        self.generators.iter().find(|e| e.name == name).copied()
    }

    /// The process of that name.
    pub fn process(&self, name: &str) -> Option<&'static Entry<dyn Process>> {
        self.processes.iter().find(|e| e.name == name).copied()
    }

    /// Names of all generators.
    pub fn generator_names(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.generators.iter().map(|e| e.name)
    }

    /// Names of all processes.
    pub fn process_names(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.processes.iter().map(|e| e.name)
    }
}
