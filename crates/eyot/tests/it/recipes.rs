//! The built-in recipes make the land that they promise: statistics against goldens, and what must hold of any of them.
//!
//! After a recipe was changed on purpose, `EYOT_UPDATE_GOLDENS=1 cargo test -p eyot --test it recipes` writes the goldens
//! anew; look at the difference before it is committed.

use eyot::{Limits, Overrides, RECIPES, Recipe, RecipeSource, Registry, Run, RunOptions, World};
use eyot_land::analyse::{TerrainOptions, terrain_stats};
use serde_json::{Map, Value, json};
use std::path::PathBuf;

/// How far a measure may be from its golden: the larger of a share of the golden and an amount in its own unit. The
/// recipes are deterministic, so that these only say which changes of the engine are too small to need a look.
const TOLERANCES: &[(&str, f64, f64)] = &[
    ("land_share", 0.03, 0.002),
    ("relief_m", 0.03, 1.0),
    ("mean_m", 0.05, 1.0),
    ("hypsometric_integral", 0.05, 0.01),
    ("slope_mean_deg", 0.05, 0.2),
    ("pits_per_1000", 0.25, 1.0),
    ("depression_fraction", 0.25, 0.005),
    ("limestone_m3", 0.1, 1.0),
    ("reef_share", 0.1, 0.03),
    ("lagoon_share", 0.2, 0.06),
    ("lagoon_m", 0.15, 0.5),
    ("centre_m", 0.15, 0.5),
];

/// A reef is limestone at least this thick whose top is at most this deep, m.
const REEF_M: f64 = 1.0;
const CREST_DEPTH_M: f64 = 6.0;
/// Shallower hollows behind a crest are no lagoon, m.
const LAGOON_M: f64 = 2.0;
/// Directions that a reef is looked for in.
const RAYS: u32 = 90;

fn run(name: &str, size: Option<(u32, Option<u32>)>, set: &[&str]) -> World {
    let recipe = RECIPES.iter().find(|r| r.name == name).expect("a built-in recipe");
    let source = RecipeSource { name: format!("{name}.toml"), text: recipe.text.into(), folder: ".".into() };
    let set = set.iter().map(|s| (*s).to_owned()).collect();
    let overrides = Overrides { size, set, ..Overrides::default() };
    let recipe = Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).expect("a sound recipe");
    let outcome = Run::start(recipe, RunOptions::default()).expect("a run").join().expect("an end");
    assert!(outcome.finished);
    outcome.world
}

/// What one meets on the way from the middle of the land to the rim.
struct Ray {
    /// The shallowest reef: its depth, m.
    crest_m: Option<f64>,
    /// How much deeper than a crest the sea between it and the land (or the middle) is, m.
    lagoon_m: f64,
}

fn rays(world: &World) -> Vec<Ray> {
    let height = &world.layer("height").unwrap().field;
    let stone = &world.layer("limestone").unwrap().field;
    let (w, h) = (height.width(), height.height());
    let depth = |x: usize, y: usize| world.sea_level_m - f64::from(height.get(x, y));
    let middle = (0.5 * w as f64, 0.5 * h as f64);
    (0..RAYS)
        .map(|k| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(RAYS)).sin_cos();
            let cells: Vec<(f64, f64)> = (0..w.min(h) / 2)
                .map(|r| ((middle.0 + r as f64 * cos) as usize, (middle.1 + r as f64 * sin) as usize))
                .map(|(x, y)| (depth(x, y), f64::from(stone.get(x, y))))
                .collect();
            // Land that the reef has made is part of the reef.
            let coast = cells.iter().rposition(|&(d, s)| d <= 0.0 && s < REEF_M).map_or(0, |i| i + 1);
            let reef = |&(d, s): &(f64, f64)| s >= REEF_M && d <= CREST_DEPTH_M;
            // From the rim inwards: water behind the shallowest crest so far that is deeper than it is a lagoon.
            let (mut crest_m, mut lagoon_m) = (None, 0.0_f64);
            for cell in cells[coast..].iter().rev() {
                if reef(cell) {
                    crest_m = Some(crest_m.map_or(cell.0, |c: f64| c.min(cell.0)));
                } else if let Some(c) = crest_m {
                    lagoon_m = lagoon_m.max(cell.0 - c.max(0.0));
                }
            }
            Ray { crest_m, lagoon_m }
        })
        .collect()
}

fn measures(world: &World) -> Map<String, Value> {
    let height = &world.layer("height").unwrap().field;
    let stats =
        terrain_stats(height, &world.grid, Some(world.sea_level_m), &TerrainOptions::default(), &Limits::default());
    let all = serde_json::to_value(stats.unwrap()).unwrap();
    let mut m = Map::new();
    for (name, ..) in TOLERANCES {
        if let Some(v) = all.get(name).filter(|v| !v.is_null()) {
            m.insert((*name).to_owned(), v.clone());
        }
    }
    if let Some(stone) = world.get("limestone") {
        let rays = rays(world);
        let share = |f: &dyn Fn(&Ray) -> bool| rays.iter().filter(|r| f(r)).count() as f64 / f64::from(RAYS);
        let lagoons: Vec<f64> = rays.iter().map(|r| r.lagoon_m).filter(|&d| d >= LAGOON_M).collect();
        let (w, h) = (height.width(), height.height());
        // How much deeper than the crests the middle is; of an island, how high it stands over them, negative.
        let crests: Vec<f64> = rays.iter().filter_map(|r| r.crest_m).collect();
        let mean = |v: &[f64]| if v.is_empty() { 0.0 } else { v.iter().sum::<f64>() / v.len() as f64 };
        let centre = world.sea_level_m - f64::from(height.get(w / 2, h / 2)) - mean(&crests);
        m.insert("limestone_m3".into(), json!(stone.sum() * world.grid.cell_area_m2()));
        m.insert("reef_share".into(), json!(share(&|r| r.crest_m.is_some())));
        m.insert("lagoon_share".into(), json!(share(&|r| r.lagoon_m >= LAGOON_M)));
        m.insert("lagoon_m".into(), json!(mean(&lagoons)));
        m.insert("centre_m".into(), json!(centre));
    }
    m
}

fn number(m: &Map<String, Value>, name: &str) -> f64 {
    m.get(name).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {name} in {m:?}"))
}

#[test]
fn built_in_recipes_make_the_land_they_promise() {
    let mut found = Map::new();
    // The others have measures and tests of their own: `own_rules.rs`, `climates.rs`, `corals.rs`, and those of the plates' crate.
    let others = ["world", "iceage", "locked", "earth", "pangaea", "reef", "reef-slope", "bleaching"];
    for recipe in RECIPES.iter().filter(|r| !r.text.contains("[[layer]]") && !others.contains(&r.name)) {
        // The size of a measured map is given, and nothing of it is grown: a few steps show that it runs.
        let world = match recipe.name {
            "real" => run("real", None, &["rain.steps=60"]),
            name => run(name, Some((128, None)), &[]),
        };
        found.insert(recipe.name.to_owned(), Value::Object(measures(&world)));
    }
    let of = |name: &str| found[name].as_object().unwrap();

    let island = of("island");
    assert!(number(island, "limestone_m3") > 0.0, "{island:?}");
    assert!(number(island, "lagoon_share") > 0.1, "no lagoon between reef and land: {island:?}");
    assert!(number(island, "land_share") > 0.05, "{island:?}");
    let atoll = of("atoll");
    assert!(number(atoll, "reef_share") > 0.8, "the ring has wide gaps: {atoll:?}");
    assert!(number(atoll, "centre_m") > 4.0, "the middle is not deeper than the ring: {atoll:?}");
    // Islets of sand, and nothing higher.
    assert!((0.002..0.15).contains(&number(atoll, "land_share")), "{atoll:?}");
    assert!((0.5..4.5).contains(&number(atoll, "relief_m")), "{atoll:?}");
    assert!(of("real").get("limestone_m3").is_none() && number(of("real"), "relief_m") > 100.0);

    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/goldens/recipes.json");
    if std::env::var_os("EYOT_UPDATE_GOLDENS").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, serde_json::to_string_pretty(&found).unwrap() + "\n").unwrap();
        return;
    }
    let goldens: Map<String, Value> = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    assert!(goldens.keys().eq(found.keys()), "other recipes than in {}", path.display());
    let mut wrong = Vec::new();
    for (recipe, golden) in &goldens {
        let (golden, found) = (golden.as_object().unwrap(), of(recipe));
        assert!(golden.keys().eq(found.keys()), "{recipe}: other measures than in {}", path.display());
        for (name, share, amount) in TOLERANCES.iter().filter(|t| golden.contains_key(t.0)) {
            let (want, is) = (number(golden, name), number(found, name));
            if (is - want).abs() > amount.max(share * want.abs()) {
                wrong.push(format!("{recipe}: {name} is {is}, the golden {want}"));
            }
        }
    }
    assert!(wrong.is_empty(), "EYOT_UPDATE_GOLDENS=1 accepts them:\n{}", wrong.join("\n"));
}

/// Another seed is another island, also after a little rain: the highest place is elsewhere and of another height.
#[test]
fn seeds_of_the_island_are_different_islands() {
    let tops: Vec<(usize, usize, f64)> = (1..=6)
        .map(|seed| {
            let seed = format!("seed={seed}");
            let world = run("island", Some((96, None)), &[&seed, "erosion.steps=30", "growth.steps=2"]);
            let z = &world.layer("height").unwrap().field;
            let cells = (0..96).flat_map(|y| (0..96).map(move |x| (x, y)));
            let (x, y) = cells.max_by(|a, b| z.get(a.0, a.1).total_cmp(&z.get(b.0, b.1))).unwrap();
            (x, y, f64::from(z.get(x, y)) - world.sea_level_m)
        })
        .collect();
    let apart = |of: &dyn Fn(&(usize, usize, f64)) -> f64| {
        tops.iter().map(of).fold(f64::MIN, f64::max) - tops.iter().map(of).fold(f64::MAX, f64::min)
    };
    assert!(apart(&|t| t.0 as f64) + apart(&|t| t.1 as f64) > 20.0, "{tops:?}");
    assert!(apart(&|t| t.2) > 100.0, "{tops:?}");
}
