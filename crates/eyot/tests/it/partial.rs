//! What a recipe gives in part keeps the defaults of its place: nothing that is not given changes.

use crate::common;
use eyot::{Limits, Overrides, Recipe, Registry, Work};
use eyot_core::process::over;
use serde_json::{Value, json};

const HEAD: &str = "sea_level = 10\n[grid]\nsize = 16\ncell = 1\n[[step]]\ngenerate = \"constant\"\n[[step]]\nsimulate = [\"corals\"]\nsteps = 1\n";

fn parse(more: &str, set: &[&str]) -> Result<Recipe, String> {
    let overrides = Overrides { set: set.iter().map(|s| (*s).to_owned()).collect(), ..Overrides::default() };
    common::parse(&format!("{HEAD}{more}"), &[], overrides, &Limits::default())
}

/// The parameters of `corals` that are in force.
fn corals(more: &str, set: &[&str]) -> Value {
    let recipe = parse(more, set).unwrap();
    let Work::Simulate(s) = &recipe.steps[1].work else { panic!() };
    s.processes[0].in_force()
}

fn usual() -> Value {
    (Registry::standard().process("corals").unwrap().defaults)()
}

/// The usual parameters with other values at some places.
fn usual_but(changes: &[(&str, Value)]) -> Value {
    let mut all = usual();
    for (at, value) in changes {
        *all.pointer_mut(at).unwrap_or_else(|| panic!("there is no {at}")) = value.clone();
    }
    all
}

#[test]
fn large_disturbances_stay_large() {
    let expected = usual_but(&[("/large_disturbances/interval", json!(9))]);
    assert_eq!(corals("corals.large_disturbances.interval = 9", &[]), expected);
    assert_eq!(corals("corals.large_disturbances = { interval = 9 }", &[]), expected);
    assert_eq!(corals("", &["corals.large_disturbances.interval=9"]), expected);
}

#[test]
fn a_species_is_changed_by_its_name_and_stays_what_it_is() {
    let expected = usual_but(&[("/species/2/growth", json!(0.05))]);
    assert_eq!(expected["species"][2]["name"], "Acropora muricata");
    assert_eq!(corals("corals.species.\"Acropora muricata\".growth = 0.05", &[]), expected);
    assert_eq!(corals("", &["corals.species.\"Acropora muricata\".growth=0.05"]), expected);
    // A list says which species there are.
    let alone = corals("corals.species = [{ name = \"Acropora muricata\", growth = 0.05 }]", &[]);
    assert_eq!(alone["species"], json!([expected["species"][2]]));
    // A change by flag meets the list of the recipe.
    let flagged = corals(
        "corals.species = [{ name = \"Acropora muricata\" }]",
        &["corals.species.\"Acropora muricata\".growth=0.05"],
    );
    assert_eq!(flagged["species"], alone["species"]);
    let nested = corals("corals.species.\"Acropora muricata\".body.height = 2.0", &[]);
    assert_eq!(nested, usual_but(&[("/species/2/body/height", json!(2.0))]));
}

#[test]
fn a_new_species_says_what_it_is_like() {
    let all = corals("corals.species.\"Acropora palmata\" = { like = \"Acropora muricata\", growth = 0.06 }", &[]);
    let mut palmata = usual()["species"][2].clone();
    palmata["name"] = json!("Acropora palmata");
    palmata["growth"] = json!(0.06);
    assert_eq!((all["species"].as_array().unwrap().len(), &all["species"][4]), (5, &palmata));
    let list =
        corals("corals.species = [{ name = \"Acropora palmata\", like = \"Acropora muricata\", growth = 0.06 }]", &[]);
    assert_eq!(list["species"], json!([palmata]));
    for (text, words) in [
        ("corals.species.\"Acropora muricatta\".growth = 0.05", "did you mean `Acropora muricata`?"),
        (
            "corals.species = [{ name = \"Acropora muricatta\", growth = 0.05 }]",
            "is new: say whose values it takes with `like`",
        ),
        ("corals.species.\"A b\" = { like = \"C d\" }", "`corals.species.A b.like` cannot be \"C d\""),
        ("corals.species.\"Acropora muricata\".growth = -1", "`corals.species.Acropora muricata.growth` is -1"),
        ("corals.species.\"Acropora muricata\".grwth = 1", "did you mean `growth`?"),
    ] {
        let said = parse(text, &[]).err().unwrap_or_else(|| panic!("{text} was taken"));
        assert!(said.contains(words), "{text}: {said}");
    }
    let said =
        parse("corals.species = [{ name = \"Porites lutea\" }]", &["corals.species.\"Acropora muricata\".growth=1"]);
    let said = said.err().unwrap();
    assert!(said.contains("`species` has no `Acropora muricata`") && said.contains("`Porites lutea`"), "{said}");
}

/// Every key of every table, at any depth, of everything that is registered.
#[test]
fn one_key_leaves_all_others_at_the_defaults_of_their_place() {
    let registry = Registry::standard();
    let (mut nested, mut wrong) = (0, Vec::new());
    let mut look = |name: &str, defaults: Value, schema: Value, taken: &dyn Fn(Value) -> Result<(), String>| {
        for (path, value) in leaves(&defaults) {
            // What a recipe gives: this value, and nothing else.
            let given = path.iter().rev().fold(value.clone(), |inner, key| json!({ key: inner }));
            match over(&defaults, given.clone()) {
                Ok(all) if all == defaults => {}
                other => wrong.push(format!("{name}.{}: {other:?}", path.join("."))),
            }
            if path.len() > 1 {
                nested += 1;
                if let Err(e) = taken(given) {
                    wrong.push(format!("{name}.{}: {e}", path.join(".")));
                }
                // The schema, which editors and `describe` show, says the same.
                let mut at = &schema;
                for key in &path {
                    let table = if at["anyOf"].is_array() { &at["anyOf"][1] } else { at };
                    at = &table["properties"][key];
                }
                if at["default"] != value {
                    wrong.push(format!("{name}.{}: the schema says {}", path.join("."), at["default"]));
                }
            }
        }
    };
    for e in registry.generators() {
        let taken = |given| (e.make)(given).map(drop).map_err(|e| e.to_string());
        look(e.name, (e.defaults)(), (e.schema)().to_value(), &taken);
    }
    for e in registry.processes() {
        let taken = |given| (e.make)(given).map(drop).map_err(|e| e.to_string());
        look(e.name, (e.defaults)(), (e.schema)().to_value(), &taken);
    }
    assert!(nested > 150 && wrong.is_empty(), "{nested}\n{}", wrong.join("\n"));
}

/// Paths and values; elements of a list of named tables by their names.
fn leaves(of: &Value) -> Vec<(Vec<String>, Value)> {
    let under = |key: &str, v: &Value| {
        let inner = leaves(v).into_iter();
        inner.map(|(path, v)| (std::iter::once(key.to_owned()).chain(path).collect(), v)).collect::<Vec<_>>()
    };
    match of {
        Value::Object(all) => all.iter().filter(|(_, v)| !v.is_null()).flat_map(|(key, v)| under(key, v)).collect(),
        Value::Array(all) if eyot_core::process::are_named(all) => {
            all.iter().flat_map(|v| under(v["name"].as_str().unwrap(), v)).collect()
        }
        _ => vec![(Vec::new(), of.clone())],
    }
}

/// What is printed as in force is a recipe, and the same one.
#[test]
fn the_recipe_in_force_is_the_recipe() {
    for text in eyot::RECIPES.iter().map(|r| r.text) {
        let recipe = common::recipe(text, &[]);
        let printed = recipe.effective_toml();
        let again = common::parse(&printed, &[], Overrides::default(), &Limits::default());
        let again = again.unwrap_or_else(|e| panic!("{}: {e}\n{printed}", recipe.name));
        assert_eq!(again.effective(), recipe.effective(), "{}", recipe.name);
        assert_eq!(
            (again.grid, again.seed, &again.exports, &again.view),
            (recipe.grid, recipe.seed, &recipe.exports, &recipe.view)
        );
        for (a, b) in again.steps.iter().zip(&recipe.steps) {
            match (&a.work, &b.work) {
                (Work::Generate(a), Work::Generate(b)) => {
                    assert_eq!(
                        (a.seed, a.merge, &a.layer, &a.mask, a.amount),
                        (b.seed, b.merge, &b.layer, &b.mask, b.amount)
                    );
                }
                (Work::Simulate(a), Work::Simulate(b)) => assert_eq!(a.steps, b.steps),
                _ => panic!("{}", recipe.name),
            }
        }
    }
    let recipe = parse("corals.large_disturbances.interval = 9", &["corals.turf.growth=0.1"]).unwrap();
    let text = recipe.effective_toml();
    for line in [
        "corals.large_disturbances.max_diameter = 10.0",
        "corals.large_disturbances.interval = 9",
        "corals.turf.growth = 0.1",
    ] {
        assert!(text.lines().any(|l| l == line), "{line}\n{text}");
    }
}
