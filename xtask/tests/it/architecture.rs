//! The invariants of ARCHITECTURE.md that are marked with a star.

use crate::circles::named;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn rust_files(folder: &str) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    let mut todo = vec![root().join(folder)];
    while let Some(dir) = todo.pop() {
        for entry in fs::read_dir(&dir).unwrap_or_else(|e| panic!("{}: {e}", dir.display())) {
            let path = entry.unwrap().path();
            if path.is_dir() {
                todo.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                files.push((path, text));
            }
        }
    }
    assert!(!files.is_empty(), "{folder} has no Rust files");
    files
}

/// Lines of code: comments and documentation left out.
fn code(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|l| !l.trim_start().starts_with("//"))
}

fn assert_absent(folder: &str, words: &[&str], except: &[&str]) {
    for (path, text) in rust_files(folder) {
        let name = path.to_string_lossy().into_owned();
        if except.iter().any(|e| name.contains(e)) {
            continue;
        }
        for line in code(&text) {
            for w in words {
                assert!(!line.contains(w), "{name} names `{w}`: {line}");
            }
        }
    }
}

#[test]
fn paths_named_in_the_architecture_exist() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let mut seen = 0;
    for path in text.split('`').skip(1).step_by(2).filter(|p| p.contains('/') && !p.contains(' ')) {
        assert!(root().join(path).exists(), "ARCHITECTURE.md names {path}");
        seen += 1;
    }
    assert!(seen > 15, "only {seen} paths found");
}

/// Neither as a type nor by its name in recipes. Layers that several processes share may be called as one of them is.
#[test]
fn the_core_names_no_process_and_does_no_io() {
    assert_absent("crates/eyot-core/src", &["std::fs", "std::net"], &[]);
    let registry = eyot::Registry::standard();
    let names: Vec<String> =
        registry.process_names().chain(registry.generator_names()).map(|name| name.to_string()).collect();
    assert!(names.len() > 40, "{names:?}");
    for folder in ["crates/eyot-core/src", "crates/eyot-gpu/src", "crates/eyot-session/src"] {
        for (path, text) in rust_files(folder).into_iter().filter(|(path, _)| !path.ends_with("tests.rs")) {
            for line in code(without_tests(&text)) {
                let shared = line.contains("LayerSpec");
                for name in &names {
                    let by_name = !shared && line.contains(&format!("\"{name}\""));
                    assert!(!by_name, "{} names the process or generator `{name}`: {line}", path.display());
                }
                for word in line.split(|c: char| !c.is_alphanumeric()) {
                    let as_type = TYPES.contains(&word);
                    assert!(!as_type, "{} names the type `{word}` of a process: {line}", path.display());
                }
            }
        }
    }
}

/// Types of parameters that no word of the core could be mistaken for.
const TYPES: &[&str] = &[
    "Hydraulic",
    "Thermal",
    "Streampower",
    "Seabed",
    "Wetness",
    "Temperature",
    "Humidity",
    "Weathering",
    "Wind",
    "Corals",
    "Tectonics",
    "Fbm",
];

#[test]
fn land_generates_and_simulates_apart() {
    assert_absent("crates/eyot-land/src/generate", &["simulate::"], &[]);
    assert_absent("crates/eyot-land/src/simulate", &["generate::"], &[]);
}

/// Modules of the processes that a file registers by their heads.
fn registered(file: &str) -> Vec<String> {
    let text = fs::read_to_string(root().join(file)).unwrap();
    let heads = text.split("about!(\"").skip(1).filter_map(|t| t.split(['/', '.']).next());
    heads.map(str::to_owned).collect()
}

#[test]
fn no_process_imports_another_one() {
    let mut checked = 0;
    for (file, folder, module) in [
        ("crates/eyot-land/src/simulate/mod.rs", "crates/eyot-land/src/simulate", &["simulate".to_owned()][..]),
        ("crates/eyot-climate/src/lib.rs", "crates/eyot-climate/src", &[]),
    ] {
        let processes = registered(file);
        for process in &processes {
            for (path, text) in rust_files(folder) {
                let inside = path.strip_prefix(root().join(folder)).unwrap().with_extension("");
                let mut own: Vec<String> = inside.iter().map(|c| c.to_string_lossy().into_owned()).collect();
                own.pop_if(|last| last == "mod");
                if own.first() != Some(process) {
                    continue;
                }
                let own: Vec<String> = module.iter().cloned().chain(own).collect();
                for named in named(&own, &code(without_tests(&text)).collect::<Vec<_>>().join("\n")) {
                    let Some([other, what, ..]) = named.strip_prefix(module) else { continue };
                    let layer = what.chars().all(|c| c.is_ascii_uppercase() || c == '_' || c.is_ascii_digit());
                    let bad = processes.contains(other) && other != process && !layer;
                    assert!(!bad, "{} imports {}", path.display(), named.join("::"));
                }
                checked += 1;
            }
        }
    }
    assert!(checked > 20, "{checked} files");
}

#[test]
fn processes_do_no_io() {
    let crates = [
        "eyot-land",
        "eyot-drainage",
        "eyot-climate",
        "eyot-noise",
        "eyot-plates",
        "eyot-reef",
        "eyot-strata",
        "eyot-water",
        "eyot-ice",
        "eyot-plants",
        "eyot-expr",
    ];
    for krate in crates {
        assert_absent(&format!("crates/{krate}/src"), &["std::fs", "std::net", "File::"], &[]);
    }
}

#[test]
fn recipes_open_files_in_one_place_and_need_nothing_heavy() {
    let manifest = fs::read_to_string(root().join("crates/eyot-recipe/Cargo.toml")).unwrap();
    let needed = manifest.split("[dev-dependencies]").next().unwrap();
    for heavy in ["png", "zarr", "wgpu", "meshopt", "tungstenite", "zstd"] {
        assert!(!needed.lines().any(|l| l.starts_with(heavy)), "eyot-recipe depends on {heavy}");
    }
    assert_absent("crates/eyot-recipe/src", &["std::fs", "std::net", "File::"], &["src/fs.rs"]);
}

#[test]
fn sessions_know_no_card_exporter_or_process() {
    let manifest = fs::read_to_string(root().join("crates/eyot-session/Cargo.toml")).unwrap();
    let needed = manifest.split("[dev-dependencies]").next().unwrap();
    for line in needed.lines().filter(|l| l.starts_with("eyot")) {
        let below = ["eyot-core.", "eyot-io.", "eyot-recipe."];
        assert!(below.iter().any(|b| line.starts_with(b)), "eyot-session depends on {line}");
    }
}

/// The crates, and the files that may open files although another crate is there for it.
#[test]
fn only_io_opens_files() {
    let except = [
        "eyot-io/src",
        // Named by ARCHITECTURE.md.
        "eyot-session/src/lock.rs",
        "eyot-session/src/timeline.rs",
        "eyot-session/src/run/mod.rs",
        "eyot-export/src/open.rs",
        "eyot-export/src/outputs.rs",
        "eyot-export/src/convert.rs",
        "eyot-export/src/import.rs",
        "eyot-film/src/path_file.rs",
        "eyot-film/src/video.rs",
        "eyot-film/src/folder.rs",
        "eyot-recipe/src/fs.rs",
        "eyot/src/card.rs",
        "eyot-testing/src",
    ];
    for krate in fs::read_dir(root().join("crates")).unwrap().map(|e| e.unwrap().file_name()) {
        let folder = format!("crates/{}/src", krate.to_string_lossy());
        for (path, text) in rust_files(&folder) {
            let name = path.to_string_lossy().replace('\\', "/");
            if except.iter().any(|e| name.contains(e)) || name.ends_with("/tests.rs") {
                continue;
            }
            for line in code(without_tests(&text)) {
                let opens = ["std::fs", "File::open", "File::create", "OpenOptions"].iter().any(|w| line.contains(w));
                assert!(!opens, "{name} opens files: {line}");
            }
        }
    }
}

#[test]
fn only_the_stream_crate_opens_connections() {
    for folder in ["crates", "apps", "fuzz"] {
        // The facade and the command know addresses; they open nothing.
        assert_absent(folder, &["TcpStream", "TcpListener", "UdpSocket"], &["eyot-live"]);
    }
    let manifest = fs::read_to_string(root().join("crates/eyot-live/Cargo.toml")).unwrap();
    let own = |l: &&str| l.starts_with("eyot") && !l.contains("optional = true");
    assert!(!manifest.lines().any(|l| own(&l)), "a client of eyot-live needs another crate of the workspace");
    assert_absent("crates/eyot-live/src", &["std::fs", "File::"], &[]);
}

#[test]
fn only_the_gpu_crates_name_wgpu_and_one_file_waits() {
    for krate in fs::read_dir(root().join("crates")).unwrap().map(|e| e.unwrap().path()) {
        let manifest = fs::read_to_string(krate.join("Cargo.toml")).unwrap();
        let is_of_cards = krate.ends_with("eyot-gpu") || krate.ends_with("eyot-view");
        let depends = manifest.lines().any(|l| l.starts_with("wgpu"));
        assert_eq!(depends, is_of_cards, "{} and wgpu", krate.display());
    }
    for folder in ["crates/eyot-gpu/src", "crates/eyot-view/src"] {
        assert_absent(folder, &["std::fs", "File::"], &[]);
        // A browser has no thread that may wait.
        assert_absent(folder, &["pollster", "PollType::Wait", "std::time::Instant"], &["blocking.rs", "clock.rs"]);
    }
}

#[test]
fn only_the_bindings_name_python() {
    for folder in ["crates", "apps", "fuzz"] {
        for package in fs::read_dir(root().join(folder)).unwrap().map(|e| e.unwrap().path().join("Cargo.toml")) {
            let manifest = fs::read_to_string(&package).unwrap_or_default();
            assert!(!manifest.lines().any(|l| l.starts_with("pyo3")), "{} depends on pyo3", package.display());
        }
    }
}

#[test]
fn unsafe_code_gives_its_reason() {
    for folder in ["bindings", "crates", "apps", "fuzz", "xtask"] {
        for (path, text) in rust_files(folder) {
            let allows = text.contains("allow(unsafe_code)");
            let gives_reason = text.lines().take(15).any(|l| l.contains("Reason for the exception"));
            assert!(
                !allows || gives_reason || path.ends_with("architecture.rs"),
                "{} allows unsafe code without a reason",
                path.display()
            );
        }
    }
}

/// The code of a file without what only its tests compile: unit tests stand at the end.
fn without_tests(text: &str) -> &str {
    text.split("\n#[cfg(test)]\nmod ").next().unwrap_or(text)
}

/// True for a flag such as `--seed`.
fn names_a_flag(line: &str) -> bool {
    line.match_indices("--").any(|(i, _)| {
        let before = line[..i].chars().next_back();
        !before.is_some_and(|c| c == '-' || c.is_alphanumeric())
            && line[i + 2..].starts_with(|c: char| c.is_ascii_lowercase())
    })
}

/// True for a verb of the command, such as `eyot run`.
fn names_a_verb(line: &str) -> bool {
    ["`eyot ", "\"eyot "].iter().any(|start| {
        let after = line.split(start).nth(1);
        after.is_some_and(|after| after.starts_with(|c: char| c.is_ascii_lowercase()) || *start == "`eyot ")
    })
}

#[test]
fn libraries_speak_no_command_line() {
    assert!(names_a_verb("see `eyot list`") && names_a_verb("(\"eyot stats\", 1)") && !names_a_verb("\"eyot {}\""));
    assert!(names_a_flag("raise --max-memory") && names_a_flag("(--layer NAME)") && !names_a_flag("a --- b"));
    for (path, text) in rust_files("crates") {
        let name = path.to_string_lossy().replace('\\', "/");
        if !name.contains("/src/") || name.ends_with("/tests.rs") {
            continue;
        }
        for line in code(without_tests(&text)) {
            assert!(!names_a_flag(line) && !names_a_verb(line), "{name} speaks of the command line: {line}");
        }
    }
}
