//! Parameters with a schema, and the lines of a registry.

use super::partial::{over, place_defaults};
use super::{Generator, Process};
use crate::error::{Error, Result};
use schemars::{JsonSchema, Schema};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// A parameter struct that is everything there is to say about a process or generator.
///
/// Field attributes carry the schema: the doc comment is the meaning, `range(min, max)` the range,
/// `extend("unit" = "m")` the unit.
pub trait Parameters: Default + Serialize + DeserializeOwned + JsonSchema {}
impl<T: Default + Serialize + DeserializeOwned + JsonSchema> Parameters for T {}

/// One line of a registry: a name, a schema, and how to make the thing from a table of parameters.
pub struct Entry<T: ?Sized> {
    /// Name in recipes.
    pub name: &'static str,
    /// JSON Schema of the parameters, made by `schemars` from the struct.
    pub schema: fn() -> Schema,
    /// Default parameters as a table.
    pub defaults: fn() -> Value,
    /// Makes it; missing parameters take their defaults.
    pub make: fn(Value) -> Result<Box<T>, serde_json::Error>,
    /// What it does, its equations and its source, as Markdown: the head of its source file, see [`about!`](crate::about!).
    pub about: &'static str,
    /// Keys in `references.bib`.
    pub cites: &'static [&'static str],
}

/// Default values of `P` as JSON.
pub fn defaults_of<P: Parameters>() -> Value {
    serde_json::to_value(P::default()).unwrap_or_default()
}

/// JSON Schema of `P`.
pub fn schema_of<P: Parameters>() -> Schema {
    let mut schema = schemars::generate::SchemaSettings::draft2020_12()
        .with(|s| s.inline_subschemas = true)
        .into_generator()
        .into_root_schema_for::<P>();
    // A struct that stands in several places need not have its own defaults there.
    place_defaults(schema.get_mut("properties"), &defaults_of::<P>());
    schema
}

/// `P` from a table; what the table leaves out has the default that `P` has at that place, at any depth ([`over`]).
///
/// Unknown keys are found here and not by `serde`, which cannot tell them where structs share parameters by `flatten`.
///
/// # Errors
/// If the table holds something else than the parameters of `P`.
pub fn parameters_from<P: Parameters>(table: Value) -> Result<P, serde_json::Error> {
    let (usual, Value::Object(table)) = (defaults_of::<P>(), table) else {
        return P::deserialize(Value::Null);
    };
    if let Some(all) = usual.as_object()
        && let Some(key) = table.keys().find(|k| !all.contains_key(*k))
    {
        let known: Vec<&str> = all.keys().map(String::as_str).collect();
        return Err(serde::de::Error::custom(format!("unknown key `{key}`; there are {}", known.join(", "))));
    }
    let all = over(&usual, Value::Object(table)).map_err(<serde_json::Error as serde::de::Error>::custom)?;
    serde_json::from_value(all)
}

/// Fails if a parameter is outside the range that its schema gives, or not a number.
///
/// Recipes are checked before they get here; this is for structs that a program filled.
///
/// # Errors
/// The first such parameter, with its range and its default.
pub fn check_ranges<P: Parameters>(owner: &str, parameters: &P) -> Result<()> {
    within_ranges(owner, &schema_of::<P>(), &serde_json::to_value(parameters).unwrap_or_default(), &defaults_of::<P>())
}

/// As [`check_ranges`], compiled once for all structs.
fn within_ranges(owner: &str, schema: &Schema, values: &Value, defaults: &Value) -> Result<()> {
    let Some(properties) = schema.get("properties").and_then(Value::as_object) else { return Ok(()) };
    for (field, rule) in properties {
        let (value, default) = (&values[field], &defaults[field]);
        let pairs = match (value.as_array(), default.as_array()) {
            (Some(v), Some(d)) => v.iter().zip(d).map(|(v, d)| (v, d, &rule["items"])).collect(),
            _ => vec![(value, default, rule)],
        };
        for (value, default, rule) in pairs.into_iter().filter(|(_, default, _)| default.is_number()) {
            let low = rule["minimum"].as_f64().unwrap_or(f64::MIN);
            let high = rule["maximum"].as_f64().unwrap_or(f64::MAX);
            // Not-a-numbers become null on the way. A range is written in f64, a parameter may have been rounded to f32.
            let slack = 1e-6 * low.abs().max(high.abs()).min(1.0);
            let fits = value.as_f64().is_some_and(|v| (low - slack..=high + slack).contains(&v));
            if !fits {
                return Err(Error::BadParameter {
                    owner: owner.to_owned(),
                    field: field.clone(),
                    reason: format!("{value} is outside {low}..={high}; the default is {default}"),
                });
            }
        }
    }
    Ok(())
}

impl Entry<dyn Process> {
    /// The entry of a parameter struct that is a process.
    pub const fn process<P: Parameters + Process + 'static>(
        name: &'static str,
        about: &'static str,
        cites: &'static [&'static str],
    ) -> Self {
        Self {
            name,
            schema: schema_of::<P>,
            defaults: defaults_of::<P>,
            make: |v| Ok(Box::new(parameters_from::<P>(v)?)),
            about,
            cites,
        }
    }
}

impl Entry<dyn Generator> {
    /// The entry of a parameter struct that is a generator.
    pub const fn generator<P: Parameters + Generator + 'static>(
        name: &'static str,
        about: &'static str,
        cites: &'static [&'static str],
    ) -> Self {
        Self {
            name,
            schema: schema_of::<P>,
            defaults: defaults_of::<P>,
            make: |v| Ok(Box::new(parameters_from::<P>(v)?)),
            about,
            cites,
        }
    }
}
