//! The JSON file beside headerless data that says what they are. `height.r32` has its description in `height.r32.json`.

use crate::about::About;
use crate::error::{Error, Result};
use crate::input::At;
use crate::raster::Raster;
use crate::sample::{ByteOrder, RowOrder};
use crate::storage::read_bytes;
use crate::target::Target;
use eyot_core::Georeference;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Sidecars are a few hundred bytes; anything far larger is something else.
const MAX_BYTES: u64 = 1 << 20;

/// What the file beside the data says. Only `width` and `height` are needed to read files of other programs.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Sidecar {
    pub(crate) format: String,
    pub(crate) width: usize,
    pub(crate) height: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) cell_x_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) cell_y_m: Option<f64>,
    /// Coordinates (x, y) of the grid's north-west corner: those of the georeference, or metres from the south-west corner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) origin: Option<[f64; 2]>,
    #[serde(default)]
    pub(crate) layer: String,
    #[serde(default)]
    pub(crate) unit: String,
    #[serde(default)]
    pub(crate) meaning: String,
    #[serde(default)]
    pub(crate) min: Option<f32>,
    #[serde(default)]
    pub(crate) max: Option<f32>,
    /// Values of 0 and of the largest number, for whole numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) low: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) high: Option<f64>,
    #[serde(default)]
    pub(crate) byte_order: ByteOrder,
    #[serde(default)]
    pub(crate) row_order: RowOrder,
    /// CRC-32 of the data file, eight hexadecimal digits: tells a sidecar that belongs to other data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) crc32: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) georeference: Option<Georeference>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) tags: BTreeMap<String, String>,
    /// What the channels of an image of several hold.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) channels: Vec<Channel>,
}

/// What one of several channels holds.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Channel {
    pub(crate) layer: String,
    #[serde(default)]
    pub(crate) unit: String,
    #[serde(default)]
    pub(crate) meaning: String,
}

impl Sidecar {
    /// What `about` says, in a file of this format and size.
    pub(crate) fn of(format: &str, size: (usize, usize), about: &About) -> Self {
        Self {
            format: format.to_owned(),
            width: size.0,
            height: size.1,
            cell_x_m: Some(about.cell_m.0),
            cell_y_m: Some(about.cell_m.1),
            layer: about.name.clone(),
            unit: about.unit.clone(),
            meaning: about.meaning.clone(),
            origin: Some([about.transform(size.1)[0], about.transform(size.1)[3]]),
            georeference: about.georeference.clone(),
            tags: about.tags.clone(),
            ..Self::default()
        }
    }

    /// The raster with what the description says of it.
    pub(crate) fn describe(self, raster: Raster) -> Raster {
        Raster {
            cell_m: self.cell_m(),
            georeference: self.georeference,
            name: self.layer,
            unit: self.unit,
            meaning: self.meaning,
            tags: self.tags,
            ..raster
        }
    }

    /// The cell size, if it is sound.
    fn cell_m(&self) -> Option<(f64, f64)> {
        self.cell_x_m.zip(self.cell_y_m).filter(|&(x, y)| x > 0.0 && y > 0.0)
    }

    /// Writes it beside the data.
    pub(crate) fn write(&self, to: &Target<'_>) -> Result<()> {
        let text = serde_json::to_string_pretty(self)
            .map_err(|e| Error::format(&sidecar_path(to.place()), e.to_string(), "this is a fault in eyot-io"))?;
        to.write_beside(&format!("{text}\n"))
    }

    /// The description beside an input if there is one that says a format of `formats`, or no format at all while the
    /// input's extension is one of them.
    pub(crate) fn beside(at: &At<'_>, formats: &[&str]) -> Result<Option<Self>> {
        let Some((storage, name)) = at.beside(".json") else { return Ok(None) };
        if storage.bytes(&name).is_none_or(|bytes| bytes > MAX_BYTES) {
            return Ok(None);
        }
        let text = read_bytes(storage, &name, MAX_BYTES)?;
        let (path, beside) = (&at.place, sidecar_path(&at.place));
        // Other programs put JSON beside their files, too: only one that names a format of ours counts.
        let value: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
        let named = value.get("format").and_then(|f| f.as_str()).is_some_and(|f| formats.contains(&f));
        let extension = path.extension().and_then(|e| e.to_str()).is_some_and(|e| formats.contains(&e));
        if !named && !extension {
            return Ok(None);
        }
        serde_json::from_slice(&text).map(Some).map_err(|e| {
            Error::format(&beside, format!("not a description of the raster beside it: {e}"), "export the file again")
        })
    }
}

/// Where the description of `path` lies.
pub(crate) fn sidecar_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".json");
    name.into()
}
