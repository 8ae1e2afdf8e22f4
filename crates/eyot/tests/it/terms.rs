//! Parameters of processes as expressions: what they give, where they may stand, and what is said where they may not.

use eyot::{
    Command, EngineChoice, EngineOptions, Event, JournalEntry, Limits, Overrides, Recipe, RecipeSource, Registry, Run,
    RunError, RunOptions, Work, World, describe,
};
use eyot_core::conformance;
use eyot_core::reference::Reference;
use std::path::Path;
use std::time::Duration;

const HILLS: &str = r#"
name = "Hills"
seed = 4
[grid]
size = [48, 40]
cell = 10.0
rim = "open"

[[step]]
generate = "fbm"
amplitude = 120.0
[[step]]
name = "time"
simulate = ["hydraulic", "thermal"]
steps = 40
hydraulic.rain = 0.004
thermal.rate = 0.4

[view]
enabled = false
"#;

/// Made only where an expression reads it: what nothing needs is a mistake.
const MOSS: &str = r#"
[[layer]]
name = "moss"
unit = "1"
start = "random()"
"#;

const PLANET: &str = r#"
name = "Planet"
seed = 3
[grid]
size = [48, 24]
extent_m = [4e7, 2e7]
rim = ["wrap", "closed"]
[[step]]
generate = "fbm"
amplitude = 3000.0
[[step]]
simulate = ["wind", "temperature", "humidity", "water", "ice", "sand"]
steps = 60
[view]
enabled = false
"#;

/// Depth of the water in air of humidity 1, m; as `eyot_climate::units::AIR_WATER`.
const AIR_WATER: f64 = 0.0325;

fn parse(text: &str, set: &[&str]) -> Result<Recipe, String> {
    let overrides = Overrides { set: set.iter().map(|s| (*s).to_owned()).collect(), ..Overrides::default() };
    let reads = text.contains("moss") || set.iter().any(|s| s.contains("moss"));
    let moss = if reads && !text.contains(MOSS) { MOSS } else { "" };
    let source = RecipeSource { name: "hills.toml".into(), text: format!("{text}{moss}"), folder: ".".into() };
    Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).map_err(|p| p.to_string())
}

fn options(threads: usize, out: Option<&Path>) -> RunOptions {
    RunOptions { threads: Some(threads), out: out.map(Path::to_owned), ..RunOptions::default() }
}

/// Hills where an expression reads moss.
fn with_moss() -> String {
    HILLS.replace("thermal.rate = 0.4", "hydraulic.evaporation = \"0.02 + 0 * moss\"\nthermal.rate = 0.4")
}

fn end(text: &str, set: &[&str]) -> World {
    Run::start(parse(text, set).unwrap(), options(2, None)).unwrap().join().unwrap().world
}

#[test]
fn what_is_the_same_everywhere_gives_the_bytes_of_the_number() {
    let plain = end(HILLS, &[]);
    let moss = end(HILLS, &["hydraulic.rain=\"0.004 * moss\""]).layer("moss").unwrap().field.min_max();
    assert!(moss.0 < 0.1 && moss.1 > 0.9, "layers that expressions read are made, with their start values");
    for set in [
        // One number for all steps, and parameters that rules know in other forms.
        &["hydraulic.rain=\"0.002 * 2\"", "thermal.rate=\"0.4\""][..],
        // In the rule itself: the value is every cell's own.
        &["hydraulic.rain=\"0.004 + 0 * moss\""],
        &["hydraulic.rain=\"if(height > -1e9, 0.004, 0)\""],
    ] {
        let world = end(HILLS, set);
        for layer in plain.layers() {
            assert!(world.get(&layer.spec.name) == Some(&layer.field), "{set:?} changes {}", layer.spec.name);
        }
        assert_eq!(world.ledger, plain.ledger, "{set:?}");
    }
}

/// An expression of time is a number that changes by hand.
#[test]
fn an_expression_of_time_is_a_number_that_changes() {
    let timed = end(HILLS, &["hydraulic.rain=\"if(steps < 25, 0.004, 0.001)\"", "thermal.talus=\"10 + 1 * steps\""]);
    let mut replay: Vec<JournalEntry> = (0..40)
        .map(|step| JournalEntry { recipe_step: 2, step, set: format!("thermal.talus={}", 10 + step) })
        .collect();
    replay.insert(25, JournalEntry { recipe_step: 2, step: 25, set: "hydraulic.rain=0.001".into() });
    let o = RunOptions { replay, ..options(2, None) };
    let by_hand = Run::start(parse(HILLS, &[]).unwrap(), o).unwrap().join().unwrap().world;
    assert_eq!(timed, by_hand);
    assert_ne!(timed, end(HILLS, &["thermal.talus=\"10 + 1 * steps\""]));
}

/// Rules with expressions of layers, places, chance and neighbours in them, in several forms: the engine and the reference agree
/// to the bit, sums and what leaves over open rims within rounding.
#[test]
fn expressions_in_rules_give_what_the_reference_gives() {
    let set = [
        "hydraulic.rain=\"0.002 * (1 + moss) * step(0.2, u)\"",
        "hydraulic.evaporation=\"0.02 + 0.01 * mean4(moss)\"",
        "hydraulic.max_speed=\"5 + 2 * random()\"",
        "hydraulic.capacity=\"0.1 * (1 + v)\"",
    ];
    let r = parse(HILLS, &set).unwrap();
    let Work::Simulate(step) = &r.steps[1].work else { panic!() };
    let scheduled = step.schedule().unwrap();
    let no_moss = parse(HILLS, &["hydraulic.rain=0.002"]).unwrap();
    let Work::Simulate(plain) = &no_moss.steps[1].work else { panic!() };
    for rim in conformance::rims() {
        let start = |name: &str, random: f32| match name {
            "height" => 50.0 * random,
            "moss" => random,
            _ => 0.0,
        };
        let mut world = conformance::random_world((37, 21), rim, 5, &scheduled, &start).unwrap();
        let mut reference = Reference::<f32>::new(&world);
        let mut other = world.clone();
        let span = eyot_core::process::Span { from: 0, steps: 12 };
        let run = |world: &mut World, s: &[eyot_core::process::Scheduled]| {
            eyot_core::engine::CpuEngine::default().simulate(world, s, span, &eyot::Control::none()).unwrap();
        };
        run(&mut world, &scheduled);
        run(&mut other, &plain.schedule().unwrap());
        reference.simulate(&scheduled, 12);
        for layer in world.layers() {
            for (x, y) in (0..21).flat_map(|y| (0..37).map(move |x| (x, y))) {
                let (a, b) = (layer.field.get(x, y), reference.get(&layer.spec.name, x, y));
                assert_eq!(a.to_bits(), b.to_bits(), "{} at {x} {y}: {a} {b} on {rim:?}", layer.spec.name);
            }
        }
        assert_ne!(world.get("water"), other.get("water"));
        for (account, sum) in &reference.ledger {
            let own = world.ledger.amount(account);
            assert!((own - sum).abs() <= 1e-5 * sum.abs().max(1.0), "{account}: {own} {sum} on {rim:?}");
        }
        let water = world.layer("water").unwrap().field.sum() * world.grid.cell_area_m2();
        let net = world.ledger.net("water");
        assert!((water - net).abs() < 1e-4 * world.ledger.amount("water.rain"), "{water} {net} on {rim:?}");
    }
}

/// Rain falls where the expression says, and as much as it says.
#[test]
fn rain_falls_where_the_expression_says() {
    let flat = HILLS.replace("amplitude = 120.0", "amplitude = 0.0").replace("steps = 40", "steps = 1");
    let off = ["hydraulic.evaporation=0", "hydraulic.sea=false", "hydraulic.time_step=0.01"];
    let world = end(&flat, &[&off[..], &["hydraulic.rain=\"0.01 * (column + 1)\""]].concat());
    let water = &world.layer("water").unwrap().field;
    for x in 2..46 {
        let expected = 0.01 * 0.01 * (x as f32 + 1.0);
        assert!((water.get(x, 20) - expected).abs() < 1e-6, "{x}: {} instead of {expected}", water.get(x, 20));
    }
    // Values beyond the parameter's range are moved to its end: it is at most 1 m/s.
    let world = end(&flat, &[&off[..], &["hydraulic.rain=\"10 * (column - 20)\""]].concat());
    let water = &world.layer("water").unwrap().field;
    assert!(water.get(5, 20) == 0.0 && (water.get(40, 20) - 0.01).abs() < 1e-6, "{}", water.get(40, 20));
}

/// An expression that is the same in all cells gives the number's bytes, whatever the parameter is to its rules.
#[test]
fn every_parameter_that_takes_expressions_means_what_its_number_means() {
    // Cells whose sizes single precision knows: what is computed in double precision for all cells is then the same in each.
    let planet =
        PLANET.replace("[4e7, 2e7]", "[4.8e7, 2.4e7]").replace("\"sand\"]", "\"sand\", \"climate\", \"zones\"]");
    let planet = planet.replace("steps = 60", "steps = 8");
    let hills = HILLS.replace("\"thermal\"]", "\"thermal\", \"wetness\"]").replace("steps = 40", "steps = 8");
    let reef = HILLS.replace("\"hydraulic\", \"thermal\"]", "\"reef\"]").replace("steps = 40", "steps = 8");
    let reef = reef.replace("hydraulic.rain = 0.004", "").replace("thermal.rate = 0.4", "");
    let reef = reef.replace("seed = 4", "seed = 4\nsea_level = 20.0");
    let (mut tried, mut wrong) = (0, Vec::new());
    for (text, processes) in [
        (planet, &["wind", "temperature", "humidity", "water", "ice", "sand", "climate", "zones"][..]),
        (hills, &["hydraulic", "wetness"]),
        (reef, &["reef"]),
    ] {
        for process in processes {
            let description = describe(process, &Registry::standard()).unwrap();
            let takes = |p: &&eyot::ParameterInfo| p.expression == eyot::Expression::Cells;
            for p in description.parameters.iter().filter(takes) {
                let usual = p.default.as_f64().unwrap();
                let range = (p.minimum.unwrap_or(f64::MIN), p.maximum.unwrap_or(f64::MAX));
                let value = if usual == 0.0 { 0.1 } else { 1.25 * usual }.clamp(range.0, range.1);
                let number = format!("{process}.{}={value}", p.name);
                let cells = format!("{process}.{}=\"{value} + 0 * height\"", p.name);
                let [a, b] = [&number, &cells].map(|set| end(&text, &[set]));
                // Multiplied with what only double precision knows.
                let most = if p.name == "mixing" { 1e-5 } else { 0.0 };
                for layer in a.layers() {
                    let (low, high) = layer.field.min_max();
                    let other = b.get(&layer.spec.name).unwrap();
                    let worst = layer.field.iter().zip(other.iter()).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
                    if worst > most * (high - low) {
                        wrong.push(format!("{cells}: {} differs by {worst} of {low}..{high}", layer.spec.name));
                    }
                }
                tried += 1;
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(tried > 45, "{tried} parameters");
}

/// Whatever takes expressions from cell to cell makes and loses no matter by them.
#[test]
fn matter_is_conserved_whatever_the_expression() {
    let short = PLANET.replace("steps = 60", "steps = 30");
    for process in ["wind", "temperature", "humidity", "water", "ice", "sand"] {
        let description = describe(process, &Registry::standard()).unwrap();
        for p in description.parameters.iter().filter(|p| p.expression == eyot::Expression::Cells) {
            let usual = p.default.as_f64().unwrap();
            let usual = if usual == 0.0 { 1.0 } else { usual };
            let set = format!("{process}.{}=\"{usual} * (0.5 + random())\"", p.name);
            let world = end(&short, &[&set]);
            let volume = |name: &str| world.layer(name).unwrap().field.sum() * world.grid.cell_area_m2();
            for (layer, factor) in [("water", 1.0), ("ice", 1.0), ("sand", 1.0), ("humidity", AIR_WATER)] {
                let of = |(n, _): &(&str, &eyot_core::Account)| n.starts_with(&format!("{layer}."));
                let turnover: f64 = world.ledger.iter().filter(of).map(|(_, a)| a.amount.abs()).sum();
                let missing = (factor * volume(layer) - world.ledger.net(layer)).abs();
                assert!(
                    missing <= 1e-5 * turnover.max(1.0),
                    "{set}: {missing} of {turnover} m3 of {layer} unaccounted for"
                );
            }
        }
    }
}

#[test]
fn stopped_changed_and_resumed_runs_replay() {
    let text = HILLS.replace("hydraulic.rain = 0.004", "hydraulic.rain = \"0.002 * (1 + moss)\"");
    let folder = tempfile::tempdir().unwrap();
    let o = RunOptions { paused: true, chunk: Some(4), ..options(2, Some(folder.path())) };
    let handle = Run::start(parse(&text, &[]).unwrap(), o).unwrap();
    let wait = |wanted: &dyn Fn(&Event) -> bool| {
        while !wanted(&handle.events().recv_timeout(Duration::from_secs(60)).expect("the run went silent")) {}
    };
    handle.send(Command::Step(12));
    wait(&|e| matches!(e, Event::Paused { .. }));
    wait(&|e| matches!(e, Event::Paused { .. }));
    handle.send(Command::Stop);
    handle.join().unwrap();
    let resumed = Run::resume(folder.path(), &Registry::standard(), options(1, None)).unwrap().join().unwrap();
    assert!(resumed.finished);
    assert_eq!(resumed.world, end(&text, &[]));
    // A number by hand takes the place of the expression.
    let replay = vec![JournalEntry { recipe_step: 2, step: 0, set: "hydraulic.rain=0.004".into() }];
    let o = RunOptions { replay, ..options(2, None) };
    let by_hand = Run::start(parse(&text, &[]).unwrap(), o).unwrap().join().unwrap().world;
    assert_eq!(by_hand.get("water"), end(HILLS, &[]).get("water"));
}

/// What is set while a run is at work is what the recipe could have said: the same bytes, journaled as it was written, and made
/// again wherever the run goes on.
#[test]
fn expressions_set_by_hand_are_those_of_the_recipe() {
    let text = with_moss();
    let sets = ["hydraulic.rain=\"0.002 * (1 + moss) * step(0.2, u)\"", "thermal.talus=\"10 + 1 * steps\""];
    // As the journal has them.
    let entry = |set: &str| eyot::Change::parse(set).unwrap().to_string();
    let by_hand = |at: u64| sets.map(|set| JournalEntry { recipe_step: 2, step: at, set: entry(set) }).to_vec();
    let replayed = |threads: usize, replay: Vec<JournalEntry>| {
        let o = RunOptions { replay, ..options(threads, None) };
        Run::start(parse(&text, &[]).unwrap(), o).unwrap().join().unwrap().world
    };
    let whole = end(&text, &sets);
    assert_eq!(replayed(3, by_hand(0)), whole);
    assert_ne!(replayed(2, by_hand(12)), whole);

    let folder = tempfile::tempdir().unwrap();
    let o = RunOptions { paused: true, chunk: Some(4), ..options(2, Some(folder.path())) };
    let handle = Run::start(parse(&text, &[]).unwrap(), o).unwrap();
    let wait = |wanted: &dyn Fn(&Event) -> bool| {
        while !wanted(&handle.events().recv_timeout(Duration::from_secs(60)).expect("the run went silent")) {}
    };
    handle.send(Command::Step(12));
    wait(&|e| matches!(e, Event::Paused { .. }));
    wait(&|e| matches!(e, Event::Paused { .. }));
    for (set, place, words) in [
        ("hydraulic.rain=\"0.002 * mos\"", "1:27", "did you mean `moss`?"),
        ("hydraulic.rain=\"0.002 + height\"", "1:19", "the parameter `rain` in m/s"),
        ("hydraulic.rain=\"0.002 *\"", "1:26", "the text ends"),
        ("hydraulic.time_step=\"0.1 + 0.1 * moss\"", "1:23", "cannot differ from cell to cell"),
        ("thermal.talus=\"30 + 5 * moss\"", "1:17", "between two cells"),
    ] {
        handle.send(Command::Change(eyot::Change::parse(set).unwrap()));
        let told = std::cell::RefCell::new(String::new());
        wait(&|e| matches!(e, Event::NotChanged { reason, .. } if { told.replace(reason.to_string()); true }));
        let told = told.into_inner();
        assert!(told.contains(place) && told.contains(words), "{set}:\n{told}");
    }
    for set in sets {
        handle.send(Command::Change(eyot::Change::parse(set).unwrap()));
        wait(&|e| matches!(e, Event::Changed(_)));
    }
    handle.send(Command::Step(9));
    wait(&|e| matches!(e, Event::Paused { .. }));
    handle.send(Command::Stop);
    let stopped = handle.join().unwrap();
    let at = stopped.journal[0].step;
    assert!(at > 0 && stopped.journal == by_hand(at), "{:?}", stopped.journal);
    let resumed = Run::resume(folder.path(), &Registry::standard(), options(1, None)).unwrap().join().unwrap();
    assert_eq!(resumed.journal, stopped.journal);
    assert_eq!(resumed.world, replayed(3, by_hand(at)));
    // A number ends an expression, and another expression takes its place.
    let mut replay = by_hand(0);
    for (step, set) in [(5, "hydraulic.rain=0.004"), (9, sets[0]), (9, "thermal.talus=30.0")] {
        replay.push(JournalEntry { recipe_step: 2, step, set: set.into() });
    }
    let turned = replayed(2, replay);
    let timed = [
        "hydraulic.rain=\"if(steps < 5 or steps >= 9, 0.002 * (1 + moss) * step(0.2, u), 0.004)\"",
        "thermal.talus=\"if(steps < 9, 10 + 1 * steps, 30)\"",
    ];
    assert_eq!(turned.get("height"), end(&text, &timed).get("height"));
}

#[test]
fn graphics_cards_give_the_same_within_rounding() {
    for (text, set, tolerance) in [
        (
            HILLS,
            &["hydraulic.rain=\"0.002 * (1 + moss) * step(0.2, u)\"", "hydraulic.max_speed=\"5 + 2 * random()\""][..],
            1e-4,
        ),
        (PLANET, &["humidity.land_dry=\"0.5 + 0.5 * step(0, height)\"", "ice.melt=\"1 + v\""], 1e-3),
    ] {
        let engine = EngineOptions { choice: EngineChoice::Gpu, ..EngineOptions::default() };
        let o_gpu = || RunOptions { engine: Some(engine.clone()), ..options(2, None) };
        let gpu = match Run::start(parse(text, set).unwrap(), o_gpu()).unwrap().join() {
            Ok(outcome) => outcome.world,
            Err(RunError::Device(e))
                if std::env::var_os("EYOT_REQUIRE_GPU").is_none() && e.to_string().contains("no graphics") =>
            {
                eprintln!("skipped: {e}");
                return;
            }
            Err(e) => panic!("{e}"),
        };
        let (cpu, plain) = (end(text, set), end(text, &[]));
        // Set by hand at the beginning it is the same on the card, too.
        let replay = set.iter().map(|s| JournalEntry { recipe_step: 2, step: 0, set: (*s).to_owned() }).collect();
        let declared = if text == HILLS { with_moss() } else { text.to_owned() };
        let by_hand =
            Run::start(parse(&declared, &[]).unwrap(), RunOptions { replay, ..o_gpu() }).unwrap().join().unwrap();
        let recipe = Run::start(parse(&declared, set).unwrap(), o_gpu()).unwrap().join().unwrap();
        assert_eq!(by_hand.world, recipe.world);
        for name in ["water", if text == HILLS { "height" } else { "humidity" }] {
            let [a, b, p] = [&gpu, &cpu, &plain].map(|w| w.get(name).unwrap());
            let (low, high) = b.min_max();
            let worst =
                |a: &eyot::Field| a.iter().zip(b.iter()).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max) / (high - low);
            println!("{name}: {:.1e} between engines, {:.1e} from the plain one", worst(a), worst(p));
            assert!(worst(a) <= tolerance && worst(p) > tolerance, "{name}: {}", worst(a));
        }
    }
}

#[test]
fn mistakes_are_shown_where_they_are() {
    let said = |to: &str| parse(&(HILLS.replace("hydraulic.rain = 0.004", to) + MOSS), &[]).err().unwrap_or_default();
    for (to, place, words) in [
        ("hydraulic.rain = \"0.002 * mos\"", "hills.toml:16:27", "did you mean `moss`?"),
        ("hydraulic.rain = \"0.002 + height\"", "hills.toml:16:19", "the parameter `rain` in m/s"),
        ("hydraulic.rain = \"moss > 0\"", "hills.toml:16:19", "condition where a number"),
        ("hydraulic.rain = \"0.002 *\"", "hills.toml:16:", "the text ends"),
        (
            "hydraulic.time_step = \"0.1 + 0.1 * moss\"",
            "hills.toml:16:23",
            "`hydraulic.time_step` cannot differ from cell to cell",
        ),
        ("hydraulic.gravity = \"9.81 * (1 + moss)\"", "hills.toml:16:21", "can differ"),
        ("hydraulic.sea = \"moss > 0\"", "hills.toml:16:17", "must be"),
        ("thermal.talus = \"30 + 5 * moss\"", "hills.toml:16:17", "between two cells"),
        ("hydraulic.rain = \"0.002 * temperature\"", "hills.toml:16:27", "makes such a layer"),
    ] {
        let said = said(to);
        assert!(said.contains(place) && said.contains(words), "{to}:\n{said}");
    }
    let plates = HILLS
        .replace("cell = 10.0", "cell = 50000.0")
        .replace("\"hydraulic\", \"thermal\"]", "\"plates\"]")
        .replace("hydraulic.rain = 0.004", "plates.speed = \"0.01 * steps\"");
    let said = parse(&plates.replace("thermal.rate = 0.4", ""), &[]).err().unwrap_or_default();
    assert!(said.contains("hills.toml:16:16") && said.contains("more than rules of cells"), "{said}");
}

#[test]
fn describe_says_which_parameters_take_expressions() {
    let text = describe("hydraulic", &Registry::standard()).unwrap().to_string();
    let line =
        |name: &str| text.lines().find(|l| l.trim_start().starts_with(&format!("{name}  ["))).unwrap().to_owned();
    assert!(line("rain").ends_with("or an expression]"), "{}", line("rain"));
    assert!(line("time_step").ends_with("or an expression of time]"), "{}", line("time_step"));
    assert!(!line("sea").contains("expression"));
    let plates = describe("plates", &Registry::standard()).unwrap().to_string();
    assert!(!plates.contains("or an expression"));
}

/// Defaults that are tables are read by people, too.
#[test]
fn describe_prints_tables_line_by_line() {
    let text = describe("corals", &Registry::standard()).unwrap().to_string();
    let line = |start: &str| text.lines().find(|l| l.trim_start().starts_with(start)).unwrap_or_default();
    assert_eq!(line("species  ["), "  species  [a list of values or a table; default below]");
    assert_eq!(line("Porites lobata"), "        Porites lobata");
    assert!(line("form = massive, growth = 0.0116").starts_with("          form"), "{text}");
    assert!(line("cell = 1, growth = 0.05, shade = 0.9").len() > 30 && text.contains("body.shape = massive"), "{text}");
    assert!(!text.contains("{\"") && text.lines().all(|l| !l.trim_end().ends_with(" =")), "{text}");
    let defaults = text.split("# Equations").next().unwrap().lines().filter(|l| l.starts_with("        "));
    assert!(defaults.clone().count() > 40 && defaults.clone().all(|l| l.chars().count() <= 104), "{text}");
}
