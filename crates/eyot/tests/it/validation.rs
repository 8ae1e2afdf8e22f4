//! What is wrong with a recipe is said at its place, with a remedy, and all of it at once.

use crate::stubs;

use eyot::{Limits, Overrides, Recipe, RecipeSource, Registry, Work};
use proptest::prelude::*;
use stubs::{GOOD, parse, registry, source};

/// Replaces one line of the good recipe and returns the complaints as text.
fn complaints(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "{from}");
    parse(&GOOD.replacen(from, to, 1), &[]).err().map(|p| p.to_string()).unwrap_or_default()
}

fn flag(set: &str) -> String {
    parse(GOOD, &[set]).err().map(|p| p.to_string()).unwrap_or_default()
}

#[test]
fn the_good_recipe_is_good() {
    let r = parse(GOOD, &[]).unwrap();
    assert_eq!((r.name.as_str(), r.seed, r.grid.width, r.grid.height, r.sea_level_m), ("Test", 5, 16, 12, 10.0));
    assert_eq!(r.steps.len(), 3);
    assert_eq!(r.steps[0].name, "base");
}

#[test]
fn an_unknown_key_is_shown_with_what_was_meant() {
    assert_eq!(
        complaints("hydraulic.rain = 0.1", "hydraulic.rian = 0.1"),
        "test.toml:15:11: `hydraulic` has no key `rian` (unknown key)\n  help: did you mean `rain`? It takes a number from 0 to 1 \
         (unit m/s, default 0.002): Water that falls in a second."
    );
}

#[test]
fn values_of_the_wrong_type_or_size_say_unit_and_range() {
    assert_eq!(
        complaints("hydraulic.rain = 0.1", "hydraulic.rain = 2"),
        "test.toml:15:18: `hydraulic.rain` is 2: it must be at most 1 m/s (out of range)\n  help: It takes a number from 0 to 1 \
         (unit m/s, default 0.002): Water that falls in a second."
    );
    assert!(complaints("height = 300.0", "height = \"high\"").starts_with(
        "test.toml:11:10: `noise.height` must be a number from 0 to 5000, not the text \"high\" (wrong type)"
    ));
    assert!(complaints("height = 300.0", "height = nan").contains("a finite number is needed"));
    assert!(complaints("cell = 5.0", "cell = -5.0").contains("`grid.cell` is -5: it must be at least"));
    assert!(complaints("size = [16, 12]", "size = [16, 12, 3]").contains("`grid.size` needs 2 values, not 3"));
    let said = complaints("seed = 5", "seed = -1");
    assert!(said.contains("`seed` is -1: it must be at least 0"), "{said}");
    assert!(complaints("seed = 5", "seed = 99999999999999999999").contains("seed"));
}

#[test]
fn every_kind_of_slip_has_its_answer() {
    let cases = [
        ("seed = 5", "sed = 5", "did you mean `seed`?"),
        ("[grid]", "[gird]", "did you mean `grid`?"),
        ("[[step]]", "[[steps]]", "did you mean `step`?"),
        (
            "generate = \"noise\"",
            "generate = \"nois\"",
            "there is no generator `nois` (unknown generator)\n  help: did you mean `noise`?",
        ),
        (
            "generate = \"noise\"",
            "generate = \"hydraulic\"",
            "`hydraulic` is a process: write simulate = [\"hydraulic\"]",
        ),
        (
            "generate = \"noise\"",
            "generat = \"noise\"",
            "step 1 does nothing (`generate` or `simulate` is missing)\n  help: did you mean `generate`?",
        ),
        (
            "simulate = [\"hydraulic\"]",
            "simulate = [\"hydralic\"]",
            "there is no process `hydralic` (unknown process)\n  help: did you mean `hydraulic`?",
        ),
        ("simulate = [\"hydraulic\"]", "simulate = [\"noise\"]", "`noise` is a generator"),
        ("simulate = [\"hydraulic\"]", "simulate = [\"hydraulic\", \"hydraulic\"]", "`hydraulic` is listed twice"),
        ("simulate = [\"hydraulic\"]", "simulate = []", "`simulate`"),
        ("simulate = [\"hydraulic\"]", "simulate = 7", "`step.simulate` must be a text in quotes or a list of texts"),
        ("hydraulic.rain = 0.1", "rain = 0.1", "write hydraulic.rain"),
        ("hydraulic.rain = 0.1", "hydraulic = 3", "`hydraulic` must be a table of parameters, not the number 3"),
        ("hydraulic.rain = 0.1", "hydraulic.every = 0", "`hydraulic.every` is 0: it must be at least 1"),
        (
            "hydraulic.rain = 0.1",
            "hydraulic.scheme = \"clasic\"",
            "did you mean \"classic\"? It may be `signed` or `classic`",
        ),
        ("hydraulic.rain = 0.1", "generate = \"noise\"", "a step either generates or simulates"),
        ("steps = 400", "steps = 0", "`step.steps` is 0: it must be at least 1"),
        ("steps = 400", "steps = 1.5", "must be a whole number"),
        ("steps = 400", "steps = 2_000_000_000", "exceed the limit of 1000000000"),
        ("name = \"base\"", "name = \"hydraulic\"", "a step cannot be named \"hydraulic\""),
        ("name = \"base\"", "name = \"12\"", "a step cannot be named \"12\""),
        ("layer = \"rough\"", "layer = \"Rough Layer\"", "a layer cannot be named \"Rough Layer\""),
        ("merge = \"max\"", "merge = \"mix\"", "did you mean \"max\"?"),
        (
            "merge = \"max\"",
            "mask = \"watr\"",
            "no step makes a layer `watr` (unknown layer)\n  help: did you mean `water`?",
        ),
        ("layers = [\"height\", \"rough\"]", "layers = [\"heigth\"]", "did you mean `height`?"),
        (
            "layers = [\"height\", \"rough\"]",
            "layers = [\"height\", \"height\"]",
            "two exports would write `height.r32`",
        ),
        ("layers = [\"height\", \"rough\"]", "prefix = \"../up\"", "cannot start a file name"),
        ("format = \"r32\"", "format = \"tif\"", "`export.format` cannot be \"tif\""),
        ("cell = 5.0", "cell = 5.0\nextent_m = 100", "both `cell` and `extent_m` are given"),
        ("cell = 5.0", "from = \"nothere.tif\"", "there is no such file"),
        ("size = [16, 12]", "", "the grid has no size"),
        ("size = [16, 12]", "size = 4000000", "a grid of 4000000 x 4000000"),
        ("size = [16, 12]", "size = 32000", "`max_memory`"),
        ("cell = 5.0", "cell = 5.0\ncell = 6.0", "not valid TOML: duplicate key"),
        ("cell = 5.0", "cell = ", "not valid TOML"),
        ("cell = 5.0", "rim = \"opne\"", "did you mean \"open\"?"),
        (
            "generate = \"noise\"\nheight = 300.0",
            "generate = \"flip\"",
            "changes a layer, but there is no layer `height` yet",
        ),
        ("generate = \"noise\"\nheight = 300.0", "generate = \"import\"", "`import` needs the key `file`"),
        (
            "generate = \"noise\"\nheight = 300.0",
            "generate = \"import\"\nfile = \"x/none.tif\"",
            "file names are relative to the recipe's folder",
        ),
        (
            "generate = \"noise\"\nheight = 300.0",
            "generate = \"import\"\nfile = \"builtin:none\"",
            "Eyot brings no height map `none`",
        ),
    ];
    for (from, to, answer) in cases {
        let said = complaints(from, to);
        assert!(said.contains(answer), "{to}\n  said: {said}\n  expected: {answer}");
        assert!(said.starts_with("test.toml:"), "{said}");
    }
}

#[test]
fn several_problems_come_in_one_go_in_the_order_of_the_text() {
    let text = GOOD
        .replace("seed = 5", "sed = 5")
        .replace("height = 300.0", "height = -1")
        .replace("steps = 400", "step = 400");
    let problems = parse(&text, &["grid.cel=3"]).err().unwrap();
    let lines: Vec<String> = problems
        .diagnostics
        .iter()
        .map(|d| d.span.as_ref().map_or("-".into(), |s| format!("{}:{}", s.source, problems.line_column(s).0)))
        .collect();
    assert_eq!(lines, ["0:3", "0:11", "0:14", "1:1"]);
}

#[test]
fn flags_change_the_document_before_it_is_checked() {
    let r = parse(
        GOOD,
        &[
            "seed=9",
            "grid.cell=2.5",
            "step.1.height=400",
            "hydraulic.rain=0.004",
            "hydraulic.every=3",
            "grid.rim=open",
            "view.size=[64, 32]",
        ],
    )
    .unwrap();
    assert_eq!((r.seed, r.grid.cell_x_m, r.view.size), (9, 2.5, [64, 32]));
    assert_eq!(r.grid.rim, eyot::Boundary::OPEN);
    match (&r.steps[0].work, &r.steps[1].work) {
        (Work::Generate(g), Work::Simulate(s)) => {
            assert_eq!(g.parameters["height"], 400);
            assert_eq!((s.processes[0].parameters["rain"].as_f64(), s.processes[0].every), (Some(0.004), 3));
        }
        _ => panic!("steps changed their kind"),
    }
    assert_eq!(parse(GOOD, &["base.height=7"]).unwrap().name, "Test");
    assert!(!parse(GOOD, &["step.base.enabled=false"]).unwrap().steps[0].enabled);
    assert_eq!(parse(GOOD, &["noise.height=7"]).unwrap().steps.len(), 3);
    // An extent by hand replaces the cell size of the recipe.
    assert_eq!(parse(GOOD, &["grid.extent_m=160"]).unwrap().grid.cell_x_m, 10.0);
}

#[test]
fn wrong_flags_are_named_with_what_was_meant() {
    assert_eq!(
        flag("hydraulic.rian=0.1"),
        "set:1:11: `hydraulic` has no key `rian` (unknown key)\n  help: did you mean `rain`? It takes a number from 0 to 1 \
         (unit m/s, default 0.002): Water that falls in a second."
    );
    for (set, answer) in [
        ("hydralic.rain=1", "did you mean `hydraulic`?"),
        ("step.7.height=1", "this recipe has no step `7` (not there)\n  help: it has 3, counted from 1"),
        ("step=3", "`step` alone cannot be set"),
        ("step.1=1", "write step.1.parameter=value"),
        ("base=3", "`base` alone cannot be set"),
        ("seed", "write key=value"),
        ("", "write key=value"),
        ("=3", "not valid TOML"),
        ("seed=1=2", "not valid TOML"),
        ("base.layer=time", "a layer cannot be named \"time\""),
        ("hydraulic.rain=lots", "nothing is called `lots` here"),
        ("base.height=lots", "must be a number"),
        ("flip.x=1", "no step of this recipe generates with `flip`"),
        ("view.azimut=3", "did you mean `azimuth`?"),
    ] {
        let said = flag(set);
        assert!(said.contains(answer), "{set}\n  said: {said}");
    }
}

#[test]
fn another_size_keeps_the_extent() {
    for (size, expected) in
        [((32, None), (32, 24)), ((8, None), (8, 6)), ((10, Some(20)), (10, 20)), ((1, None), (1, 1))]
    {
        let overrides = Overrides { size: Some(size), ..Overrides::default() };
        let r = Recipe::parse(source(GOOD), overrides, &registry(), &Limits::default()).unwrap();
        assert_eq!((r.grid.width, r.grid.height), expected);
        let (w_m, h_m) = r.grid.extent_m();
        assert!((w_m - 80.0).abs() < 1e-9 && (h_m - 60.0).abs() < 1e-9);
    }
}

#[test]
fn steps_have_seeds_of_their_own_and_a_fixed_seed_stays() {
    let seeds = |text: &str| -> Vec<u64> {
        parse(text, &[])
            .unwrap()
            .steps
            .iter()
            .filter_map(|s| if let Work::Generate(g) = &s.work { Some(g.seed) } else { None })
            .collect()
    };
    let a = seeds(GOOD);
    assert_ne!(a[0], a[1]);
    let pinned = GOOD.replace("layer = \"rough\"", "layer = \"rough\"\nseed = 3");
    let moved = pinned.replace("seed = 5", "seed = 6");
    assert_eq!(seeds(&pinned)[1], seeds(&moved)[1]);
    assert_ne!(seeds(&pinned)[0], seeds(&moved)[0]);
}

#[test]
fn the_built_in_recipes_are_sound() {
    for r in eyot::RECIPES {
        let source = eyot::RecipeSource::builtin(r.name).unwrap();
        let made = Recipe::parse(source, Overrides::default(), &eyot::Registry::standard(), &Limits::default());
        assert!(made.is_ok(), "{}", made.err().unwrap());
        assert!(!r.about().is_empty(), "{}", r.name);
    }
}

/// What a generator finds before anything runs stands at the parameter; layers that it looks at must exist.
#[test]
fn generators_check_their_parameters_before_they_run() {
    let problems = |step: &str| {
        let text = format!("[grid]\nsize = 16\n[[step]]\ngenerate = \"fbm\"\n[[step]]\n{step}");
        let made = Recipe::parse(source(&text), Overrides::default(), &eyot::Registry::standard(), &Limits::default());
        made.err().map(|p| p.to_string()).unwrap_or_default()
    };
    let said = problems("generate = \"remap\"\npoints = [[0.5, 0.0], [0.5, 1.0]]");
    assert!(said.contains("test.toml:7:10") && said.contains("must increase"), "{said}");
    let said = problems("generate = \"mask_slope\"\nlayer = \"rock\"\nof = \"hieght\"");
    assert!(said.contains("no step makes a layer `hieght`") && said.contains("did you mean `height`?"), "{said}");
    let said = problems("generate = \"ridged\"\nsharpnes = 3.0");
    assert!(said.contains("did you mean `sharpness`?"), "{said}");
    let said = problems("generate = \"ridged\"\noctaves = 99");
    assert!(said.contains("it must be at most 16"), "{said}");
    assert_eq!(problems("generate = \"mask_slope\"\nlayer = \"rock\"\nmerge = \"set\""), "");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    /// Cut, doubled and scrambled recipes give an answer, whatever it is.
    #[test]
    fn damaged_recipes_are_answered(at in 0..GOOD.len(), length in 0..40_usize, insert in "[\\[\\]{}=.\"'a-z0-9\\n #-]{0,6}") {
        let end = (at + length).min(GOOD.len());
        let text = format!("{}{insert}{}", &GOOD[..at], &GOOD[end..]);
        if let Err(problems) = parse(&text, &[]) {
            prop_assert!(!problems.diagnostics.is_empty());
            prop_assert!(!problems.to_string().is_empty());
        }
    }

    #[test]
    fn any_flag_is_answered(set in "[a-z0-9.=\"\\[\\]{}-]{0,20}") {
        if let Err(problems) = parse(GOOD, &[&set]) {
            prop_assert!(!problems.to_string().is_empty());
        }
    }
}

/// Steps after a wrong process are not blamed for the layers that it does not make.
#[test]
fn one_wrong_process_is_one_mistake() {
    let text = eyot::RECIPES.iter().find(|r| r.name == "pangaea").unwrap().text;
    let source = RecipeSource { name: "pangaea".into(), text: text.to_owned(), folder: ".".into() };
    let set = Overrides { set: vec!["plates.count=1000".into()], ..Overrides::default() };
    let problems = Recipe::parse(source, set, &Registry::standard(), &Limits::default()).err().unwrap();
    assert_eq!(problems.diagnostics.len(), 1, "{problems}");
    assert!(problems.to_string().contains("count"), "{problems}");
}

/// The processes of a world have one sun: a tilt or a year of one alone is refused at its place, with what is missing.
#[test]
fn one_sun_shines_on_all_processes() {
    let text = eyot::RECIPES.iter().find(|r| r.name == "world").unwrap().text;
    let parsed = |text: &str, set: &[&str]| {
        let source = RecipeSource { name: "world".into(), text: text.to_owned(), folder: ".".into() };
        let overrides = Overrides { set: set.iter().map(|s| (*s).to_owned()).collect(), ..Overrides::default() };
        Recipe::parse(source, overrides, &Registry::standard(), &Limits::default())
    };
    let one = parsed(text, &["temperature.tilt=0"]).err().unwrap();
    assert_eq!(one.diagnostics.len(), 1, "{one}");
    let told = one.to_string();
    assert!(told.contains("`temperature.tilt` is 0, but `wind.tilt` is 23.4"), "{told}");
    assert!(told.contains("write wind.tilt = 0 and climate.tilt = 0 as well"), "{told}");

    for set in ["temperature.tilt=\"0\"", "temperature.tilt=\"23.4 * steps / 100\""] {
        let one = parsed(text, &[set]).err().unwrap_or_else(|| panic!("{set}")).to_string();
        assert!(one.contains("but `wind.tilt` is 23.4"), "{one}");
    }
    let all = ["temperature", "wind", "climate"].map(|p| format!("{p}.tilt=\"10 + 0.01 * steps\""));
    assert!(parsed(text, &all.each_ref().map(String::as_str)).is_ok());

    let two = parsed(&text.replace("zones.every", "wind.year = 500.0\nclimate.year = 500.0\nzones.every"), &[])
        .err()
        .unwrap();
    let place = two.diagnostics[0].span.as_ref().unwrap();
    assert!(text.lines().nth(two.line_column(place).0 - 1).unwrap().starts_with("zones.every"), "{two}");
    assert!(two.to_string().contains("write temperature.year = 500 as well"), "{two}");

    assert!(parsed(text, &["temperature.tilt=0", "wind.tilt=0", "climate.tilt=0.0"]).is_ok());
    assert!(parsed(text, &["temperature.tilt=0", "wind.enabled=false", "climate.enabled=false"]).is_ok());
}

/// What comes from other languages, other systems and other programs.
#[test]
fn commas_backslashes_and_bases_are_answered_as_such() {
    let said = complaints("height = 300.0", "height = 0,5");
    assert!(said.contains("numbers have a decimal point: write 0.5"), "{said}");
    assert!(flag("base.height=-1,25").contains("write -1.25"));
    let said = complaints("cell = 5.0", "from = \"C:\\maps\\a.tif\"");
    assert!(said.contains("write the path as \"C:/maps/a.tif\""), "{said}");
    // Escapes that TOML knows: a tab in a name.
    for text in ["from = \"maps\\test.tif\"", "from = 'maps\\test.tif'"] {
        let recipe = GOOD.replacen("cell = 5.0", text, 1);
        let checked = Recipe::parse(source(&recipe), Overrides::default(), &Registry::standard(), &Limits::default());
        let said = checked.err().unwrap().to_string();
        assert!(said.contains("backslash") || said.contains("maps/test.tif") || cfg!(windows), "{said}");
    }
    let perlin = "[grid]\nsize = 8\n[[step]]\ngenerate = \"perlin\"\n";
    let checked = Recipe::parse(source(perlin), Overrides::default(), &Registry::standard(), &Limits::default());
    let said = checked.err().unwrap().to_string();
    assert!(said.contains("write generate = \"fbm\" and basis = \"perlin\""), "{said}");
}

#[test]
fn no_sea_has_a_word() {
    let r = parse(&GOOD.replacen("sea_level = 10.0", "sea_level = \"none\"", 1), &[]).unwrap();
    assert_eq!(r.sea_level_m, eyot::keys::NO_SEA_M);
    assert_eq!(eyot::keys::NO_SEA_M, f64::from(eyot_core::layer::known::HEIGHT.range.0));
    assert_eq!(parse(GOOD, &["sea_level=none"]).unwrap().sea_level_m, eyot::keys::NO_SEA_M);
    assert!(flag("sea_level=non").contains("did you mean \"none\"?"));
    assert!(flag("sea_level=99999").contains("at most 12000"));
}

#[test]
fn what_is_blind_to_rock_is_doubted() {
    let doubts = |processes: &str, more: &str| -> Vec<String> {
        let text = format!(
            "[grid]\nsize = [64, 64]\ncell = 10.0\n[[step]]\ngenerate = \"fbm\"\n[[step]]\nname = \"age\"\nsimulate = {processes}\n\
             steps = 5\n{more}"
        );
        let source = RecipeSource { name: "age.toml".into(), text, folder: ".".into() };
        let recipe = Recipe::parse(source, Overrides::default(), &Registry::standard(), &Limits::default()).unwrap();
        recipe.doubts().iter().map(ToString::to_string).collect()
    };
    let blind = doubts("[\"hydraulic\", \"strata\"]", "");
    assert_eq!(blind.len(), 1);
    assert!(blind[0].contains("step 2 (age)") && blind[0].contains("say hydraulic.by_rock = true"), "{}", blind[0]);
    assert!(doubts("[\"hydraulic\", \"strata\"]", "hydraulic.by_rock = true").is_empty());
    assert!(doubts("[\"hydraulic\"]", "").is_empty());
    let rockless = doubts("[\"hydraulic\"]", "hydraulic.by_rock = true");
    assert!(rockless.len() == 1 && rockless[0].contains("needs the layer `erodibility`"), "{rockless:?}");
    // Who needs the bedrock comes after who makes it.
    assert!(doubts("[\"strata\", \"rockfall\"]", "").is_empty());
    let early = doubts("[\"rockfall\", \"strata\"]", "");
    assert!(early.len() == 1 && early[0].contains("list `strata` before it"), "{early:?}");
}

#[test]
fn ground_that_no_step_makes_is_doubted() {
    assert!(parse(GOOD, &[]).unwrap().doubts().is_empty());
    let doubts = parse(GOOD, &["step.1.enabled=false"]).unwrap().doubts();
    assert_eq!(doubts.len(), 1);
    assert!(doubts[0].to_string().contains("step 2 (hydraulic) simulates `hydraulic` without ground"), "{}", doubts[0]);
    let sound = |name: &str| {
        let source = RecipeSource::builtin(name).unwrap();
        Recipe::parse(source, Overrides::default(), &Registry::standard(), &Limits::default()).unwrap().doubts()
    };
    for recipe in eyot::RECIPES {
        assert!(sound(recipe.name).is_empty(), "{}: {:?}", recipe.name, sound(recipe.name));
    }
}
