//! The recipe that is in force: every key with its value, whether the recipe gives it, a change of it, or nobody.

use crate::describe::tidy;
use crate::doc::written;
use crate::keys;
use crate::keys::Export;
use crate::recipe::{Recipe, Work};
use crate::toml_text;
use serde_json::{Map, Value, json};

impl Recipe {
    /// All keys of the document with their values, `--size` and presets among them. Changes by hand to a running simulation are
    /// none of the recipe's and stand in its journal.
    ///
    /// It is a recipe itself, which makes the same world in the same folder. Files have the names that the recipe gives them.
    pub fn effective(&self) -> Value {
        let mut doc = self.document.clone();
        let [width, height] = [self.grid.width, self.grid.height];
        let from = doc["grid"].get("from").cloned().unwrap_or_default();
        doc["name"] = json!(self.name);
        doc["about"] = json!(self.about);
        doc["seed"] = json!(self.seed);
        doc["sea_level"] = json!(self.sea_level_m);
        doc["grid"] = json!({
            "size": [width, height],
            "cell": [self.grid.cell_x_m, self.grid.cell_y_m],
            "rim": [self.grid.rim.x, self.grid.rim.y],
            "from": from,
        });
        for (step, table) in self.steps.iter().zip(doc["step"].as_array_mut().into_iter().flatten()) {
            let given = std::mem::take(table);
            let mut all = Map::from_iter([("enabled".to_owned(), json!(step.enabled))]);
            match &step.work {
                Work::Generate(g) => {
                    all.extend(written(&keys::Generate { merge: Some(g.merge), ..keys::Generate::default() }));
                    let mut parameters = tidy(&(g.entry.defaults)());
                    // How much memory the file may take is no key of a recipe.
                    parameters.as_object_mut().map(|p| p.remove("max_bytes"));
                    all.extend(with(parameters, &given));
                    all.extend(own(&given, &crate::GENERATE_KEYS));
                }
                Work::Simulate(s) => {
                    all.extend(written(&keys::Simulate { steps: s.steps, ..keys::Simulate::default() }));
                    all.extend(own(&given, &crate::SIMULATE_KEYS));
                    for u in &s.processes {
                        let mut one = with(tidy(&u.actor.defaults()), &given[u.actor.name()]);
                        one.insert("every".to_owned(), json!(u.every));
                        one.insert("enabled".to_owned(), json!(u.enabled));
                        all.insert(u.actor.name().to_owned(), Value::Object(one));
                    }
                }
            }
            all.insert("enabled".to_owned(), json!(step.enabled));
            *table = Value::Object(all);
        }
        let export = |e: &Export| {
            let mut keys = written(e);
            // What has no effect is refused when it is read again.
            e.narrow_keys().into_iter().filter(|(_, fits, _)| !fits).for_each(|(key, ..)| drop(keys.remove(key)));
            Value::Object(keys)
        };
        doc["export"] = self.exports.iter().map(export).collect();
        doc["view"] = Value::Object(written(&self.view));
        doc
    }

    /// [`Recipe::effective`] as the text of a recipe.
    pub fn effective_toml(&self) -> String {
        let mut doc = self.effective();
        let mut text = String::new();
        let mut lists = Vec::new();
        for key in ["grid", "layer", "rule", "step", "export", "view"] {
            lists.push((key, doc.as_object_mut().and_then(|d| d.remove(key)).unwrap_or_default()));
        }
        toml_text::lines(&mut text, "", doc.as_object().unwrap_or(&Map::new()));
        for (key, value) in lists {
            let (tables, head): (Vec<Value>, String) = match value {
                Value::Array(list) => (list, format!("[[{key}]]")),
                Value::Object(_) => (vec![value], format!("[{key}]")),
                _ => continue,
            };
            for table in tables.iter().filter_map(Value::as_object) {
                text += &format!("\n{head}\n");
                toml_text::lines(&mut text, "", table);
            }
        }
        text
    }
}

/// The usual values with what the document gives over them. Expressions and names of files stay as they are written.
fn with(usual: Value, given: &Value) -> Map<String, Value> {
    let known = |key: &str| usual.get(key).is_some();
    let given: Map<String, Value> = match given {
        Value::Object(all) => all.iter().filter(|(key, _)| known(key)).map(|(k, v)| (k.clone(), v.clone())).collect(),
        _ => Map::new(),
    };
    // The recipe was checked with it.
    let all = eyot_core::process::over(&usual, Value::Object(given)).unwrap_or(usual);
    if let Value::Object(all) = all { all } else { Map::new() }
}

/// Those keys of a step that are neither its generator's nor its processes'.
fn own(given: &Value, keys: &[&str]) -> Map<String, Value> {
    keys.iter().filter_map(|key| Some(((*key).to_owned(), given.get(key)?.clone()))).collect()
}
