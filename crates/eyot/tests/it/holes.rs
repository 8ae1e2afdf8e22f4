//! Cells of a height map without a value stay known as such from the file to the export, and what looks like them is doubted.

use crate::common;
use eyot::{Limits, Overrides, Recipe};
use std::path::{Path, PathBuf};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../eyot-io/tests/gis").join(name)
}

/// Takes grid and height from a file, rains on it, and exports the height.
fn text(name: &str, more: &str) -> String {
    let file = file(name).display().to_string().replace('\\', "/");
    format!(
        "sea_level = \"none\"\n[grid]\nfrom = \"{file}\"\n[[step]]\ngenerate = \"import\"\nfile = \"{file}\"\n{more}\n\
         [[step]]\nsimulate = [\"thermal\"]\nsteps = 5\n[[export]]\nformat = \"geotiff\"\n[view]\nenabled = false\n"
    )
}

fn recipe(name: &str, more: &str) -> Result<Recipe, String> {
    common::parse(&text(name, more), &[], Overrides::default(), &Limits::default())
}

/// The corner that all these files lack.
fn corner() -> Vec<bool> {
    (0..120).map(|i| i % 12 < 3 && i / 12 < 2).collect()
}

fn doubts(recipe: &Recipe) -> String {
    recipe.doubts().iter().map(|d| format!("{d}\n")).collect()
}

#[test]
fn what_a_mask_leaves_out_stays_empty_to_the_export() {
    let out = tempfile::tempdir().unwrap();
    let recipe = recipe("masked.tif", "").unwrap();
    assert!(doubts(&recipe).contains("6 cells") && doubts(&recipe).contains("exports leave them empty"));
    let world = common::run(recipe, out.path());
    let marks: Vec<bool> = world.layer("missing").unwrap().field.iter().map(|m| m > 0.5).collect();
    assert_eq!(marks, corner());
    assert_eq!(common::raster(&out.path().join("height.tif")).missing, Some(corner()));
    // The world that is kept knows it, too.
    let opened = eyot::store::open(out.path(), &Limits::default()).unwrap();
    assert!(opened.world.get("missing").is_some());
}

#[test]
fn numbers_that_usually_mark_missing_cells_are_doubted_until_something_is_said_of_them() {
    let silent = recipe("untagged.tif", "").unwrap();
    assert!(doubts(&silent).contains("add nodata = -9999"), "{}", doubts(&silent));
    let out = tempfile::tempdir().unwrap();
    let said = recipe("untagged.tif", "nodata = -9999").unwrap();
    assert!(!doubts(&said).contains("add nodata"), "{}", doubts(&said));
    common::run(said, out.path());
    assert_eq!(common::raster(&out.path().join("height.tif")).missing, Some(corner()));
    let refused = recipe("beyond.tif", "").err().unwrap();
    assert!(refused.contains("is no height") && refused.contains("nodata = -3.4028235e38"), "{refused}");
    assert!(recipe("beyond.tif", "nodata = -3.4028235e38").is_ok());
}

#[test]
fn one_of_several_bands_is_chosen() {
    let refused = recipe("bands.tif", "").err().unwrap();
    assert!(refused.contains("2 bands") && refused.contains("`band`"), "{refused}");
    assert!(recipe("bands.tif", "band = 3").err().unwrap().contains("choose one from 1 to 2"));
    let heights = |band: u32| {
        let out = tempfile::tempdir().unwrap();
        let text =
            text("bands.tif", &format!("band = {band}")).replace("steps = 5", "steps = 1\nthermal.enabled = false");
        common::run(common::recipe(&text, &[]), out.path()).layer("height").unwrap().field.min_max()
    };
    assert_eq!(heights(1), (7.0, 7.0));
    assert_eq!(heights(2), (100.0, 182.0));
}

#[test]
fn files_without_holes_leave_no_layer() {
    let out = tempfile::tempdir().unwrap();
    let recipe = recipe("bands.tif", "band = 2").unwrap();
    assert_eq!(doubts(&recipe), "");
    assert!(common::run(recipe, out.path()).get("missing").is_none());
}

/// Rain over land with a hole: what reaches it leaves, and the hole stays as it was; without `holes` it is land like other land.
#[test]
fn holes_are_an_open_rim() {
    let text = |processes: &str| {
        text("masked.tif", "").replace(
            "simulate = [\"thermal\"]\nsteps = 5",
            &format!("simulate = [{processes}]\nsteps = 60\nhydraulic.rain = 0.01\nthermal.talus = 5.0"),
        )
    };
    let run = |processes: &str, out: &Path| common::run(common::recipe(&text(processes), &[]), out);
    let out = tempfile::tempdir().unwrap();
    let start = run("\"thermal\", \"holes\", \"hydraulic\"", out.path()).layer("hole_floor").unwrap().field.clone();
    let world = run("\"hydraulic\", \"thermal\", \"holes\"", out.path());
    let field = |name: &str| world.layer(name).unwrap().field.to_vec();
    let [height, water, sediment, floor] = ["height", "water", "sediment", "hole_floor"].map(field);
    for i in (0..120).filter(|i| corner()[*i]) {
        assert_eq!((height[i], water[i], sediment[i]), (floor[i], 0.0, 0.0), "cell {i}");
    }
    // Ground and water are all accounted for.
    let area = world.grid.cell_area_m2();
    let sum = |v: &[f32]| v.iter().map(|v| f64::from(*v)).sum::<f64>() * area;
    let gained = sum(&height) + sum(&sediment) - sum(&start.to_vec());
    assert!(world.ledger.amount("ground.holes").abs() > 1e-3 * area, "{}", world.ledger.amount("ground.holes"));
    assert!((gained - world.ledger.net("ground")).abs() < 1e-3 * area, "{gained} {}", world.ledger.net("ground"));
    assert!((sum(&water) - world.ledger.net("water")).abs() < 1e-3 * sum(&water), "{}", world.ledger.net("water"));
    assert_eq!(common::raster(&out.path().join("height.tif")).missing, Some(corner()));
    // By choice they are land.
    let filled = run("\"hydraulic\", \"thermal\"", out.path());
    let wet = filled.layer("water").unwrap().field.to_vec();
    assert!((0..120).filter(|i| corner()[*i]).all(|i| wet[i] > 0.0));
    assert_eq!(common::raster(&out.path().join("height.tif")).missing, Some(corner()));
    let refused = common::parse(
        &text("\"holes\"")
            .replace("masked.tif", "bands.tif")
            .replace("[[step]]\nsimulate", "band = 2\n[[step]]\nsimulate"),
        &[],
        Overrides::default(),
        &Limits::default(),
    );
    assert!(refused.err().unwrap().contains("missing"));
}
