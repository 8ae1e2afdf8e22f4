//! Checks values against the JSON Schemas of the registries, with words a recipe's author understands.

use crate::diagnostic::{Diagnostic, ENOUGH, alternatives, nearest};
use crate::node::{Kind, Node};
use eyot_core::process::LIKE;
use serde_json::Value;

/// What the table of everything is called in messages.
pub(crate) const ROOT: &str = "recipe";

/// Checks a table against the schema of a parameter struct.
///
/// `owner` is whose parameters these are. Keys that `elsewhere` lists are not looked at: something else checks them, they
/// only take part in suggestions.
pub(crate) fn table(schema: &Value, node: &Node, owner: &str, elsewhere: &[&str], out: &mut Vec<Diagnostic>) {
    if !matches!(node.kind, Kind::Table(_)) {
        let message = format!("`{owner}` must be a table of parameters, not {}", node.describe());
        out.push(
            Diagnostic::at(node.span.clone(), message, "a table is needed here").help(keys_help(schema, elsewhere)),
        );
        return;
    }
    let properties = schema["properties"].as_object();
    // Keys of the recipe itself stand alone.
    let path_of = |key: &str| if owner == ROOT { key.to_owned() } else { format!("{owner}.{key}") };
    for (key, value) in node.entries() {
        if elsewhere.contains(&key.name.as_str()) {
            continue;
        }
        if out.len() >= ENOUGH {
            return;
        }
        match properties.and_then(|p| p.get(&key.name)) {
            Some(property) => check(property, value, &path_of(&key.name), property, out),
            None if schema["additionalProperties"].is_object() && value.get(LIKE).is_some() => {
                check(&schema["additionalProperties"], value, &path_of(&key.name), schema, out);
            }
            None => {
                let known =
                    properties.into_iter().flat_map(|p| p.keys().map(String::as_str)).chain(elsewhere.iter().copied());
                let help = match nearest(&key.name, known) {
                    Some(n) => match properties.and_then(|p| p.get(n)) {
                        Some(property) => format!("did you mean `{n}`? {}", meaning_line(property)),
                        None => format!("did you mean `{n}`?"),
                    },
                    None if schema["additionalProperties"].is_object() => {
                        let keys = keys_help(schema, elsewhere);
                        format!("{keys}; a new one says whose values it takes: {LIKE} = \"NAME\"")
                    }
                    None => keys_help(schema, elsewhere),
                };
                let message = format!("`{owner}` has no key `{}`", key.name);
                out.push(Diagnostic::at(key.span.clone(), message, "unknown key").help(help));
            }
        }
    }
    for required in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        if node.get(required).is_none() {
            let help = properties.and_then(|p| p.get(required)).map_or_else(String::new, meaning_line);
            let message = format!("`{owner}` needs the key `{required}`");
            out.push(Diagnostic::at(node.span.clone(), message, "missing key").help(format!("{required}: {help}")));
        }
    }
}

/// Checks one value. `whole` is the property's schema, for the help.
fn check(schema: &Value, node: &Node, path: &str, whole: &Value, out: &mut Vec<Diagnostic>) {
    if let Some(choices) = choices(schema) {
        return choice(&choices, node, path, whole, out);
    }
    let branches = branches(schema);
    if !branches.is_empty() {
        // The branch that complains least is the one that was meant.
        let best = branches.iter().filter(|s| fits_type(s, node)).map(|s| {
            let mut found = Vec::new();
            check(s, node, path, whole, &mut found);
            found
        });
        match best.min_by_key(Vec::len) {
            Some(found) => out.extend(found),
            None => wrong_type(node, path, whole, out),
        }
        range(schema, node, path, whole, out);
        return;
    }
    if !fits_type(schema, node) {
        wrong_type(node, path, whole, out);
        return;
    }
    range(schema, node, path, whole, out);
    match &node.kind {
        Kind::Array(items) => {
            let least = schema["minItems"].as_u64().unwrap_or(0);
            let most = schema["maxItems"].as_u64().unwrap_or(u64::MAX);
            if !(least..=most).contains(&(items.len() as u64)) {
                let message = format!("`{path}` needs {}, not {}", count(least, most), items.len());
                out.push(
                    Diagnostic::at(node.span.clone(), message, "wrong number of values").help(meaning_line(whole)),
                );
            }
            if schema["items"].is_object() {
                for n in items {
                    if out.len() >= ENOUGH {
                        return;
                    }
                    check(&schema["items"], n, path, whole, out);
                }
            }
            if let Some(prefix) = schema["prefixItems"].as_array() {
                prefix.iter().zip(items).for_each(|(s, n)| check(s, n, path, whole, out));
            }
        }
        Kind::Table(_) if schema["properties"].is_object() => table(schema, node, path, &[], out),
        _ => {}
    }
}

fn choice(choices: &[&str], node: &Node, path: &str, whole: &Value, out: &mut Vec<Diagnostic>) {
    let Some(text) = node.text() else { return wrong_type(node, path, whole, out) };
    if choices.contains(&text) {
        return;
    }
    if let Some(lines) = whole["$former"][text].as_str() {
        let message = format!("`{path}` is no longer \"{text}\"");
        out.push(Diagnostic::at(node.span.clone(), message, "former form").help(format!("write\n{lines}")));
        return;
    }
    let list = alternatives(choices.iter().copied());
    let help = match nearest(text, choices.iter().copied()) {
        Some(n) => format!("did you mean \"{n}\"? It may be {list}"),
        None => format!("it may be {list}"),
    };
    let message = format!("`{path}` cannot be \"{text}\"");
    out.push(Diagnostic::at(node.span.clone(), message, "not one of the choices").help(help));
}

/// The alternatives of a schema without null, which TOML does not have.
fn branches(schema: &Value) -> Vec<&Value> {
    let lists = ["anyOf", "oneOf"].iter().filter_map(|k| schema[*k].as_array());
    lists.flatten().filter(|s| !is_null(s)).collect()
}

fn range(schema: &Value, node: &Node, path: &str, whole: &Value, out: &mut Vec<Diagnostic>) {
    let value = match node.kind {
        Kind::Int(i) => i as f64,
        Kind::Float(x) => x,
        _ => return,
    };
    let mut complain = |what: String| {
        let value = if let Kind::Int(i) = node.kind { i.to_string() } else { number(value) };
        let message = format!("`{path}` is {value}: {what}");
        out.push(Diagnostic::at(node.span.clone(), message, "out of range").help(meaning_line(whole)));
    };
    let unit = unit_suffix(whole);
    if !value.is_finite() {
        return complain("a finite number is needed".to_owned());
    }
    if let Some(low) = schema["minimum"].as_f64().filter(|low| value < *low) {
        return complain(format!("it must be at least {}{unit}", number(low)));
    }
    if let Some(low) = schema["exclusiveMinimum"].as_f64().filter(|low| value <= *low) {
        return complain(format!("it must be more than {}{unit}", number(low)));
    }
    if let Some(high) = schema["maximum"].as_f64().filter(|high| value > *high) {
        return complain(format!("it must be at most {}{unit}", number(high)));
    }
    if let Some(high) = schema["exclusiveMaximum"].as_f64().filter(|high| value >= *high) {
        return complain(format!("it must be less than {}{unit}", number(high)));
    }
    let most = match schema["format"].as_str() {
        Some("float") => f64::from(f32::MAX),
        Some("uint8") => f64::from(u8::MAX),
        Some("uint16") => f64::from(u16::MAX),
        Some("uint32") => f64::from(u32::MAX),
        Some("int32") => f64::from(i32::MAX),
        Some("uint64" | "uint") => u64::MAX as f64,
        Some("int64" | "int") => i64::MAX as f64,
        _ => f64::MAX,
    };
    let inexact = matches!(node.kind, Kind::Int(i) if u64::try_from(i).is_err() && i64::try_from(i).is_err());
    if value.abs() > most || inexact {
        // The largest whole numbers are none of those that the floating point ones have.
        let most = match schema["format"].as_str() {
            Some("uint64" | "uint") => u64::MAX.to_string(),
            Some("int64" | "int") => i64::MAX.to_string(),
            _ => number(most),
        };
        complain(format!("it must be at most {most}"));
    }
}

fn wrong_type(node: &Node, path: &str, whole: &Value, out: &mut Vec<Diagnostic>) {
    let message = format!("`{path}` must be {}, not {}", expects(whole), node.describe());
    out.push(Diagnostic::at(node.span.clone(), message, "wrong type").help(meaning_line(whole)));
}

fn fits_type(schema: &Value, node: &Node) -> bool {
    let fits = |t: &str| match t {
        "number" => matches!(node.kind, Kind::Int(_) | Kind::Float(_)),
        "integer" => matches!(node.kind, Kind::Int(_)),
        "string" => matches!(node.kind, Kind::Text(_)),
        "boolean" => matches!(node.kind, Kind::Bool(_)),
        "array" => matches!(node.kind, Kind::Array(_)),
        "object" => matches!(node.kind, Kind::Table(_)),
        _ => false,
    };
    match &schema["type"] {
        Value::String(t) => fits(t),
        Value::Array(types) => types.iter().filter_map(Value::as_str).any(fits),
        _ => {
            let branches = branches(schema);
            branches.is_empty() || branches.into_iter().any(|s| fits_type(s, node))
        }
    }
}

fn is_null(schema: &Value) -> bool {
    schema["type"].as_str() == Some("null")
}

/// The texts that a schema allows, if it is a choice among texts.
pub(crate) fn choices(schema: &Value) -> Option<Vec<&str>> {
    if let Some(c) = schema["const"].as_str() {
        return Some(vec![c]);
    }
    if let Some(list) = schema["enum"].as_array() {
        return Some(list.iter().filter_map(Value::as_str).collect());
    }
    let branches = schema["oneOf"].as_array().or_else(|| schema["anyOf"].as_array())?;
    let mut all = Vec::new();
    for branch in branches.iter().filter(|b| !is_null(b)) {
        all.extend(choices(branch)?);
    }
    (!all.is_empty()).then_some(all)
}

/// What a schema takes, in words: `a number from 0 to 1`.
pub(crate) fn expects(schema: &Value) -> String {
    if let Some(c) = choices(schema) {
        return alternatives(c);
    }
    let branches = branches(schema);
    if !branches.is_empty() {
        let mut words: Vec<String> = branches.into_iter().map(expects).collect();
        words.dedup();
        return words.join(" or ");
    }
    let kind = match &schema["type"] {
        Value::String(t) => t.as_str(),
        Value::Array(types) => types.iter().filter_map(Value::as_str).find(|t| *t != "null").unwrap_or(""),
        _ => "",
    };
    match kind {
        "number" => format!("a number{}", range_words(schema)),
        "integer" => format!("a whole number{}", range_words(schema)),
        "string" => "a text in quotes".to_owned(),
        "boolean" => "true or false".to_owned(),
        "array" => {
            let least = schema["minItems"].as_u64().unwrap_or(0);
            let most = schema["maxItems"].as_u64().unwrap_or(u64::MAX);
            let of = match schema["items"]["type"].as_str() {
                Some("number") => format!("numbers{}", range_words(&schema["items"])),
                Some("integer") => format!("whole numbers{}", range_words(&schema["items"])),
                Some("string") => "texts".to_owned(),
                _ => "values".to_owned(),
            };
            if least == most { format!("a list of {least} {of}") } else { format!("a list of {of}") }
        }
        "object" => "a table".to_owned(),
        _ => "another value".to_owned(),
    }
}

/// ` from 0 to 1`, ` of at least 0`, or nothing.
pub(crate) fn range_words(schema: &Value) -> String {
    let low = schema["minimum"].as_f64().or_else(|| schema["exclusiveMinimum"].as_f64());
    let high = schema["maximum"].as_f64().or_else(|| schema["exclusiveMaximum"].as_f64());
    match (low, high) {
        (Some(l), Some(h)) => format!(" from {} to {}", number(l), number(h)),
        (Some(l), None) => format!(" of at least {}", number(l)),
        (None, Some(h)) => format!(" of at most {}", number(h)),
        (None, None) => String::new(),
    }
}

/// `a number from 0 to 1 (m/s, default 0.002). Rain per second.`
pub(crate) fn meaning_line(property: &Value) -> String {
    let mut notes = Vec::new();
    if let Some(unit) = property["unit"].as_str() {
        notes.push(if unit == "1" { "no unit".to_owned() } else { format!("unit {unit}") });
    }
    match &property["default"] {
        Value::Null => {}
        default => notes.push(format!("default {}", shown(default))),
    }
    let notes = if notes.is_empty() { String::new() } else { format!(" ({})", notes.join(", ")) };
    let meaning = property["description"].as_str().unwrap_or("").split("\n\n").next().unwrap_or("").replace('\n', " ");
    let meaning = if meaning.is_empty() { String::new() } else { format!(": {meaning}") };
    format!("It takes {}{notes}{meaning}", expects(property))
}

/// A default value as a recipe would write it; numbers that came from an `f32` lose the digits that are only noise.
pub(crate) fn shown(value: &Value) -> String {
    match value {
        Value::Number(n) if n.is_f64() => n.as_f64().map_or_else(|| n.to_string(), number),
        Value::Array(a) => format!("[{}]", a.iter().map(shown).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}

pub(crate) fn number(x: f64) -> String {
    let short = x as f32;
    let (long, short) = (format!("{x}"), if f64::from(short) == x { format!("{short}") } else { format!("{x}") });
    let text = if short.len() < long.len() { short } else { long };
    let scientific = format!("{x:e}");
    if text.len() > 8 && scientific.len() < text.len() { scientific } else { text }
}

fn unit_suffix(property: &Value) -> String {
    property["unit"].as_str().filter(|u| *u != "1").map_or_else(String::new, |u| format!(" {u}"))
}

fn count(least: u64, most: u64) -> String {
    let values = |n: u64| if n == 1 { "1 value".to_owned() } else { format!("{n} values") };
    match (least, most) {
        (a, b) if a == b => values(a),
        (a, u64::MAX) => format!("at least {}", values(a)),
        (0, b) => format!("at most {}", values(b)),
        (a, b) => format!("{a} to {}", values(b)),
    }
}

fn keys_help(schema: &Value, elsewhere: &[&str]) -> String {
    let mut keys: Vec<&str> =
        schema["properties"].as_object().map(|p| p.keys().map(String::as_str).collect()).unwrap_or_default();
    keys.extend(elsewhere.iter().filter(|k| !keys.contains(*k)).copied().collect::<Vec<_>>());
    if keys.is_empty() { "it takes no keys".to_owned() } else { format!("it takes {}", alternatives(keys)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn problems(schema: Value, text: &str) -> Vec<String> {
        let node = Node::parse(text, 0).unwrap();
        let mut out = Vec::new();
        table(&schema, &node, "p", &[], &mut out);
        out.into_iter().map(|d| d.message.to_string()).collect()
    }

    #[test]
    fn every_kind_of_schema_is_checked() {
        let schema = json!({"properties": {
            "x": {"type": ["number", "null"], "format": "float", "minimum": 0.0, "maximum": 10.0, "unit": "m"},
            "n": {"type": "integer", "format": "uint32", "minimum": 0},
            "m": {"oneOf": [{"type": "string", "const": "add"}, {"type": "string", "const": "max"}]},
            "s": {"anyOf": [{"anyOf": [{"type": "integer", "minimum": 1}, {"type": "array", "items": {"type": "integer", "minimum": 1}, "minItems": 2, "maxItems": 2}]}, {"type": "null"}]},
            "v": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
            "b": {"type": "boolean"}}});
        let ok = "x = 3\nn = 4\nm = 'add'\ns = [1, 2]\nv = [1, 2.5]\nb = true";
        assert_eq!(problems(schema.clone(), ok), Vec::<String>::new());
        let bad = [
            ("x = 11", "`p.x` is 11: it must be at most 10 m"),
            ("x = nan", "`p.x` is NaN: a finite number is needed"),
            ("x = 'a'", "`p.x` must be a number from 0 to 10, not the text \"a\""),
            ("n = 1.5", "`p.n` must be a whole number of at least 0, not the number 1.5"),
            ("n = 4294967296", "`p.n` is 4294967296: it must be at most 4294967295"),
            ("m = 'ad'", "`p.m` cannot be \"ad\""),
            ("m = 3", "`p.m` must be `add` or `max`, not the number 3"),
            ("s = 0", "`p.s` is 0: it must be at least 1"),
            ("s = [1]", "`p.s` needs 2 values, not 1"),
            ("s = [1, 0]", "`p.s` is 0: it must be at least 1"),
            ("v = [1, 2, 3]", "`p.v` needs 2 values, not 3"),
            ("v = [1, 'a']", "`p.v` must be a list of 2 numbers, not the text \"a\""),
            ("b = 1", "`p.b` must be true or false, not the number 1"),
            ("q = 1", "`p` has no key `q`"),
        ];
        for (text, message) in bad {
            assert_eq!(problems(schema.clone(), text), vec![message.to_owned()], "{text}");
        }
    }
}
