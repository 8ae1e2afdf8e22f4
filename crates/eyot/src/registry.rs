//! Every generator and process that recipes can name, in one place.

use crate::import::IMPORT;
use eyot_climate::PROCESSES as CLIMATE;
use eyot_core::ComponentKinds;
use eyot_core::process::{Entry, Generator, Process};
use eyot_land::{generate::GENERATORS, simulate::PROCESSES};
use eyot_plates::PROCESSES as TECTONICS;

/// Keys of a generating step that are not the generator's own.
pub(crate) const GENERATE_KEYS: [&str; 9] =
    ["name", "about", "enabled", "generate", "layer", "merge", "mask", "amount", "seed"];
/// Keys of a simulating step that are not a process's name.
pub(crate) const SIMULATE_KEYS: [&str; 5] = ["name", "about", "enabled", "simulate", "steps"];
/// Keys of a process's table that are not the process's own.
pub(crate) const SCHEDULE_KEYS: [&str; 2] = ["every", "enabled"];
/// Tables and keys of a document that are neither a process nor the name of a step.
pub(crate) const DOCUMENT_KEYS: [&str; 10] =
    ["name", "about", "seed", "sea_level", "grid", "layer", "rule", "step", "export", "view"];

/// The generators and processes that a recipe may use.
#[derive(Clone)]
pub struct Registry {
    generators: Vec<&'static Entry<dyn Generator>>,
    processes: Vec<&'static Entry<dyn Process>>,
    components: ComponentKinds,
}

impl Default for Registry {
    fn default() -> Self {
        Self::standard()
    }
}

impl Registry {
    /// Everything that comes with Eyot.
    pub fn standard() -> Self {
        let mut generators: Vec<_> = GENERATORS.iter().filter(|e| e.name != IMPORT.name).collect();
        generators.push(&IMPORT);
        let processes = PROCESSES.iter().chain(CLIMATE).chain(TECTONICS).chain(eyot_reef::PROCESSES).collect();
        Self { generators, processes, components: component_kinds() }
    }

    /// Only what is given, the import of files, and the components that every world can have.
    pub fn new(generators: &'static [Entry<dyn Generator>], processes: &'static [Entry<dyn Process>]) -> Self {
        let mut generators: Vec<_> = generators.iter().collect();
        generators.push(&IMPORT);
        Self { generators, processes: processes.iter().collect(), components: ComponentKinds::core() }
    }

    /// The same, and components of these kinds, which its processes keep in worlds.
    #[must_use]
    pub fn with_components(mut self, components: ComponentKinds) -> Self {
        self.components = components;
        self
    }

    #[cfg(test)]
    pub(crate) fn add(&mut self, generator: &'static Entry<dyn Generator>) {
        self.generators.push(generator);
    }

    /// All generators.
    pub fn generators(&self) -> &[&'static Entry<dyn Generator>] {
        &self.generators
    }

    /// All processes.
    pub fn processes(&self) -> &[&'static Entry<dyn Process>] {
        &self.processes
    }

    /// The kinds of components that worlds can have.
    pub fn components(&self) -> &ComponentKinds {
        &self.components
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

/// Every kind of components that the processes of this program keep in worlds.
pub fn component_kinds() -> ComponentKinds {
    ComponentKinds::core()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parameter with one of the recipe's own keys could not be reached from a recipe.
    #[test]
    fn no_parameter_hides_behind_a_key_of_the_recipe() {
        let registry = Registry::standard();
        for e in registry.generators() {
            let schema = (e.schema)().to_value();
            for key in schema["properties"].as_object().into_iter().flat_map(|p| p.keys()) {
                assert!(!GENERATE_KEYS.contains(&key.as_str()), "{}.{key}", e.name);
            }
        }
        for e in registry.processes() {
            assert!(!SIMULATE_KEYS.contains(&e.name) && !DOCUMENT_KEYS.contains(&e.name), "{}", e.name);
            let schema = (e.schema)().to_value();
            for key in schema["properties"].as_object().into_iter().flat_map(|p| p.keys()) {
                assert!(!SCHEDULE_KEYS.contains(&key.as_str()), "{}.{key}", e.name);
            }
        }
    }

    /// The schema says what the struct takes: the same names, and the defaults are inside the ranges.
    #[test]
    fn schemas_agree_with_their_structs() {
        let registry = Registry::standard();
        let generators = registry.generators().iter().map(|e| (e.name, (e.schema)(), (e.defaults)()));
        let processes = registry.processes().iter().map(|e| (e.name, (e.schema)(), (e.defaults)()));
        for (name, schema, defaults) in generators.chain(processes) {
            let schema = schema.to_value();
            let declared: Vec<&String> = schema["properties"].as_object().into_iter().flat_map(|p| p.keys()).collect();
            // The run tells an import how much memory it may take; that is no key of a recipe.
            let keys = defaults.as_object().into_iter().flat_map(|p| p.keys());
            let held: Vec<&String> = keys.filter(|k| *k != "max_bytes").collect();
            let mut sorted = (declared.clone(), held.clone());
            sorted.0.sort();
            sorted.1.sort();
            assert_eq!(sorted.0, sorted.1, "{name}");
            for key in declared {
                let property = &schema["properties"][key];
                assert!(property["description"].is_string(), "{name}.{key} has no doc comment");
                let Some(value) = defaults[key].as_f64() else { continue };
                assert!(property["minimum"].as_f64().is_none_or(|low| value >= low - 1e-6 * low.abs()), "{name}.{key}");
                assert!(
                    property["maximum"].as_f64().is_none_or(|high| value <= high + 1e-6 * high.abs()),
                    "{name}.{key}"
                );
            }
        }
    }
}
