//! No import circle between files of different folders: each folder can be read, tested and moved without the others above it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Source files of a crate by their modules, without those of tests.
fn modules(folder: &Path, module: &[String], found: &mut BTreeMap<Vec<String>, PathBuf>) {
    for path in std::fs::read_dir(folder).into_iter().flatten().map(|e| e.expect("an entry").path()) {
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let inner: Vec<String> = module.iter().cloned().chain([name.clone()]).collect();
        if path.is_dir() {
            modules(&path, &inner, found);
        } else if path.extension().is_some_and(|e| e == "rs") && name != "tests" {
            let own = if ["lib", "main", "mod"].contains(&name.as_str()) { module.to_vec() } else { inner };
            found.insert(own, path);
        }
    }
}

/// The code of a file: no comments, no tests.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).expect("a text");
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    text.lines().filter(|l| !l.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// The paths of a tree of imports: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn leaves(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some((before, rest)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap_or(tree).trim().to_owned()];
    };
    let inside = rest.rsplit_once('}').map_or(rest, |(inside, _)| inside);
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for c in inside.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        match c {
            ',' if depth == 0 => parts.push(String::new()),
            c => parts.last_mut().expect("a part").push(c),
        }
    }
    let parts = parts.iter().filter(|p| !p.trim().is_empty());
    parts.flat_map(|p| leaves(p)).map(|p| format!("{before}{p}")).collect()
}

/// Absolute paths within the crate that a module's code names; what a module hands on from its own folder is none.
pub(crate) fn named(module: &[String], code: &str) -> Vec<Vec<String>> {
    let mut paths = Vec::new();
    for statement in code.split(';') {
        let starts = statement.match_indices("use ").map(|(at, _)| at);
        let Some(at) =
            starts.into_iter().find(|&at| statement[..at].chars().next_back().is_none_or(char::is_whitespace))
        else {
            continue;
        };
        paths.extend(leaves(&statement[at + 4..]));
    }
    // Paths in the midst of code.
    for start in ["crate::", "super::"] {
        for (at, _) in code.match_indices(start) {
            let path: String = code[at..].chars().take_while(|c| c.is_alphanumeric() || "_:".contains(*c)).collect();
            paths.push(path.trim_end_matches(':').to_owned());
        }
    }
    let absolute = |path: String| {
        let mut parts = path.split("::").map(|p| p.trim().to_owned()).collect::<Vec<_>>();
        match parts.first()?.as_str() {
            "crate" => Some(parts.split_off(1)),
            "super" => {
                let up = parts.iter().take_while(|p| *p == "super").count();
                let above = &module[..module.len().checked_sub(up)?];
                Some(above.iter().cloned().chain(parts.split_off(up)).collect())
            }
            _ => None,
        }
    };
    paths.into_iter().filter_map(absolute).collect()
}

/// Circles of a crate: two files of different folders that need each other.
fn circles(source: &Path) -> Vec<String> {
    let mut files = BTreeMap::new();
    modules(source, &[], &mut files);
    let needs: BTreeMap<&Vec<String>, BTreeSet<&Vec<String>>> = files
        .iter()
        .map(|(module, file)| {
            let paths = named(module, &code(file));
            let targets = paths.iter().filter_map(|p| {
                let module_of = (1..=p.len()).rev().find_map(|n| files.get_key_value(&p[..n]));
                module_of.map(|(m, _)| m)
            });
            (module, targets.filter(|t| *t != module).collect())
        })
        .collect();
    let mut all: BTreeMap<&Vec<String>, BTreeSet<&Vec<String>>> = BTreeMap::new();
    for from in files.keys() {
        let (mut seen, mut next) = (BTreeSet::new(), vec![from]);
        while let Some(module) = next.pop() {
            next.extend(needs.get(module).into_iter().flatten().filter(|t| seen.insert(**t)));
        }
        all.insert(from, seen);
    }
    let pairs = files.iter().flat_map(|a| files.iter().map(move |b| (a, b))).filter(|((a, _), (b, _))| a < b);
    let met = pairs.filter(|((a, fa), (b, fb))| fa.parent() != fb.parent() && all[a].contains(b) && all[b].contains(a));
    met.map(|((_, a), (_, b))| format!("{} and {}", a.display(), b.display())).collect()
}

#[test]
fn files_of_different_folders_import_in_one_direction() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let crates = ["crates", "apps"].iter().flat_map(|f| std::fs::read_dir(root.join(f)).expect("a folder"));
    let mut checked = 0;
    for folder in crates.map(|e| e.expect("an entry").path()) {
        let found = circles(&folder.join("src"));
        assert!(found.is_empty(), "these need each other:\n{}", found.join("\n"));
        checked += 1;
    }
    assert!(checked > 15);
}

#[test]
fn a_circle_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    };
    write("lib.rs", "mod a;\nmod b;\npub use b::c::Thing;");
    write("a.rs", "use crate::b::{c::{Thing, Other as O}, d};\nfn f() {}");
    write("b/mod.rs", "pub mod c;\npub mod d;");
    write("b/d.rs", "");
    write("b/c.rs", "pub struct Thing;\n// use crate::a;\n#[cfg(test)]\nmod tests {\n    use crate::a;\n}\n");
    assert_eq!(circles(folder.path()), Vec::<String>::new());
    write("b/c.rs", "pub struct Thing;\npub fn g() { super::super::a::f() }\n");
    assert_eq!(circles(folder.path()).len(), 1);
}
