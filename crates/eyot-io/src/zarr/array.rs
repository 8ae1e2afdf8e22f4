//! The metadata of one array, checked.

use super::METADATA;
use super::codec::{Codec, Codecs};
use crate::error::{Error, Result};
use crate::sample::{ByteOrder, Sample};
use eyot_core::Limits;
use half::f16;
use serde_json::{Map, Value};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Metadata are kilobytes, consolidated ones of large stores a megabyte. Parsed, they can take twenty times as much.
const MAX_METADATA_BYTES: u64 = 4 << 20;
/// More dimensions than any landscape has.
const MAX_RANK: usize = 8;
/// Largest piece of an array that is worth being read at once.
const MAX_PIECE_BYTES: u128 = 1 << 30;
/// Files of an array that are looked for; more would take minutes, whether they are there or not.
const MAX_PIECES: u128 = 1 << 20;
/// Bytes of values that are unpacked for any array, and for each byte that is wanted of a larger one: chunks may hold other times,
/// too, a year of days or three of hours.
const FREE_WORK_BYTES: u128 = 2 << 30;
const MAX_WORK: u128 = 1024;
/// Chunks within shards that are unpacked for any array; more must be no more than its rows and columns have values.
const FREE_CHUNKS: u128 = 1 << 18;
/// Pieces up to this size may be far larger than their array.
const FREE_PIECE_BYTES: u128 = 32 << 20;
/// Larger ones may hold this many times their part of the array.
const MAX_EXCESS: u128 = 16;

/// An array whose sizes are sound.
pub(crate) struct Array {
    pub(crate) folder: PathBuf,
    pub(crate) shape: Vec<u64>,
    pub(crate) piece: Vec<u64>,
    pub(crate) sample: Sample,
    pub(super) fill: f64,
    pub(super) codecs: Codecs,
    pub(super) attributes: Map<String, Value>,
    pub(crate) dimensions: Vec<String>,
    /// Names of piece files: prefix (may be empty) and separator.
    key: (bool, char),
}

/// Reads a metadata file as JSON.
pub(crate) fn metadata(folder: &Path) -> Result<Value> {
    let path = folder.join(METADATA);
    metadata_from(&path, open(&path)?)
}

/// As [`metadata`], of a file that is open.
pub(crate) fn metadata_from(path: &Path, input: impl Read) -> Result<Value> {
    let mut text = Vec::new();
    input.take(MAX_METADATA_BYTES + 1).read_to_end(&mut text).map_err(Error::io(path, "read"))?;
    if text.len() as u64 > MAX_METADATA_BYTES {
        return Err(Error::format(path, "the metadata are far too long", "is this a Zarr store?"));
    }
    let value: Value = serde_json::from_slice(&text)
        .map_err(|e| Error::format(path, format!("not valid JSON: {e}"), "copy or export the store again"))?;
    match value["zarr_format"].as_u64() {
        Some(3) => Ok(value),
        v => {
            let v = v.map_or("unknown".to_owned(), |v| v.to_string());
            let problem = format!("Zarr of version {v}, this program reads version 3");
            Err(Error::format(path, problem, "write it again with zarr_format=3"))
        }
    }
}

impl Array {
    /// Reads and checks the metadata in `folder`; nothing else is read or allocated.
    pub(super) fn open(folder: &Path, limits: &Limits) -> Result<Self> {
        Self::described(folder, &metadata(folder)?, limits)
    }

    /// As [`Array::open`] with metadata from elsewhere: those in the root of a store.
    pub(crate) fn described(folder: &Path, value: &Value, limits: &Limits) -> Result<Self> {
        Self::of(folder, value, limits).map_err(|reason| match reason {
            Reason::Broken(what) => {
                Error::format(&folder.join(METADATA), what, "write it again, for example with zarr-python's defaults")
            }
            Reason::Core(e) => Error::beyond(folder)(e),
        })
    }

    fn of(folder: &Path, value: &Value, limits: &Limits) -> Result<Self, Reason> {
        if value["node_type"] != "array" {
            return broken("this is no array");
        }
        let shape = sizes(&value["shape"], "shape")?;
        let grid = &value["chunk_grid"];
        if name(grid) != Some("regular") {
            return broken("the chunk grid is not regular");
        }
        let piece = sizes(&grid["configuration"]["chunk_shape"], "chunk_shape")?;
        if shape.len() > MAX_RANK {
            return broken(format!("{} dimensions, at most {MAX_RANK} are read", shape.len()));
        }
        if piece.len() != shape.len() || piece.contains(&0) {
            return broken(format!("a chunk_shape {piece:?} does not fit the shape {shape:?}"));
        }
        let kind = value["data_type"].as_str().unwrap_or("");
        let bits = |prefix: &str| kind.strip_prefix(prefix).filter(|b| ["8", "16", "32", "64"].contains(b));
        let bytes = |b: &str| b.parse::<usize>().unwrap_or(8) / 8;
        let sample = match (bits("uint"), bits("int"), bits("float").filter(|b| *b != "8")) {
            (Some(b), _, _) => Sample::Unsigned(bytes(b)),
            (_, Some(b), _) => Sample::Signed(bytes(b)),
            (_, _, Some(b)) => Sample::Float(bytes(b)),
            _ if kind == "bool" => Sample::Unsigned(1),
            _ => return broken(format!("values of type {}", value["data_type"])),
        };
        let product = |sizes: &[u64]| sizes.iter().try_fold(1u128, |n, &s| n.checked_mul(u128::from(s)));
        if product(&shape).is_none_or(|n| n > i64::MAX as u128) {
            return broken(format!("a shape {shape:?} with more values than can be counted"));
        }
        let piece_bytes = product(&piece).and_then(|n| n.checked_mul(sample.bytes() as u128)).unwrap_or(u128::MAX);
        let most = MAX_PIECE_BYTES.min(u128::from(limits.max_bytes));
        if piece_bytes > most {
            return broken(format!(
                "chunks of {piece:?} values take {} MiB each, at most {} MiB are read",
                piece_bytes >> 20,
                most >> 20
            ));
        }
        let inside: u128 = piece.iter().zip(&shape).map(|(p, s)| u128::from(*p.min(s))).product();
        if piece_bytes > FREE_PIECE_BYTES.max(inside * MAX_EXCESS * sample.bytes() as u128) {
            return broken(format!("chunks of {piece:?} values are far larger than the shape {shape:?}"));
        }
        let (prefix, separator) = key(&value["chunk_key_encoding"])?;
        if value["storage_transformers"].as_array().is_some_and(|t| !t.is_empty()) {
            return broken("storage transformers are not read");
        }
        let codecs = Codec::chain(&value["codecs"], &piece, sample)?;
        let names = value["dimension_names"].as_array().map(Vec::as_slice).unwrap_or_default();
        Ok(Self {
            folder: folder.to_owned(),
            fill: fill(&value["fill_value"], sample)?,
            codecs,
            attributes: value["attributes"].as_object().cloned().unwrap_or_default(),
            dimensions: names.iter().map(|n| n.as_str().unwrap_or("").to_owned()).collect(),
            key: (prefix, separator),
            shape,
            piece,
            sample,
        })
    }

    /// The name of a piece in the array.
    pub(crate) fn key_of(&self, at: &[u64]) -> String {
        let (prefix, separator) = self.key;
        let mut parts: Vec<String> = at.iter().map(u64::to_string).collect();
        if prefix {
            parts.insert(0, "c".to_owned());
        } else if parts.is_empty() {
            parts.push("0".to_owned());
        }
        parts.join(&separator.to_string())
    }

    /// The file of a piece.
    fn path(&self, at: &[u64]) -> PathBuf {
        self.folder.join(self.key_of(at))
    }

    /// Refuses arrays whose rows and columns lie in too many files, or in so many or so large chunks that unpacking them would take
    /// far more work than there are values.
    pub(crate) fn check_pieces(&self) -> Result<()> {
        let sizes = || self.shape.iter().zip(&self.piece).rev().take(2);
        let pieces: u128 = sizes().map(|(s, p)| u128::from(s.div_ceil(*p))).product();
        if pieces > MAX_PIECES {
            let problem =
                format!("chunks of {:?} make {pieces} files of it, at most {MAX_PIECES} are read", self.piece);
            return Err(Error::format(&self.folder, problem, "write it again with larger chunks or in shards"));
        }
        let size = self.sample.bytes() as u128;
        let wanted: u128 = sizes().map(|(s, _)| u128::from(*s)).product();
        let work = pieces * self.piece.iter().map(|&n| u128::from(n)).product::<u128>() * size;
        let chunks = pieces * self.codecs.chunks(&self.piece);
        if work > FREE_WORK_BYTES.max(MAX_WORK * wanted * size) || chunks > FREE_CHUNKS.max(wanted) {
            let problem = format!("{} MiB in {chunks} chunks would be unpacked for {wanted} values", work >> 20);
            let remedy = "write it again in chunks of rows and columns, of one time each";
            return Err(Error::format(&self.folder, problem, remedy));
        }
        Ok(())
    }

    /// Bytes of the file of a piece, 0 if it was never written.
    pub(crate) fn piece_bytes(&self, at: &[u64]) -> u64 {
        fs::metadata(self.path(at)).map_or(0, |m| m.len())
    }

    /// The values of a piece as bytes, or `None` if it was never written and so holds the fill value.
    pub(crate) fn piece(&self, at: &[u64]) -> Result<Option<Vec<u8>>> {
        let path = self.path(at);
        let file = match open(&path) {
            Err(Error::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            other => other?,
        };
        self.decode(&path, file).map(Some)
    }

    /// The values of a piece as bytes, from its file at `path`.
    pub(crate) fn decode(&self, path: &Path, file: impl Read) -> Result<Vec<u8>> {
        let values: u64 = self.piece.iter().product::<u64>() * self.sample.bytes() as u64;
        // What does not compress grows a little; more is no piece of this array.
        let most = values + values / 8 + (1 << 20);
        let mut packed = Vec::new();
        file.take(most + 1).read_to_end(&mut packed).map_err(Error::io(path, "read"))?;
        let broken = |what: String| Error::format(path, what, "copy or export the store again");
        if packed.len() as u64 > most {
            return Err(broken("the chunk is longer than its values can be".to_owned()));
        }
        let fill = self.fill_bytes();
        self.codecs.decode(packed, &self.piece, self.sample, &fill).map_err(broken)
    }

    /// True for values that lie in the file as this program writes them.
    pub(crate) fn holds(&self, sample: Sample) -> bool {
        self.sample == sample && self.codecs.order == ByteOrder::Little
    }

    /// The number at the start of `b`.
    pub(super) fn number(&self, b: &[u8]) -> f64 {
        self.sample.number(b, self.codecs.order)
    }

    fn fill_bytes(&self) -> Vec<u8> {
        let n = self.sample.bytes();
        let mut bytes = match self.sample {
            Sample::Float(4) => (self.fill as f32).to_le_bytes().to_vec(),
            Sample::Float(8) => self.fill.to_le_bytes().to_vec(),
            Sample::Float(_) => f16::from_f64(self.fill).to_le_bytes().to_vec(),
            Sample::Unsigned(n) => (self.fill as u64).to_le_bytes()[..n].to_vec(),
            Sample::Signed(n) => (self.fill as i64).to_le_bytes()[..n].to_vec(),
        };
        if self.codecs.order == ByteOrder::Big {
            bytes[..n].reverse();
        }
        bytes
    }
}

/// Opens a file, and nothing else: a pipe could wait for ever.
fn open(path: &Path) -> Result<fs::File> {
    let metadata = fs::metadata(path).map_err(Error::io(path, "read"))?;
    if !metadata.is_file() {
        return Err(Error::format(path, "this is no ordinary file", "copy or export the store again"));
    }
    fs::File::open(path).map_err(Error::io(path, "read"))
}

/// Why an array is refused.
pub(super) enum Reason {
    Broken(String),
    Core(eyot_core::Error),
}

pub(super) fn broken<T>(what: impl Into<String>) -> Result<T, Reason> {
    Err(Reason::Broken(what.into()))
}

/// The name of an extension: a text, or an object with `name`.
pub(super) fn name(value: &Value) -> Option<&str> {
    value.as_str().or_else(|| value["name"].as_str())
}

pub(super) fn sizes(value: &Value, what: &str) -> Result<Vec<u64>, Reason> {
    let list = value.as_array().and_then(|l| l.iter().map(Value::as_u64).collect());
    list.map_or_else(|| broken(format!("`{what}` is no list of sizes")), Ok)
}

fn key(value: &Value) -> Result<(bool, char), Reason> {
    let (prefix, usual) = match name(value) {
        Some("default") => (true, '/'),
        Some("v2") => (false, '.'),
        _ => return broken("unknown names of chunk files (chunk_key_encoding)"),
    };
    match value["configuration"]["separator"].as_str() {
        None => Ok((prefix, usual)),
        Some("/") => Ok((prefix, '/')),
        Some(".") => Ok((prefix, '.')),
        Some(other) => broken(format!("`{other}` separates names of chunk files")),
    }
}

fn fill(value: &Value, sample: Sample) -> Result<f64, Reason> {
    match value {
        Value::Number(n) => Ok(n.as_f64().unwrap_or(0.0)),
        Value::Bool(b) => Ok(f64::from(*b)),
        Value::String(s) => match s.as_str() {
            "NaN" => Ok(f64::NAN),
            "Infinity" => Ok(f64::INFINITY),
            "-Infinity" => Ok(f64::NEG_INFINITY),
            hex => match (hex.strip_prefix("0x").and_then(|h| u64::from_str_radix(h, 16).ok()), sample) {
                (Some(bits), Sample::Float(n)) => Ok(sample.number(&bits.to_le_bytes()[..n], ByteOrder::Little)),
                _ => broken(format!("the fill value `{hex}`")),
            },
        },
        other => broken(format!("the fill value {other}")),
    }
}

impl From<eyot_core::Error> for Reason {
    fn from(e: eyot_core::Error) -> Self {
        Self::Core(e)
    }
}
