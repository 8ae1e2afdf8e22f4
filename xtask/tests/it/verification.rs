//! The book's table of what is tested against theory names tests that there are.

use std::collections::BTreeSet;
use std::path::Path;

/// Names of all test functions in the files under a folder, if there is one.
fn tests(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().map(|e| e.expect("an entry").path()) {
        if entry.is_dir() {
            tests(&entry, found);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(&entry).expect("a text");
            for after in text.split("#[test]").skip(1) {
                let name = after.split("fn ").nth(1).and_then(|f| f.split('(').next());
                found.extend(name.map(String::from));
            }
        }
    }
}

#[test]
fn the_table_of_tests_names_tests() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = BTreeSet::new();
    for folder in std::fs::read_dir(root.join("crates")).expect("crates").map(|e| e.expect("an entry").path()) {
        tests(&folder.join("tests"), &mut found);
    }
    tests(&root.join("apps/eyot-cli/tests"), &mut found);
    let page = std::fs::read_to_string(root.join("docs/book/src/reference/verification.md")).expect("the page");
    let rows: Vec<&str> = page.lines().filter(|l| l.starts_with("| ")).skip(1).collect();
    assert!(rows.len() >= 20, "{} rows", rows.len());
    for row in rows {
        let last = row.trim_end_matches('|').rsplit('|').next().expect("a last column");
        let named: Vec<&str> = last.split('`').skip(1).step_by(2).collect();
        assert!(!named.is_empty(), "no test: {row}");
        for name in named {
            assert!(found.contains(name), "there is no test {name}: {row}");
        }
    }
}
