//! Windows of any height make the world that a run in one piece makes.

use super::StreamedWorld;
use super::stages::Stages;
use crate::{Clock, Host, Run, RunOptions, Stream};
use eyot_core::process::{Around, Entry, Generator, Reach, Site};
use eyot_core::{Cancel, Control, Field, Limits, Result};
use eyot_recipe::{Overrides, Recipe, RecipeSource, Registry};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How far the height of a cell is below that of its neighbours in the north and south: reads a layer beside its base, and
/// rows beyond the window.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Dent {}

impl Generator for Dent {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        let height = Around::new(site, Reach::Rows(1), &site.world.layer("height")?.field)?;
        let wrap = site.grid.rim.y == eyot_core::Edge::Wrap;
        let (n, rows) = (site.grid.height, site.rows.clone());
        Ok(Field::from_fn(site.grid.width, rows.len(), |x, y| {
            let y = rows.start + y;
            let north = if wrap { (y + n - 1) % n } else { y.saturating_sub(1) };
            let south = if wrap { (y + 1) % n } else { (y + 1).min(n - 1) };
            (height.row(north)[x] + height.row(south)[x] - 2.0 * height.row(y)[x]).clamp(0.0, 1.0)
        }))
    }

    fn reach(&self, _grid: &eyot_core::Grid) -> Reach {
        Reach::Rows(1)
    }

    fn reads(&self) -> Vec<&str> {
        vec!["height"]
    }
}

static DENT: Entry<dyn Generator> = Entry::<dyn Generator>::generator::<Dent>("dent", "Dents of the height.", &[]);

fn standard() -> Registry {
    Registry::new(eyot_land::generate::GENERATORS, &[])
}

/// Every kind of dependence: filters one after the other, a mask that was made from the height of then, a layer that is
/// read, merges that need the old value, the new one, and the highest of all.
fn recipe(rim: &str) -> Recipe {
    let text = format!(
        r#"
        name = "Layers"
        sea_level = -20.0
        [grid]
        size = [70, 190]
        cell = [9.0, 11.0]
        rim = {rim}
        [[step]]
        generate = "fbm"
        [[step]]
        generate = "dent"
        layer = "dents"
        [[step]]
        generate = "smooth"
        sigma_m = 40.0
        mask = "dents"
        [[step]]
        generate = "ramp"
        layer = "dents"
        merge = "lerp"
        amount = 0.25
        [[step]]
        generate = "ridged"
        merge = "power"
        amount = 0.7
        [[step]]
        generate = "warp"
        strength = 0.05
        mask = "dents"
        [[step]]
        generate = "constant"
        enabled = false
        [[step]]
        generate = "cone"
        merge = "max"
        [[step]]
        generate = "smooth"
        kernel = "binomial"
        passes = 3
        "#
    );
    let mut registry = standard();
    registry.add(&DENT);
    let source = RecipeSource { name: "layers.toml".into(), text, folder: ".".into() };
    Recipe::parse(source, Overrides::default(), &registry, &Limits::default()).unwrap()
}

#[test]
fn bands_of_any_height_make_the_world_of_one_piece() {
    for rim in ["\"closed\"", "\"open\"", "\"wrap\"", "[\"closed\", \"wrap\"]"] {
        let recipe = recipe(rim);
        let options = RunOptions { stream: Stream::Never, ..RunOptions::default() };
        let whole =
            Run::start(recipe.clone(), options, &Host::new(&standard(), Clock::system())).unwrap().join().unwrap();
        for band in [1, 13, 64, 189, 190] {
            let control = Control::none();
            let mut world = StreamedWorld::new(&recipe, 0, &Cancel::default(), &control).unwrap();
            world.set_band(band);
            let survey = world.survey(&recipe).unwrap();
            assert_eq!(survey.fingerprint, whole.fingerprint, "bands of {band} rows, rim {rim}");
            // The grid is small enough for the overview to be the world itself.
            assert_eq!(survey.overview.layers(), whole.world.layers(), "bands of {band} rows, rim {rim}");
        }
    }
}

#[test]
fn rows_may_be_asked_for_in_any_order() {
    let recipe = recipe("\"wrap\"");
    let mut stages = Stages::new(&recipe.steps, recipe.grid, recipe.sea_level_m).unwrap();
    for (stage, _) in stages.below_tops() {
        stages.set_top(stage, 250.0);
    }
    let (width, target) = (recipe.grid.width, stages.layers()[0].1);
    let mut whole = vec![0.0; width * recipe.grid.height];
    stages.read(target, 0, &mut whole).unwrap();
    for first in [170, 150, 0, 188, 3, 4, 90] {
        let mut rows = vec![0.0; width * 2];
        stages.read(target, first, &mut rows).unwrap();
        assert_eq!(rows, whole[width * first..][..rows.len()], "from row {first}");
    }
}

#[test]
fn what_windows_hold_is_what_the_plan_says() {
    // Two rows of 16 at a time of one step that only looks at its own cell: the window, and four times as much at work.
    let recipe = {
        let text = "[grid]\nsize = 16\n[[step]]\ngenerate = \"fbm\"";
        let source = RecipeSource { name: "small.toml".into(), text: text.into(), folder: ".".into() };
        Recipe::parse(source, Overrides::default(), &standard(), &Limits::default()).unwrap()
    };
    let mut stages = Stages::new(&recipe.steps, recipe.grid, 0.0).unwrap();
    assert_eq!(stages.rows_held(), 5 * 16);
    stages.band = 2;
    assert_eq!(stages.rows_held(), 5 * 2);
}
