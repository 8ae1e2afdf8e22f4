//! The keys of a GeoTIFF that say its coordinate system (OGC 19-008r4), carried on as they stand.
//!
//! A directory has four numbers a key: which it is, the tag that holds its value (0: the last number itself), how many
//! values, and the first of them.

use super::directory::Tagged;
use eyot_core::CoordinateSystem;
#[cfg(feature = "tiff")]
use tiff_reader::{Ifd, TagValue};

const DIRECTORY: u16 = 34735;
const DOUBLES: u16 = 34736;
const ASCII: u16 = 34737;
const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
#[cfg(feature = "tiff")]
const PIXEL_IS_AREA: u16 = 1;
/// Keys that add nothing to an EPSG code: kinds of coordinates and of pixels, citations, the code itself, and units and
/// ellipsoid of the geographic part.
const SAID_BY_THE_CODE: [u16; 15] =
    [MODEL_TYPE, RASTER_TYPE, 1026, 2048, 2049, 2050, 2051, 2054, 2055, 2056, 2057, 2058, 2059, 3072, 3073];
/// The unit of the projected part, if it is the metre; another one tells readers without a database of codes.
const METRES: [u16; 4] = [3076, 0, 1, 9001];
/// Texts are names, or a well-known text at most.
const MAX_ASCII: usize = 1 << 16;

/// What a file says of its coordinate system beyond its EPSG code; `None` if that is nothing, or broken.
#[cfg(feature = "tiff")]
pub(crate) fn read(ifd: &Ifd, epsg: Option<u32>) -> Option<CoordinateSystem> {
    let mut directory = match &ifd.tag(DIRECTORY)?.value {
        TagValue::Short(numbers) => numbers.clone(),
        _ => return None,
    };
    let doubles = match ifd.tag(DOUBLES).map(|t| &t.value) {
        Some(TagValue::Double(numbers)) => numbers.clone(),
        _ => Vec::new(),
    };
    let ascii = match ifd.tag(ASCII).map(|t| &t.value) {
        Some(TagValue::Ascii(text)) => ascii(text),
        _ => String::new(),
    };
    if !are_sound(&directory, &doubles, &ascii) {
        return None;
    }
    let says_nothing = |e: &[u16]| match epsg {
        Some(_) => SAID_BY_THE_CODE.contains(&e[0]) || e == METRES,
        None => e[0] == RASTER_TYPE || e == [MODEL_TYPE, 0, 1, 0],
    };
    if entries(&directory).all(says_nothing) {
        return None;
    }
    // The transform has been brought to the corners of cells.
    for entry in directory[4..].chunks_exact_mut(4).filter(|e| e[0] == RASTER_TYPE) {
        entry.copy_from_slice(&[RASTER_TYPE, 0, 1, PIXEL_IS_AREA]);
    }
    Some(CoordinateSystem::GeoKeys { directory, doubles, ascii })
}

/// True if an EPSG code beside it would not say all of `system`.
pub(crate) fn exceeds_code(system: &CoordinateSystem) -> bool {
    let beyond = |e: &[u16]| !SAID_BY_THE_CODE.contains(&e[0]) && e[0] != METRES[0];
    matches!(system, CoordinateSystem::GeoKeys { directory, .. } if entries(directory).any(beyond))
}

/// The tags that say `system`, if it consists of sound keys.
pub(super) fn tags(system: &CoordinateSystem) -> Option<Vec<(u16, Tagged)>> {
    let CoordinateSystem::GeoKeys { directory, doubles, ascii } = system else { return None };
    if !are_sound(directory, doubles, ascii) {
        return None;
    }
    let mut tags = vec![(DIRECTORY, Tagged::Short(directory.clone()))];
    if !doubles.is_empty() {
        tags.push((DOUBLES, Tagged::Double(doubles.clone())));
    }
    if !ascii.is_empty() {
        tags.push((ASCII, Tagged::Ascii(ascii.clone())));
    }
    Some(tags)
}

fn entries(directory: &[u16]) -> impl Iterator<Item = &[u16]> {
    directory.get(4..).unwrap_or(&[]).chunks_exact(4)
}

/// True if the directory has as many keys as its head says, and all that they refer to is there.
fn are_sound(directory: &[u16], doubles: &[f64], ascii: &str) -> bool {
    let whole = matches!(directory, [1, _, _, n, ..] if *n > 0 && directory.len() == 4 + 4 * usize::from(*n));
    let there = |e: &[u16]| {
        let end = usize::from(e[2]) + usize::from(e[3]);
        match e[1] {
            0 => true,
            DIRECTORY => end <= directory.len(),
            DOUBLES => end <= doubles.len(),
            // The zero at the end of the text may count.
            ASCII => end <= ascii.len() + 1,
            _ => false,
        }
    };
    whole
        && entries(directory).all(there)
        && doubles.len() <= usize::from(u16::MAX)
        && doubles.iter().all(|v| v.is_finite())
        && ascii.len() <= MAX_ASCII
        && ascii.bytes().all(|b| b.is_ascii() && b != 0)
}

/// The text in as many bytes as it had: keys count them. A letter that was no UTF-8 has become one sign of three bytes.
#[cfg(any(test, feature = "tiff"))]
fn ascii(text: &str) -> String {
    let text = text.trim_end_matches('\0');
    let of = |c: char| match c {
        '\0' => "|".to_owned(),
        c if c.is_ascii() => c.to_string(),
        char::REPLACEMENT_CHARACTER => "?".to_owned(),
        c => "?".repeat(c.len_utf8()),
    };
    text.chars().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn system(directory: &[u16], doubles: &[f64], ascii: &str) -> CoordinateSystem {
        CoordinateSystem::GeoKeys { directory: directory.to_vec(), doubles: doubles.to_vec(), ascii: ascii.to_owned() }
    }

    #[test]
    fn keys_that_refer_to_nothing_are_not_written() {
        let head = [1, 1, 0, 1];
        let one = |e: [u16; 4]| [head, e].concat();
        assert!(tags(&system(&one([3078, DOUBLES, 1, 0]), &[29.5], "")).is_some());
        assert!(tags(&system(&one([3078, DOUBLES, 1, 1]), &[29.5], "")).is_none());
        assert!(tags(&system(&one([3078, DOUBLES, 1, 0]), &[f64::NAN], "")).is_none());
        assert!(tags(&system(&one([1026, ASCII, 5, 0]), &[], "abc|")).is_some());
        assert!(tags(&system(&one([1026, ASCII, 6, 0]), &[], "abc|")).is_none());
        assert!(tags(&system(&one([1026, ASCII, 2, 0]), &[], "\u{e9}|")).is_none());
        assert!(tags(&system(&[1, 1, 0, 2, 1024, 0, 1, 1], &[], "")).is_none());
        assert!(tags(&system(&[2, 1, 0, 1, 1024, 0, 1, 1], &[], "")).is_none());
        assert!(tags(&system(&[], &[], "")).is_none());
        assert!(tags(&CoordinateSystem::Text("ESRI:102039".to_owned())).is_none());
    }

    #[test]
    fn letters_beyond_ascii_keep_their_bytes() {
        assert_eq!(ascii("a\u{e9}b|\u{fffd}|\0"), "a??b|?|");
    }
}
