//! A change of a parameter, as a value.

use crate::diagnostic::{Diagnostic, Problems, Source};
use crate::node::{Kind, Node};
use crate::set;
use serde_json::Value;
use std::fmt;
use std::str::FromStr;

/// A change of a parameter: `hydraulic.rain` to `0.004`, `thermal.enabled` to `false`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The process and its parameter, with a dot between them.
    pub path: String,
    /// Number, text (an expression), truth value, or a list or table of them.
    pub value: Value,
}

impl Change {
    /// A change of the parameter at `path`.
    pub fn new(path: impl Into<String>, value: impl Into<Value>) -> Self {
        Self { path: path.into(), value: value.into() }
    }
}

impl FromStr for Change {
    type Err = Problems;

    /// Reads `hydraulic.rain=0.004`, as TOML; a value that is a bare word is a text.
    fn from_str(text: &str) -> Result<Self, Problems> {
        let (read, parsed) = set::parse(text, 0);
        let fail =
            |diagnostics| Problems::new(vec![Source { name: "set".to_owned(), text: read.clone() }], diagnostics);
        let node = parsed.map_err(fail)?;
        let (mut path, mut node) = (String::new(), &node);
        while let [(key, value)] = node.entries() {
            if !path.is_empty() {
                path.push('.');
            }
            path += &quoted_key(&key.name);
            node = value;
        }
        if !is_finite(node) {
            return Err(fail(vec![Diagnostic::at(node.span.clone(), "this number is not finite", "here")]));
        }
        Ok(Self { path, value: node.to_json() })
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.path, toml_of(&self.value))
    }
}

fn is_finite(node: &Node) -> bool {
    match &node.kind {
        Kind::Float(x) => x.is_finite(),
        Kind::Array(a) => a.iter().all(is_finite),
        Kind::Table(t) => t.iter().all(|(_, v)| is_finite(v)),
        _ => true,
    }
}

/// Texts of JSON are texts of TOML, and so are its numbers and lists.
fn toml_of(value: &Value) -> String {
    let list = |items: Vec<String>| items.join(", ");
    match value {
        Value::Array(a) => format!("[{}]", list(a.iter().map(toml_of).collect())),
        Value::Object(t) => {
            format!("{{ {} }}", list(t.iter().map(|(k, v)| format!("{} = {}", quoted_key(k), toml_of(v))).collect()))
        }
        other => other.to_string(),
    }
}

fn quoted_key(key: &str) -> String {
    let bare = !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    if bare { key.to_owned() } else { Value::String(key.to_owned()).to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_read_and_written() {
        for (text, path, value, again) in [
            ("hydraulic.rain=0.004", "hydraulic.rain", Value::from(0.004), "hydraulic.rain=0.004"),
            ("thermal.enabled = false", "thermal.enabled", Value::from(false), "thermal.enabled=false"),
            ("reef.every=3", "reef.every", Value::from(3), "reef.every=3"),
            ("a.rain=wet", "a.rain", Value::from("wet"), "a.rain=\"wet\""),
            ("a.rain=\"0.1 * u\"", "a.rain", Value::from("0.1 * u"), "a.rain=\"0.1 * u\""),
            ("a={b=[1, 2.5]}", "a.b", serde_json::json!([1, 2.5]), "a.b=[1, 2.5]"),
            ("a={b=1, \"c d\"=2}", "a", serde_json::json!({ "b": 1, "c d": 2 }), "a={ b = 1, \"c d\" = 2 }"),
        ] {
            let change: Change = text.parse().unwrap();
            assert_eq!((change.path.as_str(), &change.value), (path, &value), "{text}");
            assert_eq!(change.to_string(), again);
            assert_eq!(again.parse::<Change>().unwrap(), change);
        }
        for bad in ["rain", "rain=", "a.b=nan", "=1"] {
            assert!(bad.parse::<Change>().is_err(), "{bad}");
        }
    }
}
