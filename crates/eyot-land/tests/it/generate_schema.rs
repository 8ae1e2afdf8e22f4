//! Every generator says everything about its parameters, and holds users to it.
use eyot_core::process::Site;
use eyot_core::{Boundary, Control, Error, Field, Grid, Limits, World};
use eyot_land::generate::{Cone, GENERATORS};
use serde_json::{Value, json};

/// A world with this height.
fn of_height(grid: Grid, height: &Field) -> World {
    let mut world = World::new(grid, 1);
    world.put(&eyot_core::layer::known::HEIGHT, height.clone()).unwrap();
    world
}

fn is_numeric(rule: &Value) -> bool {
    let named = |t: &Value| t == "number" || t == "integer";
    named(&rule["type"]) || rule["type"].as_array().is_some_and(|a| a.iter().any(named))
}

#[test]
fn every_number_has_unit_range_and_meaning() {
    for entry in GENERATORS {
        let schema = (entry.schema)().to_value();
        let defaults = (entry.defaults)();
        assert_eq!(schema["additionalProperties"], false, "{} takes unknown parameters", entry.name);
        assert!(schema["description"].as_str().is_some_and(|d| !d.is_empty()), "{}", entry.name);
        for (field, rule) in schema["properties"].as_object().unwrap() {
            let name = format!("{}.{field}", entry.name);
            assert!(rule["description"].as_str().is_some_and(|d| d.len() > 8), "{name} has no meaning");
            let inner = if rule["items"].is_object() { &rule["items"] } else { rule };
            if !is_numeric(inner) {
                continue;
            }
            assert!(rule["unit"].as_str().is_some_and(|u| !u.is_empty()), "{name} has no unit");
            let (low, high) = (inner["minimum"].as_f64(), inner["maximum"].as_f64());
            let (low, high) =
                (low.unwrap_or_else(|| panic!("{name}: minimum")), high.unwrap_or_else(|| panic!("{name}: maximum")));
            let values = defaults[field].as_array().cloned().unwrap_or_else(|| vec![defaults[field].clone()]);
            for v in values {
                let v = v.as_f64().unwrap_or_else(|| panic!("{name} has no default"));
                assert!((low..=high).contains(&v), "{name} = {v} is outside {low}..={high}");
            }
        }
    }
}

#[test]
fn defaults_work_everywhere_and_unknown_names_do_not() {
    let sizes = [(1, 1), (1, 37), (53, 1), (17, 33), (64, 64)];
    for entry in GENERATORS {
        let made = (entry.make)((entry.defaults)()).unwrap();
        assert!((entry.make)(json!({})).is_ok());
        assert!((entry.make)(json!({ "no_such_parameter": 1.0 })).is_err(), "{}", entry.name);
        for (w, h) in sizes {
            for rim in [Boundary::CLOSED, Boundary::OPEN, Boundary::WRAP] {
                for cell_y_m in [10.0, 25.0] {
                    let grid = Grid { width: w, height: h, cell_x_m: 10.0, cell_y_m, rim };
                    let grid = grid.checked(&Limits::default()).unwrap();
                    let base = Field::from_fn(w, h, |x, y| ((x * 7 + y * 13) % 11) as f32);
                    let (world, control) = (of_height(grid, &base), Control::none());
                    let site = Site::whole(grid, 1, &world, &control);
                    let field = made.generate(&site, &base).unwrap();
                    assert_eq!((field.width(), field.height()), (w, h));
                    assert_eq!(field.find_not_finite(), None, "{} on {w}x{h}", entry.name);
                }
            }
        }
    }
}

#[test]
fn generators_chain_in_any_order() {
    let grid = Grid::new(48, 32, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
    let (flat, control) = (Field::new(48, 32, 0.0), Control::none());
    for first in GENERATORS {
        let world = of_height(grid, &flat);
        let base = (first.make)(json!({})).unwrap().generate(&Site::whole(grid, 1, &world, &control), &flat).unwrap();
        let world = of_height(grid, &base);
        let site = Site::whole(grid, 1, &world, &control);
        for second in GENERATORS {
            let field = (second.make)(json!({})).unwrap().generate(&site, &base).unwrap();
            assert_eq!(field.find_not_finite(), None, "{} after {}", second.name, first.name);
        }
    }
}

/// What leaves its range is found before anything runs, and named with the range.
#[test]
fn every_number_is_held_to_its_range() {
    let grid = Grid::new(8, 8, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
    let mut tried = 0;
    for entry in GENERATORS {
        let schema = (entry.schema)().to_value();
        for (field, rule) in schema["properties"].as_object().unwrap().iter().filter(|(_, rule)| is_numeric(rule)) {
            let high = rule["maximum"].as_f64().unwrap();
            let value = if rule["type"] == "integer" { json!(2 * high as u64 + 1) } else { json!(2.0 * high + 1.0) };
            match (entry.make)(json!({ field: value })).unwrap().check(&grid) {
                Err(Error::BadParameter { owner, field: named, reason }) => {
                    assert_eq!((owner.as_str(), &named), (entry.name, field));
                    assert!(reason.contains(&format!("{high}")), "{owner}.{named}: {reason}");
                }
                other => panic!("{}.{field} = {value}: {other:?}", entry.name),
            }
            tried += 1;
        }
        assert!((entry.make)(json!({})).unwrap().check(&grid).is_ok(), "{}", entry.name);
    }
    assert!(tried > 80, "{tried}");
}

#[test]
fn parameters_that_contradict_each_other_are_refused() {
    let grid = Grid::new(8, 8, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
    for (name, parameters, field) in [
        ("remap", json!({ "points": [[0.0, 0.0]] }), "points"),
        ("remap", json!({ "points": [[0.5, 0.0], [0.5, 1.0]] }), "points"),
        ("remap", json!({ "points": [[0.0, 0.0], [1.0, 1e9]] }), "points"),
        ("mask_height", json!({ "from": 10.0, "to": 5.0 }), "to"),
        ("mask_slope", json!({ "from": 40.0, "to": 30.0 }), "to"),
        ("mask_curvature", json!({ "from": 0.3, "to": 0.2 }), "to"),
    ] {
        let entry = GENERATORS.iter().find(|e| e.name == name).unwrap();
        match (entry.make)(parameters.clone()).unwrap().check(&grid) {
            Err(Error::BadParameter { owner, field: named, .. }) => {
                assert_eq!((owner.as_str(), named.as_str()), (name, field))
            }
            other => panic!("{name} {parameters}: {other:?}"),
        }
    }
}

/// Defaults belong to the generator, also where several generators share a struct of parameters.
#[test]
fn what_a_table_leaves_out_has_the_generators_default() {
    use eyot_core::process::parameters_from;
    use eyot_land::generate::Ridged;
    let half: Ridged = parameters_from(json!({ "octaves": 3 })).unwrap();
    let whole = Ridged::default();
    assert_eq!(half.fractal.noise.octaves, 3);
    assert_eq!(half.fractal.noise.basis, whole.fractal.noise.basis);
    assert_eq!(half.fractal.amplitude, whole.fractal.amplitude);
    let schema = GENERATORS.iter().find(|e| e.name == "ridged").map(|e| (e.schema)().to_value()).unwrap();
    assert_eq!(schema["properties"]["basis"]["default"], "perlin");
}

#[test]
fn a_value_outside_its_range_is_refused_by_name() {
    use eyot_core::process::Generator;
    let grid = Grid::new(8, 8, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
    let (world, control) = (World::new(grid, 1), Control::none());
    let site = Site::whole(grid, 1, &world, &control);
    for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        match (Cone { radius, ..Cone::default() }).generate(&site, &Field::new(8, 8, 0.0)) {
            Err(Error::BadParameter { owner, field, .. }) => {
                assert_eq!((owner.as_str(), field.as_str()), ("cone", "radius"))
            }
            other => panic!("{other:?}"),
        }
    }
    let centre = [0.5, f32::NAN];
    assert!((Cone { centre, ..Cone::default() }).generate(&site, &Field::new(8, 8, 0.0)).is_err());
}

#[test]
fn discs_far_larger_than_the_land_are_refused() {
    let grid = Grid::new(17, 9, 0.01, Boundary::WRAP, &Limits::default()).unwrap();
    let circles = GENERATORS.iter().find(|e| e.name == "circles").unwrap();
    let far = (circles.make)(json!({ "radius_m": 1e7 })).unwrap().check(&grid).unwrap_err().to_string();
    assert!(far.contains("radius_m") && far.contains("at most 0.68 m"), "{far}");
}
