//! Where checkpoints, recordings and results lie: blobs with names, in a folder or in memory.
//!
//! Names are relative, with `/` between their parts; what shares the parts before a `/` is a *group*, as a folder is.

mod folder;
mod memory;

pub use folder::Folder;
pub use memory::Memory;

use crate::error::{Error, Result};
use std::fmt;
use std::io::{self, Cursor, Read, Seek, Write};
use std::path::PathBuf;

/// What survives when a blob is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// A kill may leave half of it. For what is found by a checksum, or is not yet named by anything.
    Loose,
    /// Through a kill, the former blob or the whole new one.
    Whole,
    /// As [`Keep::Lasting`] if that takes no more than a tenth of the time since the last one, else as [`Keep::Whole`].
    Thrifty,
    /// Also through a power failure.
    Lasting,
}

/// What can be read anywhere.
pub trait ReadSeek: Read + Seek + Send {}

impl<T: Read + Seek + Send> ReadSeek for T {}

/// What can be written anywhere.
pub trait WriteSeek: Write + Seek {}

impl<T: Write + Seek + ?Sized> WriteSeek for T {}

/// What is written and read again.
pub trait Spool: Read + Write + Seek {}

impl<T: Read + Write + Seek> Spool for T {}

/// A blob to read.
pub struct Blob {
    /// Its bytes.
    pub input: Box<dyn ReadSeek>,
    /// How many there are.
    pub bytes: u64,
}

/// A member of a group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The last part of its name.
    pub name: String,
    /// Bytes of a blob; `None` for a group.
    pub bytes: Option<u64>,
}

/// What fills a blob.
pub type Fill<'a> = dyn FnMut(&mut dyn WriteSeek) -> Result<()> + 'a;

/// Writes a blob of a group by its name there; several threads may.
pub type Put<'a> = dyn Fn(&str, &[u8]) -> Result<()> + Sync + 'a;

/// What fills a group.
pub type FillGroup<'a> = dyn FnMut(&Put<'_>) -> Result<()> + 'a;

/// Blobs with names. One session writes to it at a time; several threads may.
pub trait Storage: Send + Sync + fmt::Debug {
    /// What people may call a blob, for messages.
    fn place(&self, name: &str) -> PathBuf;

    /// Finds out whether what is written still goes where it went at first.
    ///
    /// # Errors
    /// If the place was moved, removed or replaced meanwhile.
    fn check(&self) -> Result<()> {
        Ok(())
    }

    /// Opens a blob.
    ///
    /// # Errors
    /// If there is none, it is a group, or the system refuses.
    fn open(&self, name: &str) -> io::Result<Blob>;

    /// Bytes of a blob; `None` if there is none.
    fn bytes(&self, name: &str) -> Option<u64>;

    /// Whether there is a group of this name.
    fn is_group(&self, name: &str) -> bool;

    /// Makes a group, where such a thing can be empty.
    ///
    /// # Errors
    /// If the system refuses.
    fn make_group(&self, name: &str) -> Result<()>;

    /// Writes a blob in the place of any former one. Its groups are made.
    ///
    /// # Errors
    /// What `fill` returns, and if the system refuses. A former blob is then as before, unless it was to be kept loosely.
    fn write(&self, name: &str, keep: Keep, fill: &mut Fill<'_>) -> Result<()>;

    /// Writes a group in the place of a former one, which must hold the blob `mark`; a kill leaves the former group or the whole new one.
    ///
    /// # Errors
    /// What `fill` returns, if the system refuses, and if something else has that name. What was there is then as before.
    fn write_group(&self, name: &str, mark: &str, fill: &mut FillGroup<'_>) -> Result<()>;

    /// Room for what must wait until it is written, gone when it is dropped; in memory unless the storage has a better place.
    ///
    /// # Errors
    /// If the system refuses.
    fn spool(&self) -> io::Result<Box<dyn Spool>> {
        Ok(Box::new(Cursor::new(Vec::new())))
    }

    /// Gives a blob or a group another name. What has that name goes if it is a blob.
    ///
    /// # Errors
    /// If there is no such thing, or the system refuses.
    fn rename(&self, from: &str, to: &str) -> Result<()>;

    /// Removes a blob, or a group with all that is in it. It is no error if there is none.
    ///
    /// # Errors
    /// If the system refuses.
    fn remove(&self, name: &str) -> Result<()>;

    /// Removes a group that is empty; others stay.
    fn prune(&self, name: &str);

    /// What is in a group, in no order; nothing if there is none. The empty name is the group of everything.
    fn list(&self, name: &str) -> Vec<Entry>;

    /// Removes from a group what writers left that were killed.
    fn tidy(&self, name: &str);
}

/// Writes bytes as a blob.
///
/// # Errors
/// As [`Storage::write`].
pub fn write_bytes(storage: &dyn Storage, name: &str, keep: Keep, bytes: &[u8]) -> Result<()> {
    let place = storage.place(name);
    storage.write(name, keep, &mut |out| out.write_all(bytes).map_err(Error::io(&place, "write")))
}

/// The bytes of a blob, if they are no more than `most`.
///
/// # Errors
/// If there is none, it is longer, or the system refuses.
pub fn read_bytes(storage: &dyn Storage, name: &str, most: u64) -> Result<Vec<u8>> {
    let place = storage.place(name);
    let blob = storage.open(name).map_err(Error::io(&place, "read"))?;
    let mut bytes = Vec::new();
    blob.input.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(Error::io(&place, "read"))?;
    if bytes.len() as u64 > most {
        return Err(Error::format(&place, format!("more than {most} bytes"), "is this the right file?"));
    }
    Ok(bytes)
}

/// A name in a group; the empty group is that of everything.
pub fn within(group: &str, name: &str) -> String {
    match (group, name) {
        ("", name) => name.to_owned(),
        (group, "") => group.to_owned(),
        (group, name) => format!("{group}/{name}"),
    }
}
