//! Changes as values: what `key=value` texts say.

use crate::diagnostic::{Problems, Source};
use crate::node::{Kind, Node};
use crate::{set, toml_text};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::fmt;

/// The key of the sea's level in changes to a world at work, as in recipes.
pub(crate) const SEA_LEVEL: &str = "sea_level";
/// The key before a layer's name in changes to a world at work.
pub(crate) const LAYER: &str = "layer";

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
    /// Keys from the outermost: a key of the recipe, `step` and its number or name, a process, or the name of a step; at work also
    /// `layer` and a layer's name. None at all if the value is a table of several changes that are made together.
    pub path: Vec<String>,
    /// The new value; a table is united with the one that is there.
    pub value: Value,
}

impl Change {
    /// A change of the value at a path of plain keys with dots between them. Other keys are given as [`Change::path`].
    pub fn new(path: &str, value: impl Into<Value>) -> Self {
        Self { path: path.split('.').map(str::to_owned).collect(), value: value.into() }
    }

    /// Changes that are made together or not at all, such as those of a parameter that processes share.
    #[must_use]
    pub fn together(changes: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Value::Object(Map::new());
        for change in changes {
            let mut place = &mut all;
            for key in change.path {
                if !place.is_object() {
                    *place = Value::Object(Map::new());
                }
                place = &mut place[key];
            }
            *place = change.value;
        }
        Self { path: Vec::new(), value: all }
    }

    /// Whether it changes the world itself, and not only parameters: the level of the sea, or a layer.
    pub fn touches_world(&self) -> bool {
        let is_world = |key: &str| [SEA_LEVEL, LAYER].contains(&key);
        match self.path.first() {
            Some(first) => is_world(first),
            None => self.value.as_object().is_some_and(|entries| entries.keys().any(|key| is_world(key))),
        }
    }

    /// Reads `key=value`, where the value is TOML, or a bare word that is taken as a text; or several of them, a line for each.
    ///
    /// # Errors
    /// If this is no such text.
    pub fn parse(text: &str) -> Result<Self, Problems> {
        let (text, parsed) = set::parse(text, 0);
        let node =
            parsed.map_err(|problems| Problems::new(vec![Source { name: Source::SET.to_owned(), text }], problems))?;
        let [(first, value)] = node.entries() else {
            return Ok(Self { path: Vec::new(), value: node.to_json() });
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

/// The text that [`Change::parse`] reads, and [`crate::Overrides::set`] takes; of several changes, a line for each.
impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let (true, Value::Object(entries)) = (self.path.is_empty(), &self.value) {
            let mut lines = String::new();
            toml_text::lines(&mut lines, "", entries);
            return f.write_str(lines.trim_end());
        }
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
        let both = Change::together([Change::new("a.tilt", 3.0), Change::new("a.b", 1), Change::new("b.tilt", 3.0)]);
        assert_eq!(both.to_string(), "a.tilt = 3.0\na.b = 1\nb.tilt = 3.0");
        assert_eq!(Change::parse(&both.to_string()).unwrap(), both);
        let world = |c: &Change| c.touches_world();
        assert!(world(&Change::new("sea_level", 3)) && world(&Change::together([Change::new("layer.water", 0.0)])));
        assert!(!world(&both) && !world(&Change::new("reef.sea_level", 3)));
        for (text, words) in [("seed", "sets nothing"), ("a=[", "not valid TOML")] {
            let problems = Change::parse(text).unwrap_err().to_string();
            assert!(problems.contains(words), "{problems}");
        }
    }
}
