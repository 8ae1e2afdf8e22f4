//! The recipes and height maps that come inside the program.

/// A recipe that comes with Eyot.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Name on the command line.
    pub name: &'static str,
    /// The document.
    pub text: &'static str,
}

/// All built-in recipes.
pub const RECIPES: &[BuiltIn] = &[
    BuiltIn { name: "island", text: include_str!("../recipes/island.toml") },
    BuiltIn { name: "atoll", text: include_str!("../recipes/atoll.toml") },
    BuiltIn { name: "real", text: include_str!("../recipes/real.toml") },
    BuiltIn { name: "alps", text: include_str!("../recipes/alps.toml") },
    BuiltIn { name: "fjord", text: include_str!("../recipes/fjord.toml") },
    BuiltIn { name: "valley", text: include_str!("../recipes/valley.toml") },
    BuiltIn { name: "taiga", text: include_str!("../recipes/taiga.toml") },
    BuiltIn { name: "savanna", text: include_str!("../recipes/savanna.toml") },
    BuiltIn { name: "canyon", text: include_str!("../recipes/canyon.toml") },
    BuiltIn { name: "mesa", text: include_str!("../recipes/mesa.toml") },
    BuiltIn { name: "cuesta", text: include_str!("../recipes/cuesta.toml") },
    BuiltIn { name: "strata", text: include_str!("../recipes/strata.toml") },
    BuiltIn { name: "reef", text: include_str!("../recipes/reef.toml") },
    BuiltIn { name: "reef-slope", text: include_str!("../recipes/reef-slope.toml") },
    BuiltIn { name: "bleaching", text: include_str!("../recipes/bleaching.toml") },
    BuiltIn { name: "nitrogen", text: include_str!("../recipes/nitrogen.toml") },
    BuiltIn { name: "wildfire", text: include_str!("../recipes/wildfire.toml") },
    BuiltIn { name: "life", text: include_str!("../recipes/life.toml") },
    BuiltIn { name: "world", text: include_str!("../recipes/world.toml") },
    BuiltIn { name: "iceage", text: include_str!("../recipes/iceage.toml") },
    BuiltIn { name: "locked", text: include_str!("../recipes/locked.toml") },
    BuiltIn { name: "earth", text: include_str!("../recipes/earth.toml") },
    BuiltIn { name: "pangaea", text: include_str!("../recipes/pangaea.toml") },
];

/// A height map that comes with Eyot.
#[derive(Clone, Copy, Debug)]
pub struct Data {
    /// Named `builtin:NAME` in recipes.
    pub name: &'static str,
    /// The file.
    pub bytes: &'static [u8],
    /// Keys in `references.bib`.
    pub cites: &'static [&'static str],
}

/// All built-in height maps.
pub const DATA: &[Data] = &[
    Data { name: "jacksboro.tif", bytes: include_bytes!("../data/jacksboro.tif"), cites: &["jacksboro", "farr2007"] },
    Data { name: "island-reef.tif", bytes: include_bytes!("../data/island-reef.tif"), cites: &[] },
    Data { name: "earth.tif", bytes: include_bytes!("../data/earth.tif"), cites: &["etopo60"] },
];

/// The built-in height map of that name.
pub fn data(name: &str) -> Option<&'static Data> {
    DATA.iter().find(|d| d.name == name)
}

impl BuiltIn {
    /// The sentence that the recipe says about itself.
    pub fn about(&self) -> String {
        let doc = crate::node::Node::parse(self.text, 0).ok();
        doc.and_then(|d| d.get("about").and_then(|n| n.text().map(str::to_owned))).unwrap_or_default()
    }
}
