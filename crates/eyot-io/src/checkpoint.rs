//! Checkpoints: a whole world with its recipe, bit by bit, in one file.
//!
//! # Layout
//! All numbers are little-endian.
//! ```text
//! "EYOTCKPT"            8 bytes
//! format version        u32
//! length of the header  u64
//! header                JSON: engine version, grid, clock, seed, ledger, layers, recipe, state
//! CRC-32                u32, of everything before it
//! for each layer, in the header's order:
//!   values              f32, row by row from the north, without padding
//!   outer faces         f32, only for layers on faces: column -1 from the north, then row -1 from the west
//!   CRC-32              u32, of these values
//! ```
//! The header fixes the file's length, which is checked before anything is allocated: a file that was cut short, or has
//! been added to, is refused at once.

use crate::atomic::{put, row_bytes, write_atomically};
use crate::error::{Error, Result};
use crate::raster::check_size;
use eyot_core::{Beyond, Georeference, Grid, Layer, LayerSpec, Ledger, Limits, Stagger, World};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::path::Path;

const MAGIC: &[u8; 8] = b"EYOTCKPT";
/// Raised whenever an older program would misread the file.
const FORMAT_VERSION: u32 = 1;
/// Magic, version and length of the header.
const PREFIX_BYTES: usize = 8 + 4 + 8;
/// Recipe, ledger and layer list are kilobytes; the state of a run may be more.
const MAX_HEADER_BYTES: u64 = 256 << 20;
const AGAIN: &str = "use an older checkpoint, or run the recipe again";

/// A checkpoint from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The world, every value as it was.
    pub world: World,
    /// The recipe that the run was started from.
    pub recipe_toml: String,
    /// What the run itself wants to remember.
    pub state: Value,
    /// Version of the program that wrote the file.
    pub engine_version: String,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Header {
    engine_version: String,
    grid: Grid,
    seed: u64,
    step: u64,
    sea_level_m: f64,
    georeference: Option<Georeference>,
    ledger: Ledger,
    layers: Vec<LayerHeader>,
    recipe_toml: String,
    state: Value,
}

/// A [`LayerSpec`] whose range can be unbounded: JSON has no infinity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct LayerHeader {
    name: String,
    unit: String,
    meaning: String,
    min: Option<f32>,
    max: Option<f32>,
    stagger: Stagger,
    beyond_closed: Beyond,
    beyond_open: Beyond,
}

impl From<&LayerSpec> for LayerHeader {
    fn from(s: &LayerSpec) -> Self {
        let finite = |v: f32| v.is_finite().then_some(v);
        Self {
            name: s.name.to_string(),
            unit: s.unit.to_string(),
            meaning: s.meaning.to_string(),
            min: finite(s.range.0),
            max: finite(s.range.1),
            stagger: s.stagger,
            beyond_closed: s.beyond_closed,
            beyond_open: s.beyond_open,
        }
    }
}

impl From<LayerHeader> for LayerSpec {
    fn from(h: LayerHeader) -> Self {
        Self {
            name: h.name.into(),
            unit: h.unit.into(),
            meaning: h.meaning.into(),
            range: (h.min.unwrap_or(f32::NEG_INFINITY), h.max.unwrap_or(f32::INFINITY)),
            stagger: h.stagger,
            beyond_closed: h.beyond_closed,
            beyond_open: h.beyond_open,
        }
    }
}

/// Writes a checkpoint with [`write_atomically`]: a former one at `path` stays whole until the new one is.
///
/// # Errors
/// If the world's clock, ledger or georeference, or `state`, holds a number that JSON cannot carry (not finite), or if
/// the file cannot be written.
pub fn save(path: &Path, world: &World, recipe_toml: &str, state: &Value) -> Result<()> {
    let header = Header {
        engine_version: env!("CARGO_PKG_VERSION").to_owned(),
        grid: world.grid,
        seed: world.seed,
        step: world.step,
        sea_level_m: world.sea_level_m,
        // NaN is a usual nodata value and JSON's null would bring back `None`; nothing depends on the difference.
        georeference: world
            .georeference
            .clone()
            .map(|g| Georeference { nodata: g.nodata.filter(|v| v.is_finite()), ..g }),
        ledger: world.ledger.clone(),
        layers: world.layers().iter().map(|l| LayerHeader::from(&l.spec)).collect(),
        recipe_toml: recipe_toml.to_owned(),
        state: state.clone(),
    };
    let fault =
        |problem: String| Error::format(path, problem, "the checkpoint was not written, the former one is unharmed");
    let text = serde_json::to_vec(&header).map_err(|e| fault(e.to_string()))?;
    // A checkpoint that cannot be read back is worse than none, so try.
    match serde_json::from_slice::<Header>(&text) {
        Ok(back) if back == header && text.len() as u64 <= MAX_HEADER_BYTES => {}
        _ => {
            return Err(fault(
                "the world or the run's state holds a number that is not finite, or too much text".into(),
            ));
        }
    }
    write_atomically(path, |file| {
        let mut prefix = Vec::with_capacity(PREFIX_BYTES);
        prefix.extend(MAGIC);
        prefix.extend(FORMAT_VERSION.to_le_bytes());
        prefix.extend((text.len() as u64).to_le_bytes());
        let mut crc = crc32fast::Hasher::new();
        crc.update(&prefix);
        crc.update(&text);
        put(file, path, &prefix)?;
        put(file, path, &text)?;
        put(file, path, &crc.finalize().to_le_bytes())?;
        let mut buffer = Vec::new();
        for layer in world.layers() {
            let mut crc = crc32fast::Hasher::new();
            for row in layer.field.rows() {
                let bytes = row_bytes(row, &mut buffer);
                crc.update(bytes);
                put(file, path, bytes)?;
            }
            if layer.spec.stagger != Stagger::Cell {
                let bytes = row_bytes(&layer.field.outer_faces(), &mut buffer);
                crc.update(bytes);
                put(file, path, bytes)?;
            }
            put(file, path, &crc.finalize().to_le_bytes())?;
        }
        Ok(())
    })
}

/// Reads a checkpoint.
///
/// # Errors
/// If the file cannot be read, is no checkpoint, was written in another format version, is truncated or damaged, or
/// exceeds `limits`. Sizes are checked against the file's length and `limits` before anything is allocated.
pub fn load(path: &Path, limits: &Limits) -> Result<Checkpoint> {
    let io = || Error::io(path, "read");
    let metadata = fs::metadata(path).map_err(io())?;
    if !metadata.is_file() {
        return Err(Error::format(path, "this is no ordinary file", "give the name of a checkpoint"));
    }
    let file_bytes = metadata.len();
    let mut input = BufReader::with_capacity(1 << 18, File::open(path).map_err(io())?);
    let (header, header_bytes) = read_header(path, &mut input, file_bytes)?;
    let expected = expected_bytes(path, &header, header_bytes, limits)?;
    if expected != u128::from(file_bytes) {
        let problem = format!("a checkpoint of this world has {expected} bytes, the file {file_bytes}");
        return Err(Error::format(path, problem, format!("it is truncated or damaged: {AGAIN}")));
    }

    let mut world = World::new(header.grid, header.seed);
    world.step = header.step;
    world.sea_level_m = header.sea_level_m;
    world.georeference = header.georeference;
    world.ledger = header.ledger;
    let mut buffer = vec![0; 4 * header.grid.width];
    for layer in header.layers {
        let spec = LayerSpec::from(layer);
        read_values(path, &mut input, &mut buffer, world.ensure(&spec, 0.0))?;
    }
    Ok(Checkpoint {
        world,
        recipe_toml: header.recipe_toml,
        state: header.state,
        engine_version: header.engine_version,
    })
}

/// The header and the bytes that it takes with everything around it.
fn read_header(path: &Path, input: &mut impl Read, file_bytes: u64) -> Result<(Header, u64)> {
    let io = || Error::io(path, "read");
    let mut prefix = [0; PREFIX_BYTES];
    if file_bytes < PREFIX_BYTES as u64 + 4 {
        return Err(damaged(path, &format!("{file_bytes} bytes are too few")));
    }
    input.read_exact(&mut prefix).map_err(io())?;
    if &prefix[..8] != MAGIC {
        return Err(Error::format(path, "this is no Eyot checkpoint", "give the name of a checkpoint"));
    }
    let version = u32::from_le_bytes([prefix[8], prefix[9], prefix[10], prefix[11]]);
    if version != FORMAT_VERSION {
        let problem = format!("the checkpoint has format version {version}, this program reads {FORMAT_VERSION}");
        return Err(Error::format(path, problem, "continue it with the version of Eyot that wrote it"));
    }
    let length = u64::from_le_bytes(std::array::from_fn(|i| prefix[12 + i]));
    let header_bytes = length.saturating_add(PREFIX_BYTES as u64 + 4);
    if length > MAX_HEADER_BYTES || header_bytes > file_bytes {
        return Err(damaged(path, &format!("a header of {length} bytes does not fit in {file_bytes}")));
    }
    // At most as long as the file, and read in steps: no allocation beyond what is there.
    let mut text = Vec::new();
    input.take(length).read_to_end(&mut text).map_err(io())?;
    let mut crc = crc32fast::Hasher::new();
    crc.update(&prefix);
    crc.update(&text);
    check_crc(path, input, crc, "the header")?;
    let header = serde_json::from_slice(&text).map_err(|e| damaged(path, &format!("unreadable header: {e}")))?;
    Ok((header, header_bytes))
}

/// Checks the world that the header describes against the limits and returns the length of its file.
fn expected_bytes(path: &Path, header: &Header, header_bytes: u64, limits: &Limits) -> Result<u128> {
    let grid = header.grid.checked(limits).map_err(Error::core(path))?;
    let field = check_size(path, grid.width, grid.height, limits)?;
    if header.layers.len() > limits.max_layers {
        let problem = format!("it has {} layers, the limit is {}", header.layers.len(), limits.max_layers);
        return Err(Error::format(path, problem, "raise the limit"));
    }
    for (i, l) in header.layers.iter().enumerate() {
        if header.layers[..i].iter().any(|k| k.name == l.name) {
            return Err(damaged(path, &format!("two layers are called `{}`", l.name)));
        }
    }
    let layers = header.layers.len() as u128;
    limits.check_bytes("the world of this checkpoint", layers * field).map_err(Error::core(path))?;
    let values = grid.width as u128 * grid.height as u128 * 4;
    let on_faces = header.layers.iter().filter(|l| l.stagger != Stagger::Cell).count() as u128;
    let outer_faces = (grid.width as u128 + grid.height as u128) * 4;
    Ok(u128::from(header_bytes) + layers * (values + 4) + on_faces * outer_faces)
}

fn read_values(path: &Path, input: &mut impl Read, buffer: &mut [u8], layer: &mut Layer) -> Result<()> {
    let mut crc = crc32fast::Hasher::new();
    let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    for row in layer.field.rows_mut() {
        input.read_exact(buffer).map_err(Error::io(path, "read"))?;
        crc.update(buffer);
        row.iter_mut().zip(buffer.chunks_exact(4)).for_each(|(v, b)| *v = number(b));
    }
    if layer.spec.stagger != Stagger::Cell {
        let mut bytes = vec![0; 4 * (layer.field.width() + layer.field.height())];
        input.read_exact(&mut bytes).map_err(Error::io(path, "read"))?;
        crc.update(&bytes);
        let faces: Vec<f32> = bytes.chunks_exact(4).map(number).collect();
        layer.field.set_outer_faces(&faces).map_err(Error::core(path))?;
    }
    check_crc(path, input, crc, &format!("layer `{}`", layer.spec.name))
}

fn check_crc(path: &Path, input: &mut impl Read, crc: crc32fast::Hasher, what: &str) -> Result<()> {
    let mut stored = [0; 4];
    input.read_exact(&mut stored).map_err(Error::io(path, "read"))?;
    if u32::from_le_bytes(stored) != crc.finalize() {
        return Err(damaged(path, &format!("the checksum of {what} does not fit")));
    }
    Ok(())
}

fn damaged(path: &Path, problem: &str) -> Error {
    Error::format(path, format!("the checkpoint is truncated or damaged: {problem}"), AGAIN)
}
