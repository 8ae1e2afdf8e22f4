//! The recipe `reef`: colonies that live through a run, stop and go on, and the files they leave.

use crate::common;

use eyot::{Command, Event, Limits, Overrides, RECIPES, Recipe, RecipeSource, Registry, Run, RunOptions, World};
use eyot_core::component::Table;
use std::collections::HashSet;
use std::path::Path;

/// Four metres and so many months. Pictures take their time.
fn reef(months: u64, with_pictures: bool) -> Recipe {
    let text = RECIPES.iter().find(|r| r.name == "reef").unwrap().text;
    let source = RecipeSource { name: "reef.toml".into(), text: text.into(), folder: ".".into() };
    let set = [format!("colonies.steps={months}"), "view.enabled=false".into()];
    let overrides = Overrides { set: set.to_vec(), ..Overrides::default() };
    let text = source.text.replace("size = [80, 80]", "size = [32, 32]");
    let text =
        text + "[[export]]\nwhat = \"corals.colonies\"\n[[export]]\nwhat = \"corals.algae\"\nformat = \"parquet\"\n";
    let text = if with_pictures { text } else { text.replace("what = \"dive\"", "what = \"dive\"\nenabled = false") };
    Recipe::parse(RecipeSource { text, ..source }, overrides, &Registry::standard(), &Limits::default()).unwrap()
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn a_reef_leaves_its_census_its_pictures_and_a_mesh_for_each_colony() {
    let folder = tempfile::tempdir().unwrap();
    common::run(reef(30, true), folder.path());
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
    assert!(std::fs::read(folder.path().join("census.parquet")).unwrap().starts_with(b"PAR1"));
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
    let points = text(&folder.path().join("corals.colonies.csv"));
    let points: Vec<Vec<&str>> = points.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!(points[0], ["x", "y", "z", "id", "species", "age", "radius", "bleaching", "calcified"]);
    let ids: HashSet<u64> = points[1..].iter().map(|row| row[3].parse().unwrap()).collect();
    assert_eq!(ids, corals.iter().map(|n| n["extras"]["id"].as_u64().unwrap()).collect());
    assert!(std::fs::read(folder.path().join("corals.algae.parquet")).unwrap().starts_with(b"PAR1"));
    for picture in ["dive.png", "side.png", "above.png", "cover.png", "plot.png", "coral_cover_map.png"] {
        assert!(std::fs::metadata(folder.path().join(picture)).unwrap().len() > 2000, "{picture}");
    }
}

#[test]
fn a_stopped_reef_goes_on_to_the_same_bytes() {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let world = common::run(reef(24, false), whole.path());
    let options = RunOptions { out: Some(parts.path().into()), chunk: Some(1), paused: true, ..RunOptions::default() };
    let handle = Run::start(reef(24, false), options).unwrap();
    // The sea floor is a step as well.
    handle.send(Command::Step(12));
    let waits = |e: &Event| matches!(e, Event::Paused { recipe_step: 2, step } if *step > 5);
    while !waits(&handle.events().recv().unwrap()) {}
    handle.send(Command::Stop);
    assert!(!handle.join().unwrap().finished);
    let registry = Registry::standard();
    let outcome = Run::resume(parts.path(), &registry, RunOptions::default()).unwrap().join().unwrap();
    assert!(outcome.finished);
    assert_eq!(outcome.world.components, world.components);
    assert_eq!(outcome.fingerprint, world.fingerprint());
    for file in ["census.csv", "census.parquet", "corals.glb", "plot.svg", "world.eyot"] {
        let [a, b] = [&whole, &parts].map(|f| std::fs::read(f.path().join(file)).unwrap());
        assert!(a == b, "{file} differs");
    }
}

#[test]
fn exports_of_corals_without_corals_are_told_and_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let text = "name = \"bare\"\n[grid]\nsize = [16, 16]\n[[step]]\ngenerate = \"fbm\"\n[view]\nenabled = false\n";
    let recipe = common::recipe(text, &["what = \"census\"", "what = \"corals\""]);
    let handle = Run::start(recipe, RunOptions { out: Some(folder.path().into()), ..RunOptions::default() }).unwrap();
    let warnings: Vec<String> = handle
        .events()
        .iter()
        .filter_map(|e| if let Event::Warning { message } = e { Some(message.to_string()) } else { None })
        .collect();
    handle.join().unwrap();
    assert!(warnings.iter().any(|w| w.contains("census.csv")), "{warnings:?}");
    assert!(!folder.path().join("census.csv").exists() && !folder.path().join("corals.glb").exists());
}

/// A reef under the temperatures of `sea.csv` in `folder`, without pictures.
fn measured(folder: &Path, months: u64) -> Result<Recipe, String> {
    let text = format!(
        "name = \"m\"\n[grid]\nsize = [24, 24]\ncell = 0.25\n[[step]]\ngenerate = \"constant\"\nvalue = -5.0\n\
         [[step]]\nsimulate = [\"corals\"]\nsteps = {months}\ncorals.sea = \"measured\"\ncorals.temperatures = \"sea.csv\"\n\
         [[export]]\nwhat = \"census\"\n[view]\nenabled = false\n"
    );
    let source = RecipeSource { name: "m.toml".into(), text, folder: folder.into() };
    Recipe::parse(source, Overrides::default(), &Registry::standard(), &Limits::default()).map_err(|p| p.to_string())
}

#[test]
fn a_run_goes_on_with_the_series_that_it_began_with() {
    let folder = tempfile::tempdir().unwrap();
    let (sea, out) = (folder.path().join("sea.csv"), folder.path().join("out"));
    let series = |warmer: f32| -> String {
        (1..=12).map(|m| format!("2001-{m:02}; {}\n", 26.0 + warmer + 0.2 * m as f32)).collect()
    };
    assert!(measured(folder.path(), 3).err().unwrap().contains("no such file"));
    std::fs::write(&sea, "month;sst\n2001-01;27\n2001-02;hot\n").unwrap();
    let problem = measured(folder.path(), 3).err().unwrap();
    assert!(problem.contains("line 3") && problem.contains("hot"), "{problem}");
    std::fs::write(&sea, series(0.0)).unwrap();
    let whole = common::run(measured(folder.path(), 18).unwrap(), &folder.path().join("whole"));
    let options = RunOptions { out: Some(out.clone()), chunk: Some(1), paused: true, ..RunOptions::default() };
    let handle = Run::start(measured(folder.path(), 18).unwrap(), options).unwrap();
    handle.send(Command::Step(9));
    let waits = |e: &Event| matches!(e, Event::Paused { recipe_step: 2, step } if *step > 5);
    while !waits(&handle.events().recv().unwrap()) {}
    handle.send(Command::Stop);
    assert!(!handle.join().unwrap().finished);
    // Another sea, and then none: the run keeps its own.
    std::fs::write(&sea, series(4.0)).unwrap();
    let other = common::run(measured(folder.path(), 18).unwrap(), &folder.path().join("other"));
    let census = |world: &World| world.components.get::<Table>("corals.census").unwrap().unwrap().clone();
    assert_ne!(census(&other), census(&whole));
    std::fs::remove_file(&sea).unwrap();
    let outcome = Run::resume(&out, &Registry::standard(), RunOptions::default()).unwrap().join().unwrap();
    assert!(outcome.finished);
    assert_eq!(outcome.world.components, whole.components);
}

#[test]
fn a_slope_of_the_island_has_its_colonies_where_rock_and_light_are() {
    let folder = tempfile::tempdir().unwrap();
    let text = RECIPES.iter().find(|r| r.name == "reef-slope").unwrap().text;
    // Pictures of thousands of bodies take their time; `.ci/run` makes them.
    let text = text.replace("what = \"dive\"", "what = \"plots\"\nprefix = \"again_\"");
    let source = RecipeSource { name: "slope.toml".into(), text, folder: ".".into() };
    let set = ["colonies.steps=14".to_owned()];
    let overrides = Overrides { set: set.to_vec(), size: Some((200, None)), ..Overrides::default() };
    let recipe = Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).unwrap();
    assert_eq!((recipe.grid.width, recipe.grid.height, recipe.grid.cell_x_m), (200, 60, 1.0));
    let world = common::run(recipe, folder.path());
    let [height, substrate, cover] = ["height", "substrate", "coral_cover"].map(|l| &world.layer(l).unwrap().field);
    // From the lagoon over the crest down to where light ends.
    let mean = |x: usize| (0..60).map(|y| height.get(x, y)).sum::<f32>() / 60.0;
    let crest = (0..200).max_by(|&a, &b| mean(a).total_cmp(&mean(b))).unwrap();
    assert!((30..80).contains(&crest) && mean(crest) < 0.5 && mean(0) < mean(crest) - 3.0, "{crest} {}", mean(crest));
    assert!(mean(199) < -25.0 && mean(crest + 25) < mean(crest) - 8.0, "{} {}", mean(199), mean(crest + 25));
    // Cover on rock is several times that on sand.
    let on = |rock: bool| {
        let cells = (0..200)
            .flat_map(|x| (0..60).map(move |y| (x, y)))
            .filter(|&(x, y)| if rock { substrate.get(x, y) > 0.9 } else { substrate.get(x, y) < 0.1 });
        let (sum, count) = cells.fold((0.0, 0), |(s, n), (x, y)| (s + cover.get(x, y), n + 1));
        assert!(count > 500, "{count} cells, rock: {rock}");
        sum / count as f32
    };
    assert!(on(true) > 2.5 * on(false), "{} {}", on(true), on(false));
}
