//! Rock in recipes: materials of their own, what cannot be, and what was most likely not meant.

use eyot::{Limits, Overrides, Recipe, RecipeSource, Registry, Work};
use eyot_recipe::RecipeDoc;

/// A recipe on a small grid.
fn parse(steps: &str, set: &[&str]) -> Result<Recipe, String> {
    let text = format!("[grid]\nsize = 32\ncell = 10.0\n[[step]]\ngenerate = \"fbm\"\n{steps}");
    let source = RecipeSource { name: "rock.toml".into(), text, folder: ".".into() };
    let overrides = Overrides { set: set.iter().map(ToString::to_string).collect(), ..Overrides::default() };
    Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).map_err(|p| p.to_string())
}

/// A step of this name that lets these processes act, and what it says of them.
fn step(name: &str, processes: &[&str], more: &str) -> String {
    format!("[[step]]\nname = \"{name}\"\nsimulate = {processes:?}\nsteps = 2\n{more}\n")
}

fn doubts(steps: &[String]) -> Vec<String> {
    parse(&steps.concat(), &[]).unwrap().doubts().iter().map(ToString::to_string).collect()
}

/// One doubt with all of these words.
fn doubted(steps: &[String], words: &[&str]) {
    let said = doubts(steps);
    assert!(said.len() == 1 && words.iter().all(|w| said[0].contains(w)), "{said:?}, not {words:?}");
}

fn sound(steps: &[String]) {
    assert_eq!(doubts(steps), [""; 0]);
}

#[test]
fn what_acts_on_rock_alone_is_doubted_without_rock() {
    for process in ["rockfall", "soak"] {
        doubted(&[step("age", &[process], "")], &["step 2 (age)", process, "finds no rock"]);
        let soaked = if process == "soak" { "strata.soaked = true" } else { "" };
        sound(&[step("age", &["strata", process], soaked)]);
        // Rock of a step before is rock.
        sound(&[step("beds", &["strata"], ""), step("age", &[process], "")]);
        // Rock that a generator made is as good.
        let made = "[[step]]\ngenerate = \"constant\"\nlayer = \"rock_slope\"\nvalue = 1.0\n".to_owned();
        sound(&[made, step("age", &[process], "")]);
    }
    doubted(
        &[step("age", &["strata", "soak"], "")],
        &["no bed accounts for what `soak` softens", "strata.soaked = true"],
    );
    // New rock has to be there to harden: that is no doubt but an error.
    let refused = parse(&step("age", &["rock_cycle"], ""), &[]).err().unwrap();
    assert!(refused.contains("`rock_cycle` needs another layer: no step makes a layer `new_rock_1`"), "{refused}");
    sound(&[step("age", &["strata", "rock_cycle"], "strata.new_rock = true")]);
}

#[test]
fn uplift_beside_beds_is_doubted_unless_the_beds_rise() {
    let words = ["streampower.uplift", "say streampower.uplift = 0.0 and strata.uplift = 0.001"];
    doubted(&[step("age", &["streampower", "strata"], "streampower.uplift = 0.001")], &words);
    let usual = doubts(&[step("age", &["streampower", "strata"], "")]);
    assert!(usual.len() == 1 && usual[0].contains("streampower.uplift"), "the usual uplift counts, too: {usual:?}");
    sound(&[step("age", &["streampower", "strata"], "streampower.uplift = 0.0\nstrata.uplift = 0.001")]);
}

#[test]
fn beds_that_change_from_one_step_to_the_next_are_doubted() {
    let first = |more: &str| step("first", &["strata"], more);
    let second = |more: &str| step("second", &["strata"], more);
    sound(&[first("strata.new_rock = true"), second("strata.new_rock = true")]);
    // On, then off; off, then on is no loss.
    doubted(&[first("strata.new_rock = true"), second("")], &["step 3 (second)", "strata.new_rock is off here"]);
    sound(&[first(""), second("strata.new_rock = true")]);
    let beds = "strata.beds = [{ material = \"granite\", thickness = 9.0 }]";
    doubted(&[first(""), second(beds)], &["step 3 (second)", "not those of step 2 (first)"]);
    doubted(
        &[first(""), second("strata.materials.granite.talus = 50.0")],
        &["give both steps the same beds and materials"],
    );
    doubted(&[first(""), second("strata.repeat = true")], &["the beds are not those of"]);
    sound(&[first(beds), second(beds)]);
    // Where they lie counts when they are laid.
    doubted(&[first(""), second("strata.dip = 5.0")], &["strata.dip has no effect here"]);
    let two = "strata.top = 500.0\nstrata.regolith = 1.0";
    doubted(&[first(""), second(two)], &["strata.top, strata.regolith have no effect here"]);
}

#[test]
fn surfaces_without_layers_and_layers_without_surfaces_are_doubted() {
    let bed = |n: usize| format!("[[step]]\ngenerate = \"fbm\"\nlayer = \"bed_{n}\"\n");
    let beds = |count: usize, surfaces: &str| {
        let one = "{ material = \"granite\", thickness = 9.0 }";
        let more = format!("strata.surfaces = \"{surfaces}\"\nstrata.beds = [{}]", vec![one; count].join(", "));
        step("age", &["strata"], &more)
    };
    doubted(&[beds(3, "lower")], &["strata.surfaces reads `bed_1`, `bed_2`", "all beds are as thick everywhere"]);
    sound(&[bed(1), beds(3, "lower")]);
    doubted(&[bed(1), beds(3, "height")], &["`bed_2`", "lies at 0 m"]);
    sound(&[bed(1), bed(2), beds(3, "height")]);
    doubted(&[bed(1), beds(3, "flat")], &["nothing reads `bed_1`", "strata.surfaces = \"lower\""]);
}

/// The beds of a recipe with chalk.
const BEDS: &str =
    "strata.beds = [\n{ material = \"chalk\", thickness = 9.0 },\n{ material = \"granite\", thickness = 9.0 },\n]";

fn with_materials(tables: &str, more: &str, set: &[&str]) -> Result<Recipe, String> {
    parse(&format!("{}{tables}", step("age", &["strata"], &format!("{BEDS}\n{more}"))), set)
}

/// The materials in force in the last step, by name.
fn material(recipe: &Recipe, name: &str) -> serde_json::Value {
    let Work::Simulate(work) = &recipe.steps[1].work else { panic!("a step that simulates") };
    let all = work.processes[0].in_force()["materials"].clone();
    all.as_array().unwrap().iter().find(|m| m["name"] == name).unwrap_or_else(|| panic!("{name} in {all}")).clone()
}

fn near(value: &serde_json::Value, want: f64) -> bool {
    (value.as_f64().unwrap() - want).abs() < 1e-6 * want
}

#[test]
fn materials_of_a_recipe_are_known_to_every_step() {
    let full =
        "[[material]]\nname = \"chalk\"\ntalus = 55.0\nerodibility = 0.6\ndensity = 2200.0\ncolour = \"#f0f0e8\"\n";
    let r = with_materials(full, "", &[]).unwrap();
    let chalk = material(&r, "chalk");
    assert!(near(&chalk["talus"], 55.0) && near(&chalk["erodibility"], 0.6) && near(&chalk["density"], 2200.0));
    assert_eq!(chalk["colour"], "#f0f0e8");
    // As one that is there, with its other values; and one after one of the recipe's own.
    let like = "[[material]]\nname = \"chalk\"\nlike = \"limestone\"\ntalus = 50.0\n\
                [[material]]\nname = \"marl\"\nlike = \"chalk\"\nerodibility = 0.8\n";
    let r = with_materials(like, "", &[]).unwrap();
    assert!(near(&material(&r, "chalk")["erodibility"], 0.65) && near(&material(&r, "chalk")["talus"], 50.0));
    assert!(near(&material(&r, "marl")["talus"], 50.0) && near(&material(&r, "marl")["erodibility"], 0.8));
    // A change of one that is there; the step itself has the last word, and flags reach both.
    let change = format!("{full}[[material]]\nname = \"granite\"\ntalus = 80.0\n");
    let r = with_materials(&change, "strata.materials.chalk.talus = 44.0", &[]).unwrap();
    assert!(near(&material(&r, "granite")["talus"], 80.0) && near(&material(&r, "granite")["erodibility"], 0.05));
    assert!(near(&material(&r, "chalk")["talus"], 44.0) && near(&material(&r, "chalk")["density"], 2200.0));
    let r = with_materials(full, "", &["material.chalk.talus=33"]).unwrap();
    assert!(near(&material(&r, "chalk")["talus"], 33.0));
    // A list of a step's own keeps what it has, and knows the others.
    let list = "strata.materials = [{ name = \"granite\", talus = 66.0 }, { name = \"regolith\" }, { name = \"sand\" }, \
                { name = \"sandstone\" }, { name = \"limestone\" }, { name = \"schist\" }, { name = \"marble\" }]";
    let r = with_materials(&change, list, &[]).unwrap();
    assert!(near(&material(&r, "granite")["talus"], 66.0) && near(&material(&r, "chalk")["talus"], 55.0));
    // The recipe in force says the same, and documents keep it.
    let again = RecipeSource { name: "again".into(), text: r.effective_toml(), folder: ".".into() };
    let again = Recipe::parse(again, Overrides::default(), &Registry::standard(), &Limits::default()).unwrap();
    assert_eq!(material(&again, "chalk"), material(&r, "chalk"));
    let doc = RecipeDoc::parse(full).unwrap();
    let again = RecipeDoc::parse(&doc.to_toml()).unwrap();
    assert!(doc.materials[0].name == "chalk" && again == doc);
}

#[test]
fn materials_that_cannot_be_are_refused_at_their_place() {
    // The grid is lines 1 to 3, the ground 4 and 5, the step 6 to 14; tables begin in line 15.
    let refused = |tables: &str, place: &str, words: &[&str]| {
        let said = with_materials(tables, "", &[]).err().unwrap();
        let one = said.matches("rock.toml:").count() == 1;
        let told = one && said.starts_with(&format!("rock.toml:{place}")) && words.iter().all(|w| said.contains(w));
        assert!(told, "{said}\nnot {place} {words:?}");
    };
    let chalk = "[[material]]\nname = \"chalk\"\n";
    refused(
        chalk,
        "15:",
        &["the material \"chalk\" is new and lacks `talus`, `erodibility` and `density`", "like = \"NAME\""],
    );
    refused(&format!("{chalk}talus = 50.0\nerodibility = 0.5\n"), "15:", &["lacks `density`"]);
    refused(&format!("{chalk}like = \"limstone\"\n"), "17:8: ", &["there is not", "did you mean \"limestone\"?"]);
    refused(
        &format!("{chalk}like = \"limestone\"\ntalus = 95.0\n"),
        "18:9: ",
        &["`material.talus` is 95", "at most 89 degree"],
    );
    refused(
        &format!("{chalk}like = \"limestone\"\nsolubility = 0.5\n"),
        "18:1: ",
        &["`material` has no key `solubility`"],
    );
    refused(
        &format!("{chalk}like = \"sand\"\n{chalk}like = \"schist\"\n"),
        "19:8: ",
        &["two materials are named \"chalk\""],
    );
    refused(&format!("{chalk}like = \"sand\"\n[[material]]\ntalus = 5.0\n"), "18:", &["a material has no name"]);
    refused(&format!("{chalk}like = \"sand\"\ncolour = \"white\"\n"), "18:10: ", &["`white` is no colour"]);
    // One bracket on each side.
    let said = with_materials("[material]\nname = \"chalk\"\n", "", &[]).err().unwrap();
    assert!(said.contains("write [[material]] with two brackets"), "{said}");
    // Nobody has beds.
    let idle = parse(&format!("{chalk}like = \"sand\"\n"), &[]).err().unwrap();
    assert!(idle.contains("no step simulates `strata`"), "{idle}");
}

#[test]
fn beds_that_cannot_be_are_refused_at_their_place() {
    // Lines 1 to 5 as above; the step is 6 to 9, what it says of its beds begins in line 10.
    let refused = |more: &str, place: &str, words: &[&str]| {
        let said = parse(&step("age", &["strata"], more), &[]).err().unwrap();
        let one = said.matches("rock.toml:").count() == 1;
        let told = one && said.starts_with(&format!("rock.toml:{place}")) && words.iter().all(|w| said.contains(w));
        assert!(told, "{said}\nnot {place} {words:?}");
    };
    let beds = |last: &str| format!("strata.beds = [\n{{ material = \"sand\", thickness = 9.0 }},\n{last},\n]");
    refused(
        &beds("{ material = \"cheese\", thickness = 9.0 }"),
        "12:14: ",
        &["there is no material `cheese`", "regolith, sand"],
    );
    refused(
        &beds("{ material = \"sand\", thickness = 0.0 }"),
        "12:34: ",
        &["`strata.beds.thickness` is 0", "at least 0.01 m"],
    );
    refused(&beds("{ material = \"sand\", thickness = -4.0 }"), "12:34: ", &["is -4: it must be at least 0.01 m"]);
    refused(&beds("{ material = \"sand\" }"), "12:1: ", &["needs the key `thickness`"]);
    let many = beds(&vec!["{ material = \"sand\", thickness = 9.0 }"; 13].join(",\n"));
    refused(&many, "10:15: ", &["14 beds; there can be 1 to 13"]);
    refused("strata.beds = []", "10:15: ", &["0 beds; there can be 1 to 13"]);
    refused("strata.materials.granite.density = 5.0", "10:36: ", &["is 5: it must be at least 100 kg/m3"]);
    // Stages count with new rock and without.
    refused("strata.stages = [\"sand\"]", "10:17: ", &["1 material; new rock has 6 stages"]);
    let stages = |last: &str| {
        format!("strata.stages = [\"sand\", \"sandstone\", \"limestone\", \"schist\", \"marble\", \"{last}\"]")
    };
    refused(&stages("cheese"), "10:72: ", &["there is no material `cheese`"]);
    refused(&stages("sand"), "10:72: ", &["`sand` is a stage already"]);
    refused("strata.loose = \"mud\"", "10:16: ", &["there is no material `mud`"]);
}

#[test]
fn files_of_beds_have_the_size_of_the_grid() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, side: usize| {
        let values: Vec<u8> = (0..side * side).flat_map(|i| (i as f32 * 0.01).to_le_bytes()).collect();
        std::fs::write(folder.path().join(name), values).unwrap();
    };
    write("fits.r32", 32);
    write("small.r32", 16);
    let check = |file: &str, layer: &str, size: Option<(u32, Option<u32>)>| {
        let text = format!(
            "[grid]\nsize = 32\n[[step]]\ngenerate = \"fbm\"\n[[step]]\ngenerate = \"import\"\nfile = \"{file}\"\nlayer = \"{layer}\"\n{}",
            step("age", &["strata"], "strata.surfaces = \"height\"")
        );
        let source = RecipeSource { name: "beds.toml".into(), text, folder: folder.path().into() };
        let overrides = Overrides { size, ..Overrides::default() };
        Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).map(drop).map_err(|p| p.to_string())
    };
    check("fits.r32", "bed_1", None).unwrap();
    // A run in other cells than the recipe's takes its beds along.
    check("fits.r32", "bed_1", Some((64, None))).unwrap();
    let said = check("small.r32", "bed_1", None).err().unwrap();
    assert!(said.starts_with("beds.toml:7:8: the surface `bed_1` has 16 x 16 cells, the grid 32 x 32"), "{said}");
    assert!(said.matches("beds.toml:").count() == 1, "{said}");
    // Heights may be of any size.
    check("small.r32", "height", None).unwrap();
}
