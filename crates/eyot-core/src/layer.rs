//! Layers: named fields with unit, range, meaning and behaviour at the rim.

use crate::field::Field;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Where on a cell a layer's value lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Centering {
    /// In the middle of the cell.
    #[default]
    Cell,
    /// On the face towards the next column (east). Column -1 exists on open and wrapping rims.
    FaceX,
    /// On the face towards the next row (south). Row -1 exists on open and wrapping rims.
    FaceY,
}

/// What a rule reads from a layer beyond a rim that does not wrap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum GhostFill {
    /// The value of the nearest cell: no gradient across the rim.
    #[default]
    Nearest,
    /// Zero: nothing there.
    Zero,
}

/// A class of a layer that holds numbers of classes: the number is its place in a table of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Class {
    /// What people call it.
    pub name: &'static str,
    /// Its colour on maps, sRGB.
    pub colour: [u8; 3],
}

/// Shorthand for [`Class`].
pub const fn class(name: &'static str, colour: [u8; 3]) -> Class {
    Class { name, colour }
}

/// What a layer is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayerSpec {
    /// Unique name, lower case with underscores.
    pub name: Cow<'static, str>,
    /// Unit in SI notation, `1` for a plain number.
    pub unit: Cow<'static, str>,
    /// One sentence of meaning.
    pub meaning: Cow<'static, str>,
    /// Smallest and largest valid value.
    pub range: (f32, f32),
    /// Where on the cell it lives.
    pub centering: Centering,
    /// What rules read beyond a closed rim.
    pub beyond_closed: GhostFill,
    /// What rules read beyond an open rim.
    pub beyond_open: GhostFill,
}

impl LayerSpec {
    /// A cell layer with the nearest value beyond the rim.
    pub const fn new(name: &'static str, unit: &'static str, meaning: &'static str, range: (f32, f32)) -> Self {
        Self {
            name: Cow::Borrowed(name),
            unit: Cow::Borrowed(unit),
            meaning: Cow::Borrowed(meaning),
            range,
            centering: Centering::Cell,
            beyond_closed: GhostFill::Nearest,
            beyond_open: GhostFill::Nearest,
        }
    }

    /// True for what can name a layer: up to 64 lower-case letters, digits and underscores, no digit first. Names become parts
    /// of file names.
    pub fn is_name(name: &str) -> bool {
        let plain = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'_';
        (1..=64).contains(&name.len()) && !name.as_bytes()[0].is_ascii_digit() && name.bytes().all(plain)
    }

    /// True for the names of axes and of the place on Earth, which files of research keep for themselves: no layer can have them.
    pub fn is_axis(name: &str) -> bool {
        ["x", "y", "x_face", "y_face", "time", "spatial_ref"].contains(&name)
    }

    /// The same layer on a face.
    pub const fn on(mut self, centering: Centering) -> Self {
        self.centering = centering;
        self.beyond_closed = GhostFill::Zero;
        self.beyond_open = GhostFill::Zero;
        self
    }

    /// The same layer, empty beyond an open rim: what is there has fallen off.
    pub const fn empty_outside(mut self) -> Self {
        self.beyond_open = GhostFill::Zero;
        self
    }
}

/// A named scalar field.
#[derive(Clone, Debug)]
pub struct Layer {
    /// What it is.
    pub spec: LayerSpec,
    /// Its values.
    pub field: Field,
}

impl PartialEq for Layer {
    /// Compares all that the layer's state is: on faces, the outer ones too.
    fn eq(&self, other: &Self) -> bool {
        let on_faces = self.spec.centering != Centering::Cell;
        self.spec == other.spec
            && self.field == other.field
            && (!on_faces || self.field.outer_faces() == other.field.outer_faces())
    }
}

/// Names and specifications of the layers that several crates share.
pub mod known {
    use super::LayerSpec;

    /// Solid ground: bedrock, loose material and reef limestone together.
    pub const HEIGHT: LayerSpec =
        LayerSpec::new("height", "m", "Height of the solid ground, reef limestone included", (-12000.0, 12000.0));
    /// Cells of which an imported height map knows nothing.
    pub const MISSING: LayerSpec = LayerSpec::new(
        "missing",
        "1",
        "1 where the imported height map has no value, and heights are only filled in from around",
        (0.0, 1.0),
    );
    /// Standing and flowing fresh water.
    pub const WATER: LayerSpec =
        LayerSpec::new("water", "m", "Depth of fresh water on the ground", (0.0, 12000.0)).empty_outside();
    /// Lakes that depressions would hold.
    pub const LAKE: LayerSpec =
        LayerSpec::new("lake", "m", "Depth of the lake that would stand here if depressions were full", (0.0, 12000.0));
    /// Area from which water flows through a cell.
    pub const DRAINED_AREA: LayerSpec =
        LayerSpec::new("drained_area", "m2", "Area that drains through this cell, itself included", (0.0, f32::MAX));
    /// Sediment carried by the water.
    pub const SEDIMENT: LayerSpec =
        LayerSpec::new("sediment", "m", "Sediment suspended in the water, as thickness of ground", (0.0, 1000.0))
            .empty_outside();
    /// Reef limestone.
    pub const LIMESTONE: LayerSpec =
        LayerSpec::new("limestone", "m", "Thickness of reef limestone grown here; part of the height", (0.0, 12000.0));
    /// Loose ground.
    pub const SAND: LayerSpec =
        LayerSpec::new("sand", "m", "Thickness of sand and soil; part of the height", (0.0, 12000.0)).empty_outside();
    /// Bounded river counter for colours.
    pub const WETNESS: LayerSpec =
        LayerSpec::new("wetness", "1", "How much running water this cell has seen lately", (0.0, 1.0));
    /// Bounded coral counter for colours.
    pub const GROWTH: LayerSpec = LayerSpec::new("growth", "1", "How much coral has grown here lately", (0.0, 1.0));
    /// Dryness for colours.
    pub const ARIDITY: LayerSpec =
        LayerSpec::new("aridity", "1", "How dry the land is: 0 green, 1 beds of bare rock and sand", (0.0, 1.0));
    /// Dissolved inorganic carbon available to corals.
    pub const CARBON: LayerSpec =
        LayerSpec::new("carbon", "1", "Inorganic carbon in the sea water relative to the open sea", (0.0, 1.0));
    /// How easily the ground wears here.
    pub const ERODIBILITY: LayerSpec = LayerSpec::new(
        "erodibility",
        "1",
        "How fast what lies at the surface wears, over loose ground; below 0 counts as 0",
        (0.0, 1e6),
    );
    /// How far down the material at the surface reaches.
    pub const BED_LEFT: LayerSpec =
        LayerSpec::new("bed_left", "m", "Thickness of the material at the surface, down to the next one", (0.0, 1e6));
    /// What comes to light below [`BED_LEFT`].
    pub const ERODIBILITY_BELOW: LayerSpec = LayerSpec::new(
        "erodibility_below",
        "1",
        "How fast the material below the one at the surface wears, over loose ground",
        (0.0, 1e6),
    );
    /// Surface of the bedrock.
    pub const BEDROCK: LayerSpec = LayerSpec::new(
        "bedrock",
        "m",
        "Height of the bedrock's surface; what lies on it is loose",
        (-12000.0, 12000.0),
    );
    /// Steepness of walls.
    pub const ROCK_SLOPE: LayerSpec =
        LayerSpec::new("rock_slope", "1", "Tangent of the steepest slope that the rock keeps here", (0.0, 100.0));
}
