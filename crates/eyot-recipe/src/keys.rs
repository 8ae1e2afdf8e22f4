//! The keys of a recipe as structs. Their schemas check recipes, complete them in editors and make the reference.

use crate::export::former_formats;
use crate::looks::{Palette, Season, Stop};
use crate::merge::Merge;
pub use crate::rock::Material;
use eyot_core::BoundaryCondition;
use eyot_core::layer::known;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;

/// The head of a recipe.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Document {
    /// What the landscape is called.
    pub name: String,
    /// One sentence about the landscape.
    pub about: String,
    /// Seed of all random numbers. The same recipe with the same seed gives the same bytes.
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
    /// Level of the sea at the start, in the datum of the height; "none" for land without a sea.
    #[serde(deserialize_with = "level")]
    #[schemars(schema_with = "level_schema", extend("unit" = "m"))]
    pub sea_level: f64,
}

/// The level that `sea_level = "none"` stands for, m: the lowest height that there can be.
pub const NO_SEA_M: f64 = -12_000.0;

/// A level of the sea, or the word for none.
pub(crate) fn level<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Level {
        Metres(f64),
        Word(String),
    }
    match Level::deserialize(from)? {
        Level::Metres(level) => Ok(level),
        Level::Word(word) if word == "none" => Ok(NO_SEA_M),
        Level::Word(word) => {
            Err(D::Error::custom(format!("a level of the sea is a number or \"none\", not \"{word}\"")))
        }
    }
}

fn level_schema(_: &mut SchemaGenerator) -> Schema {
    let (low, high) = known::HEIGHT.range;
    json_schema!({ "anyOf": [{ "type": "number", "minimum": low, "maximum": high }, { "type": "string", "const": "none" }] })
}

/// `256` or `[256, 128]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[allow(missing_docs, reason = "texts on variants would stand in the schema")]
#[non_exhaustive]
pub enum Cells {
    One(#[schemars(range(min = 1))] u32),
    Two(#[schemars(inner(range(min = 1)))] [u32; 2]),
}

/// `10.0` or `[10.0, 12.5]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[allow(missing_docs, reason = "texts on variants would stand in the schema")]
#[non_exhaustive]
pub enum Lengths {
    One(#[schemars(range(min = 1e-6, max = 1e10))] f64),
    Two(#[schemars(inner(range(min = 1e-6, max = 1e10)))] [f64; 2]),
}

/// `"closed"` or `["wrap", "open"]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[allow(missing_docs, reason = "texts on variants would stand in the schema")]
#[non_exhaustive]
pub enum Edges {
    One(BoundaryCondition),
    Two([BoundaryCondition; 2]),
}

/// The grid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Grid {
    /// Columns and rows, or one number for a square.
    #[schemars(extend("unit" = "1"))]
    pub size: Option<Cells>,
    /// Size of a cell, west-east and north-south, or one number for square cells. 10 m if nothing else is said.
    #[schemars(extend("unit" = "m"))]
    pub cell: Option<Lengths>,
    /// Extent of the whole grid, west-east and north-south, instead of the cell size.
    #[schemars(extend("unit" = "m"))]
    pub extent_m: Option<Lengths>,
    /// What lies beyond the border: a wall, a free outfall, or the far side; one for both axes, or west-east and north-south.
    pub rim: Option<Edges>,
    /// A height map whose size, cells and place on Earth the grid takes over; relative to the recipe's folder.
    pub from: Option<String>,
}

/// A step that generates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Generate {
    /// A name for messages and for `--set NAME.parameter=value`.
    pub name: Option<String>,
    /// One sentence about the step.
    pub about: Option<String>,
    /// Whether the step is done.
    pub enabled: bool,
    /// The generator.
    pub generate: String,
    /// The layer that it works on.
    #[schemars(regex(pattern = r"^[a-z_][a-z0-9_]*$"))]
    pub layer: String,
    /// How the new values join the layer. A source adds and a filter replaces if nothing else is said.
    pub merge: Option<Merge>,
    /// A layer from 0 to 1 that says where how much of the change is kept. Less than 0 counts as 0, more than 1 as 1.
    pub mask: Option<String>,
    /// Strength of the merge: a factor on the new values, or the weight of a `lerp`.
    #[schemars(range(min = -1e6, max = 1e6), extend("unit" = "1"))]
    pub amount: f32,
    /// A seed for this step alone, so that it stays as it is when steps move or the recipe's seed changes.
    #[schemars(extend("unit" = "1"))]
    pub seed: Option<u64>,
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[allow(missing_docs, reason = "texts on variants would stand in the schema")]
#[non_exhaustive]
pub enum Names {
    One(String),
    Many(#[schemars(length(min = 1))] Vec<String>),
}

/// A step that simulates. Each process has a table of its own: `hydraulic.rain = 0.002`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Simulate {
    /// A name for messages and for `--set NAME.parameter=value`.
    pub name: Option<String>,
    /// One sentence about the step.
    pub about: Option<String>,
    /// Whether the step is done.
    pub enabled: bool,
    /// The processes, in the order in which they act within one step.
    pub simulate: Names,
    /// How many steps.
    #[schemars(range(min = 1), extend("unit" = "1"))]
    pub steps: u64,
}

impl Default for Simulate {
    fn default() -> Self {
        Self { name: None, about: None, enabled: true, simulate: Names::Many(Vec::new()), steps: 1000 }
    }
}

/// When a process acts; beside its own parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Schedule {
    /// The process acts in every n-th step.
    #[schemars(range(min = 1, max = 1_000_000_000), extend("unit" = "1"))]
    pub every: u64,
    /// Whether the process acts at all.
    pub enabled: bool,
}

impl Default for Schedule {
    fn default() -> Self {
        Self { every: 1, enabled: true }
    }
}

/// A number, or an expression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[allow(missing_docs, reason = "texts on variants would stand in the schema")]
#[non_exhaustive]
pub enum Amount {
    Number(#[schemars(range(min = -3e38, max = 3e38))] f64),
    Text(String),
}

/// A layer of the recipe's own, and the rule that changes it. Name it in `simulate` to let the rule act.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Layer {
    /// The layer's name, and the rule's.
    #[schemars(regex(pattern = r"^[a-z_][a-z0-9_]*$"))]
    pub name: String,
    /// One sentence: what the layer holds.
    pub about: Option<String>,
    /// Unit, for example `m`, `m/s` or `1` for a plain number. Units of sums are checked where it is given.
    pub unit: Option<String>,
    /// First values: a number, or an expression over layers that are there before and the recipe's layers above this one.
    pub start: Amount,
    /// Smallest and largest value. What a rule makes beyond is moved to the nearer end and counted in the ledger; what is no number ends the run.
    #[schemars(inner(range(min = -3e38, max = 3e38)))]
    pub range: Option<[f64; 2]>,
    /// An expression: the value after a step, from the values before. Without it nothing changes the layer.
    pub next: Option<String>,
    /// A condition: where the rule applies. Everywhere if not given.
    pub mask: Option<String>,
    /// The rule acts in every n-th step.
    #[schemars(range(min = 1, max = 1_000_000_000), extend("unit" = "1"))]
    pub every: u64,
    /// Numbers that the expressions name, and that a step, `--set` and a running simulation can change.
    pub parameters: BTreeMap<String, f64>,
}

impl Default for Layer {
    fn default() -> Self {
        Self {
            name: String::new(),
            about: None,
            unit: None,
            start: Amount::Number(0.0),
            range: None,
            next: None,
            mask: None,
            every: 1,
            parameters: BTreeMap::new(),
        }
    }
}

/// A rule of the recipe's own that changes layers that are there. Name it in `simulate` to let it act.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Rule {
    /// The rule's name.
    #[schemars(regex(pattern = r"^[a-z_][a-z0-9_]*$"))]
    pub name: String,
    /// One sentence: what the rule does.
    pub about: Option<String>,
    /// For each layer that the rule changes an expression: its value after a step, from all values before.
    pub set: BTreeMap<String, String>,
    /// A condition: where the rule applies. Everywhere if not given.
    pub mask: Option<String>,
    /// The rule acts in every n-th step.
    #[schemars(range(min = 1, max = 1_000_000_000), extend("unit" = "1"))]
    pub every: u64,
    /// Numbers that the expressions name, and that a step, `--set` and a running simulation can change.
    pub parameters: BTreeMap<String, f64>,
}

impl Default for Rule {
    fn default() -> Self {
        Self {
            name: String::new(),
            about: None,
            set: BTreeMap::new(),
            mask: None,
            every: 1,
            parameters: BTreeMap::new(),
        }
    }
}

/// What an export shows.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum What {
    /// The values of layers.
    Layers,
    /// The land as a coloured mesh.
    Terrain,
    /// Shares of grass, rock, sand and snow as red, green, blue and alpha, which sum to 255.
    Splat,
    /// Grey pictures of 8 bits, 0 to 255 for 0 to 1: layers of that range, or the shares of grass, rock, sand and snow, or of a class of the ground, or what water did: flow, wear, deposit, river, shore.
    Mask,
    /// Layers in colours.
    Map,
    /// What `corals` counted each month, as a table.
    Census,
    /// Drawings of what `corals` grew: cover of each species over the years, and the plot from above.
    Plots,
    /// A body for each colony that `corals` grew, with species, age and bleaching.
    Corals,
    /// Pictures of the corals' bodies: as a diver sees them, from the side, and from above.
    Dive,
    /// Single trees of the forest that `forest` leaves, each at its own place with kind, height, crown and age.
    Trees,
    /// Lines of equal height.
    Contours,
    /// A table, points, lines or polygons that a process keeps beside layers, by name: `corals.colonies`.
    #[serde(untagged)]
    View(#[schemars(regex(pattern = r"^[a-z_][a-z0-9_.]*$"))] String),
}

/// How an export is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum ExportFormat {
    /// GeoTIFF of 32-bit floats with its place on Earth, for GIS programs.
    GeoTiff,
    /// Grey picture of 16 bits; the text inside says which heights black and white are.
    Png16,
    /// Bare whole numbers of 16 bits, described by a JSON file beside them that says which heights 0 and 65535 are.
    R16,
    /// Bare 32-bit floats, little-endian, row by row from the north, described by a JSON file beside them.
    R32,
    /// OpenEXR of 32-bit floats; several layers become channels of one file.
    Exr,
    /// NumPy array of 32-bit floats, described by a JSON file beside it.
    Npy,
    /// Zarr v3 store (a folder) with all layers, their units and coordinates, for xarray and other tools of research.
    Zarr,
    /// glTF 2.0 binary: meshes with colours and names, of the terrain with levels of detail.
    Glb,
    /// Wavefront OBJ: meshes with colours.
    Obj,
    /// PLY: meshes with colours.
    Ply,
    /// Comma-separated values, a line for each row of a table, each point or each line.
    Csv,
    /// The same as Apache Parquet: with types, and units in its metadata.
    Parquet,
    /// GeoJSON: points, lines and polygons with attributes, as text.
    GeoJson,
    /// The same as FlatGeobuf: binary, with an index of places.
    FlatGeobuf,
    /// The same as GeoPackage: a table of an SQLite file.
    GeoPackage,
    /// Picture.
    Png,
    /// Drawing that can be enlarged.
    Svg,
}

/// All files that a program wants, in its sizes, scales and orders, with a JSON file that says what to enter where.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// Unreal Engine landscape: 16-bit height of 505, 1009, 2017, 4033 or 8129 vertices, one weight map a material; as those below but the last, with masks of flow, wear, deposit, rivers, wetness and shore.
    Unreal,
    /// Unity terrain: 16-bit RAW of 33 to 4097 vertices (a power of two and one), one splat map.
    Unity,
    /// Godot with Terrain3D: EXR of real heights, one splat map.
    Godot,
    /// Blender: mesh with the materials as attributes, EXR of real heights, one mask a material.
    Blender,
    /// GIS: Cloud Optimised GeoTIFF of each layer, -9999 for missing cells.
    Gis,
}

/// Order of the bytes of a number in a file without header.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Bytes {
    /// Least significant byte first, "Windows" or "PC" in some programs.
    #[default]
    Little,
    /// Most significant byte first, "Mac" in some programs.
    Big,
}

/// Which row of a file without header comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FirstRow {
    /// The northernmost, as in pictures.
    #[default]
    North,
    /// The southernmost.
    South,
}

/// A file to write when the run is done, or the files of a preset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Export {
    /// What the files show. If not given, what the format is for: `terrain` of `glb` and `obj`, `corals` of `ply`, `plots` of `svg`, and otherwise `layers`.
    pub what: Option<What>,
    /// How it is written. If not given: `layers` as `geotiff`, `terrain`, `corals` and `trees` as `glb`, `contours` as `geojson`, tables, points and lines as `csv`, `plots` as `svg` and `png`, all else as `png`.
    #[schemars(extend("$former" = former_formats()))]
    pub format: Option<ExportFormat>,
    /// All files for a program instead of one kind: sizes are resampled, scales and orders are the program's.
    pub preset: Option<Preset>,
    /// The layers that `layers`, `mask` and `map` show, one file each (`zarr` and `exr`: together in one). `grass`, `rock`, `sand` and `snow` are the shares of the ground, which no step needs to make, and so are its classes `deep_sea`, `sea_floor`, `weed`, `reef`, `wet_sand`, `beach`, `mud`, `lush_grass`, `dry_grass`, `shrub`, `forest`, `gravel`, `scree`, `bare_rock`, `soil` and `snow_cover`, and the masks `flow`, `wear`, `deposit`, `river` and `shore`, of which `wear` and `deposit` need a layer `ground_before` with the height before the erosion, and where a cell lies: `slope`, `relative_height`, `lake_shore` and `river_bank`. `bed_1_top` to `bed_13_top` are the heights of the tops of beds, worn away or not, of worlds with `strata`. `terrain`, `splat` and presets other than `gis` always show the height and do not need it.
    #[schemars(length(min = 1))]
    pub layers: Vec<String>,
    /// Start of the file name; the layer's name follows. The layer's name alone if empty.
    pub prefix: String,
    /// Levels of detail of a terrain as `glb`; each has a quarter of the triangles of the one before.
    #[schemars(range(min = 1, max = 12), extend("unit" = "1"))]
    pub levels: u32,
    /// Tiles of a terrain or of trees as `glb`, from west to east and from north to south, each a file (of a terrain with levels of detail and skirts): `terrain_x0_y0.glb` in the north-west, and `terrain.json`, which lists them.
    #[schemars(inner(range(min = 1, max = 64)), extend("unit" = "1"))]
    pub tiles: [u32; 2],
    /// How far the skirts of tiles hang down. If not given, as far as the largest gap between two levels of detail could be, and at least half the distance of two vertices; 0 for no skirts, with levels that all keep their rims.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("unit" = "m"))]
    pub skirt: Option<f32>,
    /// Whether a terrain has the surface of its water, too, as a mesh of its own: sea and lakes level, rivers as they run.
    pub water: bool,
    /// Most vertices of a terrain, or of each of its tiles. A grid with more cells is sampled at every second, third or further one. A million are about 80 MB as `glb`.
    #[schemars(range(min = 4, max = 100_000_000), extend("unit" = "1"))]
    pub vertices: u64,
    /// Heights that 0 and 65535 stand for in `png16` and `r16`; the lowest and the highest value if not given.
    #[schemars(inner(range(min = -1e6, max = 1e6)), extend("unit" = "m"))]
    pub range: Option<[f64; 2]>,
    /// Order of bytes in `r16` and `r32`.
    pub bytes: Bytes,
    /// Which row comes first in `r16` and `r32`: the north if not given. In the preset `unity`, the south if not given, as Unity has it unless "Flip Vertically" is ticked.
    pub first_row: Option<FirstRow>,
    /// Vertices along each side for the presets `unreal` and `unity`; the program's size that is nearest to the grid's if not given.
    #[schemars(range(min = 33, max = 8129), extend("unit" = "1"))]
    pub size: Option<u32>,
    /// Slope at which half of the ground is rock, in splat maps and masks. If not given, as in the pictures: 45 degrees in cells of 10 m, less in larger ones, and by the palette.
    #[schemars(range(min = 1.0, max = 89.0), extend("unit" = "degree"))]
    pub rock_slope: Option<f32>,
    /// Height above the sea up to which flat ground is sand; the seabed is sand as well. Without a sea there is none. If not given, as in the pictures: about 3 m.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub beach: Option<f32>,
    /// Height over the sea at which half of the ground that is not too steep is snow. If not given, that of `[view]`.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub snow_line: Option<f32>,
    /// Distance of heights of `contours`. If not given, 1, 2 or 5 times a power of ten so that there are about twenty levels.
    #[schemars(range(min = 0.001, max = 10_000.0), extend("unit" = "m"))]
    pub interval: Option<f64>,
    /// Whether the export is written.
    pub enabled: bool,
}

impl Default for Export {
    fn default() -> Self {
        Self {
            what: None,
            format: None,
            preset: None,
            layers: vec!["height".to_owned()],
            prefix: String::new(),
            levels: 4,
            tiles: [1, 1],
            skirt: None,
            water: true,
            vertices: 1025 * 1025,
            range: None,
            bytes: Bytes::Little,
            first_row: None,
            size: None,
            rock_slope: None,
            beach: None,
            snow_line: None,
            interval: None,
            enabled: true,
        }
    }
}

/// The pictures of a finished run: `preview.png` as a camera sees it, and `relief.png` from above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct View {
    /// Whether the pictures are made.
    pub enabled: bool,
    /// Draw the preview from above as a map, too: for planets, which no camera on the ground sees.
    pub from_above: bool,
    /// Width and height of the picture in pixels.
    #[schemars(inner(range(min = 16, max = 16384)), extend("unit" = "1"))]
    pub size: [u32; 2],
    /// Where the camera stands, seen from the middle of the land, clockwise from north.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub azimuth: Option<f32>,
    /// How high the camera stands over the horizon, seen from the middle of the land.
    #[schemars(range(min = 1.0, max = 89.0), extend("unit" = "degree"))]
    pub elevation: Option<f32>,
    /// Distance of the camera from the middle of the grid, in lengths of its longer side. If not given, the camera stands where the picture shows all of the land, as large as it can be.
    #[schemars(range(min = 0.05, max = 50.0), extend("unit" = "1"))]
    pub distance: Option<f32>,
    /// Angle of view from the bottom of the picture to its top. Small is a telephoto lens.
    #[schemars(range(min = 5.0, max = 120.0), extend("unit" = "degree"))]
    pub field_of_view: Option<f32>,
    /// Factor on heights in the view only; 1, to scale, if not given. In `relief.png` the factor of its shading, which is fitted to the slopes if not given.
    #[schemars(range(min = 0.01, max = 100.0), extend("unit" = "1"))]
    pub vertical_exaggeration: Option<f32>,
    /// Where the sun stands, clockwise from north.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub sun_azimuth: Option<f32>,
    /// How high the sun stands over the horizon.
    #[schemars(range(min = 1.0, max = 89.0), extend("unit" = "degree"))]
    pub sun_elevation: Option<f32>,
    /// Colours of the ground, which masks, splat maps and meshes follow.
    pub palette: Palette,
    /// Colours of dry land by height in the place of the palette's, the lowest first: `ramp = [{ height = 0.0, colour = "#4c5b35" }, { height = 1500.0, colour = "#8d8577" }]`. Masks and splat maps keep the palette's ground.
    pub ramp: Vec<Stop>,
    /// Height over the sea at which half of the ground that is not too steep is snow. The palette's if not given, or the climate's where there is one.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub snow_line: Option<f32>,
    /// Height over the sea at which trees end. The palette's if not given, or the climate's where there is one.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub tree_line: Option<f32>,
    /// When the pictures are taken.
    pub season: Season,
}

impl Default for View {
    fn default() -> Self {
        Self {
            enabled: true,
            from_above: false,
            size: [1280, 800],
            azimuth: None,
            elevation: None,
            distance: None,
            field_of_view: None,
            vertical_exaggeration: None,
            sun_azimuth: None,
            sun_elevation: None,
            palette: Palette::Auto,
            ramp: Vec::new(),
            snow_line: None,
            tree_line: None,
            season: Season::Summer,
        }
    }
}
