//! What a layer that a recipe names is.

use crate::recipe::{Step, Work};
use eyot_core::LayerSpec;
use eyot_core::layer::known;
use std::borrow::Cow;

const KNOWN: [LayerSpec; 10] = [
    known::HEIGHT,
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
