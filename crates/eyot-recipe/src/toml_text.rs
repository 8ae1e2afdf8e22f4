//! Values as TOML.

use serde_json::{Map, Value};
use std::fmt::Write;

/// A key, in quotes where it needs them.
pub(crate) fn key(name: &str) -> String {
    let bare = !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b"_-".contains(&b));
    if bare { name.to_owned() } else { text(name) }
}

/// A text in quotes. JSON escapes all that TOML wants escaped, but for the last character of ASCII.
fn text(s: &str) -> String {
    Value::from(s).to_string().replace('\u{7f}', "\\u007f")
}

/// A value in one line. Entries of tables that are null are left out, for TOML has no null; as an element of a list or alone,
/// it is a text that no key takes.
pub(crate) fn inline(value: &Value) -> String {
    match value {
        Value::Null => "\"null\"".to_owned(),
        Value::String(s) => text(s),
        // Shows that the number is none of the whole ones.
        Value::Number(n) if n.is_f64() => format!("{:?}", n.as_f64().unwrap_or(f64::NAN)),
        Value::Array(list) => format!("[{}]", list.iter().map(inline).collect::<Vec<_>>().join(", ")),
        Value::Object(entries) => {
            let entries = entries.iter().filter(|(_, v)| !v.is_null());
            let entries: Vec<String> = entries.map(|(k, v)| format!("{} = {}", key(k), inline(v))).collect();
            if entries.is_empty() { "{}".to_owned() } else { format!("{{ {} }}", entries.join(", ")) }
        }
        other => other.to_string(),
    }
}

/// The entries of a table, one a line; inner tables become dotted keys, and each table of a list has a line.
pub(crate) fn lines(out: &mut String, before: &str, entries: &Map<String, Value>) {
    for (name, value) in entries.iter().filter(|(_, v)| !v.is_null()) {
        let path = format!("{before}{}", key(name));
        match value {
            Value::Object(inner) if inner.values().any(|v| !v.is_null()) => lines(out, &format!("{path}."), inner),
            Value::Array(tables) if tables.iter().any(Value::is_object) => {
                let tables: String = tables.iter().map(|t| format!("    {},\n", inline(t))).collect();
                let _ = writeln!(out, "{path} = [\n{tables}]");
            }
            _ => {
                let _ = writeln!(out, "{path} = {}", inline(value));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::Node;
    use serde_json::json;

    #[test]
    fn what_is_written_is_read_again() {
        let value = json!({
            "plain": 1, "large": u64::MAX, "small": -3, "whole": 20.0, "tiny": 1.5e-9, "huge": 1e300, "third": 1.0 / 3.0,
            "yes": true, "text": "a \"b\" \\ c\n\u{7f}é\u{1}", "list": [1, [2.5, 3.0]], "": 4, "two words": {"a.b": {}},
            "table": {"inner": {"x": 1, "y": [{"z": "q"}]}},
        });
        let mut out = String::new();
        lines(&mut out, "", value.as_object().unwrap());
        assert_eq!(Node::parse(&out, 0).unwrap().to_json(), value, "{out}");
        assert!(out.contains("table.inner.x = 1"), "{out}");
        let one = format!("v = {}", inline(&value));
        assert_eq!(Node::parse(&one, 0).unwrap().to_json()["v"], value, "{one}");
    }
}
