//! What may be chosen of the looks of the ground.

use crate::math::V3;
use crate::picture::linear;
use eyot_core::World;
use eyot_strata::Sequence;

/// Colours, lines and moisture of a kind of land.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Palette {
    /// By the layers of the world: tropical where a reef grew, temperate otherwise; where there is a climate, by temperature.
    #[default]
    Auto,
    /// Woods, meadows and grey rock.
    Temperate,
    /// Rain forest, pale sand and palms, dark volcanic rock.
    Tropical,
    /// Conifers, turf, grey rock and snow.
    Alpine,
    /// Sand, scrub and beds of red and buff rock.
    Desert,
    /// Tundra, frost-broken stone and snow.
    Arctic,
    /// Black lava and ash under moss.
    Volcanic,
}

/// When the picture is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Season {
    /// Fresh green, snow still low.
    Spring,
    /// The palette as it is.
    #[default]
    Summer,
    /// Turned leaves, dry grass, first snow.
    Autumn,
    /// Grey woods and snow far down.
    Winter,
}

/// The choices that colours, masks and materials of a world follow.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Looks {
    /// The kind of land.
    pub palette: Palette,
    /// Colours of dry land by height over the sea (m, linear RGB) in the place of the palette's, lowest first; none for the palette's.
    pub ramp: Vec<(f32, V3)>,
    /// Height over the sea at which half of the level ground is snow, m; the palette's or the climate's if not given.
    pub snow_line_m: Option<f32>,
    /// Height over the sea at which trees end, m; the palette's or the climate's if not given.
    pub tree_line_m: Option<f32>,
    /// Height over the sea up to which level ground is sand, m; 3 if not given.
    pub beach_m: Option<f32>,
    /// Slope at which half of the ground is rock, degrees; 45 in cells of 10 m if not given, less in larger ones.
    pub rock_slope_deg: Option<f32>,
    /// Colours of kinds of rock (linear RGB) by their numbers in the layer `material`; those of the palette where there are none.
    pub rocks: Vec<V3>,
    /// When the picture is taken.
    pub season: Season,
}

impl Looks {
    /// The same with the colours that the materials of a world have, where kinds of rock show theirs at all.
    pub(crate) fn with_rocks_of(self, world: &World) -> Self {
        let Some(beds) = Sequence::of(world).ok().flatten().filter(|_| !self.rocks.is_empty()) else { return self };
        let rocks = beds.materials.iter().enumerate().map(|(n, m)| linear(m.shown(n))).collect();
        Self { rocks, ..self }
    }

    /// The same with [`Palette::Auto`] decided by the layers of a world.
    pub fn resolved(&self, has_layer: impl Fn(&str) -> bool) -> Self {
        let reef = has_layer("limestone") || has_layer("growth");
        let palette = match self.palette {
            Palette::Auto if reef => Palette::Tropical,
            Palette::Auto => Palette::Temperate,
            given => given,
        };
        Self { palette, ..self.clone() }
    }
}
