//! What a layer that a recipe names is.

use crate::describe::{Description, Expression, ParameterInfo};
use crate::diagnostic::alternatives;
use crate::recipe::{Step, Work};
use crate::registry::Registry;
use eyot_core::LayerSpec;
use eyot_core::layer::known;
use eyot_core::process::Access;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::collections::BTreeMap;

pub(crate) const KNOWN: [LayerSpec; 11] = [
    known::HEIGHT,
    known::MISSING,
    known::WATER,
    known::SEDIMENT,
    known::LIMESTONE,
    known::WETNESS,
    known::GROWTH,
    known::ARIDITY,
    known::CARBON,
    known::LAKE,
    known::DRAINED_AREA,
];

/// The layer of that name, if it is one that comes with Eyot.
pub fn known(name: &str) -> Option<LayerSpec> {
    KNOWN.into_iter().find(|s| s.name == name)
}

/// The specification of a layer that a generator makes: what a process of the recipe takes it for, a known one, or a plain
/// number without bounds.
pub fn spec(name: &str, step: &str, all: &[Step]) -> LayerSpec {
    let uses = all.iter().flat_map(|s| if let Work::Simulate(w) = &s.work { w.processes.as_slice() } else { &[] });
    let theirs = uses.filter_map(|u| u.make().ok()).flat_map(|p| p.layers()).map(|l| l.spec);
    theirs.chain(KNOWN).find(|s| s.name == name).unwrap_or_else(|| LayerSpec {
        name: Cow::Owned(name.to_owned()),
        meaning: Cow::Owned(format!("Made by the step `{step}` of the recipe")),
        ..LayerSpec::new("", "1", "", (f32::MIN, f32::MAX))
    })
}

/// All layers that processes work with: what each is, and whose it is.
pub(crate) fn describe(registry: &Registry) -> Description {
    let mut all: BTreeMap<String, (LayerSpec, Vec<&str>, Vec<&str>)> =
        KNOWN.into_iter().map(|s| (s.name.to_string(), (s, Vec::new(), Vec::new()))).collect();
    for entry in registry.processes() {
        let Ok(process) = (entry.make)(json!({})) else { continue };
        for used in process.layers() {
            let (_, changed, read) =
                all.entry(used.spec.name.to_string()).or_insert_with(|| (used.spec.clone(), Vec::new(), Vec::new()));
            let list = if used.access == Access::Read { read } else { changed };
            list.push(entry.name);
        }
    }
    let parameters = all.into_values().map(|(spec, changed, read)| {
        let by = |verb: &str, who: &[&str]| {
            if who.is_empty() {
                String::new()
            } else {
                format!(" {verb} by {}.", alternatives(who.iter().copied()).replace(" or ", " and "))
            }
        };
        ParameterInfo {
            name: spec.name.to_string(),
            meaning: format!("{}.{}{}", spec.meaning, by("Changed", &changed), by("Read", &read)),
            unit: spec.unit.to_string(),
            takes: "a layer".to_owned(),
            minimum: None,
            maximum: None,
            choices: Vec::new(),
            default: Value::Null,
            expression: Expression::No,
        }
    });
    Description {
        name: "layers".to_owned(),
        kind: "table",
        summary: "Layers that processes work with.".to_owned(),
        details: "A process makes those that are missing. Generators and the recipe's own rules may make any others."
            .to_owned(),
        parameters: parameters.collect(),
        about: String::new(),
        sources: Vec::new(),
    }
}
