//! Every generator says everything about its parameters, and holds users to it.
use eyot_core::process::Site;
use eyot_core::{Control, Error, Field, Grid, Limits, Rim, World};
use eyot_land::generate::{Cone, GENERATORS};
use serde_json::{Value, json};

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
            for rim in [Rim::CLOSED, Rim::OPEN, Rim::WRAP] {
                for cell_y_m in [10.0, 25.0] {
                    let grid = Grid { width: w, height: h, cell_x_m: 10.0, cell_y_m, rim };
                    let grid = grid.checked(&Limits::default()).unwrap();
                    let (world, control) = (World::new(grid, 1), Control::none());
                    let base = Field::from_fn(w, h, |x, y| ((x * 7 + y * 13) % 11) as f32);
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
    let grid = Grid::new(48, 32, 10.0, Rim::CLOSED, &Limits::default()).unwrap();
    let (world, control) = (World::new(grid, 1), Control::none());
    let site = Site::whole(grid, 1, &world, &control);
    for first in GENERATORS {
        let base = (first.make)(json!({})).unwrap().generate(&site, &Field::new(48, 32, 0.0)).unwrap();
        for second in GENERATORS {
            let field = (second.make)(json!({})).unwrap().generate(&site, &base).unwrap();
            assert_eq!(field.find_not_finite(), None, "{} after {}", second.name, first.name);
        }
    }
}

#[test]
fn a_value_outside_its_range_is_refused_by_name() {
    use eyot_core::process::Generator;
    let grid = Grid::new(8, 8, 10.0, Rim::CLOSED, &Limits::default()).unwrap();
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
