//! Frames, in.

use super::thin::MAX_FRAMES;
use super::{EVERY, Frame, HEADS, MAX_BYTES, Record, TIMES, Timeline, axes};
use crate::checkpoint::Checkpoint;
use crate::error::{Error, Result};
use crate::head::{HeadFile, check_crc, number, read_faces};
use crate::raster::check_size;
use crate::sample::Sample;
use crate::storage::{Blob, Folder, ReadSeek, Storage, within};
use crate::zarr::metadata::{Axis, FACES, X, X_FACE, Y, Y_FACE};
use crate::zarr::{Array, METADATA, SHARD, TIME, check_name, node_from};
use eyot_core::MAX_STEP;
use eyot_core::remedy::Action;
use eyot_core::{Centering, ComponentKinds, Layer, Limits};
use rayon::prelude::*;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes of a folder's name on every system.
const MAX_NAME: usize = 200;
/// Coordinates and place.
const OTHER_ARRAYS: usize = 6;
const REMEDY: &str = "use an older frame, or record the run again";

/// True if the folder is a recording.
pub fn is_recording(path: &Path) -> bool {
    let (storage, group) = Folder::around(path);
    is_recording_in(&storage, &group)
}

/// True if the group of a storage is a recording.
pub fn is_recording_in(storage: &dyn Storage, group: &str) -> bool {
    root(storage, group).is_ok_and(|root| record(&root).is_some())
}

/// The metadata of the root.
fn root(storage: &dyn Storage, group: &str) -> Result<Value> {
    let name = within(group, METADATA);
    let place = storage.place(&name);
    let Blob { input, .. } = storage.open(&name).map_err(Error::io(&place, "read"))?;
    node_from(&place, input)
}

impl Timeline {
    /// Opens a recording to read it. If a run is at work on it, frames can vanish while they are read. Frames that are missing or
    /// damaged harm no others; whoever reads one hears of it.
    ///
    /// # Errors
    /// If it cannot be read, is no recording, or what belongs to all frames is damaged. Sizes meet `limits` before anything is
    /// allocated.
    pub fn open(path: &Path, limits: &Limits) -> Result<Self> {
        let (storage, group) = Folder::around(path);
        Self::open_in(Arc::new(storage), &group, limits)
    }

    /// As [`Timeline::open`], in the group of a storage.
    ///
    /// # Errors
    /// As [`Timeline::open`].
    pub fn open_in(storage: Arc<dyn Storage>, group: &str, limits: &Limits) -> Result<Self> {
        let mut timeline = Self::open_root(storage, group, limits)?;
        let steps = timeline.times()?;
        timeline.check_arrays(steps.len() as u64)?;
        let sizes = timeline.measure(steps.len());
        let frame =
            |(&step, size): (&u64, Option<u64>)| Frame { step, bytes: size.unwrap_or(0), is_there: size.is_some() };
        timeline.frames = steps.iter().zip(sizes).map(frame).collect();
        Ok(timeline)
    }

    /// Opens a recording to go on with it: does what a killed run had begun, and removes what it left.
    ///
    /// # Errors
    /// As [`Timeline::open`], and if files cannot be written.
    pub fn open_to_write(path: &Path, limits: &Limits) -> Result<Self> {
        let (storage, group) = Folder::around(path);
        Self::open_to_write_in(Arc::new(storage), &group, limits)
    }

    /// As [`Timeline::open_to_write`], in the group of a storage.
    ///
    /// # Errors
    /// As [`Timeline::open_to_write`].
    pub fn open_to_write_in(storage: Arc<dyn Storage>, group: &str, limits: &Limits) -> Result<Self> {
        storage.tidy(group);
        storage.tidy(&within(group, HEADS));
        Self::open_root(storage.clone(), group, limits)?.finish_thinning()?;
        let mut timeline = Self::open_in(storage, group, limits)?;
        timeline.remove_from(timeline.frames.len())?;
        let steps: Vec<u64> = timeline.frames.iter().map(|f| f.step).collect();
        timeline.commit(timeline.arrays.clone(), &steps)?;
        Ok(timeline)
    }

    /// What the root says; the frames are still to be found.
    fn open_root(storage: Arc<dyn Storage>, group: &str, limits: &Limits) -> Result<Self> {
        let root = root(&*storage, group)?;
        let path = &storage.place(group);
        let Some(record) = record(&root) else {
            return Err(Error::format(
                path,
                "this is no recording of a run",
                eyot_core::remedy!["record one with ", Action::Record],
            ));
        };
        let arrays = root["consolidated_metadata"]["metadata"].as_object().cloned().unwrap_or_default();
        let attributes = root["attributes"].as_object().cloned().unwrap_or_default();
        if arrays.len() > limits.max_layers + OTHER_ARRAYS {
            return Err(damaged(path, &format!("{} arrays", arrays.len())));
        }
        for name in arrays.keys() {
            // They name folders.
            let plain = name.chars().all(|c| c.is_ascii_alphanumeric() || "_-.".contains(c));
            if !plain || name.is_empty() || name.starts_with('.') || name.len() > MAX_NAME {
                return Err(damaged(path, &format!("an array called `{name}`")));
            }
        }
        let (group, limits, frames) = (group.to_owned(), *limits, Vec::new());
        Ok(Self { storage, group, record, limits, attributes, arrays, frames })
    }

    /// What the run itself wanted to remember in frame `i`.
    ///
    /// # Errors
    /// If there is no such frame, or its head is missing or damaged.
    pub fn state(&self, i: usize) -> Result<Value> {
        Ok(self.open_head(i)?.1.head.state)
    }

    /// The recipe of the run in frame `i`.
    ///
    /// # Errors
    /// As [`Timeline::state`].
    pub fn recipe_toml(&self, i: usize) -> Result<String> {
        Ok(self.open_head(i)?.1.head.recipe_toml)
    }

    /// As [`Timeline::state`], of a frame whose files are all there. What they hold shows when it is loaded.
    ///
    /// # Errors
    /// As [`Timeline::state`], and if files are missing.
    pub fn look(&self, i: usize) -> Result<Value> {
        let head = self.open_head(i)?.1.head;
        for layer in &head.layers {
            let (array, axes) = self.array_of(&layer.name, layer.stagger, (head.grid.width, head.grid.height))?;
            let [rows, columns] = axes.map(|a| a.n.div_ceil(SHARD) as u64);
            for at in (0..rows).flat_map(|top| (0..columns).map(move |left| [i as u64, top, left])) {
                if self.storage.bytes(&self.piece_name(&layer.name, &array, &at)).unwrap_or(0) == 0 {
                    return Err(missing_piece(&array, i));
                }
            }
        }
        Ok(head.state)
    }

    /// Frame `i` as the checkpoint that it is, with components of these kinds.
    ///
    /// # Errors
    /// If there is no such frame, it is damaged, holds a component of another kind, or exceeds the limits. Sizes are checked before anything is allocated.
    pub fn load(&self, i: usize, kinds: &ComponentKinds) -> Result<Checkpoint> {
        let (path, mut file) = self.open_head(i)?;
        file.check_length(&path, file.head.face_bytes() + 4 * file.head.on_faces())?;
        let components = file.components(&path, &self.limits, kinds)?;
        let HeadFile { head, mut input, .. } = file;
        head.restore(components, |layer| {
            self.read_layer(i, layer)?;
            if layer.spec.centering == Centering::Cell {
                return Ok(());
            }
            let mut crc = crc32fast::Hasher::new();
            read_faces(&path, &mut input, layer, &mut crc)?;
            check_crc(&path, &mut input, crc, "outer faces")
        })
    }

    fn open_head(&self, i: usize) -> Result<(PathBuf, HeadFile<Box<dyn ReadSeek>>)> {
        let Some(frame) = self.frames.get(i) else {
            let problem = format!("there is no frame {i}, the recording has {}", self.frames.len());
            return Err(Error::format(&self.place(""), problem, "count from 0"));
        };
        let path = self.place(&super::head_of(i));
        if self.storage.bytes(&self.head_name(i)).is_none() {
            return Err(damaged(&path, &format!("frame {i} is missing")));
        }
        let file = HeadFile::open_in(&*self.storage, &self.head_name(i))?;
        file.head.check(&path, &self.limits)?;
        if file.head.step != frame.step {
            let problem = format!("frame {i} is of step {}, its time is {}", file.head.step, frame.step);
            return Err(damaged(&path, &problem));
        }
        Ok((path, file))
    }

    /// The coordinate `time`.
    fn times(&self) -> Result<Vec<u64>> {
        let folder = self.place(TIME);
        let array = Array::described(&folder, self.arrays.get(TIME).unwrap_or(&Value::Null), &self.limits)?;
        let (&[n], &[piece]) = (array.shape.as_slice(), array.piece.as_slice()) else {
            return Err(damaged(&folder, "its shape is no list"));
        };
        if n > MAX_FRAMES as u64 {
            return Err(damaged(&folder, &format!("{n} frames, at most {MAX_FRAMES} can be")));
        }
        if piece != TIMES as u64 || !array.holds(Sample::Signed(8)) {
            let problem = format!("times are 64-bit numbers in pieces of {TIMES}, not {piece}");
            return Err(damaged(&folder, &problem));
        }
        let mut steps = Vec::new();
        for i in 0..n.div_ceil(piece) {
            let bytes = self.piece(TIME, &array, &[i])?.ok_or_else(|| damaged(&folder, "a part of it is missing"))?;
            let times = bytes.chunks_exact(8).map(|b| i64::from_le_bytes(std::array::from_fn(|j| b[j])));
            steps.extend(times.take((n - i * piece) as usize));
        }
        if let Some(i) = steps.iter().position(|&t| !(0..=MAX_STEP as i64).contains(&t)) {
            return Err(damaged(&folder, &format!("frame {i} is of step {}, which no run comes to", steps[i])));
        }
        if let Some(i) = steps.windows(2).position(|w| w[0] >= w[1]) {
            let problem = format!(
                "steps that do not increase: frame {i} is of step {}, frame {} of step {}",
                steps[i],
                i + 1,
                steps[i + 1]
            );
            return Err(damaged(&folder, &problem));
        }
        Ok(steps.into_iter().map(|t| t as u64).collect())
    }

    /// Checks the arrays of all layers and their coordinates: over `n` frames, of one size, in pieces of ours. What is read later
    /// is then no larger than what the limits allow.
    fn check_arrays(&self, n: u64) -> Result<()> {
        let mut sizes: BTreeMap<String, (u64, &str)> = BTreeMap::new();
        for (name, described) in &self.arrays {
            let folder = self.place(name);
            if name == TIME || described["shape"].as_array().is_some_and(Vec::is_empty) {
                continue;
            }
            let array = Array::described(&folder, described, &self.limits)?;
            let named = |last: &[u64]| {
                array.dimensions.iter().rev().zip(last.iter().rev()).map(|(d, n)| (d.clone(), *n)).collect()
            };
            let along: Vec<(String, u64)> = match (array.shape.as_slice(), array.dimensions.as_slice()) {
                ([len], [axis]) if axis == name => named(&[*len]),
                ([frames, h, w], [time, y, x])
                    if time == TIME && [Y, Y_FACE].contains(&&**y) && [X, X_FACE].contains(&&**x) =>
                {
                    // Other pieces can be made such that each of them is small and all together are not.
                    if *frames != n || array.piece != [1, SHARD as u64, SHARD as u64] || !array.holds(Sample::F32) {
                        let found = format!("an array of {:?} values in pieces of {:?}", array.shape, array.piece);
                        return Err(damaged(&folder, &format!("{found}, a layer over {n} frames has no such")));
                    }
                    array.check_pieces()?;
                    named(&[*h, *w])
                }
                _ => {
                    let problem = format!("an array of the shape {:?} along {:?}", array.shape, array.dimensions);
                    return Err(damaged(&folder, &format!("{problem}, a recording has no such")));
                }
            };
            for (axis, len) in along {
                let (cells, of) = match axis.strip_suffix(FACES) {
                    Some(axis) => (len.saturating_sub(1), axis),
                    None => (len, &*axis),
                };
                match sizes.entry(of.to_owned()).or_insert((cells, name)) {
                    (known, _) if *known == cells => {}
                    (known, other) => {
                        let problem = format!("{cells} cells along {of}, `{other}` has {known}");
                        return Err(damaged(&folder, &problem));
                    }
                }
            }
        }
        let cells = |axis| sizes.get(axis).map_or(1, |s| usize::try_from(s.0).unwrap_or(usize::MAX));
        check_size(&self.place(""), cells(X), cells(Y), &self.limits).map(drop)
    }

    /// The array of a layer and its rows and columns, which are those of a world of `size`.
    fn array_of(&self, name: &str, centering: Centering, size: (usize, usize)) -> Result<(Array, [Axis; 2])> {
        check_name(&self.place(""), name)?;
        let folder = self.place(name);
        let Some(described) = self.arrays.get(name) else {
            return Err(damaged(&folder, "the store does not name this array"));
        };
        let array = Array::described(&folder, described, &self.limits)?;
        let axes = axes(centering, size);
        if array.shape.get(1..) != Some(&axes.map(|a| a.n as u64)) {
            let problem =
                format!("an array of {:?} values, a frame of {} x {} cells has no such", array.shape, size.0, size.1);
            return Err(damaged(&folder, &problem));
        }
        Ok((array, axes))
    }

    fn piece_name(&self, name: &str, array: &Array, at: &[u64]) -> String {
        self.name(&within(name, &array.key_of(at)))
    }

    /// The values of a piece as bytes, or `None` if it was never written.
    fn piece(&self, name: &str, array: &Array, at: &[u64]) -> Result<Option<Vec<u8>>> {
        let name = self.piece_name(name, array, at);
        let place = self.storage.place(&name);
        match self.storage.open(&name) {
            Ok(blob) => array.decode(&place, blob.input).map(Some),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(Error::io(&place, "read")(e)),
        }
    }

    /// The values of a layer in frame `i`, its outer faces apart.
    fn read_layer(&self, i: usize, layer: &mut Layer) -> Result<()> {
        let (width, height) = (layer.field.width(), layer.field.height());
        let (array, [rows, columns]) = self.array_of(&layer.spec.name, layer.spec.centering, (width, height))?;
        // Faces before the first row or column come from the frame's head.
        let (skip_y, skip_x) = (rows.n - height, columns.n - width);
        for top in 0..rows.n.div_ceil(SHARD) {
            let band: Vec<Option<Vec<u8>>> = (0..columns.n.div_ceil(SHARD))
                .into_par_iter()
                .map(|left| self.piece(&layer.spec.name, &array, &[i as u64, top as u64, left as u64]))
                .collect::<Result<_>>()?;
            for (left, piece) in band.into_iter().enumerate() {
                let piece = piece.ok_or_else(|| missing_piece(&array, i))?;
                for (y, line) in (top * SHARD..rows.n).zip(piece.chunks_exact(4 * SHARD)).filter(|(y, _)| *y >= skip_y)
                {
                    let row = layer.field.row_mut(y - skip_y);
                    for (x, b) in (left * SHARD..columns.n).zip(line.chunks_exact(4)).filter(|(x, _)| *x >= skip_x) {
                        row[x - skip_x] = number(b);
                    }
                }
            }
        }
        Ok(())
    }
}

fn missing_piece(array: &Array, i: usize) -> Error {
    damaged(&array.folder, &format!("a chunk of frame {i} is missing"))
}

/// How the recording of this root is made.
fn record(root: &Value) -> Option<Record> {
    let number = |key: &str| root["attributes"][key].as_u64();
    Some(Record { every: number(EVERY).filter(|n| *n > 0)?, max_bytes: number(MAX_BYTES)? })
}

fn damaged(path: &Path, problem: &str) -> Error {
    Error::format(path, format!("the recording is damaged: {problem}"), REMEDY)
}
