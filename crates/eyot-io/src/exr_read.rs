//! OpenEXR, in: one channel of any image that is not deep.

use crate::error::{Error, Result};
use crate::exr_write::ATTRIBUTE;
use crate::fill::Missing;
use crate::input::Opened;
use crate::raster::{Raster, ReadOptions, check_compression, check_size};
use crate::sidecar::{Channel, Sidecar};
use exr::block::UncompressedBlock;
use exr::block::reader::ChunksReader;
use exr::error::Error as ExrError;
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, SampleType};
use exr::meta::header::Header;
use eyot_core::remedy;
use eyot_core::remedy::Setting;
use eyot_core::{Field, Limits};
use std::io::{BufReader, Seek};
use std::path::Path;

pub(crate) fn read(opened: &mut Opened<'_>, options: &ReadOptions, limits: &Limits) -> Result<Raster> {
    let (path, file, bytes) = (&*opened.at.place, &mut opened.input, opened.bytes);
    file.rewind().map_err(Error::io(path, "read"))?;
    let failed = |e| as_error(path, e);
    let reader = exr::block::read(BufReader::with_capacity(1 << 18, file), false).map_err(failed)?;
    let (part, channel) = choose(path, reader.headers(), options.layer.as_deref())?;
    let header = reader.headers()[part].clone();
    check(path, reader.headers(), &header, channel, bytes, limits)?;
    let (width, height) = (header.layer_size.x(), header.layer_size.y());
    let chunks =
        reader.filter_chunks(true, |_, _, block| block.layer == part && block.level == Vec2(0, 0)).map_err(failed)?;
    let meta = chunks.meta_data().clone();
    let mut field = Field::new(width, height, 0.0);
    let mut missing = Missing::new(width, height, options.nodata);
    let kind = header.channels.list[channel].sample_type;
    let mut lines = 0;
    for chunk in chunks {
        let block = UncompressedBlock::decompress_chunk(chunk.map_err(failed)?, &meta, true).map_err(failed)?;
        for line in block.lines(&header.channels).filter(|l| l.location.channel == channel) {
            let (x0, y) = (line.location.position.x(), line.location.position.y());
            let mut put = |i: usize, number: f32| {
                missing.look_at(x0 + i, y, number.into());
                field.set(x0 + i, y, number);
            };
            match kind {
                SampleType::F32 => {
                    line.value.chunks_exact(4).enumerate().for_each(|(i, b)| put(i, f32::from_ne_bytes(four(b))))
                }
                SampleType::U32 => {
                    line.value.chunks_exact(4).enumerate().for_each(|(i, b)| put(i, u32::from_ne_bytes(four(b)) as f32))
                }
                SampleType::F16 => line
                    .value
                    .chunks_exact(2)
                    .enumerate()
                    .for_each(|(i, b)| put(i, exr::prelude::f16::from_ne_bytes([b[0], b[1]]).to_f32())),
            }
            lines += line.location.sample_count;
        }
    }
    if lines != width * height {
        return Err(Error::format(path, "the EXR ends too early", "it is truncated: copy or export it again"));
    }
    let missing = missing.fill(path, &mut field)?;
    let s = description(&header, (width, height));
    let name = header.channels.list[channel].name.to_string();
    let own = s.channels.iter().find(|c| c.layer == name).cloned();
    let mut raster = s.describe(Raster { missing, ..Raster::of(field) });
    if name != "Y" {
        raster.name = name;
        // Of foreign channels nothing is known; the description is that of the height.
        let Channel { unit, meaning, .. } = own.unwrap_or_default();
        (raster.unit, raster.meaning) = (unit, meaning);
    }
    Ok(raster)
}

/// The names of the channels if there are several.
pub(crate) fn names(opened: &mut Opened<'_>) -> Result<Vec<String>> {
    let (path, file) = (&*opened.at.place, &mut opened.input);
    file.rewind().map_err(Error::io(path, "read"))?;
    let reader = exr::block::read(BufReader::with_capacity(1 << 18, file), false).map_err(|e| as_error(path, e))?;
    let all: Vec<String> = channels(reader.headers()).into_iter().map(|c| c.0).collect();
    Ok(if all.len() > 1 { all } else { Vec::new() })
}

fn four(b: &[u8]) -> [u8; 4] {
    [b[0], b[1], b[2], b[3]]
}

/// Every channel's whole name, its name within its part, and its place.
fn channels(headers: &[Header]) -> Vec<(String, String, (usize, usize))> {
    let mut all = Vec::new();
    for (part, h) in headers.iter().enumerate() {
        for (channel, c) in h.channels.list.iter().enumerate() {
            let whole = match &h.own_attributes.layer_name {
                Some(layer) => format!("{layer}.{}", c.name),
                None => c.name.to_string(),
            };
            all.push((whole, c.name.to_string(), (part, channel)));
        }
    }
    all
}

/// Part and channel that are meant: the named one, or the only one, or the one that is called like a height.
fn choose(path: &Path, headers: &[Header], wanted: Option<&str>) -> Result<(usize, usize)> {
    let all = channels(headers);
    let find = |name: &str| all.iter().find(|(whole, short, _)| whole == name || short == name).map(|c| c.2);
    let names = || all.iter().map(|c| c.0.as_str()).collect::<Vec<_>>().join(", ");
    match (wanted, all.as_slice()) {
        (Some(name), _) => find(name).ok_or_else(|| {
            Error::format(path, format!("the EXR has no channel `{name}`"), format!("there is {}", names()))
        }),
        (None, [one]) => Ok(one.2),
        (None, _) => ["height", "Y", "Z"].into_iter().find_map(find).ok_or_else(|| {
            let problem = format!("the EXR has the channels {}", names());
            Error::format(path, problem, remedy!["say which one holds the heights (", Setting::Layer.form(), ")"])
        }),
    }
}

/// Refuses sizes that are too large and images whose data cannot be in the file.
fn check(path: &Path, all: &[Header], h: &Header, channel: usize, bytes: u64, limits: &Limits) -> Result<()> {
    let (width, height) = (h.layer_size.x(), h.layer_size.y());
    if width == 0 || height == 0 {
        return Err(Error::format(path, format!("an image of {width}x{height}"), "export it again"));
    }
    check_size(path, width, height, limits)?;
    if h.deep {
        return Err(Error::format(path, "a deep image holds no heights", "flatten it first"));
    }
    if h.channels.list[channel].sampling != Vec2(1, 1) {
        return Err(Error::format(
            path,
            "a subsampled channel holds no heights",
            remedy!["choose another (", Setting::Layer.form(), ")"],
        ));
    }
    // Tables of offsets come before the data, eight bytes a block.
    let blocks: u128 = all.iter().map(|h| h.chunk_count as u128).sum();
    let block = h.max_block_pixel_size();
    let pixels = block.x().min(width) as u128 * block.y().min(height) as u128;
    if blocks * 8 > u128::from(bytes) {
        let problem = format!("the file has {bytes} bytes, which cannot hold its {blocks} blocks");
        return Err(Error::format(path, problem, "it is truncated or damaged: copy or export it again"));
    }
    let image = width as u128 * height as u128 * h.channels.bytes_per_pixel as u128;
    check_compression(path, width, height, image, bytes)?;
    // The decoder takes memory for whole tiles, of all parts, even where they are far larger than the image.
    for h in all {
        let tile = h.max_block_pixel_size();
        let tile = tile.x() as u128 * tile.y() as u128 * h.channels.bytes_per_pixel as u128;
        let image = h.layer_size.x() as u128 * h.layer_size.y() as u128 * h.channels.bytes_per_pixel as u128;
        if tile > (32 << 20) && tile > 16 * image {
            let problem = format!("tiles of {} MiB for an image of {} bytes", tile >> 20, image);
            return Err(Error::format(path, problem, "it is damaged: copy or export it again"));
        }
    }
    // Compressed, decompressed and sorted.
    limits
        .check_bytes("a block of the image", 3 * pixels * h.channels.bytes_per_pixel as u128)
        .map_err(Error::beyond(path))
}

fn description(h: &Header, size: (usize, usize)) -> Sidecar {
    let of = |other: &std::collections::HashMap<_, _>| match other.get(ATTRIBUTE.as_bytes()) {
        Some(AttributeValue::Text(t)) => Some(t.to_string()),
        _ => None,
    };
    let json = of(&h.own_attributes.other).or_else(|| of(&h.shared_attributes.other)).unwrap_or_default();
    serde_json::from_str(&json).ok().filter(|s: &Sidecar| (s.width, s.height) == size).unwrap_or_default()
}

fn as_error(path: &Path, e: ExrError) -> Error {
    match e {
        ExrError::Io(e) if e.kind() != std::io::ErrorKind::UnexpectedEof => Error::io(path, "read")(e),
        ExrError::NotSupported(what) => {
            Error::format(path, format!("this kind of EXR is not read: {what}"), "export it with ZIP compression")
        }
        other => Error::format(path, format!("broken EXR: {other}"), "copy or export it again"),
    }
}
