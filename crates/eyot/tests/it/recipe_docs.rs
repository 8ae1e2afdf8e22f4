//! Recipes that are built in code are the ones that are written.

use eyot::{
    Change, Export, ExportFormat, Limits, Overrides, RECIPES, Recipe, RecipeDoc, RecipeSource, Registry, Run,
    RunOptions, StepDoc,
};

#[test]
fn a_document_makes_the_recipe_that_its_text_makes() {
    let (registry, limits) = (Registry::standard(), Limits::default());
    for built_in in RECIPES {
        let source = RecipeSource::builtin(built_in.name).unwrap();
        let written = Recipe::parse(source, Overrides::default(), &registry, &limits).unwrap();
        let doc = RecipeDoc::parse(built_in.text).unwrap();
        let built = Recipe::check(&doc, Overrides::default(), &registry, &limits).unwrap();
        assert_eq!(built.grid, written.grid, "{}", built_in.name);
        assert_eq!((built.seed, built.sea_level_m), (written.seed, written.sea_level_m), "{}", built_in.name);
        assert_eq!((&built.exports, &built.view), (&written.exports, &written.view), "{}", built_in.name);
        assert_eq!(built.steps.len(), written.steps.len());
        for (a, b) in built.steps.iter().zip(&written.steps) {
            assert!(a.does_as(b), "{}, step {}", built_in.name, b.number);
        }
    }
}

#[test]
fn a_document_runs_like_its_text() {
    let doc = RecipeDoc::new("Hill")
        .seed(3)
        .square(24, 20.0)
        .step(StepDoc::generate("cone").set("height", 300.0))
        .step(StepDoc::simulate(["thermal"], 20).set("thermal.talus", 20.0));
    let (registry, limits) = (Registry::standard(), Limits::default());
    let run = |recipe| Run::start(recipe, RunOptions::default()).unwrap().join().unwrap().world.fingerprint();
    let built = run(Recipe::check(&doc, Overrides::default(), &registry, &limits).unwrap());
    let text = "name = 'Hill'\nseed = 3\ngrid = { size = 24, cell = 20 }\n[[step]]\ngenerate = 'cone'\nheight = 300\n\
                [[step]]\nsimulate = 'thermal'\nsteps = 20\n[step.thermal]\ntalus = 20\n";
    let source = RecipeSource { name: "hill".into(), text: text.into(), folder: ".".into() };
    assert_eq!(built, run(Recipe::parse(source, Overrides::default(), &registry, &limits).unwrap()));
}

#[test]
fn what_is_wrong_points_into_the_rendered_text() {
    let doc = RecipeDoc::new("Hill")
        .square(24, 20.0)
        .step(StepDoc::generate("cone").set("heigth", 300.0))
        .export(Export { format: Some(ExportFormat::Png16), range: Some([5.0, 1.0]), ..Export::default() });
    let problems = Recipe::check(&doc, Overrides::default(), &Registry::standard(), &Limits::default()).err().unwrap();
    let places: Vec<&str> = problems
        .diagnostics
        .iter()
        .map(|d| d.span.as_ref().map_or("", |s| &problems.source(s).unwrap().text[s.start..s.end]))
        .collect();
    assert_eq!(places, ["heigth", "[5.0, 1.0]"], "{problems}");
    assert_eq!(problems.sources[0].text, doc.to_toml());
}

#[test]
fn typed_changes_are_overrides() {
    let doc = RecipeDoc::new("Hill").square(24, 20.0).step(StepDoc::generate("cone"));
    let set = vec![Change::new("cone.height", 120.0).into(), Change::new("grid.size", vec![8, 12]).into()];
    let overrides = Overrides { set, ..Overrides::default() };
    let recipe = Recipe::check(&doc, overrides, &Registry::standard(), &Limits::default()).unwrap();
    assert_eq!((recipe.grid.width, recipe.grid.height), (8, 12));
    let eyot::Work::Generate(cone) = &recipe.steps[0].work else { panic!("a generating step") };
    assert_eq!(cone.parameters["height"], 120.0);
}
