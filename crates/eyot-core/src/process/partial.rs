//! Parameters that are given in part: what is not given keeps the value that it has at that place.
//!
//! `serde` fills what a table leaves out from the default of the table's type, which need not be the default of the place where it
//! stands: small and large disturbances are of one type, and each species of a list has values of its own. So what is given is laid
//! over the usual values of the whole parameter struct before it is read.

use serde_json::{Map, Value};

/// Key of a new element of a list: the name of the element whose values it takes where it gives none.
pub const LIKE: &str = "like";

/// What is `given`, and where it says nothing, what is `usual`.
///
/// Tables are united key by key. A list whose elements have a `name` can be given as a list, each of whose elements keeps the usual
/// values of the element of its name, or as a table of names, which changes those elements and keeps the others. An element of a new
/// name says whose values it takes, [`LIKE`], or gives all. Anything else takes the place of the usual value.
///
/// # Errors
/// If an element has a name that the usual list does not, and nothing says what its other values are.
pub fn over(usual: &Value, given: Value) -> Result<Value, String> {
    match (usual, given) {
        (Value::Object(old), Value::Object(new)) => {
            let mut all = old.clone();
            for (key, value) in new {
                let value = over(all.get(&key).unwrap_or(&Value::Null), value)?;
                all.insert(key, value);
            }
            Ok(Value::Object(all))
        }
        (Value::Array(old), Value::Array(new)) if are_named(old) => {
            new.into_iter().map(|value| element(old, value)).collect::<Result<_, _>>().map(Value::Array)
        }
        (Value::Array(old), Value::Object(new)) if are_named(old) => {
            let mut all = old.clone();
            for (name, value) in new {
                let Value::Object(mut value) = value else {
                    return Err(format!("`{name}` must be a table of what is changed"));
                };
                value.entry("name").or_insert_with(|| Value::from(name.as_str()));
                let value = element(old, Value::Object(value))?;
                match all.iter_mut().find(|e| e["name"] == name.as_str()) {
                    Some(place) => *place = value,
                    None => all.push(value),
                }
            }
            Ok(Value::Array(all))
        }
        (_, given) => Ok(given),
    }
}

/// True of a list of tables that are told apart by their names.
pub fn are_named(list: &[Value]) -> bool {
    !list.is_empty() && list.iter().all(|e| e["name"].is_string())
}

/// An element of a list of named ones.
fn element(usual: &[Value], given: Value) -> Result<Value, String> {
    let Value::Object(mut given) = given else { return Ok(given) };
    let like = given.remove(LIKE);
    let Some(name) = like.as_ref().or(given.get("name")).and_then(Value::as_str) else {
        return Err(format!("an element has no `name`; there are {}", names(usual)));
    };
    if let Some(old) = usual.iter().find(|e| e["name"] == name) {
        return over(old, Value::Object(given));
    }
    let complete = |all: &Map<String, Value>| all.keys().all(|key| given.contains_key(key));
    if like.is_none() && usual[0].as_object().is_some_and(complete) {
        return Ok(Value::Object(given));
    }
    let known = names(usual);
    Err(match like {
        Some(_) => format!("`like` names `{name}`, which there is not; there are {known}"),
        None => format!("`{name}` is new: say whose values it takes with `like`, one of {known}"),
    })
}

fn names(list: &[Value]) -> String {
    list.iter().filter_map(|e| e["name"].as_str()).map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ")
}

/// Gives the properties of a schema the defaults of their place, and a list of named tables the forms that [`over`] takes.
pub(super) fn place_defaults(properties: Option<&mut Value>, usual: &Value) {
    for (name, property) in properties.and_then(Value::as_object_mut).into_iter().flatten() {
        let usual = &usual[name];
        if usual.is_null() {
            continue;
        }
        property["default"] = usual.clone();
        match usual {
            Value::Object(_) => place_defaults(property.get_mut("properties"), usual),
            Value::Array(list) if are_named(list) => both_forms(property, list),
            _ => {}
        }
    }
}

/// A list of named tables: as a list, or as a table of changes by name.
fn both_forms(property: &mut Value, usual: &[Value]) {
    let names: Vec<&Value> = usual.iter().map(|e| &e["name"]).collect();
    let like = serde_json::json!({
        "description": "For one of a new name: the one whose values it takes where it gives none.",
        "type": "string",
        "enum": names,
    });
    let mut item = property["items"].clone();
    item["properties"][LIKE] = like;
    let mut list = Map::new();
    for key in ["type", "minItems", "maxItems"] {
        if let Some(value) = property.as_object_mut().and_then(|p| p.remove(key)) {
            list.insert(key.to_owned(), value);
        }
    }
    list.insert("items".to_owned(), item.clone());
    let of = |element: &Value| {
        let mut item = item.clone();
        place_defaults(item.get_mut("properties"), element);
        item
    };
    let by_name: Map<String, Value> =
        usual.iter().filter_map(|e| Some((e["name"].as_str()?.to_owned(), of(e)))).collect();
    item["required"] = serde_json::json!([LIKE]);
    let table = serde_json::json!({ "type": "object", "properties": by_name, "additionalProperties": item });
    property.as_object_mut().map(|p| p.remove("items"));
    property["anyOf"] = Value::Array(vec![Value::Object(list), table]);
}
