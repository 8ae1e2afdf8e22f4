//! OpenEXR, out: channels of `f32` in blocks of 16 lines, losslessly compressed (ZIP).
//!
//! A single layer is the channel `Y`, which programs show as grey; several carry their names. What a file can say of its
//! place stands as JSON in the attribute `eyot`.

use crate::about::About;
use crate::atomic::watched;
use crate::error::{Error, Result};
use crate::rows::{Rows, read_band};
use crate::sidecar::{Channel, Sidecar};
use crate::target::Target;
use exr::block::chunk::Chunk;
use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::compression::Compression;
use exr::error::Error as ExrError;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{AttributeValue, ChannelDescription, LineOrder, SampleType, Text};
use exr::meta::header::{Header, LayerAttributes};
use rayon::prelude::*;
use std::path::Path;

/// The attribute that holds the description.
pub(crate) const ATTRIBUTE: &str = "eyot";
/// Lines of a block of ZIP compression.
const BLOCK: usize = 16;
/// Bytes of values that are held at a time, about.
const BAND_BYTES: usize = 16 << 20;

/// Writes layers of the same size as the channels of one OpenEXR image of `f32`; a single layer is the channel `Y`.
///
/// # Errors
/// If there is no layer, if layers differ in size, if a name has letters beyond Latin-1, if `rows` fail or give a value
/// that is not finite, or if the file cannot be written.
pub fn write_exr<'a>(to: impl Into<Target<'a>>, layers: &mut [(&About, &mut dyn Rows)]) -> Result<()> {
    let to = to.into();
    let path = to.place();
    // Channels stand in the order of their names.
    layers.sort_by(|a, b| a.0.name.cmp(&b.0.name));
    let Some((width, height)) = layers.first().map(|(_, rows)| rows.size()) else {
        return Err(Error::format(path, "no layer is to be written", "name at least one"));
    };
    if layers.iter().any(|(_, rows)| rows.size() != (width, height)) {
        return Err(Error::format(path, "the layers differ in size", "write layers of one world"));
    }
    // Coordinates are i32.
    if width.max(height) > i32::MAX as usize {
        return Err(Error::format(path, format!("{width}x{height} cells are too many for EXR"), "write Zarr or R32"));
    }
    let header = header(path, layers, (width, height))?;
    let mut failure = None;
    to.write_seeking(|file| {
        watched(file, path, |out| {
            let result = exr::block::write(out, [header].into_iter().collect(), true, |meta, writer| {
                let blocks: Vec<(usize, BlockIndex)> =
                    exr::block::enumerate_ordered_header_block_indices(&meta.headers).collect();
                let at_once = (BAND_BYTES / 4 / BLOCK / width / layers.len()).max(1);
                let mut bands = vec![vec![0.0; width * (BLOCK * at_once).min(height)]; layers.len()];
                for group in blocks.chunks(at_once) {
                    let first = group[0].1.pixel_position.y();
                    let lines: usize = group.iter().map(|(_, b)| b.pixel_size.y()).sum();
                    for ((_, rows), band) in layers.iter_mut().zip(&mut bands) {
                        if let Err(e) = read_band(path, *rows, first, &mut band[..width * lines]) {
                            failure = Some(e);
                            return Err(ExrError::Aborted);
                        }
                    }
                    let chunk = |&(number, index): &(usize, BlockIndex)| -> exr::error::Result<(usize, Chunk)> {
                        let data = block(&bands, width, index.pixel_position.y() - first, index.pixel_size.y());
                        Ok((number, UncompressedBlock { index, data }.compress_to_chunk(&meta.headers)?))
                    };
                    let chunks: Vec<_> = group.par_iter().map(chunk).collect();
                    for chunk in chunks {
                        let (number, chunk) = chunk?;
                        writer.write_chunk(number, chunk)?;
                    }
                }
                Ok(())
            });
            match (failure.take(), result) {
                (Some(e), _) => Err(e),
                (None, Err(ExrError::Io(e))) => Err(Error::io(path, "write")(e)),
                (None, Err(e)) => Err(Error::format(path, e.to_string(), "write GeoTIFF instead")),
                (None, Ok(())) => Ok(()),
            }
        })
    })
}

/// The bytes of `lines` lines from line `first` on of the bands: line by line, channel by channel.
fn block(bands: &[Vec<f32>], width: usize, first: usize, lines: usize) -> Vec<u8> {
    let mut data = Vec::with_capacity(4 * width * lines * bands.len());
    for y in first..first + lines {
        for band in bands {
            data.extend(band[y * width..][..width].iter().flat_map(|v| v.to_ne_bytes()));
        }
    }
    data
}

fn header(path: &Path, layers: &[(&About, &mut dyn Rows)], (width, height): (usize, usize)) -> Result<Header> {
    let text = |s: &str| {
        Text::new_or_none(s).ok_or_else(|| {
            Error::format(path, format!("`{s}` cannot name a channel of an EXR"), "use letters of western alphabets")
        })
    };
    let mut channels = Vec::new();
    for (about, _) in layers {
        let name = if layers.len() == 1 { text("Y")? } else { text(&about.name)? };
        channels.push(ChannelDescription::new(name, SampleType::F32, true));
    }
    let about = layers.iter().find(|(a, _)| a.name == "height").unwrap_or(&layers[0]).0;
    let mut description = Sidecar::of("exr", (width, height), about);
    if layers.len() > 1 {
        description.layer.clear();
        let channel = |a: &About| Channel { layer: a.name.clone(), unit: a.unit.clone(), meaning: a.meaning.clone() };
        description.channels = layers.iter().map(|(a, _)| channel(a)).collect();
    }
    let json = serde_json::to_string(&description)
        .map_err(|e| Error::format(path, e.to_string(), "this is a fault in eyot-io"))?;
    let mut own = LayerAttributes { software_name: Some(Text::from("Eyot")), ..LayerAttributes::default() };
    // One attribute alone: several would come in the random order of a hash map.
    own.other.insert(Text::from(ATTRIBUTE), AttributeValue::Text(text(&ascii(&json))?));
    Ok(Header::new(Text::from(""), Vec2(width, height), channels.into_iter().collect())
        .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(LayerAttributes { layer_name: None, ..own }))
}

/// JSON in which other letters than ASCII's are escaped: EXR's text is Latin-1 at best.
fn ascii(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_ascii() {
            out.push(c);
        } else {
            let mut units = [0; 2];
            for unit in c.encode_utf16(&mut units) {
                out.push_str(&format!("\\u{unit:04x}"));
            }
        }
    }
    out
}
