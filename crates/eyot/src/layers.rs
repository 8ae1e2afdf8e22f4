//! What a layer that a recipe names is.

use eyot_core::LayerSpec;
use eyot_core::layer::known;
use std::borrow::Cow;

const KNOWN: [LayerSpec; 7] =
    [known::HEIGHT, known::WATER, known::SEDIMENT, known::LIMESTONE, known::WETNESS, known::GROWTH, known::CARBON];

/// The specification of a layer that a generator makes: a known one, or a plain number without bounds.
pub(crate) fn spec(name: &str, step: &str) -> LayerSpec {
    KNOWN.into_iter().find(|s| s.name == name).unwrap_or_else(|| LayerSpec {
        name: Cow::Owned(name.to_owned()),
        meaning: Cow::Owned(format!("Made by the step `{step}` of the recipe")),
        ..LayerSpec::new("", "1", "", (f32::MIN, f32::MAX))
    })
}
