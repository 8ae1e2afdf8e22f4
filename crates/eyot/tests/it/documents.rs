//! Every generator and process has a text that the book and `eyot describe` can show.

use eyot::Registry;

#[test]
fn every_entry_says_its_equations_and_its_source() {
    let registry = Registry::standard();
    let generators = registry.generators().iter().map(|e| (e.name, e.about));
    let texts: Vec<_> = generators.chain(registry.processes().iter().map(|e| (e.name, e.about))).collect();
    for (name, about) in &texts {
        for section in ["# Equations", "# Source"] {
            assert!(
                about.lines().any(|l| l == section),
                "the head of the source file of `{name}` (its `//!` lines) needs a section `{section}`: see CONTRIBUTING.md"
            );
        }
        assert!(
            !about.contains("[`"),
            "`{name}`: links between Rust items lead nowhere in the book; write the name alone"
        );
    }
    // Two entries that name the same file show the same text.
    for (i, (name, about)) in texts.iter().enumerate() {
        for (other, theirs) in &texts[..i] {
            assert_ne!(about, theirs, "`{name}` and `{other}` have the same text");
        }
    }
}
