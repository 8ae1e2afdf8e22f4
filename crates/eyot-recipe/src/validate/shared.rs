//! Parameters that belong to the world and not to one process (`shared` in their schema): the same in all processes of a step.

use crate::recipe::ProcessUse;
use serde_json::Value;
use std::collections::BTreeMap;

/// A process whose parameter is not what the others have.
pub(crate) struct Conflict {
    /// Whose value was given.
    pub(crate) process: &'static str,
    /// The parameter.
    pub(crate) key: String,
    pub(crate) message: String,
    pub(crate) help: String,
}

/// What processes that act do not agree on, of the parameters that were `given` for a process.
pub(crate) fn conflicts(processes: &[ProcessUse], given: &dyn Fn(&str, &str) -> bool) -> Vec<Conflict> {
    let mut values: BTreeMap<String, Vec<(&'static str, Value)>> = BTreeMap::new();
    for u in processes.iter().filter(|u| u.enabled) {
        let schema = u.actor.schema();
        let shared = schema["properties"].as_object().into_iter().flatten().filter(|(_, p)| p["shared"] == true);
        for (key, property) in shared {
            let number = || u.parameters.get(key).unwrap_or(&property["default"]).clone();
            let term = u.terms.list().iter().find(|t| t.parameter() == *key);
            let value = term.map_or_else(number, |t| Value::from(t.text()));
            values.entry(key.clone()).or_default().push((u.actor.name(), value));
        }
    }
    // Parameters are single precision, and their defaults would show it.
    let number = |v: &Value| v.as_f64().map(|x| x as f32);
    let told = |v: &Value| number(v).map_or_else(|| v.to_string(), |x| x.to_string());
    // Two expressions are the same if their texts are.
    let same = |a: &Value, b: &Value| if a.is_number() { number(a) == number(b) } else { a == b };
    let mut out = Vec::new();
    for (key, of) in values {
        let Some((name, value)) = of.iter().find(|(name, _)| given(name, &key)) else { continue };
        let others: Vec<&str> = of.iter().filter(|(_, v)| !same(v, value)).map(|(n, _)| *n).collect();
        let Some(first) = of.iter().find(|(_, v)| !same(v, value)) else { continue };
        let message = format!("`{name}.{key}` is {}, but `{}.{key}` is {}", told(value), first.0, told(&first.1));
        let remedy: Vec<String> = others.iter().map(|n| format!("{n}.{key} = {}", told(value))).collect();
        let help = format!("the processes of a world share it: write {} as well", remedy.join(" and "));
        out.push(Conflict { process: name, key, message, help });
    }
    out
}
