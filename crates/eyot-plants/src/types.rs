//! Types of plants: the thirteen of dynamic vegetation models, and what is known of each.
//!
//! | values | source |
//! |---|---|
//! | coldest month, warmth sum, warmest month, survival of fires | LPJmL 4 (Schaphoff and others 2018), tables of plant functional types |
//! | height, age, shade tolerance, way of seeds | usual ranges of forestry's handbooks, rounded |
//! | diameter, growth | so that a free tree grows as the gap model JABOWA (Botkin and others 1972) has it for beech and birch |
//! | wood | density of dry wood (Chave and others 2009), times 1.3 for branches and roots |
//! | moisture, dry season | chosen, so that biomes meet where Whittaker 1975 draws them |

use eyot_core::LayerSpec;
use eyot_core::layer::{Class, class};

/// What a type of plants looks like and does with its leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Form {
    /// Trees with needles.
    Conifer,
    /// Trees with leaves.
    Broadleaf,
    /// Bushes.
    Shrub,
    /// Grass and herbs.
    Grass,
}

/// A type of plants.
#[derive(Clone, Copy, Debug)]
pub struct PlantType {
    /// Name in recipes, and at the end of the names of its layers.
    pub name: &'static str,
    /// What it looks like.
    pub form: Form,
    /// The coldest month is within these, °C.
    pub winter: [f32; 2],
    /// The warmest month is at most this, °C.
    pub summer: f32,
    /// Least sum of the degrees above 5 °C over the days of the year, K d.
    pub warmth: f32,
    /// Share that survives a fire, of plants as high as a grass fire's flames.
    pub fire: f32,
    /// Greatest height, m.
    pub height: f32,
    /// Age that one in a hundred reaches, years.
    pub age: f32,
    /// How well it grows in shade, 1 to 5.
    pub shade: f32,
    /// How far its seeds go, m.
    pub seed: f32,
    /// Diameter of the stem at the greatest height, m.
    pub stem: f32,
    /// Growth of the stem, cm a year in JABOWA's equation.
    pub growth: f32,
    /// Dry matter of a m3 of its stem with branches and roots, kg.
    pub wood: f32,
    /// Rain over potential evaporation from which it lives, and from which it grows at its best.
    pub moisture: [f32; 2],
    /// The same for rain in the driest month; below 0: the type does not mind a dry season.
    pub driest: [f32; 2],
}

/// Any winter, any summer, any dry season.
const ANY: f32 = 99.0;
const SURE: [f32; 2] = [-2.0, -1.0];

macro_rules! plant_types {
    ($($name:ident $form:ident $winter:expr, $summer:expr, $warmth:expr, $fire:expr, $height:expr, $age:expr, $shade:expr, $seed:expr,
       $stem:expr, $growth:expr, $wood:expr, $moisture:expr, $driest:expr;)*) => {
        /// All types, bushes and trees first, then grass.
        pub const TYPES: [PlantType; 13] = [$(PlantType {
            name: stringify!($name), form: Form::$form, winter: $winter, summer: $summer, warmth: $warmth, fire: $fire,
            height: $height, age: $age, shade: $shade, seed: $seed, stem: $stem, growth: $growth, wood: $wood,
            moisture: $moisture, driest: $driest,
        }),*];
        /// Names of the layers of dry matter.
        pub(crate) const BIOMASS: [&str; 13] = [$(concat!("biomass_", stringify!($name))),*];
        /// Names of the layers of sizes.
        pub(crate) const STEM: [&str; 13] = [$(concat!("stem_", stringify!($name))),*];
        pub(crate) const SUIT: [&str; 13] = [$(concat!("plants_suit_", stringify!($name))),*];
        pub(crate) const SHADE: [&str; 13] = [$(concat!("plants_shade_", stringify!($name))),*];
        pub(crate) const GROW: [&str; 13] = [$(concat!("plants_grow_", stringify!($name))),*];
        pub(crate) const SHOW: [&str; 13] = [$(concat!("plants_show_", stringify!($name))),*];
    };
}

plant_types! {
    // name form                    winter         summer warmth fire height age shade seed stem growth wood moisture   driest
    tropical_evergreen Broadleaf    [15.5, ANY],   ANY,  0.0,    0.3,  45.0, 300.0, 5.0,  50.0, 1.2,  230.0, 600.0, [0.55, 1.0], [0.05, 0.35];
    tropical_raingreen Broadleaf    [15.5, ANY],   ANY,  0.0,    0.5,  25.0, 200.0, 2.0, 100.0, 0.7,  230.0, 550.0, [0.10, 0.5], SURE;
    temperate_needle Conifer        [-5.0, 20.0],  ANY,  900.0,  0.12, 50.0, 500.0, 3.0,  80.0, 1.2,  120.0, 420.0, [0.70, 1.2], SURE;
    temperate_evergreen Broadleaf   [3.0, 20.0],   ANY,  1200.0, 0.5,  25.0, 300.0, 3.0,  50.0, 0.8,  150.0, 550.0, [0.55, 1.0], SURE;
    temperate_summergreen Broadleaf [-17.0, 20.0], ANY,  1200.0, 0.3,  35.0, 350.0, 4.0,  40.0, 1.0,  210.0, 520.0, [0.70, 1.2], [-0.1, 0.2];
    boreal_needle Conifer           [-32.5, -5.0], 23.0, 600.0,  0.12, 30.0, 300.0, 4.0,  90.0, 0.6,  120.0, 420.0, [0.60, 1.1], SURE;
    boreal_summergreen Broadleaf    [-32.5, -5.0], 23.0, 350.0,  0.3,  22.0, 140.0, 1.0, 500.0, 0.45, 180.0, 450.0, [0.60, 1.1], SURE;
    larch Conifer                   [-ANY, -7.4],  23.0, 350.0,  0.12, 30.0, 400.0, 1.0,  60.0, 0.7,  140.0, 450.0, [0.45, 0.9], SURE;
    mediterranean_pine Conifer      [0.0, 15.0],   ANY,  1500.0, 0.3,  20.0, 200.0, 1.0,  60.0, 0.6,  160.0, 450.0, [0.45, 0.85], SURE;
    mountain_pine Shrub             [-25.0, 0.0],  ANY,  300.0,  0.1,  3.0,  150.0, 2.0,  50.0, 0.15, 60.0,  450.0, [0.70, 1.2], SURE;
    desert_shrub Shrub              [-5.0, ANY],   ANY,  0.0,    0.1,  2.0,  100.0, 1.0,  20.0, 0.10, 50.0,  500.0, [0.02, 0.1], SURE;
    c3_grass Grass                  [-30.0, 15.5], ANY,  0.0,    0.01, 0.5,  5.0,   1.0, 200.0, 0.0,  0.0,   0.0,   [0.08, 0.45], SURE;
    c4_grass Grass                  [7.0, ANY],    ANY,  0.0,    0.01, 1.5,  5.0,   1.0, 200.0, 0.0,  0.0,   0.0,   [0.08, 0.45], SURE;
}

/// Trees and bushes, which have stems; the others are grass.
pub const WOODY: usize = 11;
/// Number of the first type of grass.
pub(crate) const C3: usize = WOODY;
/// Number of the other one.
pub(crate) const C4: usize = WOODY + 1;
/// Types that grow higher are trees, m.
pub const TREE_M: f32 = 5.0;

impl PlantType {
    /// Height at which stems have no thickness yet: breast height for trees, m.
    pub const fn foot(&self) -> f32 {
        if self.is_tree() { 1.37 } else { 0.1 * self.height }
    }

    /// Whether it is a tree.
    pub const fn is_tree(&self) -> bool {
        self.height > TREE_M
    }

    /// Height of a plant whose stem is this thick, m: `foot + b2 D - b3 D^2` of JABOWA, with its top at the greatest height.
    pub fn height_of(&self, stem_m: f32) -> f32 {
        let share = (stem_m / self.stem).clamp(0.0, 1.0);
        self.foot() + (self.height - self.foot()) * share * (2.0 - share)
    }

    /// Dry matter of a plant whose stem is this thick, kg.
    pub fn mass_of(&self, stem_m: f32) -> f32 {
        STEM_FORM * self.wood * stem_m * stem_m * self.height_of(stem_m)
    }
}

/// Volume of a stem over that of a beam of its diameter and height, with branches and roots.
pub(crate) const STEM_FORM: f32 = 0.45 * std::f32::consts::FRAC_PI_4 * 1.3;

/// The number of a type by its name.
pub fn by_name(name: &str) -> Option<usize> {
    TYPES.iter().position(|t| t.name == name)
}

/// Dry matter of the plants of a type, kg/m2.
pub const fn biomass(n: usize) -> LayerSpec {
    LayerSpec::new(BIOMASS[n], "kg/m2", "Dry matter of the plants of this type", (0.0, 1000.0))
}

/// Diameter of the stems of a type, m.
pub const fn stem(n: usize) -> LayerSpec {
    LayerSpec::new(STEM[n], "m", "Diameter of the stems of this type at breast height", (0.0, 10.0))
}

/// The classes of the layer `plant_type`; `None` for all other layers.
pub fn classes(layer: &str) -> Option<&'static [Class]> {
    (layer == "plant_type").then_some(CLASSES)
}

/// Names and colours of the classes of the layer `plant_type`: none, then the types in their order.
pub const CLASSES: &[Class] = &[
    class("bare", [186, 176, 158]),
    class("tropical evergreen", [10, 74, 32]),
    class("tropical raingreen", [112, 138, 40]),
    class("temperate needle", [28, 92, 84]),
    class("temperate broad evergreen", [62, 110, 56]),
    class("temperate summergreen", [98, 160, 60]),
    class("boreal needle", [22, 66, 70]),
    class("boreal summergreen", [150, 176, 96]),
    class("larch", [128, 140, 66]),
    class("mediterranean pine", [96, 118, 74]),
    class("mountain pine, alder", [84, 112, 98]),
    class("desert shrub", [172, 146, 96]),
    class("C3 grass", [168, 190, 110]),
    class("C4 grass", [212, 190, 104]),
];
