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
//! for each component, in the header's order, which is that of their names:
//!   bytes               what [`eyot_core::Component::encode`] wrote
//!   CRC-32              u32, of these bytes
//! for each layer, in the header's order:
//!   values              f32, row by row from the north, without padding
//!   outer faces         f32, only for layers on faces: column -1 from the north, then row -1 from the west
//!   CRC-32              u32, of these values
//! ```
//! The header names kind, version and bytes of each component. In format version 2 all of them were plain lists of f64, called
//! features; such files are read as version 1 of the kind that has taken the name over ([`eyot_core::ComponentKind::formerly`]).
//!
//! The header fixes the file's length, which is checked before anything is allocated: a file that was cut short, or has
//! been added to, is refused at once.

use crate::atomic::{put, row_bytes, write_atomically};
use crate::error::{Error, Result};
use crate::head::{Head, HeadFile, Sealed, check_crc, number, read_faces, write_faces};
use crate::storage::{Keep, Storage};
use eyot_core::{ComponentKinds, Layer, Limits, World};
use serde_json::Value;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

/// What a checkpoint without a name is called in messages.
const NAME: &str = "checkpoint";

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

/// Writes a checkpoint with [`write_atomically`]: a former one at `path` stays whole until the new one is.
///
/// # Errors
/// If the world's clock, ledger or georeference, or `state`, holds a number that JSON cannot carry (not finite), or if
/// the file cannot be written.
pub fn save(path: &Path, world: &World, recipe_toml: &str, state: &Value) -> Result<()> {
    let head = Head::of(path, world, recipe_toml, state)?;
    write_atomically(path, |file| write_all(path, file, world, &head))
}

/// As [`save`], as a blob that is to last.
///
/// # Errors
/// As [`save`].
pub fn save_in(storage: &dyn Storage, name: &str, world: &World, recipe_toml: &str, state: &Value) -> Result<()> {
    let place = storage.place(name);
    let head = Head::of(&place, world, recipe_toml, state)?;
    storage.write(name, Keep::Lasting, &mut |mut out| write_all(&place, &mut out, world, &head))
}

/// As [`save`], to any writer.
///
/// # Errors
/// As [`save`].
pub fn write(out: &mut impl Write, world: &World, recipe_toml: &str, state: &Value) -> Result<()> {
    let place = Path::new(NAME);
    write_all(place, out, world, &Head::of(place, world, recipe_toml, state)?)
}

fn write_all(path: &Path, file: &mut impl Write, world: &World, head: &Sealed<'_>) -> Result<()> {
    head.write(path, file)?;
    let mut buffer = Vec::new();
    for layer in world.layers() {
        let mut crc = crc32fast::Hasher::new();
        for row in layer.field.rows() {
            let bytes = row_bytes(row, &mut buffer);
            crc.update(bytes);
            put(file, path, bytes)?;
        }
        write_faces(path, file, layer, &mut crc, &mut buffer)?;
        put(file, path, &crc.finalize().to_le_bytes())?;
    }
    Ok(())
}

/// Reads a checkpoint whose components are all of these kinds.
///
/// # Errors
/// If the file cannot be read, is no checkpoint, was written in another format version, is truncated or damaged, holds a component
/// of another kind, or exceeds `limits`. Sizes are checked against the file's length and `limits` before anything is allocated.
pub fn load(path: &Path, limits: &Limits, kinds: &ComponentKinds) -> Result<Checkpoint> {
    restore(path, HeadFile::open(path)?, limits, kinds)
}

/// As [`load`], of a blob.
///
/// # Errors
/// As [`load`].
pub fn load_in(storage: &dyn Storage, name: &str, limits: &Limits, kinds: &ComponentKinds) -> Result<Checkpoint> {
    restore(&storage.place(name), HeadFile::open_in(storage, name)?, limits, kinds)
}

/// As [`load`], of any reader, from its start to its end.
///
/// # Errors
/// As [`load`].
pub fn read(mut input: impl Read + Seek, limits: &Limits, kinds: &ComponentKinds) -> Result<Checkpoint> {
    let place = Path::new(NAME);
    let bytes = input.seek(SeekFrom::End(0)).map_err(Error::io(place, "read"))?;
    input.rewind().map_err(Error::io(place, "read"))?;
    restore(place, HeadFile::of(place, input, bytes)?, limits, kinds)
}

fn restore(path: &Path, mut file: HeadFile<impl Read>, limits: &Limits, kinds: &ComponentKinds) -> Result<Checkpoint> {
    file.head.check(path, limits)?;
    file.check_length(path, file.head.value_bytes() + file.head.face_bytes())?;
    let components = file.components(path, limits, kinds)?;
    let HeadFile { head, mut input, .. } = file;
    let mut buffer = vec![0; 4 * head.grid.width];
    head.restore(components, |layer| read_values(path, &mut input, &mut buffer, layer))
}

/// What the run itself wanted to remember in a checkpoint; its layers are not read.
///
/// # Errors
/// If the file cannot be read, is no checkpoint, was written in another format version, or its head is damaged.
pub fn load_state(path: &Path) -> Result<Value> {
    Ok(HeadFile::open(path)?.head.state)
}

/// As [`load_state`], of a blob.
///
/// # Errors
/// As [`load_state`].
pub fn load_state_in(storage: &dyn Storage, name: &str) -> Result<Value> {
    Ok(HeadFile::open_in(storage, name)?.head.state)
}

fn read_values(path: &Path, input: &mut impl Read, buffer: &mut [u8], layer: &mut Layer) -> Result<()> {
    let mut crc = crc32fast::Hasher::new();
    for row in layer.field.rows_mut() {
        input.read_exact(buffer).map_err(Error::io(path, "read"))?;
        crc.update(buffer);
        row.iter_mut().zip(buffer.chunks_exact(4)).for_each(|(v, b)| *v = number(b));
    }
    read_faces(path, input, layer, &mut crc)?;
    check_crc(path, input, crc, &format!("layer `{}`", layer.spec.name))
}
