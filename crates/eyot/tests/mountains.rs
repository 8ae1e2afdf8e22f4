//! The recipe `alps` makes land that drains as mountains do: targets between measured mountains, and far from any noise.
//!
//! Reference: five measured mountain maps with cells of 30 to 93 m, and the shares of landforms of the Jacksboro map.

use eyot::land::analyse::{TerrainOptions, TerrainStats, terrain_stats};
use eyot::{Limits, Overrides, RECIPES, Recipe, RecipeSource, Registry, Run, RunOptions};

/// Shares of flat, peak, ridge, shoulder, spur, slope, hollow, footslope, valley and pit on the Jacksboro map.
const JACKSBORO: [f64; 10] = [0.0, 0.032, 0.148, 0.004, 0.174, 0.313, 0.132, 0.008, 0.151, 0.038];

fn alps(size: u32, set: &[&str]) -> TerrainStats {
    let recipe = RECIPES.iter().find(|r| r.name == "alps").unwrap();
    let source = RecipeSource { name: "alps.toml".into(), text: recipe.text.into(), folder: ".".into() };
    let set = set.iter().map(|s| (*s).to_owned()).collect();
    let overrides = Overrides { size: Some((size, None)), set, ..Default::default() };
    let recipe = Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).unwrap();
    let world = Run::start(recipe, RunOptions::default()).unwrap().join().unwrap().world;
    let height = &world.layer("height").unwrap().field;
    terrain_stats(height, &world.grid, None, &TerrainOptions::default(), &Limits::default()).unwrap()
}

/// What any size must show, with the slack that few cells need.
fn check(s: &TerrainStats, share_slack: f64, ratio_slack: f64) {
    let mut wrong = Vec::new();
    let mut within = |name: &str, value: Option<f64>, low: f64, high: f64| {
        println!("{name:24} {value:.4?}   {low}..{high}");
        if !value.is_some_and(|v| (low..=high).contains(&v)) {
            wrong.push(format!("{name} is {value:?}, not within {low}..={high}"));
        }
    };
    within("depression_fraction", s.depression_fraction, 0.0, 0.02);
    within("fill_mean_m", s.fill_mean_m, 0.0, 0.1);
    within("fill_over_relief", s.fill_over_relief, 0.0, 3.4e-4);
    within("pits_per_1000", s.pits_per_1000, 0.0, 5.0);
    within("curvature_skew", s.curvature_skew, -0.8, -0.02);
    within("concavity", s.concavity, 0.35, 0.6);
    within("hypsometric_integral", s.hypsometric_integral, 0.2, 0.5);
    within("hack", s.hack, 0.5, 0.62);
    within("horton_bifurcation", s.horton_bifurcation, 3.5 - ratio_slack, 4.6 + ratio_slack);
    within("beta_2d", s.beta_2d, 3.3, 4.2);
    let names = ["flat", "peak", "ridge", "shoulder", "spur", "slope", "hollow", "footslope", "valley", "pit"];
    for ((name, share), real) in names.into_iter().zip(s.landforms.unwrap().to_array()).zip(JACKSBORO) {
        within(name, Some(share), (real - 0.05 - share_slack).max(0.0), real + 0.05 + share_slack);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A quarter of the area with the cells of the full map.
#[test]
fn alps_drain_as_mountains_do() {
    check(&alps(512, &["grid.cell=30"]), 0.02, 1.5);
}

/// Takes half a minute on two quiet cores.
#[test]
#[ignore = "slow: run with --ignored"]
fn alps_of_a_million_cells_meet_the_targets() {
    check(&alps(1024, &[]), 0.0, 0.0);
}
