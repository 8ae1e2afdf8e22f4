//! R32: headerless `f32` rows with a JSON file beside them that says what they are.

use crate::atomic::{put, row_bytes, write_atomically};
use crate::error::{Error, Result};
use crate::raster::{Raster, check_size};
use eyot_core::{Field, Georeference, Layer, Limits, World};
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{BufReader, Read, Seek};
use std::path::{Path, PathBuf};

/// Sidecars are a few hundred bytes; anything far larger is something else.
const MAX_SIDECAR_BYTES: u64 = 1 << 20;

/// What the file beside the data says. Only `width` and `height` are needed to read files of other programs.
#[derive(Debug, Serialize, Deserialize)]
struct Sidecar {
    format: String,
    width: usize,
    height: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cell_x_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cell_y_m: Option<f64>,
    #[serde(default)]
    layer: String,
    #[serde(default)]
    unit: String,
    #[serde(default)]
    meaning: String,
    #[serde(default)]
    min: Option<f32>,
    #[serde(default)]
    max: Option<f32>,
    #[serde(default)]
    byte_order: ByteOrder,
    #[serde(default)]
    row_order: RowOrder,
    /// CRC-32 of the data file, eight hexadecimal digits: tells a sidecar that belongs to other data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    crc32: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    georeference: Option<Georeference>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum ByteOrder {
    #[default]
    #[serde(rename = "little-endian")]
    Little,
    #[serde(rename = "big-endian")]
    Big,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum RowOrder {
    #[default]
    #[serde(rename = "north to south")]
    NorthFirst,
    #[serde(rename = "south to north")]
    SouthFirst,
}

/// `height.r32` has its description in `height.r32.json`.
pub(crate) fn sidecar_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".json");
    name.into()
}

/// Writes the data, then the sidecar; a crash in between leaves a checksum that does not fit.
pub(crate) fn write(path: &Path, world: &World, layer: &Layer) -> Result<()> {
    let field = &layer.field;
    let mut crc = crc32fast::Hasher::new();
    write_atomically(path, |file| {
        let mut buffer = Vec::new();
        for row in field.rows() {
            let bytes = row_bytes(row, &mut buffer);
            crc.update(bytes);
            put(file, path, bytes)?;
        }
        Ok(())
    })?;
    let sidecar = Sidecar {
        format: "r32".to_owned(),
        width: field.width(),
        height: field.height(),
        cell_x_m: Some(world.grid.cell_x_m),
        cell_y_m: Some(world.grid.cell_y_m),
        layer: layer.spec.name.to_string(),
        unit: layer.spec.unit.to_string(),
        meaning: layer.spec.meaning.to_string(),
        min: field.iter().reduce(f32::min),
        max: field.iter().reduce(f32::max),
        byte_order: ByteOrder::Little,
        row_order: RowOrder::NorthFirst,
        crc32: Some(format!("{:08x}", crc.finalize())),
        georeference: world.georeference.clone(),
    };
    let beside = sidecar_path(path);
    let text = serde_json::to_string_pretty(&sidecar)
        .map_err(|e| Error::format(&beside, e.to_string(), "this is a fault in eyot-io"))?;
    write_atomically(&beside, |file| put(file, &beside, format!("{text}\n").as_bytes()))
}

/// Reads `path` if a sidecar lies beside it, else `None`.
pub(crate) fn read_if_described(path: &Path, file: &mut File, bytes: u64, limits: &Limits) -> Result<Option<Raster>> {
    let beside = sidecar_path(path);
    match fs::metadata(&beside) {
        Ok(m) if m.is_file() && m.len() <= MAX_SIDECAR_BYTES => {}
        _ => return Ok(None),
    }
    let text = fs::read_to_string(&beside).map_err(Error::io(&beside, "read"))?;
    // Other programs put JSON beside their files, too: only one that says `r32` counts.
    let value: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    if path.extension().is_none_or(|e| e != "r32") && value.get("format").and_then(|f| f.as_str()) != Some("r32") {
        return Ok(None);
    }
    let sidecar: Sidecar = serde_json::from_str(&text).map_err(|e| {
        Error::format(&beside, format!("not a description of an R32 file: {e}"), "export the file again")
    })?;
    read(path, &beside, file, bytes, &sidecar, limits).map(Some)
}

fn read(path: &Path, beside: &Path, file: &mut File, bytes: u64, s: &Sidecar, limits: &Limits) -> Result<Raster> {
    if s.width == 0 || s.height == 0 {
        return Err(Error::format(
            beside,
            format!("a grid of {}x{}", s.width, s.height),
            "both sides must be at least 1",
        ));
    }
    check_size(path, s.width, s.height, limits)?;
    let needed = s.width as u128 * s.height as u128 * 4;
    if u128::from(bytes) != needed {
        let problem = format!("{}x{} cells need {needed} bytes, the file has {bytes}", s.width, s.height);
        return Err(Error::format(
            path,
            problem,
            "it is truncated or its .json belongs to another file: export it again",
        ));
    }
    file.rewind().map_err(Error::io(path, "read"))?;
    let mut input = BufReader::with_capacity(1 << 18, file);
    let mut crc = crc32fast::Hasher::new();
    let mut field = Field::new(s.width, s.height, 0.0);
    let mut buffer = vec![0; 4 * s.width];
    for i in 0..s.height {
        input.read_exact(&mut buffer).map_err(Error::io(path, "read"))?;
        crc.update(&buffer);
        let y = if s.row_order == RowOrder::NorthFirst { i } else { s.height - 1 - i };
        for (v, b) in field.row_mut(y).iter_mut().zip(buffer.chunks_exact(4)) {
            let b = [b[0], b[1], b[2], b[3]];
            *v = if s.byte_order == ByteOrder::Little { f32::from_le_bytes(b) } else { f32::from_be_bytes(b) };
        }
    }
    let found = format!("{:08x}", crc.finalize());
    if s.crc32.as_ref().is_some_and(|c| !c.eq_ignore_ascii_case(&found)) {
        return Err(Error::format(path, "the checksum in its .json does not fit the data", "export the file again"));
    }
    let cell_m = s.cell_x_m.zip(s.cell_y_m).filter(|&(x, y)| x > 0.0 && y > 0.0);
    Ok(Raster { field, cell_m, georeference: s.georeference.clone(), filled: 0 })
}
