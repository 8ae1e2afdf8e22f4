//! Layers of plants, and those of others that they look at.

use crate::types::TYPES;
use eyot_core::LayerSpec;

/// Share of the ground that bushes cover.
pub const SHRUBS: LayerSpec = LayerSpec::new("shrubs", "1", "Share of the ground that bushes cover", (0.0, 1.0));
/// Share of the ground that grass covers.
pub const GRASS: LayerSpec = LayerSpec::new("grass", "1", "Share of the ground that grass covers", (0.0, 1.0));
/// Leaf area of trees and bushes.
pub const LEAF_AREA: LayerSpec =
    LayerSpec::new("leaf_area", "1", "Area of the leaves of trees and bushes over that of the ground", (0.0, 1000.0));
/// Height of the plants that dominate.
pub const CANOPY_HEIGHT: LayerSpec =
    LayerSpec::new("canopy_height", "m", "Mean height of the type of plants that dominates", (0.0, 200.0));
/// The type that dominates.
pub const PLANT_TYPE: LayerSpec =
    LayerSpec::new("plant_type", "1", "Type of plants that dominates, number of a class", (0.0, TYPES.len() as f32));
/// Dry matter of all plants.
pub const PLANT_MASS: LayerSpec = LayerSpec::new("plant_mass", "kg/m2", "Dry matter of all plants", (0.0, 1000.0));
/// Where it burnt.
pub const BURNT: LayerSpec = LayerSpec::new("burnt_area", "1", "1 where it burnt in the last year", (0.0, 1.0));
/// The ground of the year before.
pub const PLANTS_GROUND: LayerSpec =
    LayerSpec::new("plants_ground", "m", "Height of the ground when plants last grew a year", (-12000.0, 12000.0));
/// What the ground would wear like without plants.
pub const ERODIBILITY_BARE: LayerSpec =
    LayerSpec::new("erodibility_bare", "1", "Erodibility as it would be without plants", (0.0, 1e6));
/// What plants made of it.
pub const ERODIBILITY_HELD: LayerSpec = LayerSpec::new(
    "erodibility_held",
    "1",
    "Erodibility as plants left it, by which they see whether somebody wrote it since; below 0: not yet",
    (-1.0, 1e6),
);
/// Rivers, as the process `rivers` leaves them.
pub const RIVER: LayerSpec = LayerSpec::new("river", "1", "Share of the cell that a river covers", (0.0, 1.0));

/// What the process `climate` keeps.
pub(crate) const CLIMATE: [&str; 6] =
    ["temperature_mean", "temperature_cos", "temperature_sin", "rain_mean", "rain_cos", "rain_sin"];

const fn within(name: &'static str, meaning: &'static str) -> LayerSpec {
    LayerSpec::new(name, "1", meaning, (-1e6, 1e6))
}

/// What lives within a year.
pub(crate) const SCRATCH: [LayerSpec; 17] = [
    within("site_winter", "Mean of the coldest month"),
    within("site_summer", "Mean of the warmest month"),
    within("site_warmth", "Degrees above 5 °C over the days of the year"),
    within("site_trees", "How well trees grow in this season"),
    within("site_moisture", "Water over potential evaporation"),
    within("site_driest", "The same in the driest month"),
    within("site_leaves", "Most leaf area that there is water for"),
    within("overturned", "Share of the plants that slides and floods killed"),
    within("leaves_above_0", "Leaf area above the ground"),
    within("leaves_above_5", "Leaf area above 5 m"),
    within("leaves_above_16", "Leaf area above 16 m"),
    within("turf", "How much grass hinders young trees"),
    within("burns", "1 where fire can go"),
    within("suits", "How well the climate suits a type"),
    within("most_mass", "Dry matter of the type that dominates so far"),
    within("tree_leaves", "Leaf area of trees"),
    within("shrub_leaves", "Leaf area of bushes"),
];
