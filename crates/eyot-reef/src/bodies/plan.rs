//! What the bodies of a species look like: data, as everything about species.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Growth forms of corals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A boulder with lobes.
    #[default]
    Massive,
    /// Branches that a grammar draws.
    Branching,
    /// Upright fingers.
    Columnar,
    /// A crust on the ground.
    Encrusting,
    /// Whorls of leaves.
    Foliaceous,
    /// A plate on a stalk.
    Laminar,
    /// A lens with septa that lies loose, as mushroom corals do.
    FreeLiving,
}

/// How the bodies of a species are built and coloured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BodyPlan {
    /// Growth form.
    pub shape: Shape,
    /// Height of the body over its mean radius. The body is stretched or pressed from there until it has the volume that the
    /// community gives the colony.
    #[schemars(range(min = 0.02, max = 4.0), extend("unit" = "1"))]
    pub height: f32,
    /// Massive: how much lobes differ. 0 is smooth.
    #[schemars(range(min = 0.0, max = 0.8), extend("unit" = "1"))]
    pub roughness: f32,
    /// Branching: a grammar, `thicket`, `cauliflower`, or the text of one. Its lengths are in radii of the full-grown colony.
    pub grammar: String,
    /// Each colony has a colour of its own between these two, sRGB.
    pub colours: [[u8; 3]; 2],
}

impl Default for BodyPlan {
    fn default() -> Self {
        Self {
            shape: Shape::Massive,
            height: 1.0,
            roughness: 0.4,
            grammar: "thicket".into(),
            colours: [[150, 132, 74], [146, 122, 138]],
        }
    }
}

impl Shape {
    /// True if the body is thin parts with water between.
    pub(crate) const fn is_open(self) -> bool {
        matches!(self, Self::Branching | Self::Columnar | Self::Foliaceous | Self::Laminar)
    }
}
