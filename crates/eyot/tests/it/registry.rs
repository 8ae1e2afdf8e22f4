//! The standard registry: its keys, its schema and its literature.

use biblatex::Bibliography;
use eyot::{Boundary, Grid, Limits, Registry, all_citations, recipe_schema};
use eyot_core::conformance;
use eyot_core::process::{Locality, Scheduled};
use eyot_recipe::{DOCUMENT_KEYS, GENERATE_KEYS, REFERENCES, SCHEDULE_KEYS, SIMULATE_KEYS};

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
            assert!(property["maximum"].as_f64().is_none_or(|high| value <= high + 1e-6 * high.abs()), "{name}.{key}");
        }
    }
}

#[test]
fn the_schema_knows_every_entry_and_no_null() {
    let registry = Registry::standard();
    let schema = recipe_schema(&registry);
    let text = schema.to_string();
    for name in registry.generator_names().chain(registry.process_names()) {
        assert!(text.contains(&format!("\"{name}\"")), "{name}");
    }
    assert!(!text.contains("null"), "{text}");
    assert!(schema["properties"]["seed"].is_object());
    assert!(schema["properties"]["step"]["items"]["anyOf"].as_array().unwrap().len() >= registry.generators().len());
}

/// A key without an entry fails here with its name; an entry that nothing uses is dead weight.
#[test]
fn keys_and_entries_of_the_references_belong_together() {
    let used = all_citations(&Registry::standard()).unwrap();
    for entry in Bibliography::parse(REFERENCES).unwrap().iter() {
        let key = &entry.key;
        assert!(
            used.iter().any(|c| c.key == *key),
            "nothing cites `{key}`: name it in the `cites` of a registry entry, of DATA or of ENGINE, or remove it"
        );
        assert!(entry.author().is_ok_and(|a| !a.is_empty()), "{key} has no author");
        assert!(entry.get("title").is_some() && entry.get("year").is_some(), "{key}");
    }
}

#[test]
fn names_titles_and_notes_are_readable() {
    let all = all_citations(&Registry::standard()).unwrap();
    let text = |key: &str| all.iter().find(|c| c.key == key).unwrap().text.clone();
    assert_eq!(
        text("mei2007"),
        "Xing Mei, Philippe Decaudin and Bao-Gang Hu (2007): Fast Hydraulic Erosion Simulation and Visualization on GPU. \
         Pacific Graphics, 47-56. doi:10.1109/PG.2007.15"
    );
    assert!(text("jasiewicz2013").starts_with("Jarosław Jasiewicz and"), "{}", text("jasiewicz2013"));
    assert!(text("farr2007").starts_with("Tom G. Farr et al. (2007)"), "{}", text("farr2007"));
    assert!(text("jacksboro").contains("NASA and USGS") && text("jacksboro").contains("jacksboro_fault_dem.npz"));
    assert!(text("eyot").contains(eyot::VERSION), "the version in references.bib is not {}", eyot::VERSION);
    for c in &all {
        assert!(!c.text.contains(['{', '}', '\\']), "{}", c.text);
        assert!(c.bibtex.starts_with('@') && c.bibtex.trim_end().ends_with('}'), "{}", c.bibtex);
    }
}

/// Of every process it is known whether a part of a grid will do, and where it will, parts make the bytes of the whole.
#[test]
fn every_process_works_in_windows_or_says_that_it_needs_the_whole() {
    let whole = ["corals", "drainage", "glaciers", "plates", "rivers", "streampower"];
    for e in Registry::standard().processes() {
        let process = (e.make)(serde_json::json!({})).unwrap();
        let alone = [Scheduled { name: e.name, process, every: 1 }];
        let locality = alone[0].process.action().map_or(Locality::Cell, |a| a.locality());
        assert_eq!(locality == Locality::Whole, whole.contains(&e.name), "{}", e.name);
        if locality != Locality::Whole {
            assert!(conformance::check_windows(&alone, &|_, u| u).unwrap(), "{}", e.name);
        }
    }
}

/// What a process says of itself: its layers once, of each parameter what it means, of each number its unit and range.
#[test]
fn every_process_says_what_it_is() {
    // A reef's plot is small, a planet is not.
    let grids = [10.0, 1e5].map(|cell_m| Grid::new(8, 8, cell_m, Boundary::WRAP, &Limits::default()).unwrap());
    for e in Registry::standard().processes() {
        let process = (e.make)((e.defaults)()).unwrap_or_else(|err| panic!("{}: {err}", e.name));
        let layers = process.layers();
        let mut names: Vec<&str> = layers.iter().map(|l| &*l.spec.name).collect();
        names.sort_unstable();
        names.dedup();
        assert!(!names.is_empty() && names.len() == layers.len(), "{}: {names:?}", e.name);
        let schema = (e.schema)();
        for (name, p) in schema.as_value()["properties"].as_object().into_iter().flatten() {
            assert!(p["description"].is_string(), "{}.{name} says nothing about itself", e.name);
            if p["type"] == "number" || p["type"] == "integer" {
                let whole = p["unit"].is_string() && p["minimum"].is_number() && p["maximum"].is_number();
                assert!(whole, "{}.{name}: {p}", e.name);
            }
        }
        let fits = grids.iter().any(|grid| process.check(grid).is_ok());
        assert!(fits, "{}: {:?}", e.name, process.check(&grids[0]));
    }
}
