//! Zarr stores, in: one array as a raster.

use super::array::{Array, metadata};
use super::{ATTRIBUTES, METADATA, PLACE, SYSTEM};
use crate::error::{Error, Result};
use crate::fill::Missing;
use crate::georef::{cell_size_m, face_north, is_nowhere, is_sound};
use crate::raster::{Raster, ReadOptions, check_size};
use crate::sample::{ByteOrder, Narrowed, Sample};
use eyot_core::remedy;
use eyot_core::remedy::Setting;
use eyot_core::{CoordinateSystem, Field, Georeference, Limits};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// Arrays of a group that are looked at.
const MAX_ARRAYS: usize = 4096;
/// Arrays up to this size may have no chunks at all.
const FREE_BYTES: u128 = 64 << 20;
/// Values a byte of all chunks, at most: Zstandard makes 17000 of a constant, and chunks of the fill value alone are often
/// left out.
const MAX_COMPRESSION: u128 = 1 << 16;

/// True if the folder is a Zarr v3 group or array.
pub(crate) fn is_node(folder: &Path) -> bool {
    folder.join(METADATA).is_file()
}

/// Reads an array of a store, or the array at `path` itself. Of more than two dimensions, the last step of each leading
/// one is taken.
pub(crate) fn read(path: &Path, options: &ReadOptions, limits: &Limits) -> Result<Raster> {
    let folder = choose(path, options.layer.as_deref())?;
    let array = Array::open(&folder, limits)?;
    let (height, width) = match array.shape.as_slice() {
        [.., h, w] if array.shape.iter().all(|&n| n > 0) => (*h as usize, *w as usize),
        other => {
            let problem = format!("an array of the shape {other:?}, heights need rows and columns");
            return Err(Error::format(&folder, problem, remedy!["name another one (", Setting::Layer.form(), ")"]));
        }
    };
    let held = check_size(&folder, width, height, limits)?;
    // A piece, its compressed form and what it is unpacked to.
    let piece: u128 = array.piece.iter().map(|&n| u128::from(n)).product();
    limits
        .check_bytes("the array with a chunk of it", held + 3 * piece * array.sample.bytes() as u128)
        .map_err(Error::beyond(&folder))?;
    array.check_pieces()?;
    check_stored(&array, held)?;
    let nodata = options.nodata.or_else(|| missing_value(&array));
    let number = |key: &str| array.attributes.get(key).and_then(Value::as_f64);
    let (factor, offset) = (number("scale_factor").unwrap_or(1.0), number("add_offset").unwrap_or(0.0));
    let mut field = Field::new(width, height, 0.0);
    let mut missing = Missing::new(width, height, nodata);
    let mut narrowed = Narrowed::default();
    values(&array, |y, x, v| {
        missing.look_at(x, y, v);
        // Unscaled values stay as they are to the bit.
        field.set(x, y, if (factor, offset) == (1.0, 0.0) { narrowed.of(v) } else { (v * factor + offset) as f32 });
    })?;
    let missing = missing.fill(&folder, &mut field)?;
    let stands_for = |(low, high): (f64, f64)| (low * factor + offset, high * factor + offset);
    let scale = array.sample.scale().map(stands_for).filter(|(low, high)| low < high);
    let steps = array.shape.iter().rev().skip(2).product();
    let mut raster = Raster { missing, steps, scale, rounded_by: narrowed.by(), ..Raster::of(field) };
    describe(&array, path, &mut raster, limits);
    Ok(raster)
}

/// The array that is meant.
fn choose(path: &Path, wanted: Option<&str>) -> Result<PathBuf> {
    let node = metadata(path)?;
    if node["node_type"] == "array" {
        return Ok(path.to_owned());
    }
    let names = names_of(path)?;
    let there = names.join(", ");
    match (wanted, names.as_slice()) {
        (Some(name), _) if names.iter().any(|n| n == name) => Ok(path.join(name)),
        (Some(name), _) => {
            Err(Error::format(path, format!("the store has no array `{name}`"), format!("there is {there}")))
        }
        (None, [one]) => Ok(path.join(one)),
        (None, []) => {
            Err(Error::format(path, "the store has no arrays of rows and columns", "is this the right folder?"))
        }
        (None, _) if names.iter().any(|n| n == "height") => Ok(path.join("height")),
        (None, _) => {
            let problem = format!("the store has the arrays {there}");
            Err(Error::format(path, problem, remedy!["say which one holds the heights (", Setting::Layer.form(), ")"]))
        }
    }
}

/// The attributes of the root of a store; none for other files.
///
/// # Errors
/// If the store's metadata cannot be read.
pub fn store_attributes(path: &Path) -> Result<Map<String, Value>> {
    if !is_node(path) {
        return Ok(Map::new());
    }
    let node = metadata(path)?;
    // Those of an array are its own.
    let of_group = node["attributes"].as_object().filter(|_| node["node_type"] == "group");
    Ok(of_group.cloned().unwrap_or_default())
}

/// The names of the arrays of rows and columns, in their order; none if the folder is an array itself.
pub(crate) fn names(path: &Path) -> Result<Vec<String>> {
    if metadata(path)?["node_type"] == "array" { Ok(Vec::new()) } else { names_of(path) }
}

fn names_of(path: &Path) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(path).map_err(Error::io(path, "read the folder"))?.flatten().take(MAX_ARRAYS) {
        let (folder, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if !is_node(&folder) {
            continue;
        }
        // What cannot be read is named all the same: it may be the one that is meant.
        let flat = metadata(&folder).is_ok_and(|m| m["shape"].as_array().is_some_and(|s| s.len() < 2));
        if !flat {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

/// Refuses large arrays of which next to nothing is there.
fn check_stored(array: &Array, image: u128) -> Result<()> {
    if image <= FREE_BYTES {
        return Ok(());
    }
    let ((mut at, _), rank) = (last_step(array), array.shape.len());
    let count = |d: usize| array.shape[d].div_ceil(array.piece[d]);
    let (mut stored, needed) = (0, image / MAX_COMPRESSION);
    for row in 0..count(rank - 2) {
        for column in 0..count(rank - 1) {
            (at[rank - 2], at[rank - 1]) = (row, column);
            stored += u128::from(array.piece_bytes(&at));
            if stored >= needed {
                return Ok(());
            }
        }
    }
    let problem = format!("its chunks have {stored} bytes, which cannot hold its {:?} cells", array.shape);
    Err(Error::format(&array.folder, problem, "chunks are missing: copy or export the whole store again"))
}

/// The piece of the last index along the leading dimensions, and where that index lies in it.
fn last_step(array: &Array) -> (Vec<u64>, u64) {
    let rank = array.shape.len();
    let (mut at, mut start) = (vec![0; rank], 0u64);
    for d in 0..rank.saturating_sub(2) {
        let last = array.shape[d] - 1;
        at[d] = last / array.piece[d];
        start = start * array.piece[d] + last % array.piece[d];
    }
    (at, start)
}

/// Hands every value of the last two dimensions to `take(row, column, value)`, or of a list to `take(0, i, value)`.
fn values(array: &Array, mut take: impl FnMut(usize, usize, f64)) -> Result<()> {
    let rank = array.shape.len();
    let along = |d: usize| if d < rank { (array.shape[d], array.piece[d]) } else { (1, 1) };
    let ((height, down), (width, across)) =
        if rank >= 2 { (along(rank - 2), along(rank - 1)) } else { ((1, 1), along(0)) };
    let size = array.sample.bytes();
    let (mut at, start) = last_step(array);
    for row in 0..height.div_ceil(down) {
        for column in 0..width.div_ceil(across) {
            if rank >= 2 {
                at[rank - 2] = row;
            }
            if rank >= 1 {
                at[rank - 1] = column;
            }
            let piece = array.piece(&at)?;
            let rows = down.min(height - row * down);
            let columns = across.min(width - column * across);
            for y in 0..rows {
                for x in 0..columns {
                    let i = ((start * down + y) * across + x) as usize * size;
                    let v = piece.as_ref().map_or(array.fill, |p| array.number(&p[i..i + size]));
                    take((row * down + y) as usize, (column * across + x) as usize, v);
                }
            }
        }
    }
    Ok(())
}

/// The number that CF's attributes mark missing values with.
fn missing_value(array: &Array) -> Option<f64> {
    let value = ["_FillValue", "missing_value"].iter().find_map(|k| array.attributes.get(*k))?;
    match value {
        Value::Number(n) => n.as_f64(),
        Value::String(s) => match s.parse() {
            Ok(v) => Some(v),
            // xarray packs the bytes of floats in base 64.
            Err(_) => match base64(s)? {
                b if b.len() == 8 => Some(Sample::Float(8).number(&b, ByteOrder::Little)),
                b if b.len() == 4 => Some(Sample::Float(4).number(&b, ByteOrder::Little)),
                _ => None,
            },
        },
        _ => None,
    }
}

fn base64(text: &str) -> Option<Vec<u8>> {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let (mut out, mut bits, mut n) = (Vec::new(), 0u32, 0);
    for c in text.trim_end_matches('=').bytes().take(64) {
        bits = bits << 6 | LETTERS.iter().position(|l| *l == c)? as u32;
        n += 6;
        if n >= 8 {
            n -= 8;
            out.push((bits >> n) as u8);
        }
    }
    Some(out)
}

/// Name, unit and place, as far as the store says. What is broken here is only unknown.
fn describe(array: &Array, store: &Path, raster: &mut Raster, limits: &Limits) {
    let text = |key: &str| array.attributes.get(key).and_then(Value::as_str).unwrap_or_default().to_owned();
    raster.name = array.folder.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    if array.folder == store {
        raster.name = raster.name.trim_end_matches(".zarr").to_owned();
    }
    raster.unit = text("units");
    raster.meaning = text("long_name");
    let texts = array.attributes.iter().filter(|(key, _)| !ATTRIBUTES.contains(&key.as_str()));
    raster.tags = texts.filter_map(|(key, v)| Some((key.clone(), v.as_str()?.to_owned()))).collect();
    let beside = |name: &str| {
        let folder = array.folder.parent().map(|p| p.join(name)).filter(|f| is_node(f))?;
        Array::open(&folder, limits).ok()
    };
    let (width, height) = (raster.field.width(), raster.field.height());
    let mapping = array.attributes.get("grid_mapping").and_then(Value::as_str).unwrap_or(PLACE);
    let place = Some(mapping).filter(|m| !m.contains(['/', '\\'])).and_then(beside);
    let mut georeference = place.as_ref().and_then(georeference);
    let axis = |from_end: usize, n: usize| -> Option<(f64, f64, Array)> {
        let name = array.dimensions.len().checked_sub(from_end).map(|i| array.dimensions[i].as_str())?;
        let a = Some(name).filter(|m| !m.is_empty() && !m.contains(['/', '\\', '.'])).and_then(beside)?;
        let (start, step) = regular(&a, n)?;
        Some((start, step, a))
    };
    // A world of its own has coordinates, too; they say how large its cells are and which way its rows go.
    let axes = axis(1, width).zip(axis(2, height));
    let degrees =
        |a: &Array| a.attributes.get("units").and_then(Value::as_str).is_some_and(|u| u.starts_with("degree"));
    let mut own = axes.as_ref().map(|((x, dx, ax), (y, dy, _))| Georeference {
        transform: [x - dx / 2.0, *dx, 0.0, y - dy / 2.0, 0.0, *dy],
        geographic: degrees(ax),
        ..Georeference::default()
    });
    for g in georeference.iter_mut().chain(own.iter_mut()).take(1) {
        face_north(&mut raster.field, &mut raster.missing, g);
    }
    let number = |key: &str| array.attributes.get(key).and_then(Value::as_f64);
    let said = number("cell_x_m").zip(number("cell_y_m"));
    let measured = georeference.as_ref().or(own.as_ref()).map(|g| cell_size_m(g, width, height, 1.0));
    let usable = |&(x, y): &(f64, f64)| x.is_finite() && y.is_finite() && x > 0.0 && y > 0.0;
    raster.cell_m = said.or(measured).filter(usable);
    let foreign = said.is_none();
    raster.georeference = georeference.or(own.filter(|g| foreign && !is_nowhere(g, height)));
}

/// What `spatial_ref` says.
fn georeference(array: &Array) -> Option<Georeference> {
    let text = |key: &str| array.attributes.get(key).and_then(Value::as_str);
    let numbers: Vec<f64> = text("GeoTransform")?.split_whitespace().map_while(|n| n.parse().ok()).collect();
    let transform: [f64; 6] = numbers.try_into().ok()?;
    let code = text("spatial_ref").or_else(|| text("crs_wkt")).and_then(epsg);
    let keys = text(SYSTEM).and_then(|json| serde_json::from_str(json).ok());
    let words = || text("crs_wkt").or_else(|| text("spatial_ref")).map(|t| CoordinateSystem::Text(t.to_owned()));
    let system = keys.or_else(|| words().filter(|_| code.is_none()));
    let wkt = text("crs_wkt").or_else(|| text("spatial_ref")).unwrap_or("");
    let geographic = match array.attributes.get("geographic").and_then(Value::as_u64) {
        Some(known) => known == 1,
        None => wkt.starts_with("GEOG") || text("grid_mapping_name") == Some("latitude_longitude"),
    };
    let nodata = array.attributes.get("source_nodata").and_then(Value::as_f64);
    Some(Georeference { transform, epsg: code, geographic, nodata, system }).filter(is_sound)
}

/// The code in `EPSG:32611`, or that of a well-known text as a whole. Codes inside are those of its parts, such as its unit,
/// and one of a compound system says two at once.
fn epsg(text: &str) -> Option<u32> {
    if let Some(code) = text.strip_prefix("EPSG:") {
        return code.parse().ok();
    }
    let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    if text.starts_with("COMP") {
        return None;
    }
    let (_, last) = text.rsplit_once("[\"EPSG\",")?;
    last.strip_suffix("]]")?.trim_matches('"').parse().ok()
}

/// First value and step of a list of `n` evenly spaced numbers.
fn regular(array: &Array, n: usize) -> Option<(f64, f64)> {
    if array.shape != [n as u64] || n < 2 {
        return None;
    }
    array.check_pieces().ok()?;
    let mut list = vec![0.0; n];
    values(array, |_, i, v| list[i] = v).ok()?;
    let step = (list[n - 1] - list[0]) / (n - 1) as f64;
    let even = list.windows(2).all(|w| ((w[1] - w[0]) - step).abs() <= 1e-3 * step.abs());
    (step.is_finite() && step != 0.0 && even).then_some((list[0], step))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_code_of_the_whole_counts() {
        let unit = "UNIT[\"metre\",1,AUTHORITY[\"EPSG\",\"9001\"]]";
        assert_eq!(epsg("EPSG:32611"), Some(32611));
        assert_eq!(epsg(&format!("PROJCS[\"UTM\",{unit},AUTHORITY[\"EPSG\",\"32611\"]]")), Some(32611));
        assert_eq!(epsg("PROJCRS[\"UTM\",\n  ID[\"EPSG\", 32611 ]\n]"), Some(32611));
        assert_eq!(epsg(&format!("PROJCS[\"Albers\",{unit},AUTHORITY[\"ESRI\",\"102039\"]]")), None);
        assert_eq!(epsg(&format!("PROJCS[\"mine\",{unit}]")), None);
        assert_eq!(epsg("COMPOUNDCRS[\"WGS 84 + EGM2008\",ID[\"EPSG\",9518]]"), None);
        assert_eq!((epsg("ESRI:102039"), epsg("")), (None, None));
    }
}
