//! Recordings of runs: every so many steps a frame, which is a whole world and all that a run needs to go on from it.
//!
//! # Layout
//! A recording is a Zarr v3 store that opens as one data set: each layer an array (time, y, x), whose shards hold one frame
//! each, with the coordinates `time` (steps of simulation done, with the factor that makes times of them if one is known),
//! `y` and `x`. Layers on faces have one more row or column,
//! along `y_face` or `x_face`. A layer that comes late is NaN before. What else a frame needs lies where readers of Zarr do
//! not look: `.frames/N.eyot` is the head of a checkpoint ([`crate::checkpoint`]) without the values of its layers; of
//! layers on faces, outer faces and their CRC-32 follow.
//!
//! # What a kill can do
//! The root's `zarr.json` says how many frames there are, and readers here believe nothing else. It is replaced as the last
//! step of everything, whole or not at all; what lies beyond it is removed when the recording is next opened to write.
//!
//! A frame that is missing or damaged keeps its number, and the others can be read; only what belongs to all of them, the root and
//! `time`, must be whole.
//! A power failure is another thing: what decides is flushed to the disk as often as that takes no more than a tenth of the
//! time, frames are not. Checksums find what is lost; the checkpoint of the run is not here.
//!
//! # Bounds
//! Before a frame is written that could lead beyond the bound, old frames are dropped, the older the more, but for the first
//! one, and the others move up (`thin.rs`).

mod files;
mod load;
mod thin;

pub use load::{is_recording, is_recording_in};
pub use thin::{is_cut_off, is_cut_off_in};

use crate::about::About;
use crate::error::{Error, Result};
use crate::head::{Head, Sealed, write_faces};
use crate::rows::Rows;
use crate::storage::{Folder, Keep, Storage, within};
use crate::zarr::metadata::{self, Axis, X_FACE, Y_FACE};
use crate::zarr::{CHUNK, METADATA, SECONDS, SHARD, TIME, check_name, write_coordinates, write_layer};
use eyot_core::{Centering, Layer, Limits, World};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Attributes of the root that say how the recording is made.
const EVERY: &str = "record_every_steps";
const MAX_BYTES: &str = "record_max_bytes";
/// Folder of what is not for readers of Zarr.
const HEADS: &str = ".frames";
/// Steps of time in one piece of that coordinate.
const TIMES: usize = 1024;
/// More than the metadata of an array take, here and once more in the root.
const ARRAY_BYTES: u64 = 12 << 10;

/// How a run is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// Steps of simulation from one frame to the next; at least 1.
    pub every: u64,
    /// Bytes that the recording may take; old frames thin out.
    pub max_bytes: u64,
}

impl Record {
    /// The smallest bound for worlds of so many layers that take `world_bytes` bytes: two frames, even if they do not
    /// compress. `text_bytes` are those of the recipe.
    pub fn least_bytes(world_bytes: u128, layers: usize, text_bytes: usize) -> u128 {
        // It stands in the attributes, too. The journal is kilobytes.
        let texts = 8 * text_bytes as u128;
        2 * (world_bytes + world_bytes / 16) + texts + (layers + 64) as u128 * u128::from(ARRAY_BYTES)
    }
}

/// One moment of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Steps of simulation done, which the frame's time is.
    pub step: u64,
    /// Bytes of its files.
    pub bytes: u64,
    /// False if its head is gone, without which it cannot be read.
    pub is_there: bool,
}

/// A recording.
#[derive(Debug)]
pub struct Timeline {
    storage: Arc<dyn Storage>,
    /// Where it lies in the storage.
    group: String,
    record: Record,
    limits: Limits,
    attributes: Map<String, Value>,
    /// The metadata of all arrays by name.
    arrays: Map<String, Value>,
    frames: Vec<Frame>,
}

impl Timeline {
    /// Begins a recording at the folder `path`; a former one is removed. `attributes` go to the root, for readers.
    ///
    /// # Errors
    /// If `record` asks for no steps, if something else than a recording is there, or if it cannot be written.
    pub fn create(path: &Path, record: Record, attributes: &Map<String, Value>, limits: &Limits) -> Result<Self> {
        let (storage, group) = Folder::around(path);
        Self::create_in(Arc::new(storage), &group, record, attributes, limits)
    }

    /// As [`Timeline::create`], in the group of a storage.
    ///
    /// # Errors
    /// As [`Timeline::create`].
    pub fn create_in(
        storage: Arc<dyn Storage>,
        group: &str,
        record: Record,
        attributes: &Map<String, Value>,
        limits: &Limits,
    ) -> Result<Self> {
        checked(&storage.place(group), record)?;
        remove_in(&*storage, group)?;
        // It tells what the group is.
        storage.make_group(&within(group, HEADS))?;
        let (limits, attributes, group) = (*limits, attributes.clone(), group.to_owned());
        let (arrays, frames) = (Map::new(), Vec::new());
        let mut new = Self { storage, group, record, limits, attributes, arrays, frames };
        new.set_record(record)?;
        Ok(new)
    }

    /// A name in the storage.
    fn name(&self, name: &str) -> String {
        within(&self.group, name)
    }

    /// What people call something of the recording.
    fn place(&self, name: &str) -> PathBuf {
        self.storage.place(&self.name(name))
    }

    /// How the recording is made.
    pub fn record(&self) -> Record {
        self.record
    }

    /// Changes how the recording goes on.
    ///
    /// # Errors
    /// If `record` asks for no steps, or if the root cannot be written.
    pub fn set_record(&mut self, record: Record) -> Result<()> {
        self.record = checked(&self.place(""), record)?;
        self.attributes.insert(EVERY.to_owned(), json!(record.every));
        self.attributes.insert(MAX_BYTES.to_owned(), json!(record.max_bytes));
        let steps: Vec<u64> = self.frames.iter().map(|f| f.step).collect();
        self.commit(self.arrays.clone(), &steps)
    }

    /// Says that steps have no length in time any more.
    ///
    /// # Errors
    /// If the root cannot be written.
    pub fn lose_clock(&mut self) -> Result<()> {
        if self.attributes.remove(SECONDS).is_none() {
            return Ok(());
        }
        let steps: Vec<u64> = self.frames.iter().map(|f| f.step).collect();
        self.commit(self.arrays.clone(), &steps)
    }

    /// All frames, oldest first.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Adds a frame: a world and what its run needs to go on, as [`crate::checkpoint::save`] takes them.
    ///
    /// # Errors
    /// If the world is no later than the last frame, a layer has a name that no array can have or a value that is not finite,
    /// the bound does not hold two frames, or the files cannot be written. The frames so far are unharmed.
    pub fn append(&mut self, world: &World, recipe_toml: &str, state: &Value) -> Result<()> {
        if let Some(last) = self.frames.last().filter(|f| f.step >= world.step) {
            let problem = format!("a frame of step {} after one of step {}", world.step, last.step);
            return Err(Error::format(&self.place(""), problem, "drop the later frames first"));
        }
        let head = Head::of(&self.place(""), world, recipe_toml, state)?;
        self.finish_thinning()?;
        let most = most_bytes(world, &head);
        self.make_room(most, self.fixed_bytes(world))?;
        let n = self.frames.len();
        let steps: Vec<u64> = self.frames.iter().map(|f| f.step).chain([world.step]).collect();
        let written = self.write_frame(n, world, &head).and_then(|arrays| {
            self.write_times(&steps, n)?;
            self.commit(arrays, &steps)
        });
        match written {
            Ok(()) => {
                self.frames.push(Frame { step: world.step, bytes: self.frame_bytes(n), is_there: true });
                Ok(())
            }
            Err(e) => {
                // Room on a full disk; what stays is removed when the recording is next opened.
                let _ = self.remove_from(n);
                Err(e)
            }
        }
    }

    /// Drops the frames of `step` and all later ones.
    ///
    /// # Errors
    /// If the files cannot be written or removed.
    pub fn truncate(&mut self, step: u64) -> Result<()> {
        self.finish_thinning()?;
        let n = self.frames.partition_point(|f| f.step < step);
        if n == self.frames.len() {
            return Ok(());
        }
        self.frames.truncate(n);
        let steps: Vec<u64> = self.frames.iter().map(|f| f.step).collect();
        self.commit(self.arrays.clone(), &steps)?;
        self.remove_from(n)
    }

    /// A recording of the first `n` frames in another place; what is missing or damaged is so there, too.
    ///
    /// # Errors
    /// If something else than a recording is there, or files cannot be read or written.
    pub fn copy(&self, n: usize, path: &Path) -> Result<Self> {
        let (storage, group) = Folder::around(path);
        self.copy_in(n, Arc::new(storage), &group)
    }

    /// As [`Timeline::copy`], into the group of a storage.
    ///
    /// # Errors
    /// As [`Timeline::copy`].
    pub fn copy_in(&self, n: usize, storage: Arc<dyn Storage>, group: &str) -> Result<Self> {
        let mut new = Self::create_in(storage, group, self.record, &self.attributes, &self.limits)?;
        let n = n.min(self.frames.len());
        for name in self.arrays.keys() {
            self.copy_array(name, n, &new)?;
        }
        for i in (0..n).filter(|&i| self.frames[i].is_there) {
            self.copy_blob(&head_of(i), &new)?;
        }
        new.frames = self.frames[..n].to_vec();
        let steps: Vec<u64> = new.frames.iter().map(|f| f.step).collect();
        new.write_times(&steps, 0)?;
        new.commit(self.arrays.clone(), &steps)?;
        Ok(new)
    }

    fn head_name(&self, i: usize) -> String {
        self.name(&head_of(i))
    }

    /// Everything of a frame but the metadata, which are returned.
    fn write_frame(&self, n: usize, world: &World, head: &Sealed<'_>) -> Result<Map<String, Value>> {
        self.remove_from(n)?;
        let size = (world.grid.width, world.grid.height);
        let mut arrays = self.arrays.clone();
        for layer in world.layers() {
            let name = &*layer.spec.name;
            check_name(&self.place(""), name)?;
            let (about, axes) = (About::of(world, layer), axes(layer.spec.centering, size));
            let is = metadata::layer(&about, n, axes, false);
            // Their length is all that changes from frame to frame.
            let former = arrays.insert(name.to_owned(), is);
            if former.as_ref().is_some_and(|f| f["dimension_names"] != arrays[name]["dimension_names"]) {
                let problem = format!("layer `{name}` lay elsewhere on the cells in former frames");
                return Err(Error::format(&self.place(""), problem, "record into another folder"));
            }
            if former.is_some_and(|f| f["codecs"] != arrays[name]["codecs"]) {
                let problem = "a program that packs arrays in another way began this recording";
                return Err(Error::format(
                    &self.place(""),
                    problem,
                    "go on with that program, or record into another folder",
                ));
            }
            let folder = self.place(name);
            let put = |piece: &str, bytes: &[u8]| self.swap(&within(name, piece), Keep::Loose, bytes);
            match layer.spec.centering {
                Centering::Cell => write_layer(&folder, n, &mut &layer.field, &put)?,
                _ => write_layer(&folder, n, &mut OnFaces::of(layer), &put)?,
            }
            let put = |piece: &str, bytes: &[u8]| self.swap(piece, Keep::Loose, bytes);
            write_coordinates(&self.place(""), &about, size.1, axes, &mut arrays, &put)?;
        }
        let path = self.place(&head_of(n));
        self.storage.write(&self.head_name(n), Keep::Loose, &mut |mut file| {
            head.write(&path, &mut file)?;
            let mut buffer = Vec::new();
            for layer in world.layers().iter().filter(|l| l.spec.centering != Centering::Cell) {
                let mut crc = crc32fast::Hasher::new();
                write_faces(&path, &mut file, layer, &mut crc, &mut buffer)?;
                file.write_all(&crc.finalize().to_le_bytes()).map_err(Error::io(&path, "write"))?;
            }
            Ok(())
        })?;
        Ok(arrays)
    }

    /// Writes the coordinate `time` from the step with the index `from` on.
    fn write_times(&self, steps: &[u64], from: usize) -> Result<()> {
        for (i, times) in steps.chunks(TIMES).enumerate().skip(from / TIMES) {
            let mut bytes: Vec<u8> = times.iter().flat_map(|t| t.to_le_bytes()).collect();
            bytes.resize(8 * TIMES, 0);
            self.swap(&format!("{TIME}/c/{i}"), Keep::Whole, &bytes)?;
        }
        Ok(())
    }

    /// Makes frames visible: as many as there are steps.
    fn commit(&mut self, mut arrays: Map<String, Value>, steps: &[u64]) -> Result<()> {
        arrays.insert(TIME.to_owned(), metadata::time(steps.len(), TIMES, &self.attributes));
        for (name, is) in &mut arrays {
            if is["shape"].as_array().is_some_and(|s| s.len() == 3) {
                is["shape"][0] = json!(steps.len());
            }
            self.swap(&within(name, METADATA), Keep::Whole, format!("{is:#}\n").as_bytes())?;
        }
        let text = format!("{:#}\n", metadata::group(&self.attributes, &arrays));
        self.swap(METADATA, Keep::Thrifty, text.as_bytes())?;
        self.arrays = arrays;
        Ok(())
    }

    /// Bytes that everything but frames takes at most, once a world like this is in the recording.
    fn fixed_bytes(&self, world: &World) -> u64 {
        let arrays = self.arrays.len() + world.layers().len() + 8;
        let coordinates = 2 * 8 * (world.grid.width + world.grid.height + 2);
        let times = 8 * TIMES * (self.frames.len() / TIMES + 2);
        // The root is there twice while it is replaced.
        let attributes = 2 * self.attributes.values().map(|v| v.to_string().len() + 100).sum::<usize>();
        arrays as u64 * ARRAY_BYTES + (coordinates + times + attributes) as u64
    }
}

/// The head of frame `i`.
fn head_of(i: usize) -> String {
    format!("{HEADS}/{i}.eyot")
}

fn checked(path: &Path, record: Record) -> Result<Record> {
    if record.every == 0 {
        return Err(Error::format(path, "a frame every 0 steps", "record every 1 or more steps"));
    }
    Ok(record)
}

/// Bytes that a frame takes at most.
fn most_bytes(world: &World, head: &Sealed<'_>) -> u64 {
    let (width, height) = (world.grid.width + 1, world.grid.height + 1);
    let count = |side: usize| (width.div_ceil(side) * height.div_ceil(side)) as u64;
    let values = 4 * (width * height) as u64;
    // What does not compress grows by what Zstandard says of its blocks; and a chunk that is nearly full is stored in full.
    let layer = values + values / 32 + 64 * count(CHUNK) + 512 * count(SHARD);
    let faces = 4 * (width + height) as u64 + 4;
    world.layers().len() as u64 * (layer + faces) + head.len()
}

/// Rows and columns of the array of a layer.
fn axes(centering: Centering, (width, height): (usize, usize)) -> [Axis; 2] {
    let [rows, columns] = Axis::of_cells((width, height));
    match centering {
        Centering::Cell => [rows, columns],
        Centering::FaceX => [rows, Axis { name: X_FACE, n: width + 1 }],
        Centering::FaceY => [Axis { name: Y_FACE, n: height + 1 }, columns],
    }
}

/// A layer on faces with those before its first row or column.
struct OnFaces<'a> {
    layer: &'a Layer,
    outer: Vec<f32>,
}

impl<'a> OnFaces<'a> {
    fn of(layer: &'a Layer) -> Self {
        Self { layer, outer: layer.field.outer_faces() }
    }
}

impl Rows for OnFaces<'_> {
    fn size(&self) -> (usize, usize) {
        let [rows, columns] = axes(self.layer.spec.centering, (self.layer.field.width(), self.layer.field.height()));
        (columns.n, rows.n)
    }

    fn read(&mut self, first: usize, out: &mut [f32]) -> eyot_core::Result<()> {
        let (field, columns) = (&self.layer.field, self.size().0);
        for (y, row) in (first..).zip(out.chunks_exact_mut(columns)) {
            match self.layer.spec.centering {
                Centering::FaceX => {
                    row[0] = self.outer[y];
                    row[1..].copy_from_slice(field.row(y));
                }
                _ if y == 0 => row.copy_from_slice(&self.outer[field.height()..]),
                _ => row.copy_from_slice(field.row(y - 1)),
            }
        }
        Ok(())
    }
}

/// Removes a recording, if there is one.
///
/// # Errors
/// If something else is there, or if it cannot be removed.
pub fn remove(path: &Path) -> Result<()> {
    let Ok(there) = std::fs::symlink_metadata(path) else { return Ok(()) };
    if !there.is_dir() {
        return Err(no_recording(path));
    }
    let (storage, group) = Folder::around(path);
    remove_in(&storage, &group)
}

/// As [`remove`], in the group of a storage.
///
/// # Errors
/// As [`remove`].
pub fn remove_in(storage: &dyn Storage, group: &str) -> Result<()> {
    if storage.list(group).is_empty() && storage.bytes(group).is_none() && !storage.is_group(group) {
        return Ok(());
    }
    if !storage.is_group(&within(group, HEADS)) && !is_recording_in(storage, group) {
        return Err(no_recording(&storage.place(group)));
    }
    files::remove_all(storage, group)
}

fn no_recording(path: &Path) -> Error {
    Error::format(path, "something else than a recording is there", "remove it, or choose another folder")
}
