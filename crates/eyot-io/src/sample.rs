//! The kinds of numbers that rasters of other programs hold.

use serde::{Deserialize, Serialize};

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ByteOrder {
    /// Least significant byte first, as Windows, Unreal and nearly all processors have it.
    #[default]
    #[serde(rename = "little-endian")]
    Little,
    /// Most significant byte first ("Mac" in some programs).
    #[serde(rename = "big-endian")]
    Big,
}

/// Order of the rows of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum RowOrder {
    /// The northernmost row comes first, as in pictures.
    #[default]
    #[serde(rename = "north to south")]
    NorthFirst,
    /// The southernmost row comes first.
    #[serde(rename = "south to north")]
    SouthFirst,
}

/// A kind of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Sample {
    /// Whole numbers without sign, of 1, 2, 4 or 8 bytes.
    Unsigned(usize),
    /// Whole numbers with sign, of 1, 2, 4 or 8 bytes.
    Signed(usize),
    /// IEEE 754 numbers of 2, 4 or 8 bytes.
    Float(usize),
}

impl Sample {
    /// `f32`.
    pub(crate) const F32: Self = Self::Float(4);
    /// `u16`.
    pub(crate) const U16: Self = Self::Unsigned(2);

    /// A kind with its order of bytes: `u16`, `u16le`, `f32be`, ...
    pub fn parse(text: &str) -> Option<(Self, ByteOrder)> {
        let (name, order) = match (text.strip_suffix("le"), text.strip_suffix("be")) {
            (Some(name), _) => (name, ByteOrder::Little),
            (_, Some(name)) => (name, ByteOrder::Big),
            _ => (text, ByteOrder::Little),
        };
        let bytes = match name.get(1..)? {
            "8" => 1,
            "16" => 2,
            "32" => 4,
            "64" => 8,
            _ => return None,
        };
        let sample = match name.as_bytes()[0] {
            b'u' => Self::Unsigned(bytes),
            b'i' => Self::Signed(bytes),
            b'f' if bytes > 1 => Self::Float(bytes),
            _ => return None,
        };
        Some((sample, order))
    }

    /// Bytes of a number.
    pub const fn bytes(self) -> usize {
        match self {
            Self::Unsigned(n) | Self::Signed(n) | Self::Float(n) => n,
        }
    }

    /// Values that 0 and 65535 stand for in a file of 16 bits that holds these numbers as they are.
    pub(crate) const fn scale(self) -> Option<(f64, f64)> {
        match self {
            Self::Unsigned(1 | 2) => Some((0.0, 65535.0)),
            Self::Signed(1 | 2) => Some((-32768.0, 32767.0)),
            _ => None,
        }
    }

    /// The number in as many bytes.
    pub(crate) fn number(self, b: &[u8], order: ByteOrder) -> f64 {
        let mut le = [0; 8];
        for (i, v) in b.iter().enumerate() {
            le[if order == ByteOrder::Big { b.len() - 1 - i } else { i }] = *v;
        }
        let bits = u64::from_le_bytes(le);
        match self {
            Self::Unsigned(_) => bits as f64,
            Self::Signed(n) => {
                let unused = 64 - 8 * n as u32;
                ((bits << unused) as i64 >> unused) as f64
            }
            Self::Float(2) => half(bits as u16),
            Self::Float(4) => f64::from(f32::from_bits(bits as u32)),
            Self::Float(_) => f64::from_bits(bits),
        }
    }
}

/// Numbers on their way to `f32`, and how far they were rounded.
#[derive(Default)]
pub(crate) struct Narrowed(f64);

impl Narrowed {
    pub(crate) fn of(&mut self, number: f64) -> f32 {
        let narrow = number as f32;
        let difference = (number - f64::from(narrow)).abs();
        // What does not fit at all marks missing cells or is refused elsewhere, with its place.
        if difference.is_finite() {
            self.0 = self.0.max(difference);
        }
        narrow
    }

    /// The largest difference.
    pub(crate) fn by(&self) -> f64 {
        self.0
    }
}

/// A number of IEEE 754's 16-bit format.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    sign * match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        e => (1024.0 + fraction) * 2f64.powi(e - 25),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ByteOrder::{Big, Little};

    #[test]
    fn numbers_of_all_kinds() {
        assert_eq!(Sample::Signed(2).number(&[0xfe, 0xff], Little), -2.0);
        assert_eq!(Sample::Signed(2).number(&[0xff, 0xfe], Big), -2.0);
        assert_eq!(Sample::Unsigned(2).number(&[0xfe, 0xff], Little), 65534.0);
        assert_eq!(Sample::Signed(8).number(&(-5i64).to_le_bytes(), Little), -5.0);
        assert_eq!(Sample::Float(4).number(&1.5f32.to_be_bytes(), Big), 1.5);
        assert_eq!(Sample::Float(8).number(&(-1e300f64).to_le_bytes(), Little), -1e300);
        for (bits, value) in
            [(0x3c00, 1.0), (0xc000, -2.0), (0x7bff, 65504.0), (0x0001, 2f64.powi(-24)), (0x3555, 0.333_251_953_125)]
        {
            assert_eq!(half(bits), value);
        }
        assert!(half(0x7e00).is_nan() && half(0xfc00) == f64::NEG_INFINITY);
    }

    #[test]
    fn kinds_have_names() {
        assert_eq!(Sample::parse("u16le"), Some((Sample::U16, Little)));
        assert_eq!(Sample::parse("f32be"), Some((Sample::F32, Big)));
        assert_eq!(Sample::parse("i8"), Some((Sample::Signed(1), Little)));
        for bad in ["", "u", "f8", "u12", "x16", "be", "u16xe"] {
            assert_eq!(Sample::parse(bad), None, "{bad}");
        }
    }
}
