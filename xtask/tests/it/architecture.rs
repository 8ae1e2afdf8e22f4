//! The invariants of ARCHITECTURE.md that are marked with a star.

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
fn land_does_no_io_and_its_rooms_are_apart() {
    assert_absent("crates/eyot-land/src", &["std::fs", "std::net", "File::"], &[]);
    assert_absent("crates/eyot-land/src/generate", &["simulate::"], &[]);
    assert_absent("crates/eyot-land/src/simulate", &["generate::"], &[]);
    let processes = ["hydraulic", "thermal", "seabed", "reef", "wetness", "streampower"];
    for p in processes {
        for (path, text) in rust_files("crates/eyot-land/src/simulate") {
            let name = path.to_string_lossy().into_owned();
            if !name.contains(p) {
                continue;
            }
            for other in processes.iter().filter(|o| **o != p) {
                let bad = code(&text).any(|l| {
                    l.contains("use ")
                        && l.contains(&format!("{other}::"))
                        && !l.contains("{FLUX_SE, FLUX_SW, FLUX_X, FLUX_Y}")
                });
                assert!(!bad, "{name} imports from {other}");
            }
        }
    }
}

#[test]
fn processes_do_no_io() {
    for krate in ["eyot-climate", "eyot-noise", "eyot-plates", "eyot-reef", "eyot-expr"] {
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

#[test]
fn only_io_opens_files() {
    for folder in ["crates/eyot-mesh/src", "crates/eyot-render/src"] {
        assert_absent(folder, &["std::fs", "File::"], &[]);
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
    for krate in ["eyot-core", "eyot-land", "eyot-io", "eyot-mesh", "eyot-render", "eyot"] {
        let manifest = fs::read_to_string(root().join("crates").join(krate).join("Cargo.toml")).unwrap();
        assert!(!manifest.lines().any(|l| l.starts_with("wgpu")), "{krate} depends on wgpu");
    }
    for folder in ["crates/eyot-gpu/src", "crates/eyot-view/src"] {
        assert_absent(folder, &["std::fs", "File::"], &[]);
        // A browser has no thread that may wait.
        assert_absent(folder, &["pollster", "PollType::Wait", "std::time::Instant"], &["blocking.rs", "clock.rs"]);
    }
}

#[test]
fn unsafe_code_gives_its_reason() {
    for folder in ["crates", "apps", "fuzz", "xtask"] {
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

#[test]
fn libraries_speak_no_command_line() {
    assert!(names_a_flag("raise --max-memory") && names_a_flag("(--layer NAME)") && !names_a_flag("a --- b"));
    for (path, text) in rust_files("crates") {
        let name = path.to_string_lossy().replace('\\', "/");
        if !name.contains("/src/") || name.ends_with("/tests.rs") {
            continue;
        }
        for line in code(without_tests(&text)) {
            assert!(!names_a_flag(line) && !line.contains("`eyot "), "{name} speaks of the command line: {line}");
        }
    }
}
