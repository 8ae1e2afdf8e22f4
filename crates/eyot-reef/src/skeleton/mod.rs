//! What holds a colony up: balls, cylinders and cones, from the colony's rays, its species and its own random numbers.
//!
//! Places are m from the colony's centre on the sea floor: x to the east, y up, z to the south (where the plot's y points).

mod branching;
mod chance;
mod cut;
mod massive;
mod outline;
mod relief;
mod shapes;

pub(crate) use branching::drawing;
pub(crate) use chance::Chance;
pub(crate) use cut::Cut;
pub(crate) use outline::Outline;
pub(crate) use relief::{Relief, ReliefKind};

use crate::lsystem::Segment;
use branching::Branches;
use eyot_mesh::Primitive;

/// Grammars of branching bodies, by name.
pub(crate) const GRAMMARS: [(&str, &str); 2] =
    [("thicket", include_str!("grammars/thicket.txt")), ("cauliflower", include_str!("grammars/cauliflower.txt"))];

/// How a skeleton is made.
pub(crate) enum Plan<'a> {
    Massive { roughness: f32 },
    Branching { drawing: &'a [Segment], full_radius: f32, thinnest: f32 },
    Columnar,
    Foliaceous,
    Laminar,
}

/// The skeleton of a colony of this `height` (in mean radii) and volume, m3.
pub(crate) fn skeleton(plan: &Plan<'_>, outline: &Outline, height: f32, volume: f32, chance: Chance) -> Vec<Primitive> {
    match *plan {
        Plan::Massive { roughness } => massive::massive(outline, roughness, chance),
        Plan::Branching { drawing, full_radius, thinnest } => {
            branching::branching(outline, &Branches { drawing, full_radius, height, volume, thinnest })
        }
        Plan::Columnar => shapes::columnar(outline, height, chance),
        Plan::Foliaceous => shapes::foliaceous(outline, height, chance),
        Plan::Laminar => shapes::laminar(outline, height, chance),
    }
}
