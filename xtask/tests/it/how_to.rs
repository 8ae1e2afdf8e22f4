//! CONTRIBUTING.md leads to what is there: each of its ways has at most ten steps, and every step names a file that holds what it says.

use std::path::Path;

/// The lines below a heading.
fn section<'a>(text: &'a str, heading: &str) -> Vec<&'a str> {
    let lines = text.lines().skip_while(|l| *l != format!("## {heading}")).skip(1);
    lines.take_while(|l| !l.starts_with("## ")).filter(|l| !l.is_empty()).collect()
}

#[test]
fn the_ways_of_contributing_lead_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = std::fs::read_to_string(root.join("CONTRIBUTING.md")).expect("CONTRIBUTING.md");
    for what in ["a process", "a component", "an export", "a front end"] {
        let steps = section(&text, &format!("How to add {what}"));
        assert!((5..=10).contains(&steps.len()), "how to add {what}: {} steps", steps.len());
        let mut followed = 0;
        for step in steps {
            let quoted: Vec<&str> = step.split('`').collect();
            for (i, path) in quoted.iter().enumerate().skip(1).step_by(2) {
                if !path.contains('/') || !path.contains('.') || path.contains(' ') {
                    continue;
                }
                let file = root.join(path);
                assert!(file.is_file(), "how to add {what}: there is no `{path}`");
                followed += 1;
                if quoted.get(i + 1) == Some(&" → ") {
                    let name = quoted[i + 2];
                    let content = std::fs::read_to_string(&file).expect("a text");
                    let there = content.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == name);
                    assert!(there, "how to add {what}: `{path}` does not name `{name}`");
                }
            }
        }
        assert!(followed > 3, "how to add {what} names {followed} files");
    }
}
