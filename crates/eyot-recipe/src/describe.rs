//! What a generator or process takes, from its schema: for people and for programs.

use crate::check::{expects, shown};
use crate::diagnostic::{alternatives, nearest};
use crate::keys;
use crate::layers;
use crate::registry::Registry;
use eyot_core::process::{Entry, Process, schema_of};
use eyot_core::remedy::{Action, Neutral, Wording};
use eyot_expr::ParameterizedProcess;
use eyot_expr::functions::{FUNCTIONS, NAMES};
use schemars::Schema;
use serde::Serialize;
use serde_json::Value;
use std::fmt;

/// One of the texts that a parameter may be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// The text.
    pub value: String,
    /// What it means.
    pub meaning: String,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterInfo {
    /// Name in recipes.
    pub name: String,
    /// What it means.
    pub meaning: String,
    /// Unit, `1` for a plain number; empty if it is no number.
    pub unit: String,
    /// What it takes, in words.
    pub takes: String,
    /// Smallest value.
    pub minimum: Option<f64>,
    /// Largest value.
    pub maximum: Option<f64>,
    /// Texts that it may be, if it is a choice.
    pub choices: Vec<Choice>,
    /// Value if the recipe does not give one.
    pub default: Value,
    /// Where a recipe may give an expression instead of a number.
    pub expression: Expression,
}

/// Whether a parameter may be an expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Expression {
    /// It may not.
    No,
    /// One that is the same for all cells.
    Time,
    /// One that differs from cell to cell.
    Cells,
}

/// A generator, a process or a table of the recipe.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Description {
    /// Name in recipes.
    pub name: String,
    /// `generator`, `process` or `table`.
    pub kind: &'static str,
    /// One sentence.
    pub summary: String,
    /// The rest of what is to be said.
    pub details: String,
    /// Its parameters.
    pub parameters: Vec<ParameterInfo>,
    /// What it does, its equations and its source, as Markdown; empty for a table.
    pub about: String,
    /// Keys of the literature it comes from.
    pub sources: Vec<String>,
}

/// Describes a generator, a process, one of the recipe's own tables (`grid`, `step`, `layer`, `export`, `view` and others), or the
/// `layers` that come with Eyot.
///
/// # Errors
/// If there is nothing of that name; the text suggests one.
pub fn describe(name: &str, registry: &Registry) -> Result<Description, String> {
    let name = name.trim_matches(['[', ']']);
    if let Some(e) = registry.generator(name) {
        return Ok(from_schema(name, "generator", &(e.schema)().to_value(), &(e.defaults)(), e.about, e.cites));
    }
    if let Some(e) = registry.process(name) {
        let schema = (e.schema)().to_value();
        let mut description = from_schema(name, "process", &schema, &(e.defaults)(), e.about, e.cites);
        if takes_expressions(e) {
            let cells = ParameterizedProcess::possible(e);
            let number = |name: &String| eyot_expr::numbers(&schema).any(|(n, _)| n == name);
            for p in description.parameters.iter_mut().filter(|p| number(&p.name)) {
                p.expression = if cells.contains(&p.name) { Expression::Cells } else { Expression::Time };
            }
        }
        return Ok(description);
    }
    let table = match name {
        "layers" => return Ok(layers::describe(registry)),
        "step" => return Ok(step()),
        "recipe" => schema_of::<keys::Document>(),
        "grid" => schema_of::<keys::Grid>(),
        "generate" => schema_of::<keys::Generate>(),
        "simulate" => schema_of::<keys::Simulate>(),
        "schedule" => schema_of::<keys::Schedule>(),
        "material" => schema_of::<keys::Material>(),
        "layer" => schema_of::<keys::Layer>(),
        "rule" => schema_of::<keys::Rule>(),
        "expressions" => return Ok(expressions()),
        "export" => schema_of::<keys::Export>(),
        "view" => schema_of::<keys::View>(),
        _ => {
            let tables = [
                "recipe",
                "grid",
                "step",
                "material",
                "layer",
                "layers",
                "rule",
                "expressions",
                "generate",
                "simulate",
                "schedule",
                "export",
                "view",
            ];
            let known: Vec<&str> = registry.generator_names().chain(registry.process_names()).chain(tables).collect();
            return Err(match nearest(name, known.iter().copied()) {
                Some(n) => format!("nothing is called `{name}`; did you mean `{n}`?"),
                None => format!("nothing is called `{name}`; there is {}", alternatives(known)),
            });
        }
    };
    Ok(from_schema(name, "table", &table.to_value(), &Value::Null, "", &[]))
}

/// Whether a process is rules of cells alone, so that its numbers may be expressions.
pub(crate) fn takes_expressions(entry: &Entry<dyn Process>) -> bool {
    (entry.make)(serde_json::json!({})).is_ok_and(|p| p.action().is_none())
}

fn from_schema(
    name: &str,
    kind: &'static str,
    schema: &Value,
    defaults: &Value,
    about: &str,
    cites: &[&str],
) -> Description {
    let text = schema["description"].as_str().unwrap_or("");
    let (summary, details) = text.split_once("\n\n").unwrap_or((text, ""));
    let bound = |p: &Value, a: &str, b: &str| p[a].as_f64().or_else(|| p[b].as_f64());
    let parameters = schema["properties"].as_object().into_iter().flatten().map(|(key, p)| ParameterInfo {
        name: key.clone(),
        meaning: one_line(p["description"].as_str().unwrap_or("")),
        unit: p["unit"].as_str().unwrap_or("").to_owned(),
        takes: expects(p),
        minimum: bound(p, "minimum", "exclusiveMinimum"),
        maximum: bound(p, "maximum", "exclusiveMaximum"),
        choices: choice_list(p),
        default: match defaults.get(key) {
            Some(d) => tidy(d),
            None => tidy(&p["default"]),
        },
        expression: Expression::No,
    });
    Description {
        name: name.to_owned(),
        kind,
        summary: one_line(summary),
        details: details.trim().to_owned(),
        parameters: parameters.collect(),
        about: about.trim_end().to_owned(),
        sources: cites.iter().map(|c| (*c).to_owned()).collect(),
    }
}

/// Both kinds of `[[step]]`.
fn step() -> Description {
    let table = |name, schema: Schema| from_schema(name, "table", &schema.to_value(), &Value::Null, "", &[]);
    let mut all = table("step", schema_of::<keys::Generate>());
    let simulate = table("step", schema_of::<keys::Simulate>());
    all.summary = "A step of the recipe: it either generates or simulates.".to_owned();
    all.details = "With `generate = \"NAME\"` a generator makes or changes a layer, and its parameters stand beside the keys of the \
                   step. With `simulate = [\"NAME\"]` processes act `steps` times, each with a table of its own: \
                   `hydraulic.rain = 0.002`."
        .to_owned();
    let more = simulate.parameters.into_iter().filter(|p| p.name == "simulate" || p.name == "steps");
    all.parameters.extend(more.collect::<Vec<_>>());
    all
}

/// The names and functions of expressions.
fn expressions() -> Description {
    let one = |name: String, meaning: &str, unit: &str, takes: &str| ParameterInfo {
        name,
        meaning: format!("{meaning}."),
        unit: unit.to_owned(),
        takes: takes.to_owned(),
        minimum: None,
        maximum: None,
        choices: Vec::new(),
        default: Value::Null,
        expression: Expression::No,
    };
    let names = NAMES.iter().map(|n| one(n.name.to_owned(), n.meaning, n.unit, "a name"));
    let functions = FUNCTIONS.iter().map(|f| one(format!("{}({})", f.name, f.arguments), f.meaning, "", "a function"));
    Description {
        name: "expressions".to_owned(),
        kind: "table",
        summary: "What expressions of `[[layer]]` and `[[rule]]` know beside layers and parameters.".to_owned(),
        details: "Operators, from the loosest to the tightest: `or`; `and`; `not`; `<` `<=` `>` `>=` `==` `!=`; `+` `-`; \
                  `*` `/`; the sign `-`; `^`. `water[1, -1]` is the layer one column to the east and one row to the north. \
                  `name = expression;` before the value gives a part a name."
            .to_owned(),
        parameters: names.chain(functions).collect(),
        about: String::new(),
        sources: Vec::new(),
    }
}

/// The choices of a schema with the doc comments of the variants.
fn choice_list(schema: &Value) -> Vec<Choice> {
    let choice = |value: &Value, about: &Value| {
        Some(Choice { value: value.as_str()?.to_owned(), meaning: one_line(about.as_str().unwrap_or("")) })
    };
    if schema["const"].is_string() {
        return choice(&schema["const"], &schema["description"]).into_iter().collect();
    }
    if let Some(values) = schema["enum"].as_array() {
        return values.iter().filter_map(|v| choice(v, &Value::Null)).collect();
    }
    let branches = schema["oneOf"].as_array().or_else(|| schema["anyOf"].as_array());
    branches.into_iter().flatten().flat_map(choice_list).collect()
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A default that came from an `f32` with the digits that a person wrote.
pub(crate) fn tidy(value: &Value) -> Value {
    match value {
        Value::Number(n) if n.is_f64() => shown(value).parse::<f64>().ok().map_or_else(|| value.clone(), Value::from),
        Value::Array(a) => a.iter().map(tidy).collect(),
        Value::Object(o) => Value::Object(o.iter().map(|(key, v)| (key.clone(), tidy(v))).collect()),
        other => other.clone(),
    }
}

impl ParameterInfo {
    /// A default that is a table, or a list of tables, in words: for each its name if it has one, and its keys with their values. None
    /// for other defaults.
    pub fn default_tables(&self) -> Vec<(String, Vec<String>)> {
        let table = |v: &Value| {
            let mut entries = Vec::new();
            flatten("", v, &mut entries);
            (v["name"].as_str().unwrap_or_default().to_owned(), entries)
        };
        match &self.default {
            Value::Object(o) if !o.is_empty() => vec![table(&self.default)],
            Value::Array(a) if a.first().is_some_and(Value::is_object) => a.iter().map(table).collect(),
            _ => Vec::new(),
        }
    }
}

/// Keys and values of a table and of those in it, as recipes write them.
fn flatten(before: &str, table: &Value, out: &mut Vec<String>) {
    for (key, value) in
        table.as_object().into_iter().flatten().filter(|(key, _)| !(before.is_empty() && *key == "name"))
    {
        match value {
            Value::Object(_) => flatten(&format!("{before}{key}."), value, out),
            Value::String(text) => out.push(format!("{before}{key} = {text}")),
            other => out.push(format!("{before}{key} = {}", shown(other))),
        }
    }
}

impl Description {
    /// The text in the words of a front end.
    pub fn worded(&self, wording: &dyn Wording) -> String {
        let mut text = String::new();
        // Writing to a text cannot fail.
        let _ = self.write(&mut text, wording);
        text
    }

    fn write(&self, f: &mut dyn fmt::Write, wording: &dyn Wording) -> fmt::Result {
        writeln!(f, "{} ({})", self.name, self.kind)?;
        if !self.summary.is_empty() {
            writeln!(f, "  {}", self.summary)?;
        }
        if !self.details.is_empty() {
            writeln!(f, "\n{}", indent(&self.details, 2))?;
        }
        for p in &self.parameters {
            write!(f, "\n  {}", p.name)?;
            let mut notes = vec![p.takes.clone()];
            if !p.unit.is_empty() && p.unit != "1" {
                notes.push(format!("unit {}", p.unit));
            }
            let tables = p.default_tables();
            if !tables.is_empty() {
                notes.push("default below".to_owned());
            } else if !p.default.is_null() {
                notes.push(format!("default {}", shown(&p.default)));
            }
            match p.expression {
                Expression::No => {}
                Expression::Time => notes.push("or an expression of time".to_owned()),
                Expression::Cells => notes.push("or an expression".to_owned()),
            }
            writeln!(f, "  [{}]", notes.join("; "))?;
            writeln!(f, "{}", wrap(&p.meaning, 6, 100))?;
            for c in p.choices.iter().filter(|c| !c.meaning.is_empty()) {
                writeln!(f, "{}", wrap(&format!("{}: {}", c.value, c.meaning), 8, 100))?;
            }
            for (name, entries) in tables {
                if !name.is_empty() {
                    writeln!(f, "        {name}")?;
                }
                // Entries stay in one piece.
                let text = entries.join(", ").replace(" = ", " =\u{1}").replace(" =", "\u{1}=");
                writeln!(f, "{}", wrap(&text, if name.is_empty() { 8 } else { 10 }, 100).replace('\u{1}', " "))?;
            }
        }
        if !self.about.is_empty() {
            writeln!(f, "\n{}", indent(&self.about, 2))?;
        }
        if !self.sources.is_empty() {
            writeln!(f, "\n  Cited as {} ({})", self.sources.join(", "), wording.action(&Action::Cite))?;
        }
        if self.kind == "process" {
            writeln!(f, "\n  Every process also takes `every` (act in every n-th step) and `enabled`.")?;
        }
        Ok(())
    }
}

impl fmt::Display for Description {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, &Neutral)
    }
}

fn indent(text: &str, by: usize) -> String {
    text.lines().map(|l| format!("{:by$}{l}", "").trim_end().to_owned()).collect::<Vec<_>>().join("\n")
}

fn wrap(text: &str, by: usize, width: usize) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        if let Some(line) = lines.last_mut() {
            if line.is_empty() {
                line.push_str(word);
            } else if line.chars().count() + 1 + word.chars().count() + by <= width {
                line.push(' ');
                line.push_str(word);
            } else {
                lines.push(word.to_owned());
            }
        }
    }
    indent(&lines.join("\n"), by)
}
