//! What a world and its run are beside the values of the layers: the head of a checkpoint, and of a frame of a recording.
//!
//! Its bytes are described in [`crate::checkpoint`].

use crate::atomic::{put, row_bytes};
use crate::checkpoint::Checkpoint;
use crate::error::{Error, Result};
use crate::raster::check_size;
use crate::storage::{ReadSeek, Storage};
use eyot_core::check_clock;
use eyot_core::component::{Decoder, Encoder};
use eyot_core::{Centering, Layer, LayerSpec, Ledger, Limits, World};
use eyot_core::{Component, ComponentKinds, Components, Georeference, GhostFill, Grid};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fs::{self, File};
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

const MAGIC: &[u8; 8] = b"EYOTCKPT";
/// Raised whenever an older program would misread the file.
const FORMAT_VERSION: u32 = 3;
/// The last version before components had kinds: they were lists of numbers, called features.
const OF_NUMBERS: u32 = 2;
/// Magic, version and length of the header.
const PREFIX_BYTES: usize = 8 + 4 + 8;
/// Recipe, ledger and layer list are kilobytes; the state of a run may be more.
const MAX_HEADER_BYTES: u64 = 256 << 20;
/// Bytes of a component's name or kind.
const MAX_NAME: usize = 256;
/// Of what is in memory already.
const UNLIMITED: Limits = Limits {
    max_cells: u64::MAX,
    max_bytes: u64::MAX,
    max_vertices: u64::MAX,
    max_layers: usize::MAX,
    max_steps: u64::MAX,
};
const AGAIN: &str = "run the recipe again";

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Head {
    engine_version: String,
    pub(crate) grid: Grid,
    seed: u64,
    pub(crate) step: u64,
    sea_level_m: f64,
    georeference: Option<Georeference>,
    ledger: Ledger,
    pub(crate) layers: Vec<LayerHeader>,
    #[serde(default)]
    components: Vec<ComponentHeader>,
    /// In files of the version [`OF_NUMBERS`]: names of components, and how many numbers they have.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    features: Vec<(String, u64)>,
    pub(crate) recipe_toml: String,
    pub(crate) state: Value,
}

/// What a component is, and how many bytes it takes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct ComponentHeader {
    name: String,
    kind: String,
    version: u32,
    bytes: u64,
}

impl ComponentHeader {
    fn of(path: &Path, name: &str, component: &dyn Component) -> Result<Self> {
        let mut all = Summed::of(io::sink());
        encode(path, component, &mut all)?;
        let kind = component.kind();
        Ok(Self { name: name.to_owned(), kind: kind.name.to_owned(), version: kind.version, bytes: all.bytes })
    }
}

/// A [`LayerSpec`] whose range can be unbounded: JSON has no infinity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct LayerHeader {
    pub(crate) name: String,
    unit: String,
    meaning: String,
    min: Option<f32>,
    max: Option<f32>,
    pub(crate) stagger: Centering,
    beyond_closed: GhostFill,
    beyond_open: GhostFill,
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
            stagger: s.centering,
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
            centering: h.stagger,
            beyond_closed: h.beyond_closed,
            beyond_open: h.beyond_open,
        }
    }
}

impl Head {
    /// The head of a world and its run.
    ///
    /// # Errors
    /// If the world's clock, ledger or georeference, or `state`, holds a number that JSON cannot carry (not finite).
    pub(crate) fn of<'a>(path: &Path, world: &'a World, recipe_toml: &str, state: &Value) -> Result<Sealed<'a>> {
        let head = Self {
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
            components: world
                .components
                .iter()
                .map(|(name, c)| ComponentHeader::of(path, name, c))
                .collect::<Result<_>>()?,
            features: Vec::new(),
            recipe_toml: recipe_toml.to_owned(),
            state: state.clone(),
        };
        let fault = |problem: String| Error::format(path, problem, "it was not written, the former one is unharmed");
        // By the bounds that readers check, but for limits on memory, which are each reader's own.
        check_clock(head.step, head.sea_level_m).map_err(|e| fault(e.to_string()))?;
        head.check(path, &UNLIMITED)?;
        let text = serde_json::to_vec(&head).map_err(|e| fault(e.to_string()))?;
        // A head that cannot be read back is worse than none, so try.
        match serde_json::from_slice::<Self>(&text) {
            Ok(back) if back == head && text.len() as u64 <= MAX_HEADER_BYTES => {
                let bytes = head.components.iter().map(|c| c.bytes).collect();
                Ok(Sealed { text, components: &world.components, bytes })
            }
            _ => Err(fault("the world or the run's state holds a number that is not finite, or too much text".into())),
        }
    }

    /// Checks the world that the head describes against the limits.
    pub(crate) fn check(&self, path: &Path, limits: &Limits) -> Result<()> {
        let grid = self.grid.checked(limits).map_err(Error::beyond(path))?;
        let field = check_size(path, grid.width, grid.height, limits)?;
        if self.layers.len() > limits.max_layers {
            let problem = format!("it has {} layers, the limit is {}", self.layers.len(), limits.max_layers);
            return Err(Error::format(path, problem, "raise the limit"));
        }
        check_clock(self.step, self.sea_level_m).map_err(|e| damaged(path, &e.to_string()))?;
        for (i, l) in self.layers.iter().enumerate() {
            // Names become parts of file names, which must not leave their folder.
            if !LayerSpec::is_name(&l.name) {
                return Err(damaged(path, &format!("a layer is called {:?}", l.name)));
            }
            if self.layers[..i].iter().any(|k| k.name == l.name) {
                return Err(damaged(path, &format!("two layers are called `{}`", l.name)));
            }
        }
        if self.components.len() > limits.max_layers {
            let problem = format!("it has {} components, the limit is {}", self.components.len(), limits.max_layers);
            return Err(Error::format(path, problem, "raise the limit"));
        }
        for (i, c) in self.components.iter().enumerate() {
            if c.name.len().max(c.kind.len()) > MAX_NAME {
                return Err(damaged(path, "a component has a name that is too long"));
            }
            if self.components[..i].iter().any(|other| other.name == c.name) {
                return Err(damaged(path, &format!("two components are called `{}`", c.name)));
            }
        }
        let layers = self.layers.len() as u128 * field;
        limits.check_bytes("the world of this checkpoint", layers + self.component_bytes()).map_err(Error::beyond(path))
    }

    /// Bytes of all components, with a checksum each.
    fn component_bytes(&self) -> u128 {
        self.components.iter().map(|c| u128::from(c.bytes) + 4).sum()
    }

    /// Bytes of the values of all layers, with a checksum each.
    pub(crate) fn value_bytes(&self) -> u128 {
        self.layers.len() as u128 * (4 * self.grid.width as u128 * self.grid.height as u128 + 4)
    }

    /// Bytes of the outer faces of all layers on faces, without checksums.
    pub(crate) fn face_bytes(&self) -> u128 {
        self.on_faces() * 4 * (self.grid.width as u128 + self.grid.height as u128)
    }

    /// Layers on faces.
    pub(crate) fn on_faces(&self) -> u128 {
        self.layers.iter().filter(|l| l.stagger != Centering::Cell).count() as u128
    }

    /// The world, with what `fill` makes of each layer, and what else the head holds.
    pub(crate) fn restore(
        self,
        components: Components,
        mut fill: impl FnMut(&mut Layer) -> Result<()>,
    ) -> Result<Checkpoint> {
        let mut world = World::new(self.grid, self.seed);
        world.components = components;
        world.step = self.step;
        world.sea_level_m = self.sea_level_m;
        world.georeference = self.georeference;
        world.ledger = self.ledger;
        for layer in self.layers {
            fill(world.ensure(&LayerSpec::from(layer), 0.0))?;
        }
        Ok(Checkpoint { world, recipe_toml: self.recipe_toml, state: self.state, engine_version: self.engine_version })
    }
}

/// A head as the text that is written, and the components behind it.
pub(crate) struct Sealed<'a> {
    text: Vec<u8>,
    components: &'a Components,
    /// Of each component.
    bytes: Vec<u64>,
}

impl Sealed<'_> {
    /// Bytes in a file.
    pub(crate) fn len(&self) -> u64 {
        let components: u64 = self.bytes.iter().map(|bytes| bytes + 4).sum();
        (PREFIX_BYTES + self.text.len() + 4) as u64 + components
    }

    pub(crate) fn write(&self, path: &Path, file: &mut impl Write) -> Result<()> {
        let mut prefix = Vec::with_capacity(PREFIX_BYTES);
        prefix.extend(MAGIC);
        prefix.extend(FORMAT_VERSION.to_le_bytes());
        prefix.extend((self.text.len() as u64).to_le_bytes());
        let mut crc = crc32fast::Hasher::new();
        crc.update(&prefix);
        crc.update(&self.text);
        put(file, path, &prefix)?;
        put(file, path, &self.text)?;
        put(file, path, &crc.finalize().to_le_bytes())?;
        for (_, component) in self.components.iter() {
            let mut summed = Summed::of(&mut *file);
            encode(path, component, &mut summed)?;
            let crc = summed.crc;
            put(file, path, &crc.finalize().to_le_bytes())?;
        }
        Ok(())
    }
}

fn encode(path: &Path, component: &dyn Component, out: &mut impl Write) -> Result<()> {
    let mut encoder = Encoder::new(out);
    component.encode(&mut encoder);
    encoder.finish().map_err(Error::io(path, "write"))
}

/// Counts what goes through and keeps its checksum.
struct Summed<T> {
    inner: T,
    crc: crc32fast::Hasher,
    bytes: u64,
}

impl<T> Summed<T> {
    fn of(inner: T) -> Self {
        Self { inner, crc: crc32fast::Hasher::new(), bytes: 0 }
    }

    fn add(&mut self, bytes: &[u8]) {
        self.crc.update(bytes);
        self.bytes += bytes.len() as u64;
    }
}

impl<T: Write> Write for Summed<T> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.inner.write(bytes)?;
        self.add(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<T: Read> Read for Summed<T> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(bytes)?;
        self.add(&bytes[..n]);
        Ok(n)
    }
}

/// A file that begins with a head.
pub(crate) struct HeadFile<R = BufReader<File>> {
    pub(crate) head: Head,
    /// Version of the file's format.
    version: u32,
    /// What comes after the head.
    pub(crate) input: R,
    /// Bytes of the head with everything around it.
    pub(crate) head_bytes: u64,
    /// Bytes of the file.
    pub(crate) file_bytes: u64,
}

impl HeadFile {
    /// Opens a file and reads its head; nothing that the head claims is allocated.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let io = || Error::io(path, "read");
        let metadata = fs::metadata(path).map_err(io())?;
        if !metadata.is_file() {
            return Err(Error::format(path, "this is no ordinary file", "give the name of a checkpoint"));
        }
        Self::of(path, BufReader::with_capacity(1 << 18, File::open(path).map_err(io())?), metadata.len())
    }
}

impl HeadFile<Box<dyn ReadSeek>> {
    /// As [`HeadFile::open`], of a blob.
    pub(crate) fn open_in(storage: &dyn Storage, name: &str) -> Result<Self> {
        let place = storage.place(name);
        let blob = storage.open(name).map_err(Error::io(&place, "read"))?;
        Self::of(&place, blob.input, blob.bytes)
    }
}

impl<R: Read> HeadFile<R> {
    /// Reads the head at the start of `file_bytes` bytes; `path` is for messages.
    pub(crate) fn of(path: &Path, mut input: R, file_bytes: u64) -> Result<Self> {
        let (head, version, head_bytes) = read_head(path, &mut input, file_bytes)?;
        Ok(Self { head, version, input, head_bytes, file_bytes })
    }

    /// Refuses a file that is not as long as the head, the components and `rest` bytes.
    pub(crate) fn check_length(&self, path: &Path, rest: u128) -> Result<()> {
        let expected = u128::from(self.head_bytes) + self.head.component_bytes() + rest;
        if expected == u128::from(self.file_bytes) {
            return Ok(());
        }
        let problem = format!("a checkpoint of this world has {expected} bytes, the file {}", self.file_bytes);
        Err(Error::format(path, problem, format!("it is truncated or damaged: {AGAIN}")))
    }

    /// Reads the components; their size and that of the file have been checked.
    pub(crate) fn components(&mut self, path: &Path, limits: &Limits, kinds: &ComponentKinds) -> Result<Components> {
        let mut components = Components::default();
        for header in &self.head.components {
            let ComponentHeader { name, kind, version, bytes } = header;
            let kind = if self.version == OF_NUMBERS { kinds.of_former(name).name } else { kind };
            let mut summed = Summed::of((&mut self.input).take(*bytes));
            let mut decoder = Decoder::new(name, &mut summed, *bytes, &self.head.grid, limits);
            let decoded = kinds.decode(kind, *version, &mut decoder);
            // Damage explains itself, whatever the decoder made of it.
            io::copy(&mut summed, &mut io::sink()).map_err(Error::io(path, "read"))?;
            let crc = summed.crc;
            check_crc(path, &mut self.input, crc, &format!("component `{name}`"))?;
            components.insert_shared(name, decoded.map_err(Error::core(path))?);
        }
        Ok(components)
    }
}

/// The head, the version of the format, and the bytes that the head takes with everything around it.
fn read_head(path: &Path, input: &mut impl Read, file_bytes: u64) -> Result<(Head, u32, u64)> {
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
    if !(OF_NUMBERS..=FORMAT_VERSION).contains(&version) {
        let known = format!("this program reads {OF_NUMBERS} to {FORMAT_VERSION}");
        let problem = format!("the checkpoint has format version {version}, {known}");
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
    let mut head: Head =
        serde_json::from_slice(&text).map_err(|e| damaged(path, &format!("unreadable header: {e}")))?;
    let of_its_version = match version {
        OF_NUMBERS => head.components.is_empty(),
        _ => head.features.is_empty(),
    };
    if !of_its_version {
        return Err(damaged(path, "its components are those of another version"));
    }
    for (name, numbers) in std::mem::take(&mut head.features) {
        // More than any file has.
        let bytes = numbers.saturating_mul(8);
        head.components.push(ComponentHeader { name, kind: String::new(), version: 1, bytes });
    }
    Ok((head, version, header_bytes))
}

/// Writes the values of a layer's outer faces, if it lies on faces.
pub(crate) fn write_faces(
    path: &Path,
    file: &mut impl Write,
    layer: &Layer,
    crc: &mut crc32fast::Hasher,
    buffer: &mut Vec<u8>,
) -> Result<()> {
    if layer.spec.centering == Centering::Cell {
        return Ok(());
    }
    let bytes = row_bytes(&layer.field.outer_faces(), buffer);
    crc.update(bytes);
    put(file, path, bytes)
}

/// Reads what [`write_faces`] wrote.
pub(crate) fn read_faces(
    path: &Path,
    input: &mut impl Read,
    layer: &mut Layer,
    crc: &mut crc32fast::Hasher,
) -> Result<()> {
    if layer.spec.centering == Centering::Cell {
        return Ok(());
    }
    let mut bytes = vec![0; 4 * (layer.field.width() + layer.field.height())];
    input.read_exact(&mut bytes).map_err(Error::io(path, "read"))?;
    crc.update(&bytes);
    let faces: Vec<f32> = bytes.chunks_exact(4).map(number).collect();
    layer.field.set_outer_faces(&faces).map_err(Error::core(path))
}

/// The number of four bytes.
pub(crate) fn number(b: &[u8]) -> f32 {
    f32::from_le_bytes([b[0], b[1], b[2], b[3]])
}

pub(crate) fn check_crc(path: &Path, input: &mut impl Read, crc: crc32fast::Hasher, what: &str) -> Result<()> {
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
