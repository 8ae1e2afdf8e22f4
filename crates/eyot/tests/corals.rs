//! The recipe `reef`: colonies that live through a run, stop and go on, and the files they leave.

mod common;

use eyot::{Command, Event, Limits, Overrides, RECIPES, Recipe, RecipeSource, Registry, Run, RunOptions};
use std::collections::HashSet;
use std::path::Path;

/// Four metres and so many months.
fn reef(months: u64) -> Recipe {
    let text = RECIPES.iter().find(|r| r.name == "reef").unwrap().text;
    let source = RecipeSource { name: "reef.toml".into(), text: text.into(), folder: ".".into() };
    let set = [format!("colonies.steps={months}"), "view.enabled=false".into()];
    let overrides = Overrides { set: set.to_vec(), ..Overrides::default() };
    let text = source.text.replace("size = [80, 80]", "size = [32, 32]");
    Recipe::parse(RecipeSource { text, ..source }, overrides, &Registry::standard(), &Limits::default()).unwrap()
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn a_reef_leaves_its_census_its_pictures_and_a_mesh_for_each_colony() {
    let folder = tempfile::tempdir().unwrap();
    common::run(reef(30), folder.path());
    let census = text(&folder.path().join("census.csv"));
    let rows: Vec<Vec<&str>> = census.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!(rows.len(), 31);
    assert!(rows.iter().all(|r| r.len() == rows[0].len()));
    assert_eq!((rows[0][0], rows[1][0], rows[30][0]), ("month", "0", "29"));
    let last = |suffix: &str| -> usize {
        let of = rows[0].iter().zip(&rows[30]).filter(|(name, _)| name.ends_with(suffix));
        of.map(|(_, n)| n.parse::<usize>().unwrap()).sum()
    };
    assert!(text(&folder.path().join("cover.svg")).contains("Porites lobata"));
    let glb = std::fs::read(folder.path().join("corals.glb")).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let scene: serde_json::Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let nodes = scene["nodes"].as_array().unwrap();
    let corals: Vec<_> = nodes.iter().filter(|n| !n["extras"]["species"].is_null()).collect();
    assert!(corals.len() == last(".colonies") && corals.len() > 5, "{} nodes", corals.len());
    // A mesh each; all algae share one.
    let meshes: HashSet<u64> = corals.iter().map(|n| n["mesh"].as_u64().unwrap()).collect();
    assert_eq!(meshes.len(), corals.len());
    assert!(
        corals.iter().all(|n| n["extras"]["age_months"].as_u64().is_some() && n["extras"]["bleaching"].is_number())
    );
    for picture in ["dive.png", "above.png", "coral_cover_map.png"] {
        assert!(std::fs::metadata(folder.path().join(picture)).unwrap().len() > 2000, "{picture}");
    }
}

#[test]
fn a_stopped_reef_goes_on_to_the_same_bytes() {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let world = common::run(reef(24), whole.path());
    let options = RunOptions { out: Some(parts.path().into()), chunk: Some(1), paused: true, ..RunOptions::default() };
    let handle = Run::start(reef(24), options).unwrap();
    // The sea floor is a step as well.
    handle.send(Command::Step(12));
    let waits = |e: &Event| matches!(e, Event::Paused { recipe_step: 2, step } if *step > 5);
    while !waits(&handle.events().recv().unwrap()) {}
    handle.send(Command::Stop);
    assert!(!handle.join().unwrap().finished);
    let registry = Registry::standard();
    let outcome = Run::resume(parts.path(), &registry, RunOptions::default()).unwrap().join().unwrap();
    assert!(outcome.finished);
    assert_eq!(outcome.world.features, world.features);
    assert_eq!(outcome.fingerprint, world.fingerprint());
    for file in ["census.csv", "corals.glb", "plot.svg", "world.eyot"] {
        let [a, b] = [&whole, &parts].map(|f| std::fs::read(f.path().join(file)).unwrap());
        assert!(a == b, "{file} differs");
    }
}

#[test]
fn exports_of_corals_without_corals_are_told_and_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let text = "name = \"bare\"\n[grid]\nsize = [16, 16]\n[[step]]\ngenerate = \"fbm\"\n[view]\nenabled = false\n";
    let recipe = common::recipe(text, &["format = \"census\"", "format = \"corals\""]);
    let handle = Run::start(recipe, RunOptions { out: Some(folder.path().into()), ..RunOptions::default() }).unwrap();
    let warnings: Vec<String> = handle
        .events()
        .iter()
        .filter_map(|e| if let Event::Warning { message } = e { Some(message) } else { None })
        .collect();
    handle.join().unwrap();
    assert!(warnings.iter().any(|w| w.contains("census.csv")), "{warnings:?}");
    assert!(!folder.path().join("census.csv").exists() && !folder.path().join("corals.glb").exists());
}
