//! Every built-in recipe makes the bytes that it has always made: small, with few steps, in one piece, recorded, stopped and
//! resumed, on the processor and on a graphics card.
//!
//! After the bytes were changed on purpose, `EYOT_UPDATE_GOLDENS=1 cargo test -p eyot --test it fingerprints` writes the goldens
//! anew; the reason belongs into the commit.

use eyot::{
    Command, EngineChoice, EngineOptions, Event, Limits, Overrides, RECIPES, Recipe, RecipeSource, Record, Registry,
    Run, RunError, RunOptions, Work,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Steps of each simulation: enough that every process acts, two frames are recorded, and a stop falls between them.
const STEPS: u64 = 24;
/// Cells along the longer side, or columns and rows where cells must stay square.
fn size(name: &str) -> (u32, Option<u32>) {
    if name == "reef-slope" { (50, Some(15)) } else { (48, None) }
}
/// Steps before the stop.
const BEFORE: u64 = 11;

/// Fingerprints by recipe.
type Prints = BTreeMap<String, String>;

fn recipe(name: &str) -> Recipe {
    let text = RECIPES.iter().find(|r| r.name == name).expect("a built-in recipe").text;
    let parse = |set: Vec<String>| {
        let source = RecipeSource { name: format!("{name}.toml"), text: text.into(), folder: ".".into() };
        let overrides = Overrides { size: Some(size(name)), set, ..Overrides::default() };
        Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).expect("a sound recipe")
    };
    let mut set = vec!["view.enabled=false".to_owned()];
    for step in parse(Vec::new()).steps {
        if let Work::Simulate(work) = step.work {
            set.push(format!("step.{}.steps={}", step.number, work.steps.min(STEPS)));
        }
    }
    let mut recipe = parse(set);
    recipe.exports.clear();
    recipe
}

fn print(recipe: Recipe, options: RunOptions) -> Result<String, RunError> {
    let outcome = Run::start(recipe, options)?.join()?;
    assert!(outcome.finished);
    Ok(format!("{:016x}", outcome.fingerprint))
}

fn recorded(recipe: Recipe, out: &Path) -> String {
    let record = Some(Record { every: 10, max_bytes: 1 << 30 });
    print(recipe, RunOptions { out: Some(out.to_owned()), record, ..RunOptions::default() }).unwrap()
}

fn resumed(recipe: Recipe, out: &Path) -> String {
    let generators = recipe.steps.iter().filter(|s| s.enabled && matches!(s.work, Work::Generate(_)));
    let steps = BEFORE + generators.count() as u64;
    let options = RunOptions { out: Some(out.to_owned()), chunk: Some(5), paused: true, ..RunOptions::default() };
    let handle = Run::start(recipe, options).unwrap();
    handle.send(Command::Step(steps));
    for _ in 0..2 {
        while !matches!(handle.events().recv_timeout(Duration::from_secs(600)), Ok(Event::Paused { .. })) {}
    }
    handle.send(Command::Stop);
    assert!(!handle.join().unwrap().finished);
    let end = Run::resume(out, &Registry::standard(), RunOptions::default()).unwrap().join().unwrap();
    assert!(end.finished);
    format!("{:016x}", end.fingerprint)
}

/// Compares with the golden file, or writes it. `None` if there is none.
fn compare(file: &str, found: &Prints) -> Option<()> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/goldens").join(file);
    if std::env::var_os("EYOT_UPDATE_GOLDENS").is_some() {
        std::fs::write(&path, serde_json::to_string_pretty(found).unwrap() + "\n").unwrap();
        return Some(());
    }
    let golden: Prints = serde_json::from_str(&std::fs::read_to_string(&path).ok()?).unwrap();
    assert_eq!(found, &golden, "other bytes than in {}", path.display());
    Some(())
}

#[test]
fn recipes_make_the_same_bytes_as_ever() {
    let mut found = Prints::new();
    for r in RECIPES {
        let plain = print(recipe(r.name), RunOptions::default()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(recorded(recipe(r.name), &folder.path().join("recorded")), plain, "{}: recorded", r.name);
        assert_eq!(resumed(recipe(r.name), &folder.path().join("resumed")), plain, "{}: resumed", r.name);
        found.insert(r.name.to_owned(), plain);
    }
    compare("fingerprints.json", &found).expect("goldens");
}

/// A card rounds in its own way, so its fingerprints are compared with those of the same adapter only.
#[test]
fn recipes_make_the_same_bytes_as_ever_on_a_card() {
    let engine = EngineOptions { choice: EngineChoice::Gpu, ..EngineOptions::default() };
    let options = || RunOptions { engine: Some(engine.clone()), ..RunOptions::default() };
    let mut found = Prints::new();
    for r in RECIPES {
        match print(recipe(r.name), options()) {
            Ok(plain) => drop(found.insert(r.name.to_owned(), plain)),
            Err(e @ RunError::Device(_)) if std::env::var_os("EYOT_REQUIRE_GPU").is_none() => {
                eprintln!("skipped: {e}");
                return;
            }
            Err(e) => panic!("{e}"),
        }
    }
    let handle = Run::start(recipe("island"), options()).unwrap();
    let adapter = handle.events().iter().find_map(|e| match e {
        Event::Started { engine, .. } => Some(engine),
        _ => None,
    });
    let adapter: String = adapter.expect("the engine's name").chars().filter(char::is_ascii_alphanumeric).collect();
    handle.join().unwrap();
    if compare(&format!("fingerprints-{adapter}.json"), &found).is_none() {
        eprintln!("there are no goldens of {adapter}");
    }
}
