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
    BuiltIn { name: "island", text: include_str!("../../../recipes/island.toml") },
    BuiltIn { name: "atoll", text: include_str!("../../../recipes/atoll.toml") },
    BuiltIn { name: "real", text: include_str!("../../../recipes/real.toml") },
    BuiltIn { name: "alps", text: include_str!("../../../recipes/alps.toml") },
    BuiltIn { name: "canyon", text: include_str!("../../../recipes/canyon.toml") },
];

/// All built-in height maps, named `builtin:NAME` in recipes.
pub(crate) const DATA: &[(&str, &[u8])] = &[("jacksboro.tif", include_bytes!("../../../data/jacksboro.tif"))];

/// The bytes of a built-in height map.
pub(crate) fn data(name: &str) -> Option<&'static [u8]> {
    DATA.iter().find(|d| d.0 == name).map(|d| d.1)
}

impl BuiltIn {
    /// The sentence that the recipe says about itself.
    pub fn about(&self) -> String {
        let doc = crate::node::Node::parse(self.text, 0).ok();
        doc.and_then(|d| d.get("about").and_then(|n| n.text().map(str::to_owned))).unwrap_or_default()
    }
}
