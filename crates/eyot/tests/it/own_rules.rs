//! Layers and rules of a recipe's own, from the text to the files.

use crate::common;

use common::recipe;
use eyot::{
    Boundary, BoundaryCondition, Command, Control, Event, Field, Grid, JournalEntry, Limits, Overrides, RECIPES,
    Recipe, RecipeSource, Registry, Run, RunOptions, Work, World, store,
};
use eyot_core::engine::CpuEngine;
use eyot_core::process::{Scheduled, Span};
use std::path::Path;

/// A small recipe with everything that a layer and a rule may have.
const OWN: &str = r#"
name = "Own"
seed = 3
sea_level = 20.0
[grid]
size = [40, 24]
cell = 10.0
rim = "closed"

[[layer]]
name = "soil"
unit = "m"
range = [0, 0.5]
start = "0.1 + 0.001 * max(height, 0)"
next = "soil + gain * mean4(damp) - 0.05 * max(slope(height) - 0.5, 0)"
mask = "height > sea_level"
every = 2
parameters = { gain = 0.05 }

[[layer]]
name = "damp"
start = "random()"
next = "clamp(0.9 * damp + step(0.01, water) * 0.1 + 0.02 * (random() - 0.5), 0, 1)"

[[rule]]
name = "seep"
set.water = "water - share * min(water, soil)"
parameters = { share = 0.1 }

[[step]]
generate = "cone"
height = 90.0
[[step]]
name = "time"
simulate = ["hydraulic", "damp", "soil", "seep"]
steps = 30
soil.gain = 0.08

[view]
enabled = false
"#;

fn parse(text: &str, set: &[&str]) -> Result<Recipe, String> {
    let overrides = Overrides { set: set.iter().map(|s| (*s).to_owned()).collect(), ..Overrides::default() };
    let source = RecipeSource { name: "own.toml".into(), text: text.to_owned(), folder: ".".into() };
    Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).map_err(|p| p.to_string())
}

fn refused(text: &str, set: &[&str]) -> String {
    parse(text, set).err().unwrap_or_default()
}

/// What is said of the recipe with one piece of it replaced.
fn said(from: &str, to: &str) -> String {
    assert!(OWN.contains(from), "{from}");
    refused(&OWN.replacen(from, to, 1), &[])
}

fn options(threads: usize, out: Option<&Path>) -> RunOptions {
    RunOptions { threads: Some(threads), out: out.map(Path::to_owned), ..RunOptions::default() }
}

fn end(recipe: Recipe, o: RunOptions) -> World {
    Run::start(recipe, o).unwrap().join().unwrap().world
}

#[test]
fn threads_and_chunks_do_not_change_a_byte() {
    let one = end(parse(OWN, &[]).unwrap(), options(1, None));
    let spec = |name: &str| one.layer(name).unwrap().spec.clone();
    assert_eq!((spec("soil").unit.as_ref(), spec("soil").range), ("m", (0.0, 0.5)));
    assert!(one.layer("soil").unwrap().field.min_max().1 > 0.2, "it grew");
    for (threads, chunk) in [(2, Some(1)), (3, Some(7)), (8, Some(1000))] {
        let o = RunOptions { chunk, ..options(threads, None) };
        assert_eq!(end(parse(OWN, &[]).unwrap(), o), one, "{threads} threads, {chunk:?}");
    }
}

#[test]
fn the_ledger_knows_what_a_rule_takes_and_clamps() {
    let world = end(parse(OWN, &[]).unwrap(), options(2, None));
    let amount = |name: &str| world.ledger.amount(name);
    assert!(amount("water.seep") < 0.0 && amount("soil.next") < 0.0 && amount("soil.clamped") > 0.0);
    let accounts: Vec<&str> = world.ledger.iter().map(|(n, _)| n).collect();
    let water = world.layer("water").unwrap().field.sum() * world.grid.cell_area_m2();
    let net = world.ledger.net("water");
    assert!((water - net).abs() < 1e-3 * net.abs().max(1.0), "{water} of {net} m3: {accounts:?}");
}

#[test]
fn a_stopped_and_changed_run_goes_on_and_replays() {
    let folder = tempfile::tempdir().unwrap();
    let o = RunOptions { paused: true, chunk: Some(4), ..options(2, Some(folder.path())) };
    let handle = Run::start(parse(OWN, &[]).unwrap(), o).unwrap();
    handle.send(Command::Step(12));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { .. }));
    common::wait_for(&handle, |e| matches!(e, Event::Paused { .. }));
    handle.send(Command::Change(eyot::Change::parse("seep.share=0.5").unwrap()));
    common::wait_for(&handle, |e| matches!(e, Event::Changed(_)));
    handle.send(Command::Change(eyot::Change::parse("seep.shar=0.5").unwrap()));
    common::wait_for(
        &handle,
        |e| matches!(e, Event::NotChanged { reason, .. } if reason.to_string().contains("did you mean `share`?")),
    );
    handle.send(Command::Stop);
    handle.join().unwrap();
    let touched = Run::resume(folder.path(), &Registry::standard(), options(1, None)).unwrap().join().unwrap();
    assert!(touched.finished);
    assert_eq!(touched.journal, [JournalEntry { recipe_step: 2, step: 11, set: "seep.share = 0.5".into() }]);
    let o = RunOptions { replay: touched.journal.clone(), ..options(3, None) };
    assert_eq!(end(parse(OWN, &[]).unwrap(), o), touched.world);
    assert_ne!(end(parse(OWN, &[]).unwrap(), options(2, None)), touched.world);
    // The saved world has the layers with all that the recipe says of them.
    let saved = store::open(folder.path(), &Limits::default()).unwrap().world;
    assert_eq!(saved, touched.world);
}

#[test]
fn flags_reach_layers_rules_and_their_parameters() {
    let usual = end(parse(OWN, &[]).unwrap(), options(2, None));
    for set in [
        "seep.share=0.7",
        "soil.gain=0",
        "damp.enabled=false",
        "soil.every=1",
        "layer.2.start=\"0.5\"",
        "layer.soil.next=\"soil\"",
        "rule.seep.mask=\"height > 50\"",
    ] {
        assert_ne!(end(parse(OWN, &[set]).unwrap(), options(2, None)), usual, "{set}");
    }
    assert!(refused(OWN, &["seep.share=wet"]).contains("must be a number"));
    assert!(refused(OWN, &["seep.shaer=1"]).contains("did you mean `share`?"));
}

/// Line and column of the character, and what would be right.
#[test]
fn mistakes_are_shown_where_they_are() {
    for (from, to, place, words) in [
        ("mean4(damp)", "mean4(dmap)", "own.toml:15:29", "did you mean `damp`?"),
        ("mean4(damp)", "maen4(damp)", "own.toml:15:23", "did you mean `mean4`?"),
        ("mean4(damp)", "mean4(damp, 2)", "own.toml:15:23", "takes 1 argument, not 2"),
        ("mean4(damp)", "damp[3, 0]", "own.toml:15:23", "looks 3 cells away"),
        ("soil + gain", "soil + slope(height) + gain", "own.toml:15:14", "m and 1 do not go together"),
        ("soil + gain", "(soil > 1) + gain", "own.toml:15:10", "condition where a number"),
        ("\"height > sea_level\"", "\"height\"", "own.toml:16:9", "number where a condition"),
        ("0.1 + 0.001", "0.1 + + 0.001 *", "own.toml:14:", "stands where a value"),
        ("0.1 + 0.001 * max(height, 0)", "0.1 + soil", "own.toml:14:16", "nothing is called `soil`"),
        ("water - share", "watre - share", "own.toml:27:14", "did you mean `water`?"),
        ("set.water", "set.watre", "own.toml:27:", "no layer `watre`"),
        ("[0, 0.5]", "[0.5, 0]", "own.toml:13:9", "the lower number first"),
        ("range = [0, 0.5]", "range = [0, 0.5]\nstrat = 1", "own.toml:14:1", "did you mean `start`?"),
        ("name = \"damp\"", "name = \"sediment\"", "own.toml:21:8", "comes with Eyot"),
        ("name = \"damp\"", "name = \"thermal\"", "own.toml:21:8", "there is a process or generator"),
        ("name = \"damp\"", "name = \"soil\"", "own.toml:21:8", "two layers or rules"),
        ("name = \"damp\"", "name = \"x\"", "own.toml:21:8", "`x` is known in expressions"),
        ("name = \"damp\"", "name = \"min\"", "own.toml:21:8", "`min` is a function in expressions"),
        ("name = \"damp\"", "name = \"random\"", "own.toml:21:8", "for example `own_random`"),
        ("name = \"damp\"", "name = \"if\"", "own.toml:21:8", "`if` is a function"),
        ("name = \"damp\"", "name = \"not\"", "own.toml:21:8", "is a word of expressions"),
        ("name = \"damp\"", "name = \"pi\"", "own.toml:21:8", "is a number in expressions"),
        ("name = \"damp\"", "name = \"time\"", "own.toml:21:8", "is kept for expressions of later versions"),
        ("name = \"damp\"", "name = \"lat\"", "own.toml:21:8", "is kept for expressions of later versions"),
        ("name = \"damp\"", "name = \"sea_level\"", "own.toml:21:8", "is known in expressions"),
        ("name = \"seep\"", "name = \"seed\"", "own.toml:26:8", "means something else"),
        ("unit = \"m\"", "unit = \"furlong\"", "own.toml:12:9", "there is no unit `furlong`"),
        ("unit = \"m\"", "unit = \"m^1e9\"", "own.toml:12:12", "symbols of a unit run together"),
        ("unit = \"m\"", "unit = \"kg/(m2)\"", "own.toml:12:12", "write symbols with powers"),
        ("gain = 0.05", "max = 0.05", "own.toml:18:16", "it is a function in expressions"),
        ("gain = 0.05", "gain = \"much\"", "own.toml:18:23", "must be a number"),
        ("gain = 0.05", "every = 0.05", "own.toml:18:16", "cannot be named \"every\""),
        ("\"soil\", \"seep\"]", "\"seep\"]", "own.toml:37:1", "`soil` is not simulated in this step"),
        ("\"damp\", ", "", "own.toml:21:8", "no step simulates `damp`"),
        ("\"seep\"]", "\"sepe\"]", "own.toml:35:42", "did you mean `seep`?"),
        ("soil.gain", "soil.gian", "own.toml:37:6", "did you mean `gain`?"),
        ("\"hydraulic\", ", "", "own.toml:23:", "`hydraulic` makes such a layer"),
    ] {
        let said = said(from, to);
        assert!(said.contains(place) && said.contains(words), "{from} -> {to}:\n{said}");
    }
    // All at once.
    let text = OWN.replace("mean4(damp)", "mean4(dmap)").replace("water - share", "watre - share");
    assert_eq!(refused(&text, &[]).matches("did you mean").count(), 2);
}

/// The processes of a recipe's first simulating step.
fn processes(name: &str) -> Vec<Scheduled> {
    let source = RecipeSource::builtin(name).unwrap();
    let r = Recipe::parse(source, Overrides::default(), &Registry::standard(), &Limits::default()).unwrap();
    let step = r.steps.iter().find_map(|s| if let Work::Simulate(w) = &s.work { Some(w) } else { None });
    step.unwrap().schedule().unwrap()
}

/// Lets a pattern live for some steps on a grid of 20 x 16 without rims.
fn live(pattern: &[&str], steps: u64) -> Vec<(usize, usize)> {
    let grid = Grid::new(20, 16, 1.0, Boundary::both(BoundaryCondition::Wrap), &Limits::default()).unwrap();
    let mut world = World::new(grid, 1);
    let play = processes("life");
    let spec = play[0].process.layers()[0].spec.clone();
    let at = |x: usize, y: usize| pattern.get(y).and_then(|row| row.as_bytes().get(x)) == Some(&b'#');
    let field = Field::from_fn(20, 16, |x, y| if at(x, y) { 1.0 } else { 0.0 });
    world.put(&spec, field).unwrap();
    CpuEngine::default().simulate(&mut world, &play, Span { from: 0, steps }, &Control::none()).unwrap();
    let field = &world.layer("alive").unwrap().field;
    let all = (0..16).flat_map(|y| (0..20).map(move |x| (x, y)));
    all.filter(|&(x, y)| field.get(x, y) == 1.0).collect()
}

#[test]
fn life_has_its_known_oscillators() {
    let patterns: [(&str, u64, &[&str]); 5] = [
        ("block", 1, &["", " ##", " ##"]),
        ("blinker", 2, &["", "", " ###"]),
        ("toad", 2, &["", "", "  ###", " ###"]),
        ("beacon", 2, &["", " ##", " ##", "   ##", "   ##"]),
        (
            "pulsar",
            3,
            &[
                "",
                "   ###   ###",
                "",
                " #    # #    #",
                " #    # #    #",
                " #    # #    #",
                "   ###   ###",
                "",
                "   ###   ###",
                " #    # #    #",
                " #    # #    #",
                " #    # #    #",
                "",
                "   ###   ###",
            ],
        ),
    ];
    for (name, period, pattern) in patterns {
        let start = live(pattern, 0);
        for step in 1..=2 * period {
            assert_eq!(live(pattern, step) == start, step % period == 0, "{name} after {step} steps");
        }
    }
}

/// A glider moves by a cell in both directions in four steps, also over the rims.
#[test]
fn a_glider_flies_around_the_grid() {
    let glider = ["", "  #", "   #", " ###"];
    let start = live(&glider, 0);
    for n in [1, 5, 16, 20, 80] {
        let mut moved: Vec<(usize, usize)> = start.iter().map(|(x, y)| ((x + n) % 20, (y + n) % 16)).collect();
        moved.sort_by_key(|&(x, y)| (y, x));
        assert_eq!(live(&glider, 4 * n as u64), moved, "after {} steps", 4 * n);
    }
}

fn built_in(name: &str, set: &[&str]) -> World {
    let text = RECIPES.iter().find(|r| r.name == name).unwrap().text;
    let set = set.iter().map(|s| (*s).to_owned()).collect();
    let overrides = Overrides { set, size: Some((96, None)), ..Overrides::default() };
    let source = RecipeSource { name: name.into(), text: text.to_owned(), folder: ".".into() };
    let r = Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).unwrap();
    end(r, options(2, None))
}

fn sum(world: &World, layer: &str) -> f64 {
    world.layer(layer).unwrap().field.sum()
}

#[test]
fn wildfires_burn_spread_with_the_wind_and_let_the_forest_grow_back() {
    let strikes = "fire.strikes=0.00005";
    let usual = built_in("wildfire", &[strikes, "years.steps=300"]);
    let land = usual.layer("height").unwrap().field.iter().filter(|h| f64::from(*h) > usual.sea_level_m).count();
    assert!(sum(&usual, "burnt") > 0.2 * land as f64, "{} of {land} cells burnt", sum(&usual, "burnt"));
    assert!(sum(&usual, "fuel") > 0.2 * land as f64, "it grows back");
    let wet = built_in("wildfire", &[strikes, "years.steps=300", "fire.spread=0.02"]);
    assert!(sum(&wet, "burnt") < 0.2 * sum(&usual, "burnt"), "a fire that does not spread");
    let sea = usual
        .layer("height")
        .unwrap()
        .field
        .iter()
        .zip(&usual.layer("burnt").unwrap().field.to_vec())
        .filter(|(h, b)| f64::from(*h) <= usual.sea_level_m && **b > 0.0)
        .count();
    assert_eq!(sea, 0, "the sea does not burn");
}

#[test]
fn plants_spread_where_nitrogen_is() {
    let world = built_in("nitrogen", &["growth.steps=200"]);
    let [n, p] = ["nitrogen", "vegetation"].map(|l| world.layer(l).unwrap().field.clone());
    assert!(p.sum() > 500.0 && n.min_max().0 >= 0.0 && p.min_max().1 <= 1.0, "{} {:?}", p.sum(), n.min_max());
    let none = built_in("nitrogen", &["growth.steps=200", "layer.nitrogen.start=0", "nitrogen.rain=0"]);
    assert!(sum(&none, "vegetation") < 0.3 * p.sum(), "nothing grows without it");
    assert!(world.ledger.amount("water.roots") < 0.0);
}

/// Exports and pictures take the recipe's own layers as any other.
#[test]
fn own_layers_are_exported() {
    let folder = tempfile::tempdir().unwrap();
    let export = "format = \"npy\"\nlayers = [\"soil\", \"damp\"]";
    let maps = "what = \"map\"\nlayers = [\"soil\"]";
    let world = common::run(recipe(OWN, &[export, maps]), folder.path());
    let (low, high) = common::raster(&folder.path().join("soil.npy")).field.min_max();
    assert_eq!((low, high), world.layer("soil").unwrap().field.min_max());
    let found = std::fs::read_dir(folder.path()).unwrap().filter_map(Result::ok);
    assert!(found.filter(|f| f.file_name().to_string_lossy().ends_with(".png")).count() == 1);
}

/// A value that is no number is none of the range either: the run says which layer, and where.
#[test]
fn a_value_that_is_no_number_ends_the_run() {
    // What reads it in the same step would be found first.
    let own = OWN.replace("min(water, soil)", "min(water, 0.001)");
    let text =
        own.replace("+ gain * mean4(damp)", "+ gain * mean4(damp) + 0 / max(abs(column - 20) + abs(row - 12), 0)");
    let error = Run::start(parse(&text, &[]).unwrap(), options(2, None)).unwrap().join().unwrap_err().to_string();
    assert!(error.contains("soil") && error.contains("column 20") && error.contains("row 12"), "{error}");
    // Of an expression in place of a parameter, too, which then is no number everywhere.
    let text = OWN
        .replace("soil.gain = 0.08", "thermal.rate = \"0.2 + 0 * (steps - 3) / (steps - 3)\"")
        .replace("simulate = [\"hydraulic\"", "simulate = [\"thermal\", \"hydraulic\"");
    let error = Run::start(parse(&text, &[]).unwrap(), options(2, None)).unwrap().join().unwrap_err().to_string();
    assert!(error.contains("height"), "{error}");
}
