//! Public enums of libraries can grow: `#[non_exhaustive]`, but for those that are matched wholly on purpose.

use std::fs;
use std::path::{Path, PathBuf};

/// Enums that stay open to whole matches, and why.
const WHOLE: &[(&str, &[&str])] = &[
    (
        "engines, interpreters and shaders carry out each one: the compiler finds those who lack a new one",
        &[
            "eyot-core::BoundaryCondition",
            "eyot-core::Centering",
            "eyot-core::GhostFill",
            "eyot-core::Isa",
            "eyot-core::Op",
            "eyot-core::Reach",
            "eyot-core::RuleKind",
            "eyot-core::TallyUnit",
        ],
    ),
    (
        "whoever carries recipes out must know each kind of step, and whoever exports each preset",
        &["eyot-recipe::Preset", "eyot-recipe::Work"],
    ),
    (
        "the stream gives each a number, and drawings each a form",
        &["eyot-reef::Form", "eyot-reef::Shape", "eyot-render::Anchor", "eyot-render::Shape"],
    ),
    (
        "a storage keeps each promise, a field answers each question, and methods that are chosen by name are all tried",
        &["eyot-io::Keep", "eyot-mesh::Within", "eyot-mesh::Rim", "eyot-drainage::Spread"],
    ),
    ("front ends have words for each", &["eyot-export::Subject", "eyot-recipe::Expression"]),
    (
        "there are no others",
        &[
            "eyot-core::Side",
            "eyot-expr::Part",
            "eyot-io::ByteOrder",
            "eyot-io::RowOrder",
            "eyot-recipe::Bytes",
            "eyot-recipe::FirstRow",
            "eyot-recipe::Season",
            "eyot-render::Season",
        ],
    ),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        match path.is_dir() {
            true => sources(&path, found),
            false if path.extension().is_some_and(|e| e == "rs") => found.push(path),
            false => {}
        }
    }
}

#[test]
fn public_enums_can_grow_or_say_why_not() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates");
    let mut listed: Vec<&str> = WHOLE.iter().flat_map(|(_, names)| names.iter().copied()).collect();
    let mut seen = 0;
    for folder in fs::read_dir(crates).expect("crates").flatten() {
        let owner = folder.file_name().into_string().expect("a name");
        let mut files = Vec::new();
        sources(&folder.path().join("src"), &mut files);
        for path in files {
            let text = fs::read_to_string(&path).expect("a source file");
            let lines: Vec<&str> = text.lines().map(str::trim).collect();
            for (i, line) in lines.iter().enumerate() {
                let Some(rest) = line.strip_prefix("pub enum ") else { continue };
                let name = rest.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
                let head = lines[..i].iter().rev().take_while(|l| l.starts_with("#[") || l.starts_with("///"));
                let grows = head.into_iter().any(|l| *l == "#[non_exhaustive]");
                let whole = format!("{owner}::{name}");
                let is_listed = listed.iter().any(|l| *l == whole);
                let place = path.display();
                assert!(grows || is_listed, "{place}: `{name}` is to be non_exhaustive, or WHOLE says why not");
                assert!(!grows || !is_listed, "{place}: `{name}` is non_exhaustive, and WHOLE says why not");
                seen += 1;
                if is_listed {
                    listed.retain(|l| *l != whole);
                }
            }
        }
    }
    assert!(seen > 60, "only {seen} enums were found");
    assert!(listed.is_empty(), "there is no {listed:?}");
}
