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

fn problems(recipe: &str, set: &[&str], size: Option<(u32, Option<u32>)>) -> String {
    let text = eyot::RECIPES.iter().find(|r| r.name == recipe).unwrap().text;
    let source = RecipeSource { name: recipe.into(), text: text.to_owned(), folder: ".".into() };
    let overrides = Overrides { set: set.iter().map(|s| (*s).to_owned()).collect(), size, ..Overrides::default() };
    match Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()) {
        Ok(_) => String::new(),
        Err(p) => p.diagnostics.iter().map(|d| format!("{}\n", d.message)).collect(),
    }
}

/// What a run would refuse after hours is found before it starts.
#[test]
fn parameters_that_cannot_work_are_found_by_the_check() {
    assert!(problems("island", &["reef.shallow=100"], None).contains("must be less than deep"));
    assert!(problems("island", &["reef.diffusivity=1000000", "reef.years_per_step=1000"], None).contains("stages"));
    assert!(problems("island", &["hydraulic.time_step=1000"], None).contains("sub-steps"));
    assert!(problems("island", &[], Some((1, None))).contains("2 x 2 cells"));
    // Switched off, neither parameters nor exports matter.
    assert_eq!(problems("island", &["reef.shallow=100", "reef.enabled=false"], None), "");
    assert_eq!(problems("island", &["erosion.enabled=false"], None), "");
}
