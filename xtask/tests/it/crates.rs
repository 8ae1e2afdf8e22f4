//! Which crate may use which: the star of ARCHITECTURE.md, checked against the manifests as cargo reads them.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

/// Below the facade: what each crate may depend on, tests apart. A crate that is missing here fails the test: it needs a place.
const BELOW: &[(&str, &[&str])] = &[
    ("eyot-core", &[]),
    ("eyot-noise", &["core"]),
    ("eyot-drainage", &["core"]),
    // Engines.
    ("eyot-gpu", &["core"]),
    // Processes and generators; they never name each other.
    ("eyot-land", &["core", "drainage", "noise"]),
    ("eyot-climate", &["core", "noise"]),
    ("eyot-plates", &["core", "noise"]),
    ("eyot-reef", &["core", "mesh"]),
    ("eyot-strata", &["core"]),
    ("eyot-water", &["core", "drainage", "noise"]),
    ("eyot-ice", &["core"]),
    ("eyot-plants", &["core", "noise"]),
    // Layers and rules of a recipe's own.
    ("eyot-expr", &["core"]),
    // What a recipe says, and how it is carried out: no pictures, meshes, cards or network.
    ("eyot-recipe", &["core", "expr"]),
    ("eyot-session", &["core", "io", "recipe"]),
    // What is written and shown.
    ("eyot-mesh", &["core"]),
    ("eyot-io", &["core", "mesh"]),
    // Cut sides show beds, views single trees.
    ("eyot-render", &["core", "noise", "plants", "strata"]),
    ("eyot-view", &["core", "gpu", "noise", "render"]),
    (
        "eyot-export",
        &[
            "climate", "core", "drainage", "io", "land", "mesh", "plants", "recipe", "reef", "render", "session",
            "strata",
        ],
    ),
    ("eyot-film", &["core", "export", "gpu", "io", "recipe", "render", "session", "view"]),
    ("eyot-live", &["core", "recipe", "reef", "session"]),
];

/// What may depend on the facade, and on what else.
const ABOVE: &[(&str, &[&str])] = &[
    ("eyot-cli", &["eyot", "eyot-bench"]),
    (
        "eyot-bench",
        &[
            "eyot",
            "eyot-climate",
            "eyot-core",
            "eyot-drainage",
            "eyot-gpu",
            "eyot-ice",
            "eyot-land",
            "eyot-plants",
            "eyot-plates",
            "eyot-reef",
            "eyot-strata",
            "eyot-water",
            "eyot-expr",
        ],
    ),
    ("eyot-python", &["eyot"]),
    ("eyot-wasm", &["eyot"]),
    ("eyot-testing", &["eyot-climate", "eyot-core", "eyot-land", "eyot-plants", "eyot-strata"]),
];

/// The crates of the workspace, with those of them that each needs.
fn needs() -> BTreeMap<String, BTreeSet<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let out = Command::new(cargo)
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(root)
        .output()
        .expect("cargo");
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let all: Value = serde_json::from_slice(&out.stdout).expect("metadata");
    let packages = all["packages"].as_array().expect("packages");
    let of = |package: &Value| {
        let dependencies = package["dependencies"].as_array().into_iter().flatten();
        let needed = dependencies.filter(|d| d["kind"] != "dev" && d["path"].is_string());
        needed.filter_map(|d| d["name"].as_str().map(str::to_owned)).collect()
    };
    packages.iter().map(|p| (p["name"].as_str().expect("a name").to_owned(), of(p))).collect()
}

#[test]
fn every_crate_stands_where_the_star_has_it() {
    let needs = needs();
    for (name, found) in &needs {
        if let Some((_, may)) = BELOW.iter().find(|(n, _)| n == name) {
            let beyond: Vec<_> = found.iter().filter(|f| !may.iter().any(|m| **f == format!("eyot-{m}"))).collect();
            assert!(beyond.is_empty(), "{name} may not depend on {beyond:?}");
        } else if let Some((_, may)) = ABOVE.iter().find(|(n, _)| n == name) {
            let beyond: Vec<_> = found.iter().filter(|f| !may.contains(&f.as_str())).collect();
            assert!(beyond.is_empty(), "{name} may not depend on {beyond:?}");
        } else {
            // The facade gathers everything below it; chores and fuzzing look into every room.
            assert!(["eyot", "eyot-fuzz", "xtask"].contains(&name.as_str()), "`{name}` has no place in the star");
        }
    }
    let facade = &needs["eyot"];
    let strangers: Vec<_> = facade.iter().filter(|f| !BELOW.iter().any(|(n, _)| n == f)).collect();
    assert!(strangers.is_empty(), "the facade may not depend on {strangers:?}");
}

/// A front end that reaches below the facade would tie itself to how the house is cut.
#[test]
fn front_ends_use_the_facade_and_nothing_below_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let facade = std::fs::read_to_string(root.join("crates/eyot/src/lib.rs")).expect("the facade");
    for line in facade.lines().map(str::trim) {
        let whole = line.strip_prefix("pub use eyot_").is_some_and(|rest| !rest.contains("::"));
        assert!(!whole, "the facade hands out a whole crate: {line}");
    }
    let mut lines = 0;
    let mut folders = vec![root.join("crates/eyot/src")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                lines += std::fs::read_to_string(path).expect("a text").lines().count();
            }
        }
    }
    assert!(lines <= 600, "the facade has {lines} lines: what it does belongs into a crate that says so");
}
