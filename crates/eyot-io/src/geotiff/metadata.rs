//! What a GeoTIFF says of itself in words: GDAL's XML tag, and the texts of plain TIFF.

use crate::about::About;
#[cfg(any(test, feature = "tiff"))]
use std::collections::BTreeMap;
use std::fmt::Write;

/// GDAL's tag.
pub(crate) const GDAL_METADATA: u16 = 42112;
/// Texts of TIFF itself under GDAL's names, in the order of their tags.
pub(crate) const TEXTS: [(u16, &str); 5] = [
    (270, "TIFFTAG_IMAGEDESCRIPTION"),
    (305, "TIFFTAG_SOFTWARE"),
    (306, "TIFFTAG_DATETIME"),
    (315, "TIFFTAG_ARTIST"),
    (33432, "TIFFTAG_COPYRIGHT"),
];
/// Band item that holds one sentence of meaning.
const MEANING: &str = "long_name";
/// Longer texts are no description.
#[cfg(any(test, feature = "tiff"))]
const MAX_BYTES: usize = 1 << 18;

/// What the XML says.
#[cfg(any(test, feature = "tiff"))]
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Metadata {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) meaning: String,
    /// Of the whole file.
    pub(crate) tags: BTreeMap<String, String>,
    /// Values are numbers times this ...
    pub(crate) scale: Option<f64>,
    /// ... plus this.
    pub(crate) offset: Option<f64>,
}

#[cfg(any(test, feature = "tiff"))]
impl Metadata {
    /// Reads `<Item name="..." sample="0" role="...">text</Item>`, of the first band and of the file. Whatever else there
    /// is does not count.
    pub(crate) fn parse(xml: &str) -> Self {
        let mut this = Self::default();
        let xml = if xml.len() > MAX_BYTES { "" } else { xml };
        for item in xml.split("<Item").skip(1) {
            let Some((head, rest)) = item.split_once('>') else { continue };
            let text = if head.ends_with('/') { "" } else { rest.split_once("</Item").map_or("", |(text, _)| text) };
            let attribute = |key: &str| {
                let at = head.find(&format!(" {key}=\""))? + key.len() + 3;
                head[at..].split('"').next()
            };
            let (name, text) = (unescaped(attribute("name").unwrap_or("")), unescaped(text));
            match (attribute("domain"), attribute("sample"), attribute("role")) {
                (None, Some("0"), Some("unittype")) => this.unit = text,
                (None, Some("0"), Some("description")) => this.name = text,
                (None, Some("0"), Some("scale")) => this.scale = text.trim().parse().ok(),
                (None, Some("0"), Some("offset")) => this.offset = text.trim().parse().ok(),
                (None, Some("0"), None) if name == MEANING => this.meaning = text,
                (None, None, None) if !name.is_empty() => drop(this.tags.insert(name, text)),
                _ => {}
            }
        }
        this
    }
}

/// The XML of what a file of these values says, if there is anything to say.
pub(crate) fn xml(about: &About) -> Option<String> {
    let mut out = String::from("<GDALMetadata>\n");
    let empty = out.len();
    let mut item = |name: &str, more: &str, text: &str| {
        if !text.is_empty() {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "  <Item name=\"{}\"{more}>{}</Item>", escaped(name), escaped(text));
        }
    };
    for (name, text) in about.tags.iter().filter(|(name, _)| TEXTS.iter().all(|(_, n)| n != name)) {
        item(name, "", text);
    }
    item(MEANING, " sample=\"0\"", &about.meaning);
    item("DESCRIPTION", " sample=\"0\" role=\"description\"", &about.name);
    item("UNITTYPE", " sample=\"0\" role=\"unittype\"", &about.unit);
    let said = out.len() > empty;
    out.push_str("</GDALMetadata>\n");
    said.then_some(out)
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // XML has no other control characters, not even escaped.
            c if c.is_control() && !"\n\t".contains(c) => {}
            c => out.push(c),
        }
    }
    out
}

#[cfg(any(test, feature = "tiff"))]
fn unescaped(text: &str) -> String {
    // The ampersand last: what it gives is no escape.
    let pairs = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    pairs.iter().fold(text.to_owned(), |t, (from, to)| t.replace(from, to))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_is_read_back() {
        let about = About {
            name: "height".to_owned(),
            unit: "m".to_owned(),
            meaning: "Height of the \"ground\" & <sea>".to_owned(),
            tags: [("SOURCE", "a &amp; b > c"), ("DATE", "2000-02-11")]
                .map(|(k, v)| (k.to_owned(), v.to_owned()))
                .into(),
            ..About::default()
        };
        let read = Metadata::parse(&xml(&about).unwrap());
        assert_eq!((&read.name, &read.unit, &read.meaning), (&about.name, &about.unit, &about.meaning));
        assert_eq!(read.tags, about.tags);
        assert_eq!(xml(&About::default()), None);
    }

    #[test]
    fn other_bands_and_broken_items_do_not_count() {
        let xml = "<GDALMetadata><Item name=\"UNITTYPE\" sample=\"1\" role=\"unittype\">ft</Item><Item name=\"X\" \
            domain=\"Y\">z</Item><Item name=\"EMPTY\"/><Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.1</Item><Item";
        let read = Metadata::parse(xml);
        let tags = [("EMPTY".to_owned(), String::new())].into();
        assert_eq!(read, Metadata { tags, scale: Some(0.1), ..Metadata::default() });
    }
}
