//! The keys of a recipe as structs. Their schemas check recipes, complete them in editors and make the reference.

use crate::merge::Merge;
use eyot_core::Edge;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The head of a recipe.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub(crate) struct Document {
    /// What the landscape is called.
    pub(crate) name: String,
    /// One sentence about the landscape.
    pub(crate) about: String,
    /// Seed of all random numbers. The same recipe with the same seed gives the same bytes.
    #[schemars(extend("unit" = "1"))]
    pub(crate) seed: u64,
    /// Level of the sea at the start, in the datum of the height.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub(crate) sea_level: f64,
}

/// `256` or `[256, 128]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum Cells {
    One(#[schemars(range(min = 1))] u32),
    Two(#[schemars(inner(range(min = 1)))] [u32; 2]),
}

/// `10.0` or `[10.0, 12.5]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum Lengths {
    One(#[schemars(range(min = 1e-6, max = 1e10))] f64),
    Two(#[schemars(inner(range(min = 1e-6, max = 1e10)))] [f64; 2]),
}

/// `"closed"` or `["wrap", "open"]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum Edges {
    One(Edge),
    Two([Edge; 2]),
}

/// The grid.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Grid {
    /// Columns and rows, or one number for a square.
    #[schemars(extend("unit" = "1"))]
    pub(crate) size: Option<Cells>,
    /// Size of a cell, west-east and north-south, or one number for square cells. 10 m if nothing else is said.
    #[schemars(extend("unit" = "m"))]
    pub(crate) cell: Option<Lengths>,
    /// Extent of the whole grid, west-east and north-south, instead of the cell size.
    #[schemars(extend("unit" = "m"))]
    pub(crate) extent_m: Option<Lengths>,
    /// What lies beyond the border: a wall, a free outfall, or the far side; one for both axes, or west-east and north-south.
    pub(crate) rim: Option<Edges>,
    /// A height map whose size, cells and place on Earth the grid takes over; relative to the recipe's folder.
    pub(crate) from: Option<String>,
}

/// A step that generates.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub(crate) struct Generate {
    /// A name for messages and for `--set NAME.parameter=value`.
    pub(crate) name: Option<String>,
    /// One sentence about the step.
    pub(crate) about: Option<String>,
    /// Whether the step is done.
    pub(crate) enabled: bool,
    /// The generator.
    pub(crate) generate: String,
    /// The layer that it works on.
    #[schemars(regex(pattern = r"^[a-z_][a-z0-9_]*$"))]
    pub(crate) layer: String,
    /// How the new values join the layer. A source adds and a filter replaces if nothing else is said.
    pub(crate) merge: Option<Merge>,
    /// A layer from 0 to 1 that says where how much of the change is kept.
    pub(crate) mask: Option<String>,
    /// Strength of the merge: a factor on the new values, or the weight of a `lerp`.
    #[schemars(range(min = -1e6, max = 1e6), extend("unit" = "1"))]
    pub(crate) amount: f32,
    /// A seed for this step alone, so that it stays as it is when steps move or the recipe's seed changes.
    #[schemars(extend("unit" = "1"))]
    pub(crate) seed: Option<u64>,
}

impl Default for Generate {
    fn default() -> Self {
        Self {
            name: None,
            about: None,
            enabled: true,
            generate: String::new(),
            layer: "height".to_owned(),
            merge: None,
            mask: None,
            amount: 1.0,
            seed: None,
        }
    }
}

/// One name or several.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum Names {
    One(String),
    Many(#[schemars(length(min = 1))] Vec<String>),
}

/// A step that simulates. Each process has a table of its own: `hydraulic.rain = 0.002`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub(crate) struct Simulate {
    /// A name for messages and for `--set NAME.parameter=value`.
    pub(crate) name: Option<String>,
    /// One sentence about the step.
    pub(crate) about: Option<String>,
    /// Whether the step is done.
    pub(crate) enabled: bool,
    /// The processes, in the order in which they act within one step.
    pub(crate) simulate: Names,
    /// How many steps.
    #[schemars(range(min = 1), extend("unit" = "1"))]
    pub(crate) steps: u64,
}

impl Default for Simulate {
    fn default() -> Self {
        Self { name: None, about: None, enabled: true, simulate: Names::Many(Vec::new()), steps: 1000 }
    }
}

/// When a process acts; beside its own parameters.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub(crate) struct Schedule {
    /// The process acts in every n-th step.
    #[schemars(range(min = 1, max = 1_000_000_000), extend("unit" = "1"))]
    pub(crate) every: u64,
    /// Whether the process acts at all.
    pub(crate) enabled: bool,
}

impl Default for Schedule {
    fn default() -> Self {
        Self { every: 1, enabled: true }
    }
}

/// What a file holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ExportFormat {
    /// Grey picture of 16 bits; the text inside says which heights black and white are.
    Png16,
    /// GeoTIFF of 32-bit floats with its place on Earth, for GIS programs.
    #[default]
    GeoTiff,
    /// Bare 32-bit floats, little-endian, row by row from the north.
    R32,
    /// glTF 2.0 binary: the terrain as a coloured mesh with levels of detail.
    Glb,
    /// Picture of a layer in colours, PNG.
    Map,
}

/// A file to write when the run is done.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Export {
    /// What the file holds.
    pub format: ExportFormat,
    /// The layers, one file each. A mesh always shows the height and does not need it.
    #[schemars(length(min = 1))]
    pub layers: Vec<String>,
    /// Start of the file name; the layer's name follows. The layer's name alone if empty.
    pub prefix: String,
    /// Levels of detail of a mesh; each has a quarter of the triangles of the one before.
    #[schemars(range(min = 1, max = 12), extend("unit" = "1"))]
    pub levels: u32,
    /// Whether the export is written.
    pub enabled: bool,
}

impl Default for Export {
    fn default() -> Self {
        Self {
            format: ExportFormat::GeoTiff,
            layers: vec!["height".to_owned()],
            prefix: String::new(),
            levels: 4,
            enabled: true,
        }
    }
}

/// The pictures of a finished run: `preview.png` as a camera sees it, and `relief.png` from above.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct View {
    /// Whether the pictures are made.
    pub enabled: bool,
    /// Width and height of the picture in pixels.
    #[schemars(inner(range(min = 16, max = 16384)), extend("unit" = "1"))]
    pub size: [u32; 2],
    /// Where the camera stands, seen from the middle of the land, clockwise from north.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub azimuth: Option<f32>,
    /// How high the camera stands over the horizon, seen from the middle of the land.
    #[schemars(range(min = 1.0, max = 89.0), extend("unit" = "degree"))]
    pub elevation: Option<f32>,
    /// Distance of the camera from the middle of the land, in lengths of the grid's longer side.
    #[schemars(range(min = 0.05, max = 50.0), extend("unit" = "1"))]
    pub distance: Option<f32>,
    /// Angle of view from the bottom of the picture to its top. Small is a telephoto lens.
    #[schemars(range(min = 5.0, max = 120.0), extend("unit" = "degree"))]
    pub field_of_view: Option<f32>,
    /// Factor on heights in the picture only. If not given, flat land is drawn higher and mountains as they are.
    #[schemars(range(min = 0.01, max = 100.0), extend("unit" = "1"))]
    pub vertical_exaggeration: Option<f32>,
    /// Where the sun stands, clockwise from north.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub sun_azimuth: Option<f32>,
    /// How high the sun stands over the horizon.
    #[schemars(range(min = 1.0, max = 89.0), extend("unit" = "degree"))]
    pub sun_elevation: Option<f32>,
}

impl Default for View {
    fn default() -> Self {
        Self {
            enabled: true,
            size: [1280, 800],
            azimuth: None,
            elevation: None,
            distance: None,
            field_of_view: None,
            vertical_exaggeration: None,
            sun_azimuth: None,
            sun_elevation: None,
        }
    }
}
