//! The palettes: two colours for each class, between which a place's own noise chooses, and beds of rock.
//!
//! Linear albedos, from photographs of such grounds, darkened where a photograph holds sunlight already. They are muted: the green of meadows
//! reflects hardly more green than red.

use super::Class;
use super::looks::{Looks, Palette, Season};
use crate::math::{V3, mix};

/// Two colours of each class, in the order of [`Class::ALL`].
pub(super) type Pairs = [[V3; 2]; Class::ALL.len()];

/// The colours and lines of a choice of looks.
#[derive(Clone)]
pub(super) struct Tints {
    pub pairs: Pairs,
    /// Colours of beds of rock.
    pub beds: [V3; 5],
    /// The same of land that the layer `aridity` makes a desert, and of cold and hot lands for worlds with a climate.
    pub arid: Box<Kind>,
    pub cold: Box<Kind>,
    pub hot: Box<Kind>,
    /// Tree line and snow line, m.
    pub trees: f32,
    pub snow: f32,
    /// How wet level ground is, 0..1.
    pub moisture: f32,
    /// Factor on the slope of rock: green climbs the cliffs of wet lands.
    pub cliffs: f32,
    /// What the season adds to the height of snow, m.
    pub winter: f32,
}

/// A palette.
#[derive(Clone)]
pub(super) struct Kind {
    pub pairs: Pairs,
    pub beds: [V3; 5],
    trees: f32,
    snow: f32,
    moisture: f32,
    cliffs: f32,
}

const TEMPERATE: Kind = Kind {
    pairs: [
        [[0.240, 0.250, 0.220], [0.200, 0.220, 0.200]],
        [[0.440, 0.415, 0.320], [0.380, 0.370, 0.290]],
        [[0.130, 0.150, 0.085], [0.095, 0.115, 0.065]],
        [[0.430, 0.420, 0.320], [0.165, 0.140, 0.085]],
        [[0.250, 0.205, 0.145], [0.210, 0.175, 0.125]],
        [[0.430, 0.365, 0.255], [0.380, 0.315, 0.220]],
        [[0.085, 0.078, 0.048], [0.066, 0.070, 0.038]],
        [[0.086, 0.098, 0.037], [0.122, 0.122, 0.050]],
        [[0.180, 0.154, 0.084], [0.142, 0.127, 0.064]],
        [[0.062, 0.066, 0.030], [0.088, 0.082, 0.042]],
        [[0.024, 0.036, 0.016], [0.042, 0.052, 0.021]],
        [[0.205, 0.185, 0.160], [0.160, 0.146, 0.128]],
        [[0.195, 0.178, 0.155], [0.150, 0.138, 0.122]],
        [[0.142, 0.130, 0.114], [0.092, 0.085, 0.076]],
        [[0.145, 0.106, 0.070], [0.190, 0.147, 0.102]],
        [[0.800, 0.830, 0.870], [0.730, 0.775, 0.840]],
    ],
    beds: [
        [0.150, 0.138, 0.120],
        [0.118, 0.108, 0.096],
        [0.172, 0.155, 0.130],
        [0.098, 0.092, 0.084],
        [0.135, 0.118, 0.098],
    ],
    trees: 1850.0,
    snow: 2900.0,
    moisture: 0.67,
    cliffs: 1.0,
};

/// `base` with other colours of some classes.
const fn with(mut base: Pairs, changes: &[(Class, [V3; 2])]) -> Pairs {
    let mut i = 0;
    while i < changes.len() {
        base[changes[i].0 as usize] = changes[i].1;
        i += 1;
    }
    base
}

const TROPICAL: Kind = Kind {
    pairs: with(
        TEMPERATE.pairs,
        &[
            (Class::SeaFloor, [[0.560, 0.535, 0.420], [0.480, 0.465, 0.365]]),
            (Class::Reef, [[0.470, 0.465, 0.365], [0.165, 0.140, 0.085]]),
            (Class::WetSand, [[0.370, 0.320, 0.230], [0.320, 0.275, 0.200]]),
            (Class::Sand, [[0.600, 0.535, 0.405], [0.530, 0.460, 0.335]]),
            (Class::Grass, [[0.072, 0.092, 0.028], [0.112, 0.118, 0.040]]),
            (Class::DryGrass, [[0.165, 0.145, 0.062], [0.132, 0.122, 0.050]]),
            (Class::Shrub, [[0.046, 0.060, 0.020], [0.078, 0.080, 0.030]]),
            (Class::Forest, [[0.020, 0.037, 0.012], [0.040, 0.056, 0.017]]),
            (Class::Scree, [[0.150, 0.120, 0.090], [0.112, 0.092, 0.072]]),
            (Class::Rock, [[0.105, 0.085, 0.066], [0.062, 0.053, 0.044]]),
            (Class::Soil, [[0.185, 0.098, 0.054], [0.150, 0.088, 0.055]]),
        ],
    ),
    beds: [
        [0.110, 0.088, 0.068],
        [0.082, 0.068, 0.055],
        [0.128, 0.098, 0.070],
        [0.070, 0.060, 0.050],
        [0.098, 0.074, 0.056],
    ],
    trees: 3300.0,
    snow: 4800.0,
    moisture: 0.76,
    cliffs: 1.3,
};

const ALPINE: Kind = Kind {
    pairs: with(
        TEMPERATE.pairs,
        &[
            (Class::Grass, [[0.080, 0.090, 0.036], [0.115, 0.112, 0.050]]),
            (Class::DryGrass, [[0.170, 0.148, 0.082], [0.135, 0.122, 0.066]]),
            (Class::Shrub, [[0.058, 0.060, 0.032], [0.092, 0.074, 0.046]]),
            (Class::Forest, [[0.018, 0.028, 0.015], [0.032, 0.041, 0.020]]),
            (Class::Scree, [[0.225, 0.215, 0.198], [0.175, 0.167, 0.155]]),
            (Class::Rock, [[0.155, 0.147, 0.136], [0.098, 0.094, 0.089]]),
        ],
    ),
    beds: [
        [0.165, 0.156, 0.142],
        [0.120, 0.114, 0.106],
        [0.190, 0.176, 0.155],
        [0.104, 0.100, 0.096],
        [0.148, 0.136, 0.118],
    ],
    trees: 2050.0,
    snow: 2750.0,
    moisture: 0.64,
    cliffs: 0.95,
};

const DESERT: Kind = Kind {
    pairs: with(
        TEMPERATE.pairs,
        &[
            (Class::Sand, [[0.430, 0.285, 0.160], [0.375, 0.235, 0.125]]),
            (Class::Mud, [[0.230, 0.165, 0.105], [0.190, 0.135, 0.085]]),
            (Class::Grass, [[0.120, 0.118, 0.052], [0.150, 0.138, 0.066]]),
            (Class::DryGrass, [[0.250, 0.178, 0.092], [0.205, 0.150, 0.080]]),
            (Class::Shrub, [[0.100, 0.096, 0.048], [0.135, 0.112, 0.058]]),
            (Class::Forest, [[0.050, 0.056, 0.028], [0.078, 0.076, 0.038]]),
            (Class::Gravel, [[0.280, 0.205, 0.135], [0.230, 0.170, 0.115]]),
            (Class::Scree, [[0.255, 0.150, 0.085], [0.205, 0.120, 0.070]]),
            (Class::Rock, [[0.240, 0.118, 0.060], [0.155, 0.078, 0.043]]),
            (Class::Soil, [[0.290, 0.168, 0.090], [0.335, 0.215, 0.125]]),
        ],
    ),
    // Sedimentary rock: red and orange sandstone, buff limestone, brown shale.
    beds: [
        [0.205, 0.075, 0.036],
        [0.275, 0.118, 0.056],
        [0.345, 0.225, 0.130],
        [0.145, 0.072, 0.044],
        [0.290, 0.150, 0.076],
    ],
    trees: 2600.0,
    snow: 4600.0,
    moisture: 0.10,
    cliffs: 0.80,
};

const ARCTIC: Kind = Kind {
    pairs: with(
        TEMPERATE.pairs,
        &[
            (Class::Sand, [[0.235, 0.215, 0.185], [0.190, 0.172, 0.148]]),
            (Class::WetSand, [[0.140, 0.128, 0.110], [0.115, 0.105, 0.092]]),
            (Class::SeaFloor, [[0.270, 0.265, 0.225], [0.225, 0.225, 0.195]]),
            (Class::Mud, [[0.090, 0.074, 0.046], [0.070, 0.062, 0.038]]),
            (Class::Grass, [[0.098, 0.090, 0.042], [0.128, 0.104, 0.052]]),
            (Class::DryGrass, [[0.155, 0.122, 0.070], [0.130, 0.098, 0.060]]),
            (Class::Shrub, [[0.078, 0.064, 0.036], [0.110, 0.070, 0.044]]),
            (Class::Forest, [[0.030, 0.036, 0.022], [0.046, 0.048, 0.028]]),
            (Class::Rock, [[0.125, 0.120, 0.115], [0.082, 0.080, 0.079]]),
            (Class::Soil, [[0.140, 0.115, 0.088], [0.175, 0.150, 0.120]]),
        ],
    ),
    beds: [
        [0.130, 0.125, 0.120],
        [0.102, 0.100, 0.098],
        [0.150, 0.140, 0.128],
        [0.084, 0.083, 0.083],
        [0.118, 0.108, 0.100],
    ],
    trees: 150.0,
    snow: 700.0,
    moisture: 0.50,
    cliffs: 0.90,
};

const VOLCANIC: Kind = Kind {
    pairs: with(
        TEMPERATE.pairs,
        &[
            (Class::Sand, [[0.060, 0.056, 0.053], [0.085, 0.078, 0.072]]),
            (Class::WetSand, [[0.036, 0.035, 0.034], [0.048, 0.046, 0.044]]),
            (Class::SeaFloor, [[0.120, 0.120, 0.110], [0.095, 0.098, 0.092]]),
            (Class::Grass, [[0.098, 0.108, 0.030], [0.128, 0.132, 0.038]]),
            (Class::DryGrass, [[0.125, 0.115, 0.048], [0.100, 0.086, 0.046]]),
            (Class::Gravel, [[0.090, 0.084, 0.078], [0.068, 0.064, 0.060]]),
            (Class::Scree, [[0.078, 0.066, 0.058], [0.110, 0.066, 0.050]]),
            (Class::Rock, [[0.052, 0.047, 0.044], [0.034, 0.032, 0.031]]),
            (Class::Soil, [[0.070, 0.058, 0.050], [0.098, 0.066, 0.052]]),
        ],
    ),
    beds: [
        [0.052, 0.047, 0.044],
        [0.040, 0.037, 0.035],
        [0.078, 0.050, 0.040],
        [0.034, 0.032, 0.031],
        [0.062, 0.055, 0.050],
    ],
    trees: 700.0,
    snow: 2400.0,
    moisture: 0.46,
    cliffs: 0.85,
};

impl super::Palette {
    /// Heights over the sea at which trees end and at which snow begins to lie, m, where no climate says otherwise.
    pub fn lines_m(self) -> [f32; 2] {
        let Tints { trees, snow, .. } = Tints::of(&Looks { palette: self, ..Looks::default() });
        [trees, snow]
    }
}

impl Tints {
    pub(super) fn of(looks: &Looks) -> Self {
        let kind = match looks.palette {
            Palette::Auto | Palette::Temperate => &TEMPERATE,
            Palette::Tropical => &TROPICAL,
            Palette::Alpine => &ALPINE,
            Palette::Desert => &DESERT,
            Palette::Arctic => &ARCTIC,
            Palette::Volcanic => &VOLCANIC,
        };
        // What has no winter has a little of one on its heights.
        let warm = matches!(looks.palette, Palette::Tropical | Palette::Desert);
        let year = if warm { 0.3 } else { 1.0 };
        let (winter, pairs) = match looks.season {
            Season::Summer => (0.0, kind.pairs),
            Season::Spring => (-450.0, turned(kind.pairs, year, &SPRING)),
            Season::Autumn => (-250.0, turned(kind.pairs, year, &AUTUMN)),
            Season::Winter => (-1500.0, turned(kind.pairs, year, &WINTER)),
        };
        Self {
            pairs,
            beds: kind.beds,
            arid: Box::new(DESERT),
            cold: Box::new(ARCTIC),
            hot: Box::new(TROPICAL),
            trees: kind.trees,
            snow: kind.snow,
            moisture: kind.moisture,
            cliffs: kind.cliffs,
            winter: year * winter,
        }
    }
}

/// What a season makes of some classes: their two colours, and how much of them.
type Turn = [(Class, [V3; 2], f32)];
const SPRING: [(Class, [V3; 2], f32); 3] = [
    (Class::Grass, [[0.082, 0.112, 0.032], [0.110, 0.135, 0.040]], 0.7),
    (Class::Shrub, [[0.062, 0.082, 0.028], [0.085, 0.098, 0.036]], 0.6),
    (Class::Forest, [[0.034, 0.054, 0.018], [0.056, 0.074, 0.024]], 0.5),
];
const AUTUMN: [(Class, [V3; 2], f32); 3] = [
    (Class::Grass, [[0.125, 0.112, 0.048], [0.155, 0.130, 0.060]], 0.6),
    (Class::Shrub, [[0.130, 0.066, 0.030], [0.105, 0.072, 0.034]], 0.7),
    (Class::Forest, [[0.130, 0.060, 0.020], [0.062, 0.050, 0.022]], 0.75),
];
const WINTER: [(Class, [V3; 2], f32); 4] = [
    (Class::Grass, [[0.135, 0.118, 0.066], [0.165, 0.142, 0.086]], 0.8),
    (Class::DryGrass, [[0.175, 0.152, 0.104], [0.145, 0.126, 0.086]], 0.7),
    (Class::Shrub, [[0.088, 0.074, 0.056], [0.110, 0.094, 0.072]], 0.7),
    (Class::Forest, [[0.052, 0.046, 0.036], [0.034, 0.038, 0.026]], 0.6),
];

fn turned(mut pairs: Pairs, year: f32, turn: &Turn) -> Pairs {
    for (class, colours, share) in turn {
        let pair = &mut pairs[*class as usize];
        *pair = [0, 1].map(|i| mix(pair[i], colours[i], year * share));
    }
    pairs
}
