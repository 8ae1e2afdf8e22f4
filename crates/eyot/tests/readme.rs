//! The recipes printed in the README are sound.

use eyot::{Limits, Overrides, Recipe, RecipeSource, Registry};

#[test]
fn recipes_in_the_readme_are_sound() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../README.md")).unwrap();
    let blocks = text.split("```toml\n").skip(1).map(|b| b.split("```").next().unwrap_or_default());
    let recipes: Vec<&str> = blocks.filter(|b| b.contains("[[step]]")).collect();
    assert_eq!(recipes.len(), 1);
    for r in recipes {
        let source = RecipeSource { name: "README".into(), text: r.to_owned(), folder: ".".into() };
        let parsed = Recipe::parse(source, Overrides::default(), &Registry::standard(), &Limits::default());
        assert!(parsed.is_ok(), "{:?}", parsed.err());
    }
}
