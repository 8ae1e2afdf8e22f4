//! The JSON Schema of a whole recipe, composed from the registries, for editors.

use crate::describe;
use crate::keys;
use crate::registry::Registry;
use eyot_core::process::schema_of;
use serde_json::{Map, Value, json};

/// A JSON Schema (draft 2020-12) that completes and checks recipes in editors that know TOML.
pub fn recipe_schema(registry: &Registry) -> Value {
    let mut document = schema_of::<keys::Document>().to_value();
    let mut steps: Vec<Value> =
        registry.generators().iter().map(|e| generate(e.name, &(e.schema)().to_value())).collect();
    if !registry.processes().is_empty() {
        steps.push(simulate(registry));
    }
    let table = |mut schema: Value| {
        strip(&mut schema);
        schema
    };
    let p = &mut document["properties"];
    p["grid"] = table(schema_of::<keys::Grid>().to_value());
    for (key, what, schema) in [
        ("material", "Materials of the recipe's own, for beds of rock.", schema_of::<keys::Material>()),
        ("layer", "Layers of the recipe's own.", schema_of::<keys::Layer>()),
        ("rule", "Rules of the recipe's own.", schema_of::<keys::Rule>()),
    ] {
        let mut items = table(schema.to_value());
        items["required"] = json!(["name"]);
        p[key] = json!({ "description": what, "type": "array", "items": items });
    }
    p["step"] = json!({ "description": "What to do, in order.", "type": "array", "minItems": 1, "items": { "type": "object", "anyOf": steps } });
    p["export"] = json!({ "description": "Files to write when the run is done.", "type": "array", "items": table(schema_of::<keys::Export>().to_value()) });
    p["view"] = table(schema_of::<keys::View>().to_value());
    strip(&mut document);
    document["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    document["title"] = json!("Eyot recipe");
    document["description"] = json!("Everything that decides the bytes of a landscape.");
    document["required"] = json!(["grid", "step"]);
    document["additionalProperties"] = json!(false);
    document
}

fn generate(name: &str, schema: &Value) -> Value {
    let mut own = schema_of::<keys::Generate>().to_value();
    own["properties"]["generate"] = json!({ "const": name, "description": schema["description"] });
    let theirs = schema["properties"].as_object().cloned().unwrap_or_default();
    if let Some(properties) = own["properties"].as_object_mut() {
        properties.extend(theirs);
    }
    own["title"] = json!(format!("generate = \"{name}\""));
    own["required"] = json!(["generate"]);
    finish(own)
}

fn simulate(registry: &Registry) -> Value {
    let mut own = schema_of::<keys::Simulate>().to_value();
    let names: Vec<&str> = registry.process_names().collect();
    // Beside those of the registry there are the layers and rules of the recipe's own.
    let name = json!({ "anyOf": [{ "enum": names }, { "type": "string", "pattern": "^[a-z_][a-z0-9_]*$" }] });
    own["properties"]["simulate"] = json!({
        "description": "The processes, in the order in which they act within one step.",
        "anyOf": [name, { "type": "array", "items": name, "minItems": 1, "uniqueItems": true }],
    });
    let schedule = schema_of::<keys::Schedule>().to_value()["properties"].as_object().cloned().unwrap_or_default();
    for e in registry.processes() {
        let mut process = (e.schema)().to_value();
        let mut properties: Map<String, Value> = process["properties"].as_object().cloned().unwrap_or_default();
        if describe::takes_expressions(e) {
            let numbers: Vec<String> = eyot_expr::numbers(&process).map(|(name, _)| name.clone()).collect();
            numbers.iter().for_each(|name| properties[name]["type"] = json!(["number", "string"]));
        }
        properties.extend(schedule.clone());
        process["properties"] = Value::Object(properties);
        own["properties"][e.name] = finish(process);
    }
    own["title"] = json!("simulate = [...]");
    own["required"] = json!(["simulate"]);
    let mut step = finish(own);
    step["additionalProperties"] =
        json!({ "type": "object", "description": "Parameters of a rule of the recipe's own." });
    step
}

fn finish(mut schema: Value) -> Value {
    strip(&mut schema);
    schema["type"] = json!("object");
    schema["additionalProperties"] = json!(false);
    schema
}

/// Removes what only stands at the root of a schema, what TOML does not know (null), and texts of earlier versions.
fn strip(schema: &mut Value) {
    if let Some(map) = schema.as_object_mut() {
        map.remove("$schema");
        map.remove("$former");
        if map.get("default").is_some_and(Value::is_null) {
            map.remove("default");
        }
        if let Some(Value::Array(types)) = map.get_mut("type") {
            types.retain(|t| t != "null");
            if let [one] = types.as_slice() {
                let one = one.clone();
                map.insert("type".to_owned(), one);
            }
        }
        for key in ["anyOf", "oneOf"] {
            if let Some(Value::Array(branches)) = map.get_mut(key) {
                branches.retain(|b| b["type"] != "null");
            }
        }
        map.values_mut().for_each(strip);
    } else if let Some(list) = schema.as_array_mut() {
        list.iter_mut().for_each(strip);
    }
}
