//! Recipes as values that programs build.

use crate::check;
use crate::diagnostic::{Diagnostic, Problems, Source};
use crate::keys::{self, Cells, Export, Lengths, View};
use crate::node::{Kind, Node};
use crate::recipe::RecipeSource;
use crate::registry::TABLES;
use crate::toml_text;
use eyot_core::process::{Parameters, over, schema_of};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::path::PathBuf;

/// A recipe before it is checked: the keys of the document as fields.
///
/// ```
/// use eyot_recipe::{RecipeDoc, StepDoc};
///
/// let doc = RecipeDoc::new("Hill")
///     .square(128, 20.0)
///     .step(StepDoc::generate("cone").set("height", 300.0))
///     .step(StepDoc::simulate(["hydraulic", "thermal"], 500).set("hydraulic.rain", 0.002));
/// assert_eq!(
///     doc.to_toml(),
///     r#"name = "Hill"
///
/// [grid]
/// size = 128
/// cell = 20.0
///
/// [[step]]
/// generate = "cone"
/// height = 300.0
///
/// [[step]]
/// simulate = ["hydraulic", "thermal"]
/// steps = 500
/// hydraulic.rain = 0.002
/// "#
/// );
/// assert_eq!(RecipeDoc::parse(&doc.to_toml()).unwrap(), doc);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct RecipeDoc {
    /// What the landscape is called.
    pub name: String,
    /// One sentence about it.
    pub about: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Level of the sea at the start, m; [`keys::NO_SEA_M`] for land without a sea.
    #[serde(deserialize_with = "keys::level")]
    pub sea_level: f64,
    /// The grid.
    pub grid: keys::Grid,
    /// Materials of the recipe's own.
    #[serde(rename = "material")]
    pub materials: Vec<keys::Material>,
    /// Layers of the recipe's own.
    #[serde(rename = "layer")]
    pub layers: Vec<keys::Layer>,
    /// Rules of the recipe's own.
    #[serde(rename = "rule")]
    pub rules: Vec<keys::Rule>,
    /// What to do, in order.
    #[serde(rename = "step")]
    pub steps: Vec<StepDoc>,
    /// Files to write in the end.
    #[serde(rename = "export")]
    pub exports: Vec<Export>,
    /// The preview picture.
    pub view: View,
}

/// One `[[step]]`: its keys, those of its generator or the tables of its processes among them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct StepDoc {
    /// The keys, in the order in which they are written.
    pub keys: Map<String, Value>,
}

impl StepDoc {
    /// A step that makes or changes a layer.
    pub fn generate(generator: &str) -> Self {
        Self::default().set("generate", generator)
    }

    /// A step that lets processes act so many times.
    pub fn simulate<S: Into<String>>(processes: impl IntoIterator<Item = S>, steps: u64) -> Self {
        let names: Vec<Value> = processes.into_iter().map(|p| Value::String(p.into())).collect();
        Self::default().set("simulate", names).set("steps", steps)
    }

    /// The same with a value for a key, or for the parameter of a process: `hydraulic.rain`.
    #[must_use]
    pub fn set(mut self, path: &str, value: impl Into<Value>) -> Self {
        let mut keys: Vec<&str> = path.split('.').collect();
        let last = keys.pop().unwrap_or_default();
        let mut table = &mut self.keys;
        for key in keys {
            if !table.get(key).is_some_and(Value::is_object) {
                table.insert(key.to_owned(), json!({}));
            }
            match table.get_mut(key) {
                Some(Value::Object(inner)) => table = inner,
                _ => return self,
            }
        }
        table.insert(last.to_owned(), value.into());
        self
    }
}

impl RecipeDoc {
    /// A document with a name and nothing else.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// The same on a square grid: cells along each side, and the size of a cell, m.
    #[must_use]
    pub fn square(mut self, cells: u32, cell_m: f64) -> Self {
        self.grid.size = Some(Cells::One(cells));
        self.grid.cell = Some(Lengths::One(cell_m));
        self
    }

    /// The same with another seed.
    #[must_use]
    pub fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// The same with one step more.
    #[must_use]
    pub fn step(mut self, step: StepDoc) -> Self {
        self.steps.push(step);
        self
    }

    /// The same with one export more.
    #[must_use]
    pub fn export(mut self, export: Export) -> Self {
        self.exports.push(export);
        self
    }

    /// Reads a document. Whether its steps make sense is checked by [`crate::Recipe::check`] alone.
    ///
    /// # Errors
    /// If it is not TOML, or a key of the document, the grid, a layer, a rule, an export or the view is unknown or of another
    /// type.
    pub fn parse(text: &str) -> Result<Self, Problems> {
        let fail =
            |problems| Problems::new(vec![Source { name: "recipe".to_owned(), text: text.to_owned() }], problems);
        let doc = Node::parse(text, 0).map_err(fail)?;
        let mut out = Vec::new();
        check::table(&schema::<keys::Document>(), &doc, "recipe", &TABLES, &mut out);
        for (key, schema) in [("grid", schema::<keys::Grid>()), ("view", schema::<View>())] {
            doc.get(key).into_iter().for_each(|table| check::table(&schema, table, key, &[], &mut out));
        }
        let lists = [
            ("material", schema::<keys::Material>()),
            ("layer", schema::<keys::Layer>()),
            ("rule", schema::<keys::Rule>()),
            ("export", schema::<Export>()),
            ("step", json!({})),
        ];
        for (key, schema) in lists {
            let Some(list) = doc.get(key) else { continue };
            if !matches!(list.kind, Kind::Array(_)) {
                let message = format!("`{key}` must be a list of tables, not {}", list.describe());
                let help = format!("write [[{key}]] with two brackets on each side");
                out.push(Diagnostic::at(list.span.clone(), message, "here").help(help));
            }
            for item in list.elements() {
                if !matches!(item.kind, Kind::Table(_)) {
                    let message = format!("`{key}` must be a list of tables, not of {}", item.describe());
                    out.push(Diagnostic::at(item.span.clone(), message, "here"));
                } else if key != "step" {
                    check::table(&schema, item, key, &[], &mut out);
                }
            }
        }
        if !out.is_empty() {
            return Err(fail(out));
        }
        let usual = serde_json::to_value(Self::default()).unwrap_or_default();
        let all = over(&usual, doc.to_json()).and_then(|all| serde_json::from_value(all).map_err(|e| e.to_string()));
        all.map_err(|e| fail(vec![Diagnostic::whole(e)]))
    }

    /// The document as TOML; keys with their usual values are left out.
    pub fn to_toml(&self) -> String {
        let mut out = String::new();
        let head = keys::Document {
            name: self.name.clone(),
            about: self.about.clone(),
            seed: self.seed,
            sea_level: self.sea_level,
        };
        toml_text::lines(&mut out, "", &unusual(&head));
        let grid = unusual(&self.grid);
        let mut table = |head: &str, entries: &Map<String, Value>| {
            out.push_str(if out.is_empty() { "" } else { "\n" });
            out.push_str(head);
            out.push('\n');
            toml_text::lines(&mut out, "", entries);
        };
        if !grid.is_empty() {
            table("[grid]", &grid);
        }
        self.materials.iter().for_each(|material| table("[[material]]", &unusual(material)));
        self.layers.iter().for_each(|layer| table("[[layer]]", &unusual(layer)));
        self.rules.iter().for_each(|rule| table("[[rule]]", &unusual(rule)));
        self.steps.iter().for_each(|step| table("[[step]]", &step.keys));
        self.exports.iter().for_each(|export| table("[[export]]", &unusual(export)));
        let view = unusual(&self.view);
        if !view.is_empty() {
            table("[view]", &view);
        }
        out
    }

    /// The source that [`crate::Recipe::parse`] takes. Files are looked for in the current folder.
    pub fn source(&self) -> RecipeSource {
        let name = if self.name.is_empty() { "recipe".to_owned() } else { self.name.clone() };
        RecipeSource { name, text: self.to_toml(), folder: PathBuf::from(".") }
    }
}

fn schema<T: Parameters>() -> Value {
    schema_of::<T>().to_value()
}

/// The keys whose values are not the usual ones.
fn unusual<T: Serialize + Default>(value: &T) -> Map<String, Value> {
    let usual = written(&T::default());
    let mut entries = written(value);
    entries.retain(|key, value| usual.get(key) != Some(value));
    entries
}

/// By way of the text, in which numbers of single precision have no digits that are only noise.
pub(crate) fn written<T: Serialize>(value: &T) -> Map<String, Value> {
    let text = serde_json::to_string(value).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RECIPES;

    #[test]
    fn the_recipes_that_come_with_eyot_survive() {
        for recipe in RECIPES {
            let doc = RecipeDoc::parse(recipe.text).unwrap_or_else(|p| panic!("{}: {p}", recipe.name));
            let again = RecipeDoc::parse(&doc.to_toml()).unwrap_or_else(|p| panic!("{}: {p}", recipe.name));
            assert_eq!(again, doc, "{}", recipe.name);
            assert_eq!(doc.steps.len(), recipe.text.matches("[[step]]").count(), "{}", recipe.name);
        }
    }

    #[test]
    fn numbers_of_single_precision_stay_short() {
        let doc = RecipeDoc::new("a").export(Export { rock_slope: Some(33.3), ..Export::default() });
        assert!(doc.to_toml().ends_with("[[export]]\nrock_slope = 33.3\n"), "{}", doc.to_toml());
    }

    #[test]
    fn wrong_keys_are_told_with_their_place() {
        for (text, place) in [
            ("nam = 'x'", "recipe:1:1: `recipe` has no key `nam`"),
            ("[grid]\nsize = 'x'", "recipe:2:8: `grid.size` must be"),
            ("[[export]]\nformat = 'tiff'", "recipe:2:10: `export.format` cannot be"),
            ("step = 3", "recipe:1:8: `step` must be a list of tables"),
            ("step = [3]", "recipe:1:9: `step` must be a list of tables, not of the number 3"),
            ("view = 1", "recipe:1:8: "),
            ("a = ", "recipe:1:"),
        ] {
            let problems = RecipeDoc::parse(text).unwrap_err().to_string();
            assert!(problems.starts_with(place), "{text}: {problems}");
        }
    }

    #[test]
    fn values_take_the_place_of_values() {
        let step = StepDoc::simulate(["a"], 3).set("a", 1).set("a.b.c", 2).set("a.b.d", "x").set("steps", 4);
        assert_eq!(
            Value::Object(step.keys),
            json!({ "simulate": ["a"], "steps": 4, "a": { "b": { "c": 2, "d": "x" } } })
        );
    }
}
