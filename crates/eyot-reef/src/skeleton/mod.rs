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

pub(crate) use chance::Chance;
pub(crate) use cut::Cut;
pub(crate) use outline::Outline;
pub(crate) use relief::{Relief, ReliefKind};

use crate::lsystem::Grammar;
use branching::Branches;
use eyot_core::Result;
use eyot_mesh::Primitive;

/// Grammars of branching bodies, by name.
pub(crate) const GRAMMARS: [(&str, &str); 2] =
    [("thicket", include_str!("grammars/thicket.txt")), ("cauliflower", include_str!("grammars/cauliflower.txt"))];

/// How a skeleton is made.
pub(crate) enum Plan<'a> {
    Massive { roughness: f32 },
    Branching { grammar: &'a Grammar, full_radius: f32, thinnest: f32 },
    Columnar,
    Foliaceous,
    Laminar,
}

/// The skeleton of a colony of this `height` (in mean radii) and volume, m3.
///
/// # Errors
/// If a grammar makes more than fits into 256 MiB, or leaves the range of numbers.
pub(crate) fn skeleton(
    plan: &Plan<'_>,
    outline: &Outline,
    height: f32,
    volume: f32,
    chance: Chance,
) -> Result<Vec<Primitive>> {
    Ok(match *plan {
        Plan::Massive { roughness } => massive::massive(outline, roughness, chance),
        Plan::Branching { grammar, full_radius, thinnest } => {
            branching::branching(outline, &Branches { grammar, full_radius, height, volume, thinnest }, chance)?
        }
        Plan::Columnar => shapes::columnar(outline, height, chance),
        Plan::Foliaceous => shapes::foliaceous(outline, height, chance),
        Plan::Laminar => shapes::laminar(outline, height, chance),
    })
}
