//! The recipes printed in the README and in the book are sound.

use eyot::{Limits, Overrides, Recipe, RecipeSource, Registry};
use std::path::{Path, PathBuf};

/// Blocks of TOML in a document, without those that are saved and run by `.ci/commands`.
fn blocks(page: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(page).unwrap();
    text.split("```toml\n").skip(1).map(|b| b.split("```").next().unwrap_or_default().to_owned()).collect()
}

fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pages = vec![root.join("README.md")];
    for folder in ["tutorial", "concepts", "reference"] {
        let folder = std::fs::read_dir(root.join("docs/book/src").join(folder)).unwrap();
        pages.extend(folder.map(|e| e.unwrap().path()));
    }
    pages
}

#[test]
fn recipes_in_the_documents_are_sound() {
    // Parts of recipes are tried in the place of the exports and the view of the island.
    let island = eyot::RECIPES.iter().find(|r| r.name == "island").unwrap().text.split("[[export]]").next().unwrap();
    let mut tried = 0;
    for page in pages() {
        for block in blocks(&page).into_iter().filter(|b| !b.contains("[dependencies]")) {
            let text = if block.contains("[grid]") { block } else { format!("{island}\n{block}") };
            let source = RecipeSource { name: page.display().to_string(), text, folder: ".".into() };
            let parsed = Recipe::parse(source, Overrides::default(), &Registry::standard(), &Limits::default());
            assert!(parsed.is_ok(), "{}: {:?}", page.display(), parsed.err());
            tried += 1;
        }
    }
    assert!(tried > 4, "{tried}");
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
