//! Changes as values: what `key=value` texts say.

use crate::diagnostic::{Diagnostic, Problems, Source};
use crate::node::{Kind, Node, Span};
use crate::{set, toml_text};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fmt;

/// A change to one value of a recipe, or of a process that is at work.
///
/// ```
/// use eyot_recipe::Change;
///
/// let change = Change::new("hydraulic.rain", 0.004);
/// assert_eq!(change.to_string(), "hydraulic.rain = 0.004");
/// assert_eq!(Change::parse("hydraulic.rain=0.004").unwrap(), change);
/// assert_eq!(Change::parse("grid.rim=open").unwrap(), Change::new("grid.rim", "open"));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Keys from the outermost: a key of the recipe, `step` and its number or name, a process, or the name of a step.
    pub path: Vec<String>,
    /// The new value; a table is united with the one that is there.
    pub value: Value,
}

impl Change {
    /// A change of the value at a path of plain keys with dots between them. Other keys are given as [`Change::path`].
    pub fn new(path: &str, value: impl Into<Value>) -> Self {
        Self { path: path.split('.').map(str::to_owned).collect(), value: value.into() }
    }

    /// Reads `key=value`, where the value is TOML, or a bare word that is taken as a text.
    ///
    /// # Errors
    /// If this is no such text, or sets several values.
    pub fn parse(text: &str) -> Result<Self, Problems> {
        let (text, parsed) = set::parse(text, 0);
        let end = text.len();
        let fail = |problems| Problems::new(vec![Source { name: Source::SET.to_owned(), text }], problems);
        let node = match parsed {
            Ok(node) => node,
            Err(problems) => return Err(fail(problems)),
        };
        let [(first, value)] = node.entries() else {
            let span = Span { source: 0, start: 0, end };
            let help = "give each change of its own";
            return Err(fail(vec![Diagnostic::at(span, "several values are set", "more than one").help(help)]));
        };
        let (mut path, mut value): (Vec<String>, &Node) = (vec![first.name.clone()], value);
        while let Kind::Table(entries) = &value.kind
            && let [(key, inner)] = entries.as_slice()
        {
            path.push(key.name.clone());
            value = inner;
        }
        Ok(Self { path, value: value.to_json() })
    }
}

/// The text that [`Change::parse`] reads, and [`crate::Overrides::set`] takes.
impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path: Vec<String> = self.path.iter().map(|k| toml_text::key(k)).collect();
        write!(f, "{} = {}", path.join("."), toml_text::inline(&self.value))
    }
}

impl From<Change> for String {
    fn from(change: Change) -> Self {
        change.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn changes_are_their_texts() {
        for (text, path, value) in [
            ("seed=7", vec!["seed"], json!(7)),
            ("grid.size=[3, 4]", vec!["grid", "size"], json!([3, 4])),
            ("step.2.enabled=false", vec!["step", "2", "enabled"], json!(false)),
            ("thermal={every=2}", vec!["thermal", "every"], json!(2)),
            ("thermal={every=2, enabled=true}", vec!["thermal"], json!({ "every": 2, "enabled": true })),
            ("\"my step\".height=1e3", vec!["my step", "height"], json!(1000.0)),
            ("view.look=from above", vec!["view", "look"], json!("from above")),
        ] {
            let change = Change::parse(text).unwrap();
            assert_eq!(change, Change { path: path.into_iter().map(str::to_owned).collect(), value }, "{text}");
            assert_eq!(Change::parse(&change.to_string()).unwrap(), change, "{text}");
        }
        for (text, words) in [("seed", "sets nothing"), ("a=1\nb=2", "several values"), ("a=[", "not valid TOML")] {
            let problems = Change::parse(text).unwrap_err().to_string();
            assert!(problems.contains(words), "{problems}");
        }
    }
}
