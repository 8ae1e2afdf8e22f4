//! Materials of which beds are made, and what is known of them.

use crate::sequence::Sequence;
use eyot_core::layer::{Class, class};
use eyot_core::{World, intern};
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
    /// Colour in sections, on maps and in legends, written `#rrggbb`; one by its number if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(regex(pattern = r"^#[0-9a-fA-F]{6}$"))]
    pub colour: Option<String>,
}

impl Material {
    /// Its colour, sRGB, if it is the material of this number.
    pub fn shown(&self, number: usize) -> [u8; 3] {
        self.colour.as_deref().and_then(hexadecimal).unwrap_or_else(|| colour(number))
    }
}

/// Red, green and blue of `#rrggbb`.
pub(crate) fn hexadecimal(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let part = |i: usize| u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).ok();
    Some([part(0)?, part(1)?, part(2)?])
}

impl Default for Material {
    fn default() -> Self {
        material("rock", 60.0, 0.3, 2600.0)
    }
}

fn material(name: &str, talus: f32, erodibility: f32, density: f32) -> Material {
    Material { name: name.into(), talus, erodibility, density, colour: None }
}

/// The seven of the rock cycle, softest first. Angles and erodibilities (there solubilities) are those of the source, chosen for pictures
/// and not measured, but for the angle of regolith, there 20 degrees, which is that of dry soil here; densities are the averages of wet samples of Telford, Geldart and Sheriff 1990, table 2.1 (soil for regolith).
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
    class("marble", [208, 202, 196]),
    class("granite", [168, 130, 128]),
    class("material 8", [120, 92, 70]),
    class("material 9", [92, 108, 140]),
    class("material 10", [150, 140, 84]),
    class("material 11", [130, 70, 72]),
    class("material 12", [84, 120, 90]),
    class("material 13", [70, 70, 78]),
    class("material 14", [196, 170, 186]),
    class("material 15", [148, 168, 178]),
    class("material 16", [206, 150, 96]),
];

/// The classes of the layer `material`, by the numbers of the usual materials; `None` for all other layers.
pub fn classes(layer: &str) -> Option<&'static [Class]> {
    (layer == "material").then_some(CLASSES)
}

/// The colour of a material by its number, sRGB: those beyond the list begin again after the usual ones.
pub fn colour(number: usize) -> [u8; 3] {
    let usual = 7;
    let n = if number < CLASSES.len() { number } else { usual + (number - usual) % (CLASSES.len() - usual) };
    CLASSES[n].colour
}

/// As [`classes`], with the materials of a world that has strata: those that its recipe made, too.
pub fn classes_of(world: &World, layer: &str) -> Option<Vec<Class>> {
    let sequence = Sequence::of(world).ok().flatten().filter(|_| layer == "material")?;
    let named = |(n, m): (usize, &Material)| {
        // Too many names end in those of the list.
        let name = intern(&m.name).unwrap_or(CLASSES[n.min(CLASSES.len() - 1)].name);
        Class { name, colour: m.shown(n) }
    };
    Some(sequence.materials.iter().enumerate().map(named).collect())
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
