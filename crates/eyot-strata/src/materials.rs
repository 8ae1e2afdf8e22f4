//! Materials of which beds are made, and what is known of them.

use eyot_core::layer::{Class, class};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A kind of rock, or of loose ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Material {
    /// Name in tables and legends.
    pub name: String,
    /// Steepest slope that a wall of it keeps.
    #[schemars(range(min = 1.0, max = 89.0), extend("unit" = "degree"))]
    pub talus: f32,
    /// How fast it wears, over loose ground.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "1"))]
    pub erodibility: f32,
    /// Mass of a cubic metre, pores and their water included.
    #[schemars(range(min = 100.0, max = 10000.0), extend("unit" = "kg/m3"))]
    pub density: f32,
}

impl Default for Material {
    fn default() -> Self {
        material("rock", 60.0, 0.3, 2600.0)
    }
}

fn material(name: &str, talus: f32, erodibility: f32, density: f32) -> Material {
    Material { name: name.into(), talus, erodibility, density }
}

/// The seven of the rock cycle, softest first. Angles and erodibilities are those of the source, chosen for pictures and not measured;
/// densities are the averages of wet samples of Telford, Geldart and Sheriff 1990, table 2.1 (soil for regolith).
pub fn standard() -> Vec<Material> {
    vec![
        material("regolith", 33.0, 1.0, 1920.0),
        material("sand", 45.0, 0.9, 2000.0),
        material("sandstone", 50.0, 0.7, 2350.0),
        material("limestone", 60.0, 0.65, 2550.0),
        material("schist", 60.0, 0.3, 2640.0),
        material("marble", 65.0, 0.1, 2750.0),
        material("granite", 70.0, 0.05, 2640.0),
    ]
}

/// Names and colours of the standard materials, and of those that a recipe adds after them.
const CLASSES: &[Class] = &[
    class("regolith", [170, 150, 118]),
    class("sand", [224, 202, 150]),
    class("sandstone", [190, 112, 70]),
    class("limestone", [208, 200, 172]),
    class("schist", [104, 116, 116]),
    class("marble", [236, 232, 224]),
    class("granite", [168, 130, 128]),
    class("material 8", [134, 98, 74]),
    class("material 9", [142, 138, 112]),
    class("material 10", [222, 196, 152]),
    class("material 11", [176, 104, 74]),
    class("material 12", [158, 92, 70]),
    class("material 13", [190, 120, 92]),
    class("material 14", [204, 190, 164]),
    class("material 15", [150, 140, 130]),
    class("material 16", [206, 150, 96]),
];

/// The classes of the layer `material`, by the numbers of the usual materials; `None` for all other layers.
pub fn classes(layer: &str) -> Option<&'static [Class]> {
    (layer == "material").then_some(CLASSES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_named_as_the_materials_are() {
        let names: Vec<String> = standard().into_iter().map(|m| m.name).collect();
        assert!(CLASSES.iter().map(|c| c.name).take(names.len()).eq(names.iter().map(String::as_str)));
        assert!(classes("height").is_none());
    }
}
