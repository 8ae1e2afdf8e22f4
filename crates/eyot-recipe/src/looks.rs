//! The keys of a view that colour the ground.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Colours of a kind of land, with its tree line, snow line and moisture. A layer `aridity` makes a desert of any of them, and where there is a climate it
/// decides what grows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Palette {
    /// Tropical where a reef grew, temperate otherwise.
    #[default]
    Auto,
    /// Woods, meadows and grey rock; trees to 1850 m, snow from 2900 m.
    Temperate,
    /// Rain forest, pale sand and palms, dark rock; trees to 3300 m, snow from 4800 m.
    Tropical,
    /// Conifers, turf, grey rock and snow; trees to 2050 m, snow from 2750 m.
    Alpine,
    /// Sand, scrub and beds of red and buff rock; trees to 2600 m, snow from 4600 m.
    Desert,
    /// Tundra and frost-broken stone; trees to 150 m, snow from 700 m.
    Arctic,
    /// Black lava and ash under moss; trees to 700 m, snow from 2400 m.
    Volcanic,
}

/// When pictures are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Season {
    /// Fresh green, and snow 450 m lower.
    Spring,
    /// The palette as it is.
    #[default]
    Summer,
    /// Turned leaves and dry grass, and snow 250 m lower.
    Autumn,
    /// Grey woods, and snow 1500 m lower; in warm palettes a third of it.
    Winter,
}

/// A colour at a height.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// Height over the sea; over zero if there is no sea.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub height: f32,
    /// The land's colour there, such as `"#5a6b3c"`.
    #[schemars(with = "String", regex(pattern = "^#[0-9a-fA-F]{6}$"))]
    pub colour: Colour,
}

/// A colour as screens take it: red, green and blue from 0 to 255 on the sRGB curve, written `#rrggbb`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Colour(pub [u8; 3]);

impl TryFrom<String> for Colour {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()));
        let part = |i: usize| digits.and_then(|d| u8::from_str_radix(&d[2 * i..2 * i + 2], 16).ok());
        match (part(0), part(1), part(2)) {
            (Some(r), Some(g), Some(b)) => Ok(Self([r, g, b])),
            _ => Err(format!("`{text}` is no colour; write # and six digits from 0 to f, such as \"#5a6b3c\"")),
        }
    }
}

impl From<Colour> for String {
    fn from(Colour([r, g, b]): Colour) -> Self {
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read_as_they_are_written() {
        let colour = Colour([0x5a, 0x6b, 0xfc]);
        assert_eq!(Colour::try_from("#5A6bfc".to_owned()), Ok(colour));
        assert_eq!(String::from(colour), "#5a6bfc");
        for bad in ["5a6b3c", "#5a6b3", "#5a6b3cff", "#+a6b3c", "#ä5a6b", ""] {
            assert!(Colour::try_from(bad.to_owned()).unwrap_err().contains("six digits"), "{bad}");
        }
    }
}
